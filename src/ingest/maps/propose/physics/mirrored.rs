//! A position that is mirrored: whose letters of the hemisphere were lost, so that south is north or west is east.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::log::Log;
use super::signal::line;
use super::speeds::Position;
use super::verdict::Verdicts;
use crate::contract::channel::Channel;
use crate::ingest::maps::units;
use crate::statistics::order;

/// The path follows a course that is nearer than this, rad, ...
const COURSE_TOLERANCE_RAD: f64 = 0.12;
/// ... and does not follow one that is farther.
const FAR: f64 = 0.35;
/// A lean goes with the path when its correlation is larger than this.
const LEANS: f64 = 0.5;
/// Fewest points that tell: 5 s.
const MIN_POINTS: usize = 100;

/// Which coordinate is mirrored by a compass course in the log, and what that is called. `turn` is that of the path,
/// rad/s to the left.
///
/// A course that is positive to the left would look the same. A lean decides: it is positive to the right by every
/// convention.
pub(super) fn mirrored(
    log: &Log<'_>,
    position: &Position,
    turn: &[f64],
) -> Option<(Channel, String)> {
    let compass = |place: &usize| {
        let words = ["course", "bearing", "heading", "compass", "cog"];
        words.iter().any(|w| log.has_word(*place, w)) && !log.of_other_dimension(*place, &["angle"])
    };
    let place = log.named(Channel::Yaw).into_iter().find(compass)?;
    let size = log.live(place)?.extent[1].abs();
    let unit = log.unit(place, "angle").unwrap_or(if size > 7.0 { "deg" } else { "rad" });
    let factor = units::conversion(unit, "rad").ok()?.factor;
    let course: Vec<f64> = log.x(place).iter().map(|x| x * factor).collect();
    let channel = by_course(&position.course, &course)?;
    let lateral: Vec<f64> = turn.iter().zip(&position.speed).map(|(w, v)| w * v).collect();
    let lean = log.named(Channel::Roll).into_iter().find_map(|i| line(&lateral, log.x(i)));
    let to_the_right = lean.is_some_and(|l| l.r < -LEANS);
    (!to_the_right).then(|| (channel, log.name(place)))
}

/// The mirrored coordinate, by the direction of the path (rad, to the left from east) and a course (rad, to the right
/// from north).
fn by_course(path: &[f64], course: &[f64]) -> Option<Channel> {
    let off = |expected: &dyn Fn(f64) -> f64| -> Option<f64> {
        let both = path.iter().zip(course).filter(|(p, c)| p.is_finite() && c.is_finite());
        let off = both.map(|(p, c)| {
            let d = (c - expected(*p)).rem_euclid(TAU);
            d.min(TAU - d)
        });
        let mut off: Vec<f64> = off.collect();
        (off.len() >= MIN_POINTS).then(|| order::median(&mut off)).flatten()
    };
    if off(&|p| FRAC_PI_2 - p)? < FAR {
        return None;
    }
    let west = off(&|p| p - FRAC_PI_2)?;
    let south = off(&|p| FRAC_PI_2 + p)?;
    match (west < COURSE_TOLERANCE_RAD, south < COURSE_TOLERANCE_RAD) {
        (true, false) => Some(Channel::Longitude),
        (false, true) => Some(Channel::Latitude),
        _ => None,
    }
}

/// Puts the position in doubt.
pub(super) fn doubt(channel: Channel, course: &str, out: &mut Verdicts) {
    let [half, other, letter] = match channel {
        Channel::Latitude => ["north", "south", "S"],
        _ => ["east", "west", "W"],
    };
    let why = format!(
        "`{course}` says that {half} is {other} in the position: a letter `{letter}` was lost, and `sign = -1` at the \
         {channel} mends it; or the course is the wrong one"
    );
    for e in &mut out.entries {
        if matches!(e.channel, Channel::Latitude | Channel::Longitude) && e.doubt.is_none() {
            if e.channel == channel {
                e.sign = -1.0;
            }
            e.doubt = Some(why.clone());
        }
    }
    out.remarks.push(format!(
        "the position is mirrored against `{course}`, which decides what is left and right"
    ));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_tells_which_coordinate_is_mirrored() {
        // a path that bends between north and south-east, compass
        let course: Vec<f64> = (0..600).map(|i| 1.2 + 1.1 * (f64::from(i) * 0.02).sin()).collect();
        let path = |north: f64, east: f64| -> Vec<f64> {
            course.iter().map(|c| (north * c.cos()).atan2(east * c.sin())).collect()
        };
        let turns: Vec<f64> = course.iter().map(|c| c.rem_euclid(TAU)).collect();
        assert_eq!(by_course(&path(1.0, 1.0), &turns), None);
        assert_eq!(by_course(&path(1.0, -1.0), &turns), Some(Channel::Longitude));
        assert_eq!(by_course(&path(-1.0, 1.0), &turns), Some(Channel::Latitude));
        // a yaw angle from anywhere is no compass
        let yaw: Vec<f64> = course.iter().map(|c| 1.0 - c).collect();
        assert_eq!(by_course(&path(1.0, 1.0), &yaw), None);
        // straight to the north both are the same
        let straight = vec![0.0; 600];
        assert_eq!(by_course(&[FRAC_PI_2; 600], &straight), None);
    }
}
