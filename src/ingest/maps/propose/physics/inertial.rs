//! An inertial unit with all six axes that is not level: its channels go to the smoother, not to the columns.
//!
//! ```text
//! forces  three axes of one sensor whose vector is as long as gravity on straights
//! rates   three axes of one sensor whose vector is as long as the turn in corners, however the unit sits
//! ```
//!
//! Which axis is which, their signs and the receiver's delay are found by [`navigation`](crate::ingest::motion::navigation) later.

use super::log::{Log, Unit, unit_of};
use super::signal::{self, mean};
use super::speed::SPAN;
use super::speeds::{MOVING, Motion};
use super::turning::RATES;
use super::verdict::{Verdict, Verdicts};
use crate::GRAVITY;
use crate::contract::channel::Channel;

/// Units of specific forces that loggers write.
const FORCES: [&str; 3] = ["g", "m/s2", "mg"];
/// How far the length of gravity may be off: a quarter of it along and across make 6 % more.
const GRAVITY_NEAR: f64 = 0.15;
/// How far the length of the turn may be off: the roll is in the rates, too.
const TURN_NEAR: f64 = 0.4;
/// A corner turns by more than this, rad/s.
const TURNS: f64 = 0.15;
/// Least points of the common clock in corners and on straights: 3 s.
const LEAST: usize = 60;

/// Three channels of one sensor and the unit that they are in.
struct Triple {
    places: [usize; 3],
    unit: Unit,
    /// Length of the vector over that of what it measures.
    size: f64,
}

/// Drafts the six channels of a unit that leans with the frame or is turned in it, where the log has no measured lean.
pub(super) fn inertial(log: &Log<'_>, motion: &Motion, out: &mut Verdicts) {
    let Some(turn) = &motion.turn else { return };
    if out.sure(Channel::Roll).is_some() || out.sure(Channel::VelocityX).is_none() {
        return;
    }
    let straight = |i: usize| {
        motion.lateral[i].abs() < 0.25 * GRAVITY
            && motion.acceleration[i].abs() < 0.25 * GRAVITY
            && motion.speed[i] > MOVING
    };
    let bend = |i: usize| turn[i].abs() > TURNS;
    let one = vec![GRAVITY; log.len()];
    let forces = triples(log, "acceleration")
        .find_map(|t| measured(log, t, ("m/s2", &FORCES, GRAVITY_NEAR), &one, &straight));
    let rates = triples(log, "angular rate")
        .find_map(|t| measured(log, t, ("rad/s", &RATES, TURN_NEAR), turn, &bend));
    let (Some(forces), Some(rates)) = (forces, rates) else { return };
    let level = |c: Channel| out.sure(c).is_some_and(|e| forces.places.contains(&e.source));
    if level(Channel::AccelerationX) && level(Channel::AccelerationY) {
        return;
    }
    use Channel::*;
    let said = format!(
        "of a unit with all six axes: {:.2} g on straights, {:.2} of the turn of {} in corners",
        forces.size, rates.size, motion.turn_from
    );
    for (triple, columns) in
        [(rates, [ImuRateX, ImuRateY, ImuRateZ]), (forces, [ImuForceX, ImuForceY, ImuForceZ])]
    {
        for (place, column) in triple.places.into_iter().zip(columns) {
            let v = Verdict::new(column, place, &triple.unit.name).because(&said);
            let v = match &triple.unit.not {
                Some(not) => v.because(format!("not in {not}, as the log says")),
                None => v,
            };
            out.entries.push(Verdict { confirmed: true, ..v });
        }
    }
    out.remarks.push(
        "an inertial unit that is not level, and no measured lean: the level frame is made of its six channels \
         and the satellite receiver's (book: any inertial unit). It must be fixed to the frame: of a unit in a \
         pocket take its entries out"
            .into(),
    );
}

/// Triples of live channels that measure this, or whose names say so, one per sensor.
fn triples<'a>(
    log: &'a Log<'_>,
    dimension: &'static str,
) -> impl Iterator<Item = [usize; 3]> + use<'a> {
    let words: &[&str] = match dimension {
        "acceleration" => &["acc", "accel", "acceleration", "gforce", "force", "g"],
        _ => &["gyro", "gyroscope", "rate", "rotation", "omega"],
    };
    let all: Vec<(usize, String, char)> = (0..log.channels.len())
        .filter(|i| log.live(*i).is_some() && !log.of_other_dimension(*i, &[dimension]))
        .filter(|i| log.unit(*i, dimension).is_some() || words.iter().any(|w| log.has_word(*i, w)))
        .filter_map(|i| log.axis(i).map(|(family, axis)| (i, family, axis)))
        .collect();
    let of = |family: &str, axis: char| {
        let mut found = all.iter().filter(|a| a.1 == family && a.2 == axis);
        // two sensors that only their axes tell apart are none
        found.next().filter(|_| found.next().is_none()).map(|a| a.0)
    };
    let triples: Vec<[usize; 3]> = all
        .iter()
        .filter(|a| a.2 == 'x')
        .filter_map(|(x, family, _)| Some([*x, of(family, 'y')?, of(family, 'z')?]))
        .collect();
    triples.into_iter()
}

/// A triple whose vector is as long as the reference where `keep` holds, in the unit in which it is.
fn measured(
    log: &Log<'_>,
    places: [usize; 3],
    (si, units, near): (&str, &[&str], f64),
    reference: &[f64],
    keep: &dyn Fn(usize) -> bool,
) -> Option<Triple> {
    let axes = places.map(|p| mean(log.x(p), SPAN));
    let ratio = |i: usize| {
        let length = axes.iter().map(|x| x[i] * x[i]).sum::<f64>().sqrt();
        if keep(i) { length / reference[i].abs() } else { f64::NAN }
    };
    let ratios: Vec<f64> = (0..reference.len()).map(ratio).collect();
    if ratios.iter().filter(|r| r.is_finite()).count() < LEAST {
        return None;
    }
    let middle = signal::quantile(&ratios, 0.5);
    let unit = unit_of(log.unit(places[0], dimension(si)), si, units, middle, near)?;
    let factor = crate::ingest::maps::units::conversion(si, &unit.name).ok()?.factor;
    Some(Triple { places, unit, size: middle / factor })
}

fn dimension(si: &str) -> &'static str {
    if si == "m/s2" { "acceleration" } else { "angular rate" }
}
