//! Velocity and wheel speeds against each other, the bike's radii and the track over ground.

use super::finding::{Finding, Findings};
use super::view::{Median, View, quantile};
use crate::contract::bike::{Axle, Bike};
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;

/// Speeds by the units that loggers write, m/s.
const SPEED_UNITS: [(&str, f64); 4] =
    [("km/h", 1.0 / 3.6), ("mph", 0.447_04), ("knots", 0.514_444), ("m/s", 1.0)];

/// Factor of a spin's number in another unit.
struct Unit {
    factor: f64,
    name: &'static str,
}

/// Per rad/s; the speed of the tread depends on the radius and is handled in [`unit_candidates`].
const SPIN_UNITS: [Unit; 3] = [
    Unit { factor: 1.0 / std::f64::consts::TAU, name: "revolutions per second" },
    Unit { factor: 60.0 / std::f64::consts::TAU, name: "revolutions per minute" },
    Unit { factor: 57.295_78, name: "deg/s" },
];

/// How many times too large a speed is that is in one unit and read as another, and how that is said.
fn misread() -> impl Iterator<Item = (f64, String)> {
    let pairs = SPEED_UNITS.iter().flat_map(|is| SPEED_UNITS.iter().map(move |read| (is, read)));
    let other = pairs.filter(|(is, read)| is.0 != read.0);
    other.map(|(is, read)| (read.1 / is.1, format!("{} read as {}", is.0, read.0)))
}

/// How near a ratio must be to a unit's, relative: radii are a few per cent off, units more.
const RATIO_TOLERANCE: f64 = 0.08;
/// Units nearer to each other than this are not distinguished from a speed that is off (knots and mph), logarithm.
const DISTINCT: f64 = 0.3;
/// Velocity and track over ground are as fast within this.
const GROUND: f64 = 0.12;
/// Nominal radii are right within this.
const RADIUS_WARN: f64 = 0.10;
/// Beyond this something else is wrong.
const RADIUS_REJECT: f64 = 0.25;
/// A wheel's radius where there is no bike file, m: it decides units, nothing else.
const USUAL: f64 = 0.3;
/// Range of a wheel's speed that counts as none, per that of the bike, both per their level.
const STUCK: f64 = 0.05;

/// One wheel's `v / (omega R)`.
struct Wheel {
    channel: Channel,
    radius: f64,
    ratio: Median,
}

/// Channels that agree with the velocity.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Witnesses {
    /// The track over ground.
    pub ground: bool,
    /// A wheel rolls as the bike file says; it may be in the same wrong unit.
    pub wheel: bool,
}

/// Checks speeds against each other; what agrees with the velocity.
pub(crate) fn check(
    view: &View,
    bike: Option<&Bike>,
    out: &mut Findings<'_>,
) -> Result<Witnesses, Error> {
    let Some(v) = view.get(Channel::VelocityX) else { return Ok(Witnesses::default()) };
    let ahead = view.median(|i| v[i]);
    if let Some(m) = ahead
        && m.value < 0.0
    {
        out.push(Finding {
            code: RejectionCode::SignVelocityX,
            channel: Channel::VelocityX,
            count: m.n,
            message: format!(
                "velocity_x is negative while riding (median {:.1} m/s); forward is positive: \
                 turn its sign in the channel map",
                m.value
            ),
        })?;
    }
    let mut wheels = Vec::new();
    for axle in Axle::BOTH {
        let channel = match axle {
            Axle::Front => Channel::WheelSpeedFront,
            Axle::Rear => Channel::WheelSpeedRear,
        };
        let Some(omega) = view.get(channel) else { continue };
        let radius = bike.map_or(USUAL, |b| b.wheel(axle).radius);
        if let Some(finding) = stuck(view, v, omega, channel) {
            out.push(finding)?;
            continue;
        }
        if let Some(ratio) = view.ratio(|i| v[i], |i| omega[i] * radius, 0.02) {
            wheels.push(Wheel { channel, radius, ratio });
        }
    }
    let rolls = |w: &Wheel| off(w.ratio.value, 1.0) < RADIUS_WARN;
    let by_wheel = wheels.iter().any(rolls);
    let by_ground = over_ground(view, v, by_wheel, out)?;
    judge(&wheels, by_ground, bike.is_some(), out)?;
    Ok(Witnesses { ground: by_ground, wheel: by_wheel && bike.is_some() })
}

