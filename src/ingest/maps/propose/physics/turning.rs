//! Course, yaw rate and lean: they turn with the path.
//!
//! ```text
//! (1)  yaw rate = d(course)/dt        (2)  tan(roll) = -v r / g
//! ```

use super::calculated;
use super::course::{BY_POSITION, course};
use super::delay::{Delay, delay};
use super::log::{Log, unit_of};
use super::mirrored;
use super::signal::{change, earlier, line, mean};
use super::speed::SPAN;
use super::speeds::{MOVING, Motion};
use super::verdict::{Verdict, Verdicts, unknown};
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::ingest::maps::units;
use crate::statistics::order;

/// Units of leans that loggers write, whole numbers of a fraction of a degree included.
const LEANS: [&str; 4] = ["deg", "rad", "0.1 deg", "0.01 deg"];
pub(super) const RATES: [&str; 2] = ["deg/s", "rad/s"];
/// A motorcycle leans by this much more than its centre of mass would have to: tyres are wide.
const TYRES: f64 = 1.08;
/// Corners that tell whether a gyroscope leans with the bike, rad of lean.
const LEANING: f64 = 0.45;
/// A gyroscope is taken to be late only beyond so many standard errors: boxes seldom are.
const FAR: f64 = 4.0;
/// The frame leans and yaws before the path of a receiver turns, by about this, s.
pub(super) const LEADS: f64 = 0.02;
/// A lean that follows from speed and turn within this share of its size is calculated.
const TOO_PERFECT: f64 = 0.045;
/// ... and is as large within this: tyres are wide, and a measured lean is 2.5 to 7 % larger.
const AS_LARGE: f64 = 0.02;

/// A lean that is not larger than this share of what the turn asks for may be calculated.
const LARGER: f64 = 1.015;

/// A lean that says more than this upright is not counted from there, deg: no sensor is mounted that badly ...
const COUNTED: f64 = 25.0;
/// ... and within this of a quarter turn it is counted from that.
const NEAR_QUARTER: f64 = 4.0;

/// How much faster a wheel turns by its crown: `v = w R (1 - CROWN (1 - cos(roll)))`.
const CROWN: f64 = 0.2;
/// Two leans that go with each other like this are one, as the sensor has it and as somebody made it.
const SAME: f64 = 0.98;
/// A step that is fine whatever the other's is, rad.
const FINE: f64 = 0.002;

/// Finds what turns; gives the motion its rate of turn.
pub(super) fn turning(log: &Log<'_>, motion: &mut Motion, out: &mut Verdicts) {
    let receiver = motion.receiver;
    if let Some(position) = &motion.position {
        let late = motion.after_wheels(&position.speed);
        let turn = change(&position.course, SPAN);
        let late = late.filter(|_| receiver.is_some());
        placed(log, motion, late, out);
        let mut turn = earlier(&turn, late.map_or(0.0, |d| d.value));
        let mirror = mirrored::mirrored(log, position, &turn);
        motion.turn_from = "the path of the position".into();
        if let Some((channel, course)) = mirror {
            mirrored::doubt(channel, &course, out);
            turn.iter_mut().for_each(|w| *w = -*w);
            motion.turn_from += " (mirrored)";
        }
        motion.turn = Some(turn);
    }
    course(log, motion, out);
    let gyro = yaw_rate(log, motion, out);
    lean(log, motion, gyro.as_ref(), out);
    if let Some(turn) = &motion.turn {
        motion.lateral = turn
            .iter()
            .zip(&motion.speed)
            .map(|(w, v)| if w.is_finite() && v.is_finite() { w * v } else { 0.0 })
            .collect();
    }
}

