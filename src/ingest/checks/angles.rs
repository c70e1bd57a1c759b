//! Attitude, rates and steering against each other: units and signs.
//!
//! ```text
//! (1)  tan(roll) = -v r / g              leaning into the corner, steady
//! (2)  delta = l (r / v) cos(roll) / cos(epsilon)      a slow corner without tyre slip
//! ```

use super::finding::{Finding, Findings};
use super::view::{Median, View};
use crate::GRAVITY;
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;

/// Degrees per radian.
const DEGREES: f64 = 57.295_78;
/// Largest angle a rider survives, rad: what is beyond is in degrees.
const LARGEST: f64 = 1.4;
/// Largest `v r / g`: 72 deg of lean.
const LARGEST_LATERAL: f64 = 3.0;
/// Middle of the leans of a ride beyond which it is not counted from upright, rad: a ride of one circle leans less.
const OFFSET: f64 = 1.2;
/// `v r / g` above which it is a corner.
const BEND: f64 = 0.1;
/// Yaw rate above which it is a turn, rad/s.
const TURN: f64 = 0.1;
/// A median ratio beyond this has a sign.
const SIGNED: f64 = 0.3;
/// A rate is its angle's change within this factor.
const SCALE: f64 = 1.6;
/// Less than this is left of two channels that do not go together.
const TOGETHER: f64 = 0.25;
/// A handlebar turns as (2) says within this factor.
const STEERED: f64 = 3.0;
/// Below this speed (2) holds, m/s.
const SLOW: f64 = 9.0;

pub(crate) fn check(view: &View, bike: Option<&Bike>, out: &mut Findings<'_>) -> Result<(), Error> {
    if let Some(offset) = counted_from_elsewhere(view) {
        out.push(offset)?;
        // what is said of signs and units would be of the offset
        return bike.map_or(Ok(()), |bike| steer(view, bike, out));
    }
    for channel in [Channel::Roll, Channel::Pitch, Channel::SteerAngle] {
        let p99 = view.get(channel).and_then(|x| view.p99(|i| x[i]));
        if let Some(p99) = p99.filter(|p| *p > LARGEST) {
            let seen = format!("it reaches {p99:.1} while riding, {:.0} deg as rad", p99 * DEGREES);
            out.push(unit(
                RejectionCode::UnitAngle,
                channel,
                view.count_moving(),
                "degrees",
                "rad",
                &seen,
            ))?;
        }
    }
    rate_of_angle(view, Channel::Roll, Channel::RollRate, out)?;
    rate_of_angle(view, Channel::Pitch, Channel::PitchRate, out)?;
    bends(view, out)?;
    bike.map_or(Ok(()), |bike| steer(view, bike, out))
}

/// A lean that is not zero upright, but counted from the horizontal, say: it swings about a middle that no ride has.
fn counted_from_elsewhere(view: &View) -> Option<Finding> {
    let roll = view.get(Channel::Roll)?;
    let middle = view.median(|i| roll[i])?;
    let swing = view.p99(|i| roll[i] - middle.value)?;
    // numbers in degrees that are read as rad swing by more
    (middle.value.abs() > OFFSET && swing < LARGEST).then(|| Finding {
        code: RejectionCode::UnitAngle,
        channel: Channel::Roll,
        count: middle.n,
        message: format!(
            "roll is {:.2} rad ({:.0} deg) in the middle of the ride and swings about that by {swing:.2} rad: upright it has \
             to be 0; give the channel map an `offset` of minus what the log says upright",
            middle.value,
            middle.value.to_degrees()
        ),
    })
}

/// Whether an angle is larger than one in radians can be.
fn large(view: &View, angle: Channel) -> bool {
    view.get(angle).and_then(|x| view.p99(|i| x[i])).is_some_and(|p| p > LARGEST)
}

fn unit(
    code: RejectionCode,
    channel: Channel,
    count: usize,
    is: &str,
    not: &str,
    seen: &str,
) -> Finding {
    Finding {
        code,
        channel,
        count,
        message: format!(
            "{channel} looks like {is}, not {not}: {seen}; give its unit in the channel map"
        ),
    }
}

/// Whether a ratio is that of degrees to radians, either way of turning.
fn degrees(ratio: f64) -> bool {
    (0.6 * DEGREES..1.4 * DEGREES).contains(&ratio.abs())
}

