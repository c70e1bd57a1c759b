//! Position, speed over ground and the wheels' speeds: they go with each other.

use super::delay::Delay;
use super::ground::velocity;
use super::lag::{Wheel, lag};
use super::log::{Log, unit_of};
use super::signal::{self, RATE, change, line, mean, regression};
use super::speed::{SPAN, SPEEDS, Speed, called, in_si, is_wheel};
use super::verdict::{FAR, Verdict, Verdicts};
use super::wheel;
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::geodesy::metres_per_degree;
use crate::ingest::checks::coarse::COARSE;
use crate::ingest::maps::units;

/// Above this the bike moves, m/s.
pub(super) const MOVING: f64 = 3.0;
/// Least correlation with the speed of a channel that is a speed.
const ALIKE: f64 = 0.97;
/// The same of a channel with the name of a wheel: wheels slip.
const WHEEL_ALIKE: f64 = 0.93;
/// Reference of the others: both wheels are one sensor's, their clocks differ by less than this, s.
const REFERENCE: f64 = 0.02;
/// Faster than any motorcycle: a position that jumps, m/s.
const FASTEST: f64 = 120.0;
/// Points of a position that froze, at least: 2 s.
const FROZEN: usize = 40;
/// Share of the time that positions may jump.
const JUMPS: f64 = 0.15;
/// Share of the time that a speed may be off the reference, a dropout, a stop of the receiver.
const OFF: f64 = 0.1;

/// Where the log says it was.
pub(super) struct Position {
    pub places: [usize; 2],
    /// Speed over ground, m/s, over a second.
    pub speed: Vec<f64>,
    /// Direction, rad, to the left, without jumps; NaN at rest.
    pub course: Vec<f64>,
}

/// The motion that every other channel is compared with, on the clock of the wheels, or of the speed without wheels.
pub(super) struct Motion {
    /// Speed, m/s.
    pub speed: Vec<f64>,
    /// Speed over ground, m/s: the receiver's without its delay where the log has one. The same as `speed` without wheels.
    pub ground: Vec<f64>,
    /// Acceleration, m/s².
    pub acceleration: Vec<f64>,
    /// The same of the speed over ground where the log has one: free of slip.
    pub pull: Vec<f64>,
    /// Rate of turn, rad/s, to the left, over a second; `None` where nothing tells.
    pub turn: Option<Vec<f64>>,
    /// Source of the turn.
    pub turn_from: String,
    /// Lateral acceleration, m/s²; zeros where it is not known.
    pub lateral: Vec<f64>,
    /// Speeds by the wheels' spin, m/s, front and rear.
    pub wheels: [Option<Vec<f64>>; 2],
    pub position: Option<Position>,
    /// Delay of the satellite receiver after the wheels.
    pub receiver: Option<Delay>,
}

/// Position from latitude and longitude, if the log has them in degrees.
pub(super) fn position(log: &Log<'_>) -> Option<Position> {
    let lat = *log.named(Channel::Latitude).first()?;
    let lon = *log.named(Channel::Longitude).first()?;
    let degrees = |place: usize| {
        let unit = log.unit(place, "angle").unwrap_or("deg");
        units::conversion(unit, "deg").map_or(1.0, |c| c.factor)
    };
    let (fa, fo) = (degrees(lat), degrees(lon));
    let [north, east] = metres_per_degree(signal::quantile(log.x(lat), 0.5) * fa);
    let metres = |place: usize, factor: f64| -> Vec<f64> {
        log.x(place).iter().map(|x| x * factor).collect()
    };
    let [mut y, mut x] = [metres(lat, fa * north), metres(lon, fo * east)];
    without_frozen(&mut y, &mut x);
    let [vn, ve] = [change(&y, SPAN), change(&x, SPAN)];
    let whole: Vec<f64> = vn.iter().zip(&ve).map(|(n, e)| n.hypot(*e)).collect();
    // a position that jumps is none there, and one that jumps often is none at all
    let sane = |v: f64| !v.is_finite() || v < FASTEST;
    let there = whole.iter().filter(|v| v.is_finite()).count();
    let jumps = whole.iter().filter(|v| !sane(**v)).count();
    let speed = signal::masked(&whole, |i| sane(whole[i]));
    let direction: Vec<f64> = vn
        .iter()
        .zip(&ve)
        .map(
            |(n, e)| if n.hypot(*e) > MOVING && sane(n.hypot(*e)) { n.atan2(*e) } else { f64::NAN },
        )
        .collect();
    let moving = speed.iter().filter(|v| **v > MOVING).count() as f64 / RATE;
    (moving > 20.0 && jumps as f64 <= JUMPS * there as f64).then(|| Position {
        places: [lat, lon],
        course: signal::unwrapped(&direction, std::f64::consts::TAU),
        speed,
    })
}