/// Latitude and longitude; what agrees with a speed in a known unit is in degrees.
fn placed(log: &Log<'_>, motion: &Motion, late: Option<Delay>, out: &mut Verdicts) {
    let Some(position) = &motion.position else { return };
    let columns = [Channel::Latitude, Channel::Longitude];
    let of_speed = [Channel::VelocityX, Channel::WheelSpeedFront, Channel::WheelSpeedRear];
    let speed = out.entries.iter().any(|e| e.confirmed && of_speed.contains(&e.channel));
    for (column, place) in columns.into_iter().zip(position.places) {
        let own = log.unit(place, "angle");
        let mut v =
            Verdict { confirmed: true, ..Verdict::new(column, place, own.unwrap_or("deg")) };
        if let Some(late) = late {
            (v.delay, v.delay_error) = (late.value, Some(late.error));
        }
        v = match (own, speed) {
            (_, true) => v.because("its path gives the speed of the other channels"),
            (Some(_), false) => v.because("by name and unit; no speed to compare it with"),
            (None, false) => v.doubted("the log does not say its unit, and no speed shows it"),
        };
        out.entries.push(v);
    }
}

/// A gyroscope about the vertical, or about the frame's own.
pub(super) struct Gyro {
    /// rad/s, to the left, over a second.
    rate: Vec<f64>,
    /// Whether it leans with the frame.
    leans: bool,
    /// After the motion and its standard error, s.
    late: (f64, f64),
    name: String,
}

fn yaw_rate(log: &Log<'_>, motion: &Motion, out: &mut Verdicts) -> Option<Gyro> {
    let mut gyro = None;
    let Some(reference) = &motion.turn else {
        for place in log.named(Channel::YawRate) {
            out.entries.push(
                by_name(log, Channel::YawRate, place, "angular rate").doubted(
                    "nothing else in the log turns: neither its sign nor its frame is known",
                ),
            );
        }
        return None;
    };
    let bend = |i: usize| (motion.speed[i] * reference[i] / GRAVITY).atan().abs();
    for place in log.named(Channel::YawRate) {
        let own = log.unit(place, "angular rate");
        if log.of_other_dimension(place, &["angular rate"]) {
            continue;
        }
        let x = mean(log.x(place), SPAN);
        let late = delay(reference, &x);
        let x = earlier(&x, late.map_or(0.0, |d| d.value));
        // mild corners are short, and a receiver swings with the roll there
        let steep = |i: usize| if bend(i) > LEANING { x[i] / reference[i] } else { f64::NAN };
        let mut ratios = order::finite((0..x.len()).map(steep));
        let steep = (ratios.len() > 60).then(|| order::median(&mut ratios)).flatten();
        let upright = order::finite((0..x.len()).map(bend).filter(|b| *b > LEANING));
        let leaning = order::median_of_finite(&upright).map_or(1.0, |b| (TYRES * b).cos());
        let whole = line(reference, &x);
        let Some(whole) = whole.filter(|l| l.r.abs() > 0.8) else {
            let r = whole.map_or(0.0, |l| l.r);
            out.left.push((place, format!(
                "named like yaw_rate, but it does not turn with {} (r = {r:.2}): the unit is not upright in the frame, or it is another axis",
                motion.turn_from
            )));
            continue;
        };
        let slope = steep.unwrap_or(whole.slope);
        let unit = unit_of(own, "rad/s", &RATES, slope, 0.8);
        let factor = unit.as_ref().and_then(|u| units::conversion("rad/s", &u.name).ok());
        let share = factor.map(|f| slope.abs() / f.factor);
        let mut v = Verdict::new(
            Channel::YawRate,
            place,
            unit.as_ref().map_or(own.unwrap_or("?"), |u| &u.name),
        );
        v.sign = slope.signum();
        v.confirmed = true;
        (v.delay, v.delay_error) = late.map_or((0.0, None), |d| (d.value, Some(d.error)));
        v = v.because(format!("r = {:.4} with the turn of {}", whole.r, motion.turn_from));
        let Some(unit) = unit else {
            out.left.push((place, format!(
                "it turns with {} (r = {:.2}), but by {slope:.3} of its numbers per rad/s: turned axes, or no unit that is known",
                motion.turn_from, whole.r
            )));
            continue;
        };
        let share = share.unwrap_or(1.0);
        let upright = (share - 1.0).abs() < 0.07;
        let leans = steep.is_some() && !upright && (share - leaning).abs() < 0.1;
        if steep.is_some() && !upright && !leans {
            out.left.push((place, format!(
                "it turns with {} (r = {:.2}), but by {share:.2} of the turn in steep corners: neither about the vertical nor the frame's own axis",
                motion.turn_from, whole.r
            )));
            continue;
        }
        let factor =
            units::conversion("rad/s", &unit.name).map_or(1.0, |c| c.factor) * slope.signum();
        if leans {
            v = v.doubted(format!(
                "it leans with the frame: in steep corners it is {share:.2} of the turn, as the cosine of the lean; the yaw rate is about the vertical"
            ));
        }
        if steep.is_none() {
            v = v.because("no corners steep enough to show whether it leans with the frame");
        }
        if let Some(not) = &unit.not {
            v = v.because(format!("not in {not}, as the log says"));
        }
        let late = if leans {
            let frame: Vec<f64> =
                (0..reference.len()).map(|i| reference[i] * (TYRES * bend(i)).cos()).collect();
            delay(&frame, &mean(log.x(place), SPAN))
        } else {
            late
        };
        let late = late.map(|d| Delay { error: d.error.hypot(BY_POSITION), ..d });
        (v.delay, v.delay_error) = late.map_or((0.0, None), |d| (d.value, Some(d.error)));
        let x = earlier(&mean(log.x(place), SPAN), late.map_or(0.0, |d| d.value));
        if gyro.is_none() {
            gyro = Some(Gyro {
                rate: x.iter().map(|x| x / factor).collect(),
                leans,
                late: late.map_or((0.0, 0.0), |d| {
                    if d.value.abs() > FAR * d.error { (d.value, d.error) } else { (0.0, d.error) }
                }),
                name: log.name(place),
            });
        } else {
            v = v.doubted("there is more than one such channel");
        }
        out.entries.push(v);
    }
    gyro
}