/// A rate against the change of its angle.
fn rate_of_angle(
    view: &View,
    angle: Channel,
    rate: Channel,
    out: &mut Findings<'_>,
) -> Result<(), Error> {
    let (Some(x), Some(r)) = (view.get(angle), view.get(rate)) else { return Ok(()) };
    let (change, r) = (view.rate_of(x), view.smooth(r));
    let Some(m) = view.ratio(|i| r[i], |i| change[i], 0.1) else { return Ok(()) };
    if degrees(m.value) {
        let seen = format!("it is {:.0} times the change of {angle}", m.value);
        out.push(unit(RejectionCode::UnitRate, rate, m.n, "deg/s", "rad/s", &seen))?;
    }
    if degrees(1.0 / m.value) && large(view, angle) {
        let seen = format!("it changes {:.0} times as fast as {rate} says", 1.0 / m.value);
        out.push(unit(RejectionCode::UnitAngle, angle, m.n, "degrees", "rad", &seen))?;
    } else if degrees(1.0 / m.value) {
        let seen = format!("{angle} changes {:.0} times as fast", 1.0 / m.value);
        out.push(unit(RejectionCode::UnitRate, rate, m.n, "rad/s", "deg/s", &seen))?;
    }
    let pair = view.pair(&r, &change, 0.1);
    if let Some(p) = pair.filter(|p| rate == Channel::RollRate && !degrees(p.scale))
        && !out.concern(rate)
        && (p.scale.abs().ln().abs() > SCALE.ln() || p.together < TOGETHER)
        && !degrees(1.0 / p.scale)
    {
        out.push(Finding {
            code: RejectionCode::ScaleRate,
            channel: rate,
            count: p.n,
            message: format!(
                "{rate} is {:.2} times the change of {angle}, or disagrees with it: check its unit \
                 and axis in the channel map",
                p.scale
            ),
        })?;
    }
    // pitch moves little and slowly: its rate's sign is not judged
    if rate == Channel::RollRate && m.value < -SIGNED {
        out.push(Finding {
            code: RejectionCode::SignRollRate,
            channel: rate,
            count: m.n,
            message: format!(
                "{rate} is {:.2} times the change of {angle}: its sign is wrong; \
                 turn it in the channel map",
                m.value
            ),
        })?;
    }
    Ok(())
}

/// Yaw rate, roll, yaw and the track over ground: they turn the same way.
fn bends(view: &View, out: &mut Findings<'_>) -> Result<(), Error> {
    let (Some(v), Some(r)) = (view.get(Channel::VelocityX), view.get(Channel::YawRate)) else {
        return Ok(());
    };
    let yaw = view.get(Channel::Yaw).map(|y| view.rate_of(y));
    let smooth = view.smooth(r);
    let together = |a: &[f64], b: &[f64], least: f64| {
        view.pair(a, b, least).is_none_or(|p| p.together > TOGETHER)
    };
    let heading = yaw
        .as_ref()
        .filter(|y| together(y, &smooth, TURN))
        .and_then(|y| view.ratio(|i| y[i], |i| smooth[i], TURN));
    let lateral = |i: usize| v[i] * r[i] / GRAVITY;
    let roll = view.get(Channel::Roll);
    let lean = roll.and_then(|roll| view.ratio(|i| roll[i].tan(), lateral, BEND));

    // units first: a sign of a wrong unit is no news
    let p99 = view.p99(lateral);
    let by_lean =
        roll.and_then(|roll| view.ratio(|i| r[i], |i| -GRAVITY * roll[i].tan() / v[i], 0.03));
    if by_lean.is_some_and(|m| degrees(m.value)) || p99.is_some_and(|p| p > LARGEST_LATERAL) {
        let seen = match by_lean {
            Some(m) => format!("it is {:.0} times what the lean and the speed ask for", m.value),
            None => format!("the lateral acceleration would reach {:.0} g", p99.unwrap_or(0.0)),
        };
        let n = by_lean.map_or(view.count_moving(), |m| m.n);
        out.push(unit(RejectionCode::UnitRate, Channel::YawRate, n, "deg/s", "rad/s", &seen))?;
    }
    if let Some(m) = roll.and_then(|x| view.ratio(|i| x[i], |i| -lateral(i).atan(), BEND / 2.0))
        && degrees(m.value)
    {
        let seen = format!("it is {:.0} times what yaw rate and speed ask for", m.value);
        out.push(unit(RejectionCode::UnitAngle, Channel::Roll, m.n, "degrees", "rad", &seen))?;
    }
    if let Some(m) = heading
        && degrees(m.value)
    {
        let seen = format!("it changes {:.0} times as fast as yaw_rate says", m.value);
        out.push(unit(RejectionCode::UnitAngle, Channel::Yaw, m.n, "degrees", "rad", &seen))?;
    }

    let track = view.track();
    let course = track
        .as_ref()
        .filter(|(_, turn)| together(turn, &smooth, TURN))
        .and_then(|(_, turn)| view.ratio(|i| v[i] * turn[i] / GRAVITY, lateral, BEND));
    if let Some(lean) = lean.filter(|m| m.value > SIGNED) {
        let ay = view.get(Channel::AccelerationY);
        let side = ay.and_then(|a| view.ratio(|i| a[i] / GRAVITY, lateral, BEND));
        out.push(lean_against_yaw(lean, &[heading, course, side]))?;
    }
    if let Some(m) = heading.filter(|m| m.value < -SIGNED) {
        out.push(Finding {
            code: RejectionCode::SignYaw,
            channel: Channel::Yaw,
            count: m.n,
            message: format!(
                "yaw changes {:.2} times as fast as yaw_rate says: its sign is wrong (a compass \
                 heading is positive to the right); turn it in the channel map",
                m.value
            ),
        })?;
    }
    if let Some(m) = course.filter(|m| m.value < -SIGNED) {
        out.push(Finding {
            code: RejectionCode::SignLateral,
            channel: Channel::YawRate,
            count: m.n,
            message: "the track over ground turns the other way than yaw_rate: either every \
                      lateral channel is mirrored (left and right have changed names, the \
                      coefficients stay) or latitude and longitude are exchanged"
                .into(),
        })?;
    }
    Ok(())
}

