//! Channels against physics and against each other.

use crate::bike::Bike;
use crate::ingest::{Config, Error};
use crate::session::Session;
use crate::warning::Warning;

/// Checks channels against physics and against each other, given the bike.
///
/// # Errors
/// A channel's unit or sign is wrong in a way that would give coefficients nobody may believe.
pub fn check(
    _session: &mut Session,
    _bike: &Bike,
    _config: &Config,
) -> Result<Vec<Warning>, Error> {
    Ok(Vec::new())
}