/// Velocity against the satellite track: `true` if they agree, a finding if they do not.
fn over_ground(
    view: &View,
    v: &[f64],
    by_wheel: bool,
    out: &mut Findings<'_>,
) -> Result<bool, Error> {
    let Some((speed, _)) = view.track() else { return Ok(false) };
    let Some(ratio) = view.ratio(|i| v[i], |i| speed[i], 0.5) else { return Ok(false) };
    let nearest = misread().map(|(factor, how)| (off(ratio.value, factor), factor, how));
    let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|n| n.0 < RATIO_TOLERANCE);
    let seen =
        format!("it is {:.2} times the speed over ground from latitude and longitude", ratio.value);
    if let Some((_, factor, how)) = &nearest
        && factor.ln().abs() > DISTINCT
    {
        out.push(Finding {
            code: RejectionCode::UnitVelocity,
            channel: Channel::VelocityX,
            count: ratio.n,
            message: format!(
                "velocity_x looks like {how}: {seen}; give its unit in the channel map"
            ),
        })?;
    } else if off(ratio.value, 1.0) > (1.0 + GROUND).ln() {
        // wheels that roll as the bike file says may be in the same wrong unit: they only tell where to look
        let what = match by_wheel {
            true => {
                "the wheels agree with the velocity: check latitude and longitude, and the units of all speeds"
            }
            false => "check its unit and calibration",
        };
        let or = nearest.map_or(String::new(), |n| format!(" (as {})", n.2));
        let contradict = [Channel::VelocityX, Channel::Latitude, Channel::Longitude];
        out.push_contradiction(
            Finding {
                code: RejectionCode::SpeedOverGround,
                channel: Channel::VelocityX,
                count: ratio.n,
                message: format!("velocity_x does not fit the track: {seen}{or}; {what}"),
            },
            &contradict,
        )?;
    }
    Ok(off(ratio.value, 1.0) < RADIUS_WARN)
}

/// How far a ratio is from an expected one, in natural logarithm; infinite for a wrong sign.
fn off(ratio: f64, expected: f64) -> f64 {
    if ratio > 0.0 { (ratio / expected).ln().abs() } else { f64::INFINITY }
}

fn stuck(view: &View, v: &[f64], omega: &[f64], channel: Channel) -> Option<Finding> {
    let spread = |x: &[f64]| {
        let mut x = view.moving(|i| x[i]);
        (!x.is_empty()).then(|| (quantile(&mut x, 0.95) - quantile(&mut x, 0.05), x.len()))
    };
    let (range_v, _) = spread(v)?;
    let (range_omega, n) = spread(omega)?;
    // against its own level: independent of the unit
    let level = view.median(|i| omega[i].abs())?.value;
    let level_v = view.median(|i| v[i])?.value;
    let still = range_omega * level_v <= STUCK * range_v * level.max(1e-9) || level < 1e-6;
    (range_v > 3.0 && still).then(|| Finding {
        code: RejectionCode::Stuck,
        channel,
        count: n,
        message: format!(
            "{channel} stays within {range_omega:.2} rad/s while velocity_x changes by {range_v:.1} \
             m/s: taken as stuck; check the sensor"
        ),
    })
}

/// Wheel speeds against velocity: small deviations are findings, large ones an error that names the
/// likeliest wrong unit.
fn judge(
    wheels: &[Wheel],
    velocity_good: bool,
    radii_known: bool,
    out: &mut Findings<'_>,
) -> Result<(), Error> {
    let bad = |w: &Wheel| off(w.ratio.value, 1.0) > (1.0 + RADIUS_REJECT).ln();
    let suspects: Vec<&Wheel> = wheels.iter().filter(|w| bad(w)).collect();
    if suspects.is_empty() {
        let deviating = |w: &&Wheel| radii_known && (w.ratio.value - 1.0).abs() > RADIUS_WARN;
        for wheel in wheels.iter().filter(deviating) {
            out.push_contradiction(implausible_radius(wheel), &[wheel.channel])?;
        }
        return Ok(());
    }
    if let Some(w) = suspects.iter().find(|w| w.ratio.value < 0.0) {
        return out.push(Finding {
            code: RejectionCode::SignWheelSpeed,
            channel: w.channel,
            count: w.ratio.n,
            message: format!(
                "{} is negative while velocity_x is positive; forward spin is positive: turn its \
                 sign in the channel map",
                w.channel
            ),
        });
    }
    // a unit of the velocity is seen on every wheel
    let velocity_suspect = suspects.len() == wheels.len() && !velocity_good;
    out.push(wrong_unit(&suspects, velocity_suspect))
}