/// Roll and yaw rate lean and turn opposite ways: which of them is wrong, by the others' vote.
fn lean_against_yaw(lean: Median, witnesses: &[Option<Median>]) -> Finding {
    let vote: i32 = witnesses
        .iter()
        .flatten()
        .filter(|m| m.value.abs() > SIGNED)
        .map(|m| if m.value > 0.0 { 1 } else { -1 })
        .sum();
    let (channel, which) = match vote {
        1.. => (
            Channel::Roll,
            "the other channels agree with yaw_rate: turn the sign of roll in the channel map",
        ),
        ..=-1 => (
            Channel::YawRate,
            "the other channels agree with roll: turn the sign of yaw_rate in the channel map",
        ),
        0 => (Channel::Roll, "one of them has the wrong sign, and no other channel shows which"),
    };
    Finding {
        code: RejectionCode::SignRollYaw,
        channel,
        count: lean.n,
        message: format!(
            "roll and yaw_rate disagree on left and right: tan(roll) is {:+.2} times v r / g in {} \
             means of 0.2 s, it should be about -1 (left corner: roll negative, yaw_rate \
             positive); {which}",
            lean.value, lean.n
        ),
    }
}

/// The handlebar against the path's curvature in slow corners, (2).
fn steer(view: &View, bike: &Bike, out: &mut Findings<'_>) -> Result<(), Error> {
    let (Some(v), Some(r), Some(delta)) =
        (view.get(Channel::VelocityX), view.get(Channel::YawRate), view.get(Channel::SteerAngle))
    else {
        return Ok(());
    };
    let roll = view.get(Channel::Roll);
    let expected = |i: usize| {
        if v[i] > SLOW {
            return f64::NAN;
        }
        let upright = roll.map_or(1.0, |roll| roll[i].cos());
        bike.wheelbase * r[i] / v[i] * upright / bike.caster_angle.cos()
    };
    let Some(m) = view.ratio(|i| delta[i], expected, 0.04) else { return Ok(()) };
    if degrees(m.value) {
        let seen = format!("it is {:.0} times what slow corners ask for", m.value);
        out.push(unit(
            RejectionCode::UnitAngle,
            Channel::SteerAngle,
            m.n,
            "degrees",
            "rad",
            &seen,
        ))?;
    }
    if !(1.0 / STEERED..STEERED).contains(&m.value.abs()) && !degrees(m.value) {
        let hint = if degrees(1.0 / m.value) { "it looks like rad read as degrees: " } else { "" };
        return out.push(Finding {
            code: RejectionCode::ScaleSteer,
            channel: Channel::SteerAngle,
            count: m.n,
            message: format!(
                "steer_angle is {:.3} times what slow corners ask for: {hint}check its unit in the channel map",
                m.value
            ),
        });
    }
    if m.value < -SIGNED {
        out.push(Finding {
            code: RejectionCode::SignSteer,
            channel: Channel::SteerAngle,
            count: m.n,
            message: format!(
                "steer_angle is {:.2} times what slow corners ask for: its sign is wrong (left is \
                 positive); turn it in the channel map",
                m.value
            ),
        })?;
    }
    Ok(())
}
