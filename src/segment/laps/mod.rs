//! Laps of a track session: when the line was crossed, where each lap won or lost, what the tyres were used for.
//!
//! ```text
//! positions, speed -> ground -> line (given, the logger's, the fastest part) -> find: crossings, laps, is it a track
//!                  -> trace: laps over the stations of the fastest -> corners, grip -> rows
//! ```
//!
//! A ride that does not go round has no laps and no rows.

pub mod config;
pub mod corners;
pub mod find;
pub mod grip;
pub mod ground;
pub mod line;
mod rows;
pub mod trace;

pub use self::config::Config;
use self::find::{Found, find};
pub use self::grip::Known;
use self::ground::Ground;
pub use self::rows::Laps;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::store::tables::rows::Ident;

/// The laps of a session; empty where it does not go round a track.
pub fn run(session: &Session, known: &Known<'_>, ident: &Ident, config: &Config) -> Laps {
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
