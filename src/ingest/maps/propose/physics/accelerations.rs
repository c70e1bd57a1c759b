//! Accelerations: `a_x = dv/dt`, `a_y = v r`, and the vertical feels about one g.

use super::course::BY_POSITION;
use super::delay::delay;
use super::log::{Log, unit_of};
use super::signal::{self, earlier, line, mean};
use super::speed::SPAN;
use super::speeds::{MOVING, Motion};
use super::verdict::{Verdict, Verdicts};
use crate::GRAVITY;
use crate::contract::channel::Channel;

const UNITS: [&str; 3] = ["m/s2", "g", "mg"];
/// How far the slope of an acceleration may be off.
const SLOPE_TOLERANCE: f64 = 0.25;
/// The vertical grows by this share in corners where the sensor leans.
const GROWS: f64 = 1.05;
/// An axis that should be level and feels this share of gravity is turned.
const TURNED: f64 = 0.09;

/// Mounting of a sensor by its three axes.
struct Seat {
    /// The names without the axis.
    family: String,
    /// Why it is not level, if it is not.
    not_level: Option<String>,
}

/// Finds forward and lateral acceleration.
pub(super) fn accelerations(log: &Log<'_>, motion: &Motion, out: &mut Verdicts) {
    let seats = seats(log, motion, out);
    let seat = |place: usize| {
        let family = log.axis(place)?.0;
        seats.iter().find(|s| s.family == family)?.not_level.clone()
    };
    let tilted = seats.iter().find_map(|s| s.not_level.clone());
    let rates = out.entries.iter_mut().filter(|e| e.channel == Channel::YawRate);
    for e in rates.filter(|_| tilted.is_some()) {
        let doubt =
            format!("{}; of a gyroscope that is not upright", tilted.clone().unwrap_or_default());
        e.doubt.get_or_insert(doubt);
    }
    along(log, motion, &seat, out);
    across(log, motion, &seat, out);
}

/// How each sensor with a vertical axis sits.
fn seats(log: &Log<'_>, motion: &Motion, out: &mut Verdicts) -> Vec<Seat> {
    let is_force = |i: &usize| {
        let named = ["acc", "accel", "acceleration", "gforce", "force", "g"]
            .iter()
            .any(|w| log.has_word(*i, w));
        log.unit(*i, "acceleration").is_some() || named
    };
    let all: Vec<(usize, String, char)> = (0..log.channels.len())
        .filter(|i| log.live(*i).is_some() && is_force(i))
        .filter(|i| !log.of_other_dimension(*i, &["acceleration"]))
        .filter_map(|i| log.axis(i).map(|(family, axis)| (i, family, axis)))
        .collect();
    let steep = |i: usize| motion.lateral[i].abs() > 0.7 * GRAVITY;
    let gentle =
        |i: usize| motion.lateral[i].abs() < 0.15 * GRAVITY && motion.acceleration[i].abs() < 1.0;
    let mut seats = Vec::new();
    for (place, family, _) in all.iter().filter(|a| a.2 == 'z') {
        let of = |axis: char| all.iter().find(|a| a.1 == *family && a.2 == axis).map(|a| a.0);
        let (Some(x), Some(y)) = (of('x'), of('y')) else { continue };
        let middle = |p: usize, keep: &dyn Fn(usize) -> bool| {
            let v = signal::masked(log.x(p), |i| keep(i) && motion.speed[i] > MOVING);
            signal::quantile(&v, 0.5)
        };
        let down = [x, y, *place].map(|p| middle(p, &gentle));
        let whole = down.iter().map(|d| d * d).sum::<f64>().sqrt();
        let [gx, gy, gz] = down.map(|d| d / whole);
        let turned = gx.hypot(gy) > TURNED;
        let grown = middle(*place, &steep) / down[2];
        let not_level = if turned {
            let angle = gz.abs().min(1.0).acos().to_degrees();
            Some(format!("its sensor is turned by {angle:.0} deg against the vertical"))
        } else if grown > GROWS {
            Some(format!(
                "its sensor leans with the frame: the vertical feels {grown:.2} times as much in steep corners as upright"
            ))
        } else if grown.is_nan() {
            Some(
                "no corner is steep enough to show whether its sensor leans with the frame"
                    .to_owned(),
            )
        } else {
            None
        };
        let level = if not_level.is_some() || grown.is_nan() { "" } else { ", level" };
        let bends = match grown.is_nan() {
            true => "no steep corners".to_owned(),
            false => format!("{grown:.2} times that in steep corners"),
        };
        out.left.push((
            *place,
            format!(
                "the vertical of a sensor: {:.2} upright, {bends}{level}; no column of a ride on the road",
                down[2]
            ),
        ));
        let seat = Seat { family: family.clone(), not_level };
        for other in [x, y] {
            let column = [Channel::AccelerationX, Channel::AccelerationY];
            let named = column.iter().any(|c| log.score(other, *c).is_some());
            if let Some(why) = seat.not_level.clone().filter(|_| !named) {
                out.left.push((other, format!("an acceleration, but {why}")));
            }
        }
        seats.push(seat);
    }
    seats
}

