//! What no motion decides: constants, flags, copies of other channels, and columns that only a name speaks for.

use super::log::Log;
use super::signal::line;
use super::speeds::Motion;
use super::turning::by_name;
use super::verdict::Verdicts;
use crate::contract::channel::Channel;
use crate::ingest::maps::units;

/// A channel that goes with another like this is the same thing again.
const SAME: f64 = 0.985;
/// ... and like this it is the same number by number.
const EXACT: f64 = 0.9999;

/// Channels that hold nothing, one number, or a flag.
pub(super) fn still(log: &Log<'_>, out: &mut Verdicts) {
    for (place, signal) in log.signals.iter().enumerate() {
        match signal {
            None => out.left.push((place, nothing(log, place).into())),
            Some(s) if s.constant() => {
                out.left.push((place, format!("always {}", s.extent[0])));
                out.constant.push(place);
            }
            Some(s) if s.distinct == 2 && s.whole && !log.is_named(place) => {
                out.left.push((place, format!("only {} and {}: a flag", s.extent[0], s.extent[1])));
            }
            Some(_) => {}
        }
    }
}

/// Why a channel holds nothing: positions that are no degrees were taken out.
fn nothing(log: &Log<'_>, place: usize) -> &'static str {
    let position =
        [Channel::Latitude, Channel::Longitude].iter().any(|c| log.score(place, *c).is_some());
    match position {
        true => {
            "it holds no number that is an angle in degrees; if it is in another scale, give `scale`"
        }
        false => "it holds no number",
    }
}

/// Columns by name and unit alone, and what the channels are that are still without a word.
pub(super) fn others(log: &Log<'_>, motion: &Motion, out: &mut Verdicts) {
    use Channel::*;
    for (column, dimension) in [
        (VelocityY, "speed"),
        (SteerAngle, "angle"),
        (Altitude, "length"),
        (AirTemperature, "temperature"),
        (TyreTemperatureFront, "temperature"),
        (TyreTemperatureRear, "temperature"),
        (TyrePressureFront, "pressure"),
        (TyrePressureRear, "pressure"),
        (SteerTorque, "torque"),
        (BrakeTorqueFront, "torque"),
        (BrakeTorqueRear, "torque"),
        (SlipAngleFront, "angle"),
        (SlipAngleRear, "angle"),
        (WheelForceXFront, "force"),
        (WheelForceXRear, "force"),
        (WheelForceYFront, "force"),
        (WheelForceYRear, "force"),
        (WheelForceZFront, "force"),
        (WheelForceZRear, "force"),
        (WheelMomentXFront, "torque"),
        (WheelMomentXRear, "torque"),
    ] {
        for place in log.named(column) {
            let taken =
                out.entries.iter().any(|e| e.source == place) || out.left_out(place).is_some();
            if taken || log.of_other_dimension(place, &[dimension]) {
                continue;
            }
            let mut v = by_name(log, column, place, dimension);
            v = match column {
                SteerAngle | VelocityY | SteerTorque | SlipAngleFront | SlipAngleRear
                | WheelForceXFront | WheelForceXRear | WheelForceYFront | WheelForceYRear
                | WheelMomentXFront | WheelMomentXRear | BrakeTorqueFront | BrakeTorqueRear => {
                    v.doubted("by its name alone: the motion does not show its sign")
                }
                _ => v.because("by its name and unit; no motion to compare it with"),
            };
            if out.entries.iter().any(|e| e.channel == column && e.doubt.is_none()) {
                v = v.doubted("there is more than one such channel");
            }
            out.entries.push(v);
        }
    }
    laps(log, out);
    for place in 0..log.channels.len() {
        let taken = out.entries.iter().any(|e| e.source == place) || out.left_out(place).is_some();
        if taken || log.live(place).is_none() {
            continue;
        }
        let why = copy(log, motion, place, out).unwrap_or_else(|| unlike(log, motion, place));
        out.left.push((place, why));
    }
}

/// A counter of laps: whole numbers that never fall.
fn laps(log: &Log<'_>, out: &mut Verdicts) {
    for place in log.named(Channel::LapNumber) {
        let Some(signal) = log.live(place).filter(|s| s.whole) else { continue };
        let x: Vec<f64> = log.x(place).iter().copied().filter(|x| x.is_finite()).collect();
        if log.of_other_dimension(place, &["ratio"]) || x.windows(2).any(|w| w[1] < w[0]) {
            continue;
        }
        let [first, last] = signal.extent;
        let mut v = by_name(log, Channel::LapNumber, place, "ratio")
            .because(format!("it counts from {first} to {last} and never falls"));
        if out.sure(Channel::LapNumber).is_some() {
            v = v.doubted("there is more than one such channel");
        }
        out.entries.push(v);
    }
}

/// Channel that is repeated: a raw voltage, a target, the same in another unit.
fn copy(log: &Log<'_>, motion: &Motion, place: usize, out: &Verdicts) -> Option<String> {
    use Channel::{VelocityX, WheelSpeedFront, WheelSpeedRear};
    let x = log.x(place);
    let best = out
        .entries
        .iter()
        .filter_map(|e| Some((e, line(log.x(e.source), x)?)))
        .filter(|(_, l)| l.r.abs() > SAME)
        .max_by(|a, b| a.1.r.abs().total_cmp(&b.1.r.abs()))?;
    let (entry, l) = best;
    let high = super::signal::quantile(x, 0.98).abs();
    let name = log.name(entry.source);
    let offset = l.offset.abs() > 0.02 * high;
    let of_speed = [VelocityX, WheelSpeedFront, WheelSpeedRear].contains(&entry.channel);
    if of_speed && !offset && l.r < EXACT {
        let radius = radius(log, motion, place).map_or(String::new(), |said| format!(" ({said})"));
        return Some(format!(
            "goes with `{name}` (r = {:.4}), but is not the same: a wheel's speed, by a name that is not known, or a \
             filtered one{radius}; if it is a wheel's, enter it as wheel_speed_front or wheel_speed_rear",
            l.r
        ));
    }
    Some(match offset {
        true => format!(
            "goes with `{name}` (r = {:.4}) as {:.4} times it {:+.3}: its raw signal, or the same in another unit",
            l.r, l.slope, l.offset
        ),
        false => format!(
            "goes with `{name}` (r = {:.4}), {:.3} times as much: a target or the same again",
            l.r, l.slope
        ),
    })
}

/// The radius of a wheel that spins like this in the log's own unit, for people.
fn radius(log: &Log<'_>, motion: &Motion, place: usize) -> Option<String> {
    let unit = log.unit(place, "angular rate")?;
    let factor = units::conversion("rad/s", unit).ok()?.factor;
    let slope = line(&motion.speed, log.x(place))?.slope;
    Some(format!("in {unit} its radius would be {:.3} m", factor / slope))
}

fn unlike(log: &Log<'_>, motion: &Motion, place: usize) -> String {
    let named: Vec<&str> = super::super::words::RULES
        .iter()
        .filter(|r| log.score(place, r.channel).is_some())
        .map(|r| r.channel.name())
        .collect();
    let r = line(&motion.speed, log.x(place)).map_or(0.0, |l| l.r);
    if named.is_empty() {
        format!("no column by name or motion (r = {r:.2} with the speed)")
    } else if fits(log, place) {
        format!(
            "named like {}, but the motion disagrees with it (r = {r:.2} with the speed); does a \
             number in it stand for none, or does it jump? Name such numbers in `csv.missing`",
            named.join(", ")
        )
    } else {
        format!("named like {}, but its unit measures something else", named.join(", "))
    }
}

/// Whether a channel's unit is that of the column of the same name, or unknown.
fn fits(log: &Log<'_>, place: usize) -> bool {
    let unit = log.channels[place].unit.as_deref().and_then(units::dimension);
    let named = |r: &&super::super::words::Rule| log.score(place, r.channel).is_some();
    let mut rules = super::super::words::RULES.iter().filter(named);
    unit.is_none_or(|unit| rules.any(|r| r.dimension == unit))
}