/// The lean that speed over ground and turn ask for, rad.
fn ideal_lean(motion: &Motion, turn: &[f64], gyro: Option<&Gyro>) -> Vec<f64> {
    let lean = |v: f64, i: usize| match gyro {
        // of a gyroscope that leans: v r = v r_frame / cos(roll)
        Some(g) if g.leans => {
            let sine = -v * g.rate[i] / GRAVITY;
            if sine.abs() < 0.97 { sine.asin() } else { f64::NAN }
        }
        Some(g) => -(v * g.rate[i] / GRAVITY).atan(),
        None => -(v * turn[i] / GRAVITY).atan(),
    };
    let by_wheel = motion.ground == motion.speed && motion.wheels.iter().any(Option::is_some);
    let of = |i: usize| {
        let v = motion.ground[i];
        if v.is_nan() || v < MOVING {
            return f64::NAN;
        }
        // a wheel runs faster than the ground where it rolls on the side of its crown
        match by_wheel {
            true => lean(v * (1.0 - CROWN * (1.0 - lean(v, i).cos())), i),
            false => lean(v, i),
        }
    };
    (0..turn.len()).map(of).collect()
}

/// Reading of a lean upright, in its own unit, where that is no error of its zero but another way to count: from the
/// horizontal, say. `factor` of its numbers are 1 rad.
fn upright(offset: f64, factor: f64) -> Option<f64> {
    let degrees = (offset / factor).to_degrees();
    if degrees.abs() < COUNTED {
        return None;
    }
    let quarter = 90.0 * (degrees / 90.0).round();
    let degrees = if (degrees - quarter).abs() < NEAR_QUARTER { quarter } else { degrees };
    let own = degrees.to_radians() * factor;
    // to a hundredth of a degree, in a number that can be read
    let digits = 10.0_f64.powf(2.0 - (factor.to_radians()).log10().floor());
    Some((own * digits).round() / digits)
}

