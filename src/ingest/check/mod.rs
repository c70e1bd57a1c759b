//! Channels against physics and against each other.
//!
//! A wrong unit or sign gives coefficients that look fine and are not. Here each channel is
//! compared with the others' account of the same motion: wheel speeds against velocity and the bike's
//! radii, lean against yaw rate, accelerations against velocity, driven against free wheel.
//! Medians of ratios over 0.2 s means while the bike moves: vibration, spikes and short faults
//! do not matter, nor does the cost.
//!
//! Assumes [`run`](super::run) before, and no filter yet. What is wrong in a channel that every
//! coefficient needs is an [`Error`]; another channel is left out, with a [`Warning`], so that
//! what depends on it becomes *not available* instead of wrong. Where physics allows what is seen,
//! it is a warning at most.
//!
//! What each is seen by and what it does is declared in [`CHECKS`](crate::ingest::CHECKS); `[ingest.check]` of a pipeline
//! switches it.
//!
//! Cannot be seen: every lateral channel mirrored at once without a track over ground (the tyre
//! is symmetric, coefficients stay right, left and right change names), and the sign of
//! `velocity_y`, which physics leaves open.

use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::ingest::config::Config;
use crate::ingest::error::Error;

mod accelerations;
mod angles;
mod course;
mod finding;
mod slip;
mod speeds;
mod swapped;
#[cfg(test)]
mod tests;
mod view;

use finding::{Finding, Findings};
use view::View;

/// Checks channels against physics and against each other, and against the bike where it is known.
///
/// # Errors
/// A channel's unit or sign is wrong in a way that would give coefficients nobody may believe.
pub fn check(
    session: &mut Session,
    bike: Option<&Bike>,
    config: &Config,
) -> Result<Vec<Warning>, Error> {
    let v = session.get(Channel::VelocityX);
    if !v.is_some_and(|v| v.iter().any(|v| v.is_finite())) {
        let state = if v.is_some() { "has no valid sample" } else { "is missing" };
        return Err(Error {
            code: "missing_column",
            message: format!(
                "velocity_x {state}; every coefficient needs the forward velocity: map a speed \
                 channel onto it"
            ),
        });
    }
    let mut view = View::new(session);
    let mut findings = Findings::new(&config.check);
    if view.count_moving() < view::FEWEST {
        findings.push(Finding {
            code: "standstill",
            channel: Channel::VelocityX,
            count: view.count_moving(),
            message: format!(
                "velocity_x is above {} m/s for only {:.1} s: units and signs could not be checked",
                view::MOVING,
                view.count_moving() as f64 * view.step()
            ),
        })?;
        return Ok(findings.warnings);
    }
    if let Some(bike) = bike {
        speeds::check(&view, bike, &mut findings)?;
    }
    // a channel that is left out must not be used in further checks
    findings.left_out.iter().for_each(|c| view.remove(*c));
    if let Some(bike) = bike {
        angles::check(&view, bike, &mut findings)?;
    }
    course::check(&view, &mut findings)?;
    accelerations::check(&view, &mut findings)?;
    if let Some(bike) = bike {
        swapped::check(&view, bike, &mut findings)?;
    }
    findings.left_out.into_iter().for_each(|channel| drop(session.remove(channel)));
    Ok(findings.warnings)
}
