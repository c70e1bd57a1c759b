//! What the report draws of an off-road session: the riders side by side.
//!
//! The time line has a panel per force with a line per rider. Three situations are drawn in full,
//! as the paper does: the longest flight (with the next one, if it follows at once), the longest
//! whoops, the longest corner.

use super::ride::bins;
use super::sheet::{BINS, Sheet};
use crate::contract::session::Session;
use crate::estimate::offroad::{Estimate, Ridden};
use crate::tables::rows::PlotPoint;
use crate::{contract::manoeuvre::ManoeuvreKind, segment::Segment};

/// Points of a line in a situation.
const POINTS: usize = 500;
/// Longest situation, s.
const LONGEST: f64 = 9.0;

/// Everything the report draws of an off-road session.
pub fn rows(session: &Session, estimate: &Estimate, segments: &[Segment]) -> Vec<PlotPoint> {
    let mut sheet = Sheet { session, rows: Vec::new() };
    let step = session.len.div_ceil(BINS).max(1);
    let k = &estimate.kinematics;
    for (series, x) in [
        ("velocity_x", &k.xd),
        ("pitch_up", &k.mu),
        ("fork_travel", &k.z_f),
        ("shock_travel", &k.shock),
    ] {
        if x.iter().any(|v| v.is_finite()) {
            bins(&mut sheet, series, step, &|i| x[i]);
        }
    }
    for ridden in &estimate.riders {
        let rider = ridden.rider.name();
        for (name, force) in FORCES {
            bins(&mut sheet, &format!("{name}_{rider}"), step, &|i| force(ridden, i));
        }
    }
    for (name, window) in situations(segments, session.rate, session.len) {
        let every = window.len().div_ceil(POINTS / 2).max(1);
        for ridden in &estimate.riders {
            let series = format!("rider_{}", ridden.rider.name());
            for (force_name, force) in FORCES {
                let plot = format!("{name}_{force_name}");
                for start in window.clone().step_by(every) {
                    let places = start..(start + every).min(window.end);
                    for i in extremes(places, &|i| force(ridden, i)) {
                        let value = [Some(force(ridden, i)), None, None];
                        sheet.push(&plot, &series, session.time(i), value, None, None);
                    }
                }
            }
        }
    }
    sheet.rows
}

/// Where the least and the largest of some values are, in their order: a landing is over within a
/// few samples, and every n-th would miss its peak.
fn extremes(places: std::ops::Range<usize>, f: &dyn Fn(usize) -> f64) -> Vec<usize> {
    let finite = || places.clone().filter(|i| f(*i).is_finite());
    let least = finite().min_by(|a, b| f(*a).total_cmp(&f(*b)));
    let largest = finite().max_by(|a, b| f(*a).total_cmp(&f(*b)));
    // a gap stays one
    let mut found = match least.zip(largest) {
        Some((a, b)) => vec![a.min(b), a.max(b)],
        None => vec![places.start],
    };
    found.dedup();
    found
}

type Force = fn(&Ridden, usize) -> f64;

/// Forces that are drawn, by the first part of the series' name.
const FORCES: [(&str, Force); 6] = [
    ("legs", |r, i| r.forces.lz[i]),
    ("arms", |r, i| r.forces.ax[i]),
    ("load_front", |r, i| r.tyres.n_f[i]),
    ("load_rear", |r, i| r.tyres.n_r[i]),
    ("along_front", |r, i| -r.tyres.b_f[i]),
    ("along_rear", |r, i| r.tyres.d_r[i] - r.tyres.b_r[i]),
];

/// The three situations of the paper, as far as the session has them.
fn situations(
    segments: &[Segment],
    rate: f64,
    len: usize,
) -> Vec<(&'static str, std::ops::Range<usize>)> {
    // whole in the log before cut by its end
    let margin = rate as usize;
    let longest = |kind: ManoeuvreKind| {
        let whole = |s: &Segment| s.start >= margin && s.end + margin <= len;
        let kin = segments.iter().filter(|s| s.kind == kind && s.used);
        kin.max_by_key(|s| (whole(s), s.end - s.start))
    };
    let window = |start: usize, end: usize, before: f64, after: f64| {
        let start = start.saturating_sub((before * rate) as usize);
        start..(end + (after * rate) as usize).min(len).min(start + (LONGEST * rate) as usize)
    };
    let mut out = Vec::new();
    if let Some(first) = longest(ManoeuvreKind::Airborne) {
        let soon = (4.0 * rate) as usize;
        let neighbour = |s: &&Segment| {
            s.kind == ManoeuvreKind::Airborne
                && ((s.start > first.end && s.start - first.end < soon)
                    || (s.end < first.start && first.start - s.end < soon))
        };
        let (mut start, mut end) = (first.start, first.end);
        if let Some(other) = segments.iter().filter(neighbour).max_by_key(|s| s.end - s.start) {
            (start, end) = (start.min(other.start), end.max(other.end));
        }
        out.push(("jumps", window(start, end, 0.8, 1.2)));
    }
    if let Some(s) = longest(ManoeuvreKind::Whoops) {
        out.push(("whoops", window(s.start, s.end, 0.5, 0.5)));
    }
    if let Some(s) = longest(ManoeuvreKind::Cornering) {
        out.push(("corner", window(s.start, s.end, 0.3, 0.3)));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bucket_keeps_its_peaks_in_order() {
        let y = [0.0, 5.0, 1.0, -2.0, f64::NAN];
        assert_eq!(extremes(0..5, &|i| y[i]), [1, 3]);
        assert_eq!(extremes(0..1, &|i| y[i]), [0]);
        assert_eq!(extremes(4..5, &|i| y[i]), [4]);
    }
}
