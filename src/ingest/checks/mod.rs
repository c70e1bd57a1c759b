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
//! is symmetric, coefficients stay right, left and right change names), and scales that are off by less than a
//! tenth.

use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::ingest::config::Config;
use crate::ingest::error::Error;

mod accelerations;
pub(crate) mod aids;
mod angles;
mod bends;
#[cfg(test)]
mod broken;
mod calculated;
pub(crate) mod clean;
pub(crate) mod coarse;
mod controls;
mod course;
mod finding;
pub(crate) mod frozen;
mod impossible;
pub(crate) mod judge;
mod sideways;
mod slip;
mod speeds;
mod still;
mod swapped;
pub(crate) mod switches;
#[cfg(test)]
mod tests;
mod view;
mod zero_speed;

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
    let findings = run(session, bike, Findings::new(&config.check, false))?;
    session.contradicted = findings.contradicted;
    for channel in findings.left_out {
        session.remove(channel);
    }
    if !has_velocity(session) {
        return Err(Error {
            code: RejectionCode::MissingColumn,
            message: format!(
                "velocity_x is stuck or impossible, and every coefficient needs it: {}",
                findings.warnings.last().map_or("", |w| w.message.as_str())
            ),
        });
    }
    Ok(findings.warnings)
}

/// Findings of the same checks on a session; it stays as it is.
pub(crate) fn look(session: &Session, bike: Option<&Bike>, config: &Config) -> Vec<Warning> {
    if !has_velocity(session) {
        return Vec::new();
    }
    // what is only said refuses nothing
    run(session, bike, Findings::new(&config.check, true))
        .map_or_else(|_| Vec::new(), |f| f.warnings)
}

fn has_velocity(session: &Session) -> bool {
    session.get(Channel::VelocityX).is_some_and(|v| v.iter().any(|v| v.is_finite()))
}

fn run<'a>(
    session: &Session,
    bike: Option<&Bike>,
    mut findings: Findings<'a>,
) -> Result<Findings<'a>, Error> {
    if !has_velocity(session) {
        let there = session.has(Channel::VelocityX);
        let state = if there { "has no valid sample" } else { "is missing" };
        return Err(Error {
            code: RejectionCode::MissingColumn,
            message: format!(
                "velocity_x {state}; every coefficient needs the forward velocity: map a speed \
                 channel onto it"
            ),
        });
    }
    let mut view = View::new(session);
    findings.warnings.extend(coarse::take_out(session, &mut view));
    if view.count_moving() < view::MIN_MEANS {
        findings.push(Finding {
            code: RejectionCode::Standstill,
            channel: Channel::VelocityX,
            count: view.count_moving(),
            message: format!(
                "velocity_x is above {} m/s for only {:.1} s: units and signs could not be checked",
                view::MOVING,
                view.count_moving() as f64 * view.step()
            ),
        })?;
        return Ok(findings);
    }
    // a channel that is left out must not be used in further checks
    let drop_left_out = |view: &mut View, findings: &Findings<'_>| {
        findings.left_out.iter().for_each(|c| view.remove(*c));
    };
    still::check(&view, &mut findings)?;
    drop_left_out(&mut view, &findings);
    if view.get(Channel::VelocityX).is_none() {
        return Ok(findings);
    }
    let speed = speeds::check(&view, bike, &mut findings)?;
    drop_left_out(&mut view, &findings);
    angles::check(&view, bike, &mut findings)?;
    course::check(&view, &mut findings)?;
    accelerations::check(&view, speed, &mut findings)?;
    drop_left_out(&mut view, &findings);
    calculated::check(&view, &mut findings)?;
    drop_left_out(&mut view, &findings);
    bends::check(&view, speed.ground, &mut findings)?;
    drop_left_out(&mut view, &findings);
    sideways::check(&view, &mut findings)?;
    controls::check(&view, &mut findings)?;
    impossible::check(&view, &mut findings)?;
    drop_left_out(&mut view, &findings);
    if let Some(bike) = bike {
        swapped::check(&view, bike, &mut findings)?;
    }
    Ok(findings)
}