/// How coarse a channel of leans is: the share of the ride that it rests at zero, and its step in rad.
fn coarseness(log: &Log<'_>, motion: &Motion, place: usize, factor: f64) -> (f64, f64) {
    let rides = |i: &usize| motion.ground.get(*i).is_some_and(|v| *v > MOVING);
    let x = log.x(place);
    let all: Vec<f64> = (0..x.len()).filter(rides).map(|i| x[i]).collect();
    let rest = all.iter().filter(|x| **x == 0.0).count() as f64 / all.len().max(1) as f64;
    (rest, log.live(place).map_or(0.0, |s| s.step) / factor)
}

/// Whether one of two channels of one lean is the coarser: it rests at zero, or it is rounded.
fn coarser(a: (f64, f64), b: (f64, f64)) -> bool {
    match (a.0 - b.0).abs() > 0.02 {
        true => a.0 > b.0,
        false => a.1 > 3.0 * b.1 && a.1 > FINE,
    }
}

/// Lean, its rate, pitch and its rate.
fn lean(log: &Log<'_>, motion: &Motion, gyro: Option<&Gyro>, out: &mut Verdicts) {
    let expected = motion.turn.as_ref().map(|turn| ideal_lean(motion, turn, gyro));
    let from = gyro.map_or(motion.turn_from.clone(), |g| format!("`{}`", g.name));
    let receiver = motion.receiver.map(|d| (d.value, d.error));
    let first = out.entries.len();
    for place in log.named(Channel::Roll) {
        if log.of_other_dimension(place, &["angle"]) {
            continue;
        }
        let own = log.unit(place, "angle");
        let Some(expected) = &expected else {
            out.entries.push(by_name(log, Channel::Roll, place, "angle")
                .doubted("nothing else in the log turns: neither its sign nor whether it is measured is known"));
            continue;
        };
        let x = mean(log.x(place), SPAN);
        let late = delay(expected, &x);
        let shifted = earlier(&x, late.map_or(0.0, |d| d.value));
        let Some(l) = line(expected, &shifted).filter(|l| l.r.abs() > 0.9) else {
            out.left.push((
                place,
                format!("named like roll, but it does not lean as v x turn of {from} asks for"),
            ));
            continue;
        };
        let Some(unit) = unit_of(own, "rad", &LEANS, l.slope, 0.35) else {
            out.left.push((
                place,
                format!(
                    "it leans with the corners (r = {:.2}), but neither in degrees nor rad",
                    l.r
                ),
            ));
            continue;
        };
        let factor = units::conversion("rad", &unit.name).map_or(1.0, |c| c.factor);
        let mut v = Verdict { confirmed: true, ..Verdict::new(Channel::Roll, place, &unit.name) };
        v.sign = l.slope.signum();
        if let Some(upright) = upright(l.offset, factor) {
            v.offset = -upright;
            v = v.because(format!("upright it says {upright}: taken off"));
        }
        let after = gyro.map_or(receiver, |g| Some(g.late));
        (v.delay, v.delay_error) = late.map_or((0.0, None), |d| {
            (
                d.value + gyro.map_or(0.0, |g| g.late.0),
                Some(d.error.hypot(after.map_or(0.0, |l| l.1)).hypot(LEADS)),
            )
        });
        let size = l.slope.abs() / factor;
        let side = if l.slope > 0.0 { "right" } else { "left" };
        let off = l.rms / l.slope.abs() / spread(expected);
        v = v.because(format!(
            "r = {:.4} with the lean that v x turn of {from} asks for, {size:.2} times as much; positive to the {side}",
            l.r
        ));
        if let Some(not) = &unit.not {
            v = v.because(format!("not in {not}, as the log says"));
        }
        let calculated = ["calc", "calculated", "computed"].iter().any(|w| log.has_word(place, w))
            || log.channels[place].group.contains("calc");
        if calculated {
            v = v.doubted(format!(
                "by its name it is calculated: it is no measurement ({:.1} % off v x turn / g)",
                100.0 * off
            ));
        } else if let Some((name, off)) = calculated::lateral(log, place, factor)
            && size < 1.0 + AS_LARGE
        {
            v = v.doubted(format!(
                "it is atan(`{name}` / g) within {:.1} %: no measurement, it is calculated from that",
                100.0 * off
            ));
        } else if off < TOO_PERFECT && (size - 1.0).abs() < AS_LARGE {
            v = v.doubted(format!(
                "it agrees with atan(v x turn / g) within {:.1} %: too perfect for a measurement, it is calculated", 100.0 * off
            ));
        } else if size / (l.r * l.r) < LARGER {
            // by r, as an error of the turn makes the lean look smaller
            v.confirmed = false;
            v = v.doubted(
                "no larger than the turn asks for, where a measured lean is 2.5 to 7 % larger \
                 (tyres are wide): it may be calculated; use it if an inertial unit measures it",
            );
        } else {
            v = v.because(format!("off it by {:.1} %: measured", 100.0 * off));
        }
        out.entries.push(v);
    }
    let best = finest(log, motion, first, out);
    roll_rate(log, best.as_deref(), gyro, out);
    for (column, dimension) in [(Channel::Pitch, "angle"), (Channel::PitchRate, "angular rate")] {
        for place in log.named(column) {
            if log.of_other_dimension(place, &[dimension]) {
                continue;
            }
            let v = by_name(log, column, place, dimension);
            let leans = column == Channel::PitchRate
                && gyro.is_some_and(|g| g.leans && same_unit(log, place, &g.name));
            out.entries.push(if leans {
                v.doubted("its unit leans with the frame: it measures a share of the turn, too")
            } else {
                v.doubted("by its name alone: pitch moves too little to check its sign and frame")
            });
        }
    }
}

