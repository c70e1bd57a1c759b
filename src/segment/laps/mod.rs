//! Laps of a track session: when the line was crossed, where each lap won or lost, what the tyres were used for.
//!
//! ```text
//! positions, speed -> ground -> line (given, the logger's, the fastest part) -> find: crossings, laps, is it a track
//!                  -> trace: laps over the stations of the fastest -> corners, grip -> rows
//! ```
//!
//! A ride that does not go round has no laps and no rows.

pub(crate) mod config;
pub(crate) mod corners;
pub(crate) mod find;
pub(crate) mod grip;
pub(crate) mod ground;
pub(crate) mod line;
pub(crate) mod rows;
pub(crate) mod trace;

pub(crate) use self::config::Config;
use self::find::{Found, find};
pub(crate) use self::grip::Known;
use self::ground::Ground;
pub(crate) use self::rows::Laps;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::store::tables::rows::Ident;

/// The laps of a session; empty where it does not go round a track.
pub(crate) fn run(session: &Session, known: &Known<'_>, ident: &Ident, config: &Config) -> Laps {
    match detect(session, config) {
        Some((ground, found)) => rows::rows(session, &ground, &found, known, ident),
        None => Laps::default(),
    }
}

/// The laps alone: times and what they were found by.
pub fn detect(session: &Session, config: &Config) -> Option<(Ground, Found)> {
    if !config.enabled {
        return None;
    }
    let ground = Ground::new(session)?;
    let found = find(&ground, session.get(Channel::LapNumber), config)?;
    Some((ground, found))
}