/// Whether the position is rounded too coarsely to tell a speed; its columns are by name then.
fn coarse(log: &Log<'_>, out: &mut Verdicts) -> bool {
    let columns = [Channel::Latitude, Channel::Longitude];
    let places = columns.map(|c| log.named(c).first().copied());
    let [Some(lat), Some(lon)] = places else { return false };
    let degrees = |place: usize| {
        let unit = log.unit(place, "angle").unwrap_or("deg");
        units::conversion(unit, "deg").map_or(1.0, |c| c.factor)
    };
    let metres = metres_per_degree(signal::quantile(log.x(lat), 0.5) * degrees(lat));
    let step = |place: usize, metres: f64| {
        log.live(place).map_or(0.0, |s| s.step * degrees(place) * metres)
    };
    let steps = [step(lat, metres[0]), step(lon, metres[1])];
    if !steps.iter().all(|s| *s > COARSE) {
        return false;
    }
    let rounded = format!("rounded to {:.0} m", steps[0].max(steps[1]));
    out.remarks.push(format!(
        "the position is {rounded}: too coarse to compare speeds and corners with; write it with seven decimals of a degree"
    ));
    for (column, place) in columns.into_iter().zip([lat, lon]) {
        let own = log.unit(place, "angle");
        let v = Verdict::new(column, place, own.unwrap_or("deg")).because(format!(
            "by its name: {rounded}, it shows where the ride was and not how fast"
        ));
        out.entries.push(match own {
            Some(_) => v,
            None => v.doubted("the log does not say its unit, and its path shows none"),
        });
    }
    true
}

/// Takes positions out that froze: they rest, and then jump as no motorcycle moves.
fn without_frozen(y: &mut [f64], x: &mut [f64]) {
    let hops: Vec<f64> =
        y.windows(2).zip(x.windows(2)).map(|(y, x)| (y[1] - y[0]).hypot(x[1] - x[0])).collect();
    let far = |hop: &f64| *hop > FASTEST / RATE;
    let mut at = 0;
    for run in hops.chunk_by(|a, b| (*a == 0.0) == (*b == 0.0)) {
        let end = at + run.len();
        let jump = hops[end..].iter().take_while(|hop| far(hop)).count();
        if run[0] == 0.0 && run.len() >= FROZEN && jump > 0 {
            // its first point is that of the last fix; a line was drawn along the jump
            y[at + 1..end + jump].fill(f64::NAN);
            x[at + 1..end + jump].fill(f64::NAN);
        }
        at = end;
    }
}

/// Every channel that is a speed, by the reference (m/s, over a second) where the bike goes straight.
fn alike(log: &Log<'_>, reference: &[f64], straight: impl Fn(usize) -> bool) -> Vec<Speed> {
    let upright = signal::masked(reference, |i| reference[i] > MOVING && straight(i));
    let all = signal::masked(reference, |i| reference[i].is_finite());
    let look = |place: usize| {
        log.live(place).filter(|s| s.distinct >= 12)?;
        let x = mean(log.x(place), SPAN);
        let least = if is_wheel(log, place) { WHEEL_ALIKE } else { ALIKE };
        let found = line(&all, &x)
            .filter(|l| l.r > least)
            .or_else(|| line_without_dropouts(&all, &x).filter(|l| l.r > least))?;
        // as straight riding is only a part: the ratio, not the line
        let ratios: Vec<f64> = upright.iter().zip(&x).map(|(v, x)| x / v).collect();
        let slope = signal::quantile(&ratios, 0.5);
        let high = signal::quantile(&x, 0.95).abs();
        (found.offset.abs() < 0.12 * high).then_some(Speed { place, slope, r: found.r })
    };
    (0..log.channels.len()).filter_map(look).collect()
}