/// Of several leans the finest is the column; what repeats a finer one is what that is. Gives its samples, rad.
fn finest(log: &Log<'_>, motion: &Motion, first: usize, out: &mut Verdicts) -> Option<Vec<f64>> {
    let factor = |v: &Verdict| units::conversion("rad", &v.unit).map_or(1.0, |c| c.factor);
    let mut leans: Vec<Verdict> = out.entries.drain(first..).collect();
    let coarse: Vec<(f64, f64)> =
        leans.iter().map(|v| coarseness(log, motion, v.source, factor(v))).collect();
    for k in 0..leans.len() {
        let repeats = |j: &usize| {
            let (a, b) = (log.x(leans[*j].source), log.x(leans[k].source));
            coarser(coarse[k], coarse[*j]) && line(a, b).is_some_and(|l| l.r.abs() > SAME)
        };
        if let Some(j) = (0..leans.len()).find(repeats) {
            let name = log.name(leans[j].source);
            let what = "rounded or held at zero when it is small";
            leans[k].doubt.get_or_insert(format!("it is `{name}` again, {what}"));
        }
    }
    let best = leans.iter().position(|v| v.doubt.is_none());
    for (k, v) in leans.iter_mut().enumerate() {
        if best.is_some_and(|b| b != k) {
            v.doubt.get_or_insert("there is more than one such channel".into());
        }
    }
    let samples = best.map(|b| {
        let sign = leans[b].sign / factor(&leans[b]);
        log.x(leans[b].source).iter().map(|x| sign * x).collect()
    });
    out.entries.extend(leans);
    samples
}

/// Whether a channel seems to be of the same sensor as that of a name: they begin or end alike.
fn same_unit(log: &Log<'_>, place: usize, other: &str) -> bool {
    let name = log.name(place).to_lowercase();
    let other = other.to_lowercase();
    let ends = name.bytes().rev().zip(other.bytes().rev()).take_while(|(a, b)| a == b).count();
    let begins = name.bytes().zip(other.bytes()).take_while(|(a, b)| a == b).count();
    begins.max(ends) >= 3
}

