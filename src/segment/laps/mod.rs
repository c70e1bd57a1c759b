//! Laps of a track session: when the line was crossed, where each lap won or lost, what the tyres were used for.
//!
//! ```text
//! positions, speed -> ground -> markers (the logger's own, judged)
//!                  -> line (given, of the markers, the log's, the counter's, the fastest part)
//!                  -> find: passages, laps, is it a track
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
pub(crate) mod markers;
pub(crate) mod rows;
pub(crate) mod trace;

pub(crate) use self::config::Config;
use self::find::{DetectedLaps, find};
pub(crate) use self::grip::RideEstimates;
use self::ground::Ground;
use self::markers::judge;
pub(crate) use self::rows::Laps;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::store::tables::rows::Ident;

/// The laps of a session, empty where it does not go round a track, and what is wrong with the logger's markers.
pub(crate) fn run(
    session: &Session,
    known: &RideEstimates<'_>,
    ident: &Ident,
    config: &Config,
) -> (Laps, Vec<Warning>) {
    let (found, warnings) = look(session, config);
    let laps = match found {
        Some((ground, found)) => rows::rows(session, &ground, &found, known, ident),
        None => Laps::default(),
    };
    (laps, warnings)
}

/// The laps alone: times and what they were found by.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn detect(session: &Session, config: &Config) -> Option<(Ground, DetectedLaps)> {
    look(session, config).0
}

/// Laps, and what is wrong with the logger's markers.
pub fn look(session: &Session, config: &Config) -> (Option<(Ground, DetectedLaps)>, Vec<Warning>) {
    let ground = Ground::new(session).filter(|_| config.enabled);
    let Some(ground) = ground else { return (None, Vec::new()) };
    let markers = &session.markers;
    let judged = judge(&ground, &markers.times, config);
    let found = find(&ground, session.get(Channel::LapNumber), markers, &judged, config);
    let warnings = judged.warnings(markers.times.len());
    (found.map(|found| (ground, found)), warnings)
}
