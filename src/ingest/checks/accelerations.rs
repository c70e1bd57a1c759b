//! Accelerations against those that follow from velocity and yaw rate.
//!
//! ```text
//! (1)  a_x = dv/dt       (2)  a_y = v r
//! ```
//! (up to the side-slip terms, which are small beside them in a corner).

use super::finding::{Finding, Findings};
use super::speeds::Witnesses;
use super::view::{Median, View};
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;
use crate::statistics::order::median_and_spread;

/// Accelerations above this are compared, m/s².
const LEAST: f64 = 1.0;
/// An offset of this is a tilt of 3 deg, more than a sensor's bias, m/s².
const TILT: f64 = 0.5;

/// An offset of this is no bend of a mounting but another axis: the box stands on end, m/s².
const ON_END: f64 = 0.4 * GRAVITY;

/// Factor that scales are equal within: pitch, filters and good sensors change them less (0.94 to 1.01 on rides of both
/// simulators).
const EQUAL: f64 = 1.1;
/// Scatter of the ratio's logarithm from mean to mean, and standard errors of its median that are added.
const RATIO: f64 = 0.15;
const SURE: f64 = 2.0;
/// Largest ratio of two units of speed; the smallest, of knots and mph, and how near to it in its logarithm.
const OF_SPEED: f64 = 4.0;
const KNOTS: f64 = 1.150_78;
const UNIT_RATIO_TOLERANCE: f64 = 0.02;
/// From here on no two units of speed but these are.
const FEW: f64 = 1.4;
/// How long before and after an event nothing acts, s: more than a receiver's delay. Longest event, s, least change of
/// speed, m/s, and fewest events.
const CALM: f64 = 1.0;
const LONGEST: f64 = 20.0;
const CHANGE: f64 = 3.0;
const EVENTS: usize = 5;
/// Less than this of each other is left of two channels that do not go together.
const TOGETHER: f64 = 0.3;

pub(crate) fn check(view: &View, speed: Witnesses, out: &mut Findings<'_>) -> Result<(), Error> {
    let Some(v) = view.get(Channel::VelocityX) else { return Ok(()) };
    if let Some(ax) = view.get(Channel::AccelerationX) {
        let (dv, ax) = (view.rate_of(v), view.smooth(ax));
        let ratio = view.ratio(|i| ax[i], |i| dv[i], LEAST);
        let tilted = view.median(|i| ax[i] - dv[i]).filter(|m| m.value.abs() > TILT);
        if let Some(m) = tilted.filter(|m| m.value.abs() > ON_END) {
            out.push(tilt(m))?;
        } else if let Some(finding) = ratio.and_then(|m| judge(Channel::AccelerationX, m, "dv/dt"))
        {
            out.push(finding)?;
        } else if let Some((finding, of_speed)) = scale(view, [v, &ax, &dv], speed) {
            match of_speed {
                false => out.push(finding)?,
                true => {
                    out.push_contradiction(finding, &[Channel::VelocityX, Channel::AccelerationX])?
                }
            }
        } else if let Some(m) = tilted {
            out.push(tilt(m))?;
        }
    }
    if let (Some(ay), Some(r)) = (view.get(Channel::AccelerationY), view.get(Channel::YawRate)) {
        let Some(m) = view.ratio(|i| ay[i], |i| v[i] * r[i], 1.5 * LEAST) else { return Ok(()) };
        if let Some(finding) = judge(Channel::AccelerationY, m, "v r in corners") {
            out.push(finding)?;
        } else if m.value.abs() < 0.25 {
            // a sensor that leans with the bike feels next to nothing in a corner
            let seen = format!("in corners it is only {:.2} times v r", m.value);
            out.push(gravity(Channel::AccelerationY, m.n, &seen))?;
        }
    }
    Ok(())
}

