//! Kinds sample by sample made into segments that cover the ride.

use crate::contract::reason::{Reason, ReasonCode};
use std::ops::Range;

use crate::segment::manoeuvre::means::Ride;
use crate::segment::manoeuvre::offroad::Config;
use crate::segment::manoeuvre::{Course, Direction, ManoeuvreKind};
use crate::segment::segments::Segment;

/// Runs shorter than this go to the run before them, s.
const SHORTEST: f64 = 0.06;

/// Segments in time order, from the kind of every sample.
pub(super) fn cover(ride: &Ride<'_>, kinds: &[ManoeuvreKind], config: &Config) -> Vec<Segment> {
    pieces(kinds, (SHORTEST * ride.rate) as usize)
        .into_iter()
        .map(|at| segment(ride, at.clone(), kinds[at.start], config))
        .collect()
}

/// Runs of one kind; one shorter than `shortest` samples goes to the run before it, unless
/// either is a flight.
fn pieces(kinds: &[ManoeuvreKind], shortest: usize) -> Vec<Range<usize>> {
    let mut out: Vec<Range<usize>> = Vec::new();
    let mut start = 0;
    while start < kinds.len() {
        let end = kinds[start..]
            .iter()
            .position(|k| *k != kinds[start])
            .map_or(kinds.len(), |d| start + d);
        let scrap = end - start < shortest && kinds[start] != ManoeuvreKind::Airborne;
        match out.last_mut() {
            Some(last)
                if kinds[last.start] == kinds[start]
                    || (scrap && kinds[last.start] != ManoeuvreKind::Airborne) =>
            {
                last.end = end;
            }
            _ => out.push(start..end),
        }
        start = end;
    }
    out
}

fn segment(ride: &Ride<'_>, at: Range<usize>, kind: ManoeuvreKind, config: &Config) -> Segment {
    let missing = ride.load[at.clone()].iter().filter(|v| !v.is_finite()).count();
    let missing = missing as f64 / at.len() as f64;
    let reason = if missing > config.missing {
        Some(Reason::new(
            ReasonCode::MissingSamples,
            format!("{:.0} % of its samples have no estimate", 100.0 * missing),
        ))
    } else if kind == ManoeuvreKind::Other {
        Some(Reason::new(ReasonCode::NoKind, "neither flight, whoops, corner, braking nor drive"))
    } else {
        None
    };
    let direction = match (kind.declaration().course, ride.yaw_rate) {
        (Course::Bend, Some(yaw)) => {
            let turn: f64 = yaw[at.clone()].iter().filter(|v| v.is_finite()).sum();
            (turn != 0.0).then_some(if turn > 0.0 { Direction::Left } else { Direction::Right })
        }
        _ => None,
    };
    Segment {
        kind,
        start: at.start,
        end: at.end,
        direction,
        quality: 1.0 - missing,
        used: reason.is_none(),
        reason,
    }
}