fn implausible_radius(w: &Wheel) -> Finding {
    Finding {
        code: RejectionCode::ImplausibleRadius,
        channel: w.channel,
        count: w.ratio.n,
        message: format!(
            "velocity_x per {} gives a rolling radius of {:.3} m, {:+.0} % off the bike \
             file's {:.3} m; check the tyre there and the calibration of both channels",
            w.channel,
            w.ratio.value * w.radius,
            100.0 * (w.ratio.value - 1.0),
            w.radius
        ),
    }
}

/// The units that would explain the suspects' ratios: distance (natural logarithm), code, name;
/// the nearest first.
fn unit_candidates(
    suspects: &[&Wheel],
    velocity_suspect: bool,
) -> Vec<(f64, RejectionCode, String)> {
    let worst = |expected: &dyn Fn(&Wheel) -> f64| {
        suspects.iter().map(|w| off(w.ratio.value, expected(w))).fold(0.0, f64::max)
    };
    let mut candidates = Vec::new();
    // of equals the first stays first: a unit of the velocity is the simpler account of two wheels
    for (factor, how) in misread().filter(|_| velocity_suspect) {
        candidates.push((worst(&|_| factor), RejectionCode::UnitVelocity, how));
    }
    for (factor, how) in misread() {
        candidates.push((worst(&|_| 1.0 / factor), RejectionCode::UnitWheelSpeed, how));
    }
    for unit in &SPIN_UNITS {
        candidates.push((
            worst(&|_| 1.0 / unit.factor),
            RejectionCode::UnitWheelSpeed,
            unit.name.to_owned(),
        ));
    }
    let tread = "m/s (the speed of the tread, not rad/s)";
    candidates.push((worst(&|w| 1.0 / w.radius), RejectionCode::UnitWheelSpeed, tread.to_owned()));
    candidates.sort_by(|a, b| (1e6 * a.0).round().total_cmp(&(1e6 * b.0).round()));
    candidates
}

/// The finding for wheel speeds that do not fit the velocity, with the likeliest wrong unit.
fn wrong_unit(suspects: &[&Wheel], velocity_suspect: bool) -> Finding {
    let seen = suspects
        .iter()
        .map(|w| {
            format!(
                "velocity_x / {} = {:.3} m against the radius {:.3} m of the bike file",
                w.channel,
                w.ratio.value * w.radius,
                w.radius
            )
        })
        .collect::<Vec<_>>()
        .join(", ");
    let what = |code: RejectionCode| match code {
        RejectionCode::UnitVelocity => "velocity_x".to_owned(),
        _ => suspects.iter().map(|w| w.channel.name()).collect::<Vec<_>>().join(" and "),
    };
    let candidates = unit_candidates(suspects, velocity_suspect);
    if let [(near, code, unit), (next, code2, unit2), ..] = &candidates[..]
        && *near < RATIO_TOLERANCE
    {
        let (next, code) = (*next, *code);
        let or = if next < 1.5 * RATIO_TOLERANCE {
            format!(" (or {} like {unit2})", what(*code2))
        } else {
            String::new()
        };
        let velocity = code == RejectionCode::UnitVelocity;
        return Finding {
            code,
            channel: if velocity { Channel::VelocityX } else { suspects[0].channel },
            count: suspects[0].ratio.n,
            message: format!(
                "{} looks like {unit}{or}: {seen}; give the unit in the channel map",
                what(code)
            ),
        };
    }
    Finding {
        code: RejectionCode::ImplausibleRadius,
        channel: suspects[0].channel,
        count: suspects[0].ratio.n,
        message: format!(
            "wheel and forward speed do not fit each other: {seen}; check the bike file's \
             `front.radius` and `rear.radius`, and both channels' units and calibration"
        ),
    }
}