fn spread(x: &[f64]) -> f64 {
    let finite: Vec<f64> = x.iter().copied().filter(|v| v.is_finite()).collect();
    (finite.iter().map(|v| v * v).sum::<f64>() / finite.len().max(1) as f64).sqrt()
}

fn roll_rate(log: &Log<'_>, lean: Option<&[f64]>, gyro: Option<&Gyro>, out: &mut Verdicts) {
    for place in log.named(Channel::RollRate) {
        if log.of_other_dimension(place, &["angular rate"]) {
            continue;
        }
        let own = log.unit(place, "angular rate");
        let Some(lean) = lean else {
            out.entries.push(by_name(log, Channel::RollRate, place, "angular rate").doubted(
                "no measured lean to compare it with: neither its sign nor its axis is known",
            ));
            continue;
        };
        let (reference, x) = (change(lean, 3), mean(log.x(place), 3));
        // the gyroscope is the faster of the two: what is late is the lean
        let late = delay(&x, &reference);
        let shifted = earlier(&reference, late.map_or(0.0, |d| d.value));
        let Some(l) = line(&shifted, &x).filter(|l| l.r.abs() > 0.9) else {
            out.left.push((
                place,
                "named like roll_rate, but it disagrees with the change of the lean".into(),
            ));
            continue;
        };
        let Some(unit) = unit_of(own, "rad/s", &RATES, l.slope, 0.12) else {
            out.left.push((place, format!("it goes with the change of the lean (r = {:.2}), but by {:.3} of its numbers per rad/s", l.r, l.slope)));
            continue;
        };
        let mut v =
            Verdict { confirmed: true, ..Verdict::new(Channel::RollRate, place, &unit.name) };
        v.sign = l.slope.signum();
        v = v.because(format!("r = {:.4} with the change of the lean", l.r));
        if let Some(not) = &unit.not {
            v = v.because(format!("not in {not}, as the log says"));
        }
        let after_gyro = gyro.map_or(0.0, |g| g.late.0);
        if let Some(late) = late
            && let Some(roll) =
                out.entries.iter_mut().find(|e| e.channel == Channel::Roll && e.doubt.is_none())
            && roll.delay_error.is_none_or(|e| late.error < e)
        {
            roll.delay = late.value + after_gyro;
            roll.delay_error = Some(late.error.max(0.002));
        }
        v.delay = after_gyro;
        v.delay_error = gyro.map(|g| g.late.1);
        if out.entries.iter().any(|e| e.channel == Channel::RollRate) {
            v = v.doubted("there is more than one such channel");
        }
        out.entries.push(v);
    }
}

/// An entry that only its name and unit speak for.
pub(super) fn by_name(log: &Log<'_>, column: Channel, place: usize, dimension: &str) -> Verdict {
    let own = log.unit(place, dimension);
    let v = Verdict::new(column, place, own.unwrap_or("?"));
    match own {
        Some(_) => v,
        None if dimension == "ratio" => Verdict { unit: "1".into(), ..v },
        None => match log.unknown_unit(place) {
            Some(unit) => v.doubted(unknown(unit)),
            None => v.doubted("the log does not say its unit"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lean_may_be_counted_from_the_horizontal() {
        let degree = 1.0_f64.to_degrees();
        assert_eq!(upright(90.8, degree), Some(90.0));
        assert_eq!(upright(-179.2, degree), Some(-180.0));
        assert_eq!(upright(9130.0, 100.0 * degree), Some(9000.0));
        assert!(upright(1.56, 1.0).is_some_and(|x| (x - 90.0_f64.to_radians()).abs() < 1e-4));
        assert_eq!(upright(40.123, degree), Some(40.12));
        assert_eq!(upright(5.0, degree), None, "a zero that is off");
    }
}