/// The line through a speed that goes with the reference but for a little while.
fn line_without_dropouts(reference: &[f64], x: &[f64]) -> Option<signal::Line> {
    let ratios: Vec<f64> =
        reference.iter().zip(x).map(|(v, x)| if *v > MOVING { x / v } else { f64::NAN }).collect();
    let slope = signal::quantile(&ratios, 0.5);
    // a reference that rests while the other moves is off as well
    let rests = |i: usize| reference[i] <= MOVING && x[i] / slope > 2.0 * MOVING;
    let off = |i: usize| (ratios[i] / slope - 1.0).abs() > 0.25 || rests(i);
    let there = (0..ratios.len()).filter(|&i| ratios[i].is_finite() || rests(i)).count();
    let lost = (0..ratios.len()).filter(|&i| off(i)).count();
    let near = signal::masked(x, |i| !off(i));
    (lost as f64 <= OFF * there as f64).then(|| line(reference, &near))?
}

/// Speed over ground and wheels, and the reference of all other channels; `None` where the log has no speed.
pub(super) fn speeds(log: &Log<'_>, radii: Option<[f64; 2]>, out: &mut Verdicts) -> Option<Motion> {
    let position = if coarse(log, out) { None } else { position(log) };
    let (reference, from) = match &position {
        Some(p) => (p.speed.clone(), "speed over ground from the position".to_owned()),
        None => named_reference(log)?,
    };
    let curve: Vec<f64> = match &position {
        Some(p) => change(&p.course, SPAN).iter().zip(&p.speed).map(|(w, v)| w * v).collect(),
        None => vec![0.0; log.len()],
    };
    let pull = change(&reference, SPAN);
    let straight = |i: usize| !(curve[i].abs() > 2.0 || pull[i].abs() > 1.5);
    let speeds = alike(log, &reference, straight);
    out.remarks.push(format!("speeds are compared with the {from}"));
    let wheels = wheels(log, &speeds, &from, &curve, radii, out);
    let found = |k: usize| wheels[k].as_ref().map(|w| in_si(log, w));
    let both = [found(0), found(1)];
    let any_wheel = both.iter().any(Option::is_some);
    let lateral = signal::masked(&curve, |i| curve[i].is_finite());
    let wheel = both[0].as_ref().or(both[1].as_ref());
    let ground = velocity(log, &speeds, &wheels, &both, &from, out);
    let speed = match (wheel, &ground) {
        (Some(w), _) => w.clone(),
        (None, Some(ground)) => in_si(log, ground),
        (None, None) => return None,
    };
    let acceleration = change(&speed, 5);
    let mut motion = Motion {
        ground: speed.clone(),
        pull: acceleration.clone(),
        acceleration,
        turn: None,
        turn_from: String::new(),
        lateral,
        wheels: both,
        position,
        receiver: None,
        speed,
    };
    if !any_wheel && let Some(v) = out.entries.iter_mut().find(|e| e.channel == Channel::VelocityX)
    {
        v.delay_error = Some(REFERENCE);
    }
    if let (true, Some(ground)) = (any_wheel, &ground) {
        motion.receiver = motion.after_wheels(&mean(&in_si(log, ground), SPAN));
        if let Some(v) = out.entries.iter_mut().find(|e| e.channel == Channel::VelocityX)
            && let Some(delay) = motion.receiver
        {
            v.delay = delay.value;
            v.delay_error = Some(delay.error);
            // wheels run ahead of the ground by their slip
            let shifted = signal::earlier(&in_si(log, ground), delay.value);
            motion.pull = change(&mean(&shifted, 2), 5);
            motion.ground = shifted;
        }
    }
    Some(motion)
}