fn along(
    log: &Log<'_>,
    motion: &Motion,
    seat: &dyn Fn(usize) -> Option<String>,
    out: &mut Verdicts,
) {
    let column = Channel::AccelerationX;
    let reference = mean(&motion.pull, 2);
    for place in log.named(column) {
        if log.of_other_dimension(place, &["acceleration"]) {
            continue;
        }
        let own = log.unit(place, "acceleration");
        let x = mean(log.x(place), 5);
        let late = delay(&reference, &x);
        let shifted = earlier(&x, late.map_or(0.0, |d| d.value));
        let found = line(&reference, &shifted);
        let not_level = seat(place);
        let Some(l) = found.filter(|l| l.r.abs() > 0.8) else {
            let r = found.map_or(0.0, |l| l.r);
            let seen = not_level.unwrap_or_else(|| {
                "not along the bike, badly filtered, or the log's clock is wrong".into()
            });
            out.left
                .push((place, format!("named like {column}, but r = {r:.2} with dv/dt: {seen}")));
            continue;
        };
        let Some(unit) = unit_of(own, "m/s2", &UNITS, l.slope, SLOPE_TOLERANCE) else {
            out.left.push((place, format!("r = {:.2} with dv/dt, but {:.3} of its numbers are 1 m/s2: turned axes, or no unit that is known", l.r, l.slope)));
            continue;
        };
        let mut v = Verdict { confirmed: true, ..Verdict::new(column, place, &unit.name) };
        v.sign = l.slope.signum();
        (v.delay, v.delay_error) = late.map_or((0.0, None), |d| (d.value, Some(d.error)));
        v = v.because(format!(
            "r = {:.4} with dv/dt, {:.2} m/s2 per unit: {}",
            l.r,
            1.0 / l.slope.abs(),
            unit.name
        ));
        if let Some(not) = &unit.not {
            v = v.because(format!("not in {not}, as the log says"));
        }
        v = taken(v, not_level, (l.offset / l.slope).abs(), out);
        out.entries.push(v);
    }
}

/// With a doubt where the sensor is not level or another one is there already.
fn taken(v: Verdict, not_level: Option<String>, offset: f64, out: &Verdicts) -> Verdict {
    let v = match not_level {
        Some(why) => v.doubted(format!("{why}; the column is level and without gravity")),
        None if offset > 0.5 => {
            v.doubted(format!("{offset:.1} m/s2 off throughout: tilted, or gravity is in it"))
        }
        None => v,
    };
    let other = out.entries.iter().any(|e| e.channel == v.channel && e.doubt.is_none());
    if other { v.doubted("there is more than one such channel") } else { v }
}

fn across(
    log: &Log<'_>,
    motion: &Motion,
    seat: &dyn Fn(usize) -> Option<String>,
    out: &mut Verdicts,
) {
    let column = Channel::AccelerationY;
    let reference = motion.turn.as_ref().map(|_| {
        signal::masked(&motion.lateral, |i| {
            motion.speed[i] > MOVING && motion.turn.as_ref().is_some_and(|t| t[i].is_finite())
        })
    });
    for place in log.named(column) {
        if log.of_other_dimension(place, &["acceleration"]) {
            continue;
        }
        let own = log.unit(place, "acceleration");
        let Some(reference) = &reference else {
            out.entries.push(
                super::turning::by_name(log, column, place, "acceleration").doubted(
                    "nothing else in the log turns: neither its sign nor its frame is known",
                ),
            );
            continue;
        };
        let x = mean(log.x(place), SPAN);
        let late = delay(reference, &x);
        let shifted = earlier(&x, late.map_or(0.0, |d| d.value));
        let found = line(reference, &shifted);
        let not_level = seat(place);
        let Some(l) = found.filter(|l| l.r.abs() > 0.9) else {
            let r = found.map_or(0.0, |l| l.r);
            let seen = not_level.unwrap_or_else(|| {
                "a sensor that leans with the bike feels next to nothing in a corner".into()
            });
            out.left.push((
                place,
                format!("named like {column}, but r = {r:.2} with v x turn: {seen}"),
            ));
            continue;
        };
        let Some(unit) = unit_of(own, "m/s2", &UNITS, l.slope, SLOPE_TOLERANCE) else {
            out.left.push((place, format!("r = {:.2} with v x turn, but {:.3} of its numbers are 1 m/s2: it leans with the bike, or is turned", l.r, l.slope)));
            continue;
        };
        let mut v = Verdict { confirmed: true, ..Verdict::new(column, place, &unit.name) };
        v.sign = l.slope.signum();
        (v.delay, v.delay_error) =
            late.map_or((0.0, None), |d| (d.value, Some(d.error.hypot(BY_POSITION))));
        let side = if l.slope > 0.0 { "left" } else { "right" };
        v = v.because(format!(
            "r = {:.4} with v x turn of {}, {:.2} m/s2 per unit: {}; positive to the {side}",
            l.r,
            motion.turn_from,
            1.0 / l.slope.abs(),
            unit.name
        ));
        if let Some(not) = &unit.not {
            v = v.because(format!("not in {not}, as the log says"));
        }
        v = taken(v, not_level, (l.offset / l.slope).abs(), out);
        out.entries.push(v);
    }
}
