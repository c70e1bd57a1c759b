//! What a standing rider does to the bike: forces at pegs and handlebar.
//!
//! Every rider gives the same table: [`Forces`], on the bike, in ground axes (X forward, Z down),
//! N, for `A_r` of the [`equations`](crate::motorcycle::offroad::equations). Adding a rider is adding a file, a line in
//! [`Rider`] and one in [`forces`].

pub(crate) mod a;
pub(crate) mod b;
pub(crate) mod c;
pub(crate) mod types;

use crate::contract::key_error::KeyError;
use crate::motorcycle::offroad::body::Body;
pub(crate) use types::{Base, Config, Forces, Rider, hold};

/// A rider's forces over a session. NaN where the motion is not known.
///
/// # Errors
/// Rider A cannot stand in this posture; a sentence that names the keys.
pub fn forces(
    rider: Rider,
    body: &Body,
    peg: [f64; 2],
    bar: [f64; 2],
    base: &Base<'_>,
    config: &Config,
) -> Result<Forces, KeyError> {
    match rider {
        Rider::None => Ok(Forces::zeros(base.mu.len())),
        Rider::A => a::forces(body, peg, bar, base),
        Rider::B => Ok(b::forces(body.mass, base, config)),
        Rider::C => Ok(c::forces(body.mass, base, config)),
    }
}