impl Motion {
    /// The delay of a speed over ground, a mean over a second, after the wheels, apart from slip.
    pub(super) fn after_wheels(&self, speed: &[f64]) -> Option<Delay> {
        let (k, wheel) = match &self.wheels {
            [Some(w), _] => (0, w),
            [None, Some(w)] => (1, w),
            _ => return None,
        };
        let w = mean(wheel, SPAN);
        let acceleration = change(&w, 2);
        let after = |lateral: &[f64]| {
            let driven = k == 1;
            lag(&Wheel { speed: &w, acceleration: &acceleration, lateral, driven }, speed)
        };
        // the corners are on the receiver's clock as long as its delay is not known
        let first = after(&self.lateral)?;
        after(&signal::earlier(&self.lateral, first.value)).map(believed)
    }
}

/// A receiver that seems to be earlier than the wheels is not, unless the evidence is overwhelming: it computes for longer.
fn believed(delay: Delay) -> Delay {
    match delay.value > -FAR * delay.error {
        true => Delay { value: delay.value.max(0.0), ..delay },
        false => delay,
    }
}

/// Without a position: the speed whose name and unit say most.
fn named_reference(log: &Log<'_>) -> Option<(Vec<f64>, String)> {
    [Channel::VelocityX, Channel::WheelSpeedFront, Channel::WheelSpeedRear].into_iter().find_map(
        |channel| {
            let place = log.named(channel).into_iter().find(|i| log.unit(*i, "speed").is_some())?;
            let factor = units::conversion(log.unit(place, "speed")?, "m/s").ok()?.factor;
            let si: Vec<f64> = log.x(place).iter().map(|x| x * factor).collect();
            let v = mean(&si, SPAN);
            let moving = v.iter().filter(|v| **v > MOVING).count() as f64 / RATE;
            (moving > 20.0).then(|| (v, called(log, place)))
        },
    )
}

/// Front and rear wheel among the speeds.
fn wheels(
    log: &Log<'_>,
    speeds: &[Speed],
    from: &str,
    curve: &[f64],
    radii: Option<[f64; 2]>,
    out: &mut Verdicts,
) -> [Option<Speed>; 2] {
    let columns = [Channel::WheelSpeedFront, Channel::WheelSpeedRear];
    let mut found: [Option<Speed>; 2] = [None, None];
    let mut doubts: [Option<String>; 2] = [None, None];
    for (k, column) in columns.into_iter().enumerate() {
        let named = log.named(column);
        let is = |i: &usize| speeds.iter().find(|s| s.place == *i);
        let fit: Vec<&Speed> = named.iter().filter_map(is).collect();
        for i in named.iter().filter(|i| is(i).is_none()) {
            out.left.push((*i, format!("named like {column}, but it disagrees with the {from}")));
        }
        let best = fit.first().map(|s| log.score(s.place, column));
        let equals: Vec<&&Speed> =
            fit.iter().filter(|s| Some(log.score(s.place, column)) == best).collect();
        if equals.len() > 1 {
            let names: Vec<String> =
                equals.iter().map(|s| format!("`{}`", log.name(s.place))).collect();
            doubts[k] = Some(format!("there is more than one such channel: {}", names.join(", ")));
        }
        found[k] = fit.first().map(|s| (*s).clone());
    }
    let mut order = None;
    if let [Some(a), Some(b)] = &found {
        if a.place == b.place {
            found[1] = None;
        } else if let Some((slip, t)) = driven(log, a, b, curve) {
            if t < -4.0 {
                found.swap(0, 1);
                doubts.swap(0, 1);
                order = Some(format!(
                    "by its name it is the other wheel, but {}",
                    said_of_slip(-slip, -t)
                ));
            } else if t > 4.0 {
                order = Some(said_of_slip(slip, t));
            } else if out.remarks.len() < 20 {
                out.remarks.push(format!(
                    "which wheel is driven does not show in their slip (t = {t:.1}): front and rear are by their names"
                ));
            }
        }
    }
    for (k, column) in columns.into_iter().enumerate() {
        let Some(speed) = &found[k] else { continue };
        // both wheels are logged in one unit
        let other = found[1 - k].as_ref().filter(|o| (o.slope / speed.slope).ln().abs() < 0.12);
        let other = other.filter(|o| {
            unit_of(None, "m/s", &SPEEDS, o.slope, 0.03).is_some()
                && log.unit(o.place, "angular rate").is_none()
        });
        let mut verdict = wheel::entry(log, speed, column, radii.map(|r| r[k]), other.is_some());
        verdict.why.insert(0, format!("r = {:.4} with the {from}", speed.r));
        verdict.why.extend(order.clone());
        if let Some(doubt) = doubts[k].take() {
            verdict = verdict.doubted(doubt);
        }
        // the reference clock of the others
        verdict.delay_error = Some(REFERENCE);
        out.entries.push(verdict);
    }
    found
}

