//! What loggers on motorcycles write: formats, names, units, rates and delays that are not ours.
//!
//! ```text
//! track ride -> columns (name, value by sample, delay, noise, step) -> rows at the logger's rate -> text
//! ```
//!
//! Adding a logger is one file that lists its columns, and one line in [`write()`]. Names and units follow
//! exports of such loggers as their owners publish them; none is a copy of one.

pub(crate) mod board;
mod factory;
mod phone;
pub(crate) mod profile;
mod satellite;
mod superbike;

use self::board::Board;
pub(crate) use self::board::Foreign;
pub(crate) use self::profile::Profile;
use super::track::ridden::TrackRide;
use crate::statistics::random::Random;

/// Writes the log of a ride.
pub fn write(profile: Profile, ridden: &TrackRide, seed: u64) -> Foreign {
    let id = &ridden.ride.session.meta.session_id;
    let random = Random::new(seed, &format!("logger {} {id}", profile.name()));
    let board = Board::new(ridden, random);
    match profile {
        Profile::Superbike => superbike::write(board),
        Profile::Factory => factory::write(board),
        Profile::Phone => phone::write(board),
        Profile::Satellite => satellite::write(board),
    }
}