/// A scale of `a_x` that is not that of `dv/dt`, and whether the velocity's unit may be the reason. Where wheels roll as
/// the bike file says, a small difference is the velocity's only if all speeds are knots read as mph or the reverse.
/// A small difference must be there over whole events, too: delays and filters change the ratio of accelerations.
fn scale(view: &View, [v, ax, dv]: [&[f64]; 3], speed: Witnesses) -> Option<(Finding, bool)> {
    // what a tilt adds is no scale
    let rest = |i: usize| if dv[i].abs() < 0.5 * LEAST { ax[i] } else { f64::NAN };
    let offset = view.median(rest).map_or(0.0, |m| m.value);
    let level: Vec<f64> = ax.iter().map(|a| a - offset).collect();
    let pair = view.pair(&level, dv, LEAST)?;
    let apart = pair.together < TOGETHER;
    let size = pair.scale.abs().ln().abs();
    let off = size > FEW.ln()
        || size > EQUAL.ln() + SURE * RATIO / (pair.n as f64).sqrt()
            && over_events(view, v, [&level, dv]).is_some_and(|(scale, error)| {
                let size = scale.ln() * pair.scale.abs().ln().signum();
                size > EQUAL.ln() + SURE * error
            });
    let is_knots = (size - KNOTS.ln()).abs() < UNIT_RATIO_TOLERANCE;
    let by_wheel = speed.wheel && size < FEW.ln() && !is_knots;
    let of_speed = !apart && size < OF_SPEED.ln() && !(speed.ground || by_wheel);
    let what = match (apart, off) {
        (true, _) => "disagrees with dv/dt: is it another axis of its sensor?".to_owned(),
        (_, true) if of_speed => {
            format!("is {:.2} times dv/dt: check the units of both", pair.scale)
        }
        (_, true) => format!("is {:.2} times dv/dt: check its scale", pair.scale),
        _ => return None,
    };
    let finding = Finding {
        code: RejectionCode::ScaleAcceleration,
        channel: Channel::AccelerationX,
        count: pair.n,
        message: format!("acceleration_x {what} in the channel map"),
    };
    Some((finding, of_speed))
}

/// The change of speed by the accelerometer over that by the velocity, and its standard error, from whole events: from
/// quiet to quiet, so that neither delays nor filters matter. `None` of too few.
fn over_events(view: &View, v: &[f64], [ax, dv]: [&[f64]; 2]) -> Option<(f64, f64)> {
    let calm = (CALM / view.step()).ceil() as usize;
    let acts = |i: usize| ax[i].abs() > LEAST || dv[i].abs() > LEAST;
    let mut ratios = Vec::new();
    let mut i = calm;
    while i + calm < v.len() {
        if !acts(i) {
            i += 1;
            continue;
        }
        let start = i - calm;
        let mut last = i;
        while i + calm < v.len() && i <= last + 2 * calm {
            last = if acts(i) { i } else { last };
            i += 1;
        }
        let end = (last + calm).min(v.len() - 1);
        let change = v[end] - v[start];
        let sum: f64 = (start..end).map(|k| 0.5 * (ax[k] + ax[k + 1])).sum::<f64>() * view.step();
        let ratio = sum / change;
        let is_short = (end - start) as f64 * view.step() < LONGEST;
        if change.abs() > CHANGE && is_short && ratio.is_finite() && ratio > 0.0 {
            ratios.push(ratio.ln());
        }
    }
    if ratios.len() < EVENTS {
        return None;
    }
    let (middle, spread) = median_and_spread(&mut ratios)?;
    Some((middle.exp(), 1.25 * spread / (ratios.len() as f64).sqrt()))
}

/// A wrong sign or unit, from the median ratio to what is expected.
fn judge(channel: Channel, m: Median, of: &str) -> Option<Finding> {
    // turned and in g as well: along x only, across a leaning sensor looks like that
    let sized = if channel == Channel::AccelerationX { m.value.abs() } else { m.value };
    let (code, what) = if (0.65..1.5).contains(&(sized * GRAVITY)) {
        (RejectionCode::UnitAcceleration, "it looks like g, not m/s2")
    } else if m.value < -0.3 {
        let code = match channel {
            Channel::AccelerationX => RejectionCode::SignAccelerationX,
            _ => RejectionCode::SignAccelerationY,
        };
        (code, "its sign is wrong")
    } else {
        return None;
    };
    Some(Finding {
        code,
        channel,
        count: m.n,
        message: format!(
            "{channel} is {:.2} times {of}: {what}; correct it in the channel map",
            m.value
        ),
    })
}

/// A forward acceleration that has a part of gravity throughout.
fn tilt(m: Median) -> Finding {
    let angle = (m.value.abs() / GRAVITY).min(1.0).asin().to_degrees();
    let seen = format!(
        "it differs from dv/dt by {:+.2} m/s2 throughout, as if tilted by {angle:.0} deg",
        m.value
    );
    gravity(Channel::AccelerationX, m.n, &seen)
}

fn gravity(channel: Channel, count: usize, seen: &str) -> Finding {
    Finding {
        code: RejectionCode::GravityInAcceleration,
        channel,
        count,
        message: format!(
            "{channel} seems to contain gravity: {seen}; it must be in the level frame without \
             gravity"
        ),
    }
}