fn said_of_slip(slip: f64, t: f64) -> String {
    format!("under drive the rear wheel gains {:.2} % per m/s2 (t = {t:.0})", 100.0 * slip)
}

/// How much the second of two wheels gains on the first under drive, per m/s², and its t value.
///
/// ```text
/// ln(w2 / w1) = s0 + s sat(a) + c (1 - cos(p))        tan(p) = lateral / g
/// ```
///
/// `sat` is between drive and engine braking of 1.5 m/s²: beyond, slip says more of the brakes and of the load. The
/// tyres' radii shrink differently in corners.
fn driven(log: &Log<'_>, first: &Speed, second: &Speed, lateral: &[f64]) -> Option<(f64, f64)> {
    let (a, b) = (mean(&in_si(log, first), 5), mean(&in_si(log, second), 5));
    let pull = change(&a, 5);
    let ratio: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (b / a).ln()).collect();
    let bend = lateral.iter().map(|f| 1.0 - (f / GRAVITY).atan().cos()).collect();
    let force = pull.iter().map(|a| a.clamp(-1.5, 1.5)).collect();
    let columns = [force, bend, vec![1.0; a.len()]];
    let keep = |i: usize| {
        a[i] > 8.0 && b[i] > 8.0 && ratio[i].abs() < 0.15 && (-3.0..8.0).contains(&pull[i])
    };
    let (found, error) = regression(&columns, &ratio, keep)?;
    Some((found[0], found[0] / error[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 15 m/s to the north with a corner; `frozen` seconds from 30 s on.
    fn path(frozen: f64, jumps: bool) -> [Vec<f64>; 2] {
        let at = |i: i32| {
            let t = f64::from(i) / RATE;
            match (30.0..30.0 + frozen).contains(&t) {
                true => 30.0,
                false if !jumps && t > 30.0 => t - frozen,
                false => t,
            }
        };
        let of = |f: &dyn Fn(f64) -> f64| (0..1200).map(|i| f(at(i))).collect();
        [of(&|t| 15.0 * t), of(&|t| 40.0 * (0.2 * t).sin())]
    }

    #[test]
    fn a_frozen_position_is_none_and_a_stop_is_one() {
        let lost = |[mut y, mut x]: [Vec<f64>; 2]| {
            without_frozen(&mut y, &mut x);
            y.iter().filter(|y| y.is_nan()).count()
        };
        let frozen = lost(path(8.0, true));
        assert!((155..=165).contains(&frozen), "{frozen}");
        assert_eq!(lost(path(8.0, false)), 0, "it stood");
        assert_eq!(lost(path(1.0, true)), 0, "a slow receiver");
        assert_eq!(lost([vec![0.0; 400], vec![0.0; 400]]), 0);
    }

    /// A reference that rests for 8 of 60 s takes no speed away.
    #[test]
    fn a_speed_is_one_though_the_reference_stops_for_a_while() {
        let speed: Vec<f64> =
            (0..1200).map(|i| 20.0 + 5.0 * (0.4 * f64::from(i) / RATE).sin()).collect();
        let mut reference = speed.clone();
        reference[600..710].fill(0.0);
        let wheel: Vec<f64> = speed.iter().map(|v| 3.6 * v).collect();
        let found = line_without_dropouts(&reference, &wheel).expect("a little while");
        assert!(found.r > 0.999 && (found.slope - 3.6).abs() < 1e-6, "{found:?}");
        // half of the time is no little while
        reference[100..710].fill(0.0);
        assert!(line_without_dropouts(&reference, &wheel).is_none());
    }
}
