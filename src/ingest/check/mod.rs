//! Channels against physics and against each other.
//!
//! A wrong unit or sign gives coefficients that look fine and are not. Here each channel is
//! compared with the others' account of the same motion: wheel speeds against velocity and the bike's
//! radii, lean against yaw rate, accelerations against velocity, driven against free wheel.
//! Medians of ratios over 0.2 s means while the bike moves: vibration, spikes and short faults
//! do not matter, nor does the cost.
//!
//! Assumes [`run`](super::run) before, and no filter yet. What is wrong in a channel that every
//! coefficient needs is an [`Error`]; another channel is taken out, with a [`Warning`], so that
//! what depends on it becomes *not available* instead of wrong.
//!
//! | code | seen by | effect |
//! |---|---|---|
//! | `missing_column` | no `velocity_x` | rejected |
//! | `standstill` | too little motion to check anything | warning |
//! | `unit_velocity`, `unit_wheel_speed`, `sign_velocity_x` | `v / (omega R)`, track over ground | rejected |
//! | `implausible_radius` | the same, off by 25 % (10 %) | rejected (warning) |
//! | `stuck` | a wheel speed that stays while `v` changes | taken out |
//! | `unit_angle`, `unit_rate` | magnitudes, `tan(roll)` against `v r / g`, angles against rates | rejected |
//! | `sign_roll_yaw` | `tan(roll)` against `v r / g` | rejected |
//! | `sign_yaw`, `sign_roll_rate`, `sign_steer` | angles against rates, path curvature | taken out |
//! | `sign_lateral` | roll and yaw rate against the track over ground | warning |
//! | `sign_acceleration_*`, `unit_acceleration`, `gravity_in_acceleration` | `dv/dt`, `v r` | taken out |
//! | `wheels_swapped`, `brakes_swapped` | which wheel slips under brake and drive | rejected |
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
mod finding;
mod speeds;
mod swapped;
#[cfg(test)]
mod tests;
mod view;

use finding::Finding;
use view::View;

/// Checks channels against physics and against each other, given the bike.
///
/// # Errors
/// A channel's unit or sign is wrong in a way that would give coefficients nobody may believe.
pub fn check(session: &mut Session, bike: &Bike, _config: &Config) -> Result<Vec<Warning>, Error> {
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
    if view.count_moving() < view::FEWEST {
        return Ok(vec![warning(Finding {
            code: "standstill",
            channel: Channel::VelocityX,
            remove: false,
            count: view.count_moving(),
            message: format!(
                "velocity_x is above {} m/s for only {:.1} s: units and signs could not be checked",
                view::MOVING,
                view.count_moving() as f64 * view.step()
            ),
        })]);
    }
    let mut findings = Vec::new();
    speeds::check(&view, bike, &mut findings)?;
    // a channel that is taken out must not be used in further checks
    findings.iter().filter(|f| f.remove).for_each(|f| view.remove(f.channel));
    angles::check(&view, bike, &mut findings)?;
    accelerations::check(&view, &mut findings);
    swapped::check(&view, bike)?;
    let mut warnings = Vec::with_capacity(findings.len());
    for finding in findings {
        if finding.remove {
            session.remove(finding.channel);
        }
        warnings.push(warning(finding));
    }
    Ok(warnings)
}

fn warning(finding: Finding) -> Warning {
    Warning {
        stage: "ingest",
        code: finding.code,
        channel: Some(finding.channel),
        count: finding.count,
        time: None,
        message: finding.message,
    }
}
