//! The plots of an off-road session: the rider models side by side.
//!
//! The time line has a panel per force with a line per rider. Three situations are drawn in full,
//! as the paper does: the longest flight (with the next one, if it follows at once), the longest
//! whoops, the longest corner.

use super::plot::{Axis, Panel, Plot, Section, Series};
use super::sheet::{Sheet, TIMELINE_BINS};
use crate::contract::session::Session;
use crate::estimate::offroad::{Estimate, RiderEstimate};
use crate::segment::Segment;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::store::tables::rows::PlotPoint;

const TIME: Axis = Axis::new("time", "s", 1.0);
const RIDER_FORCE: Axis = Axis::new("force on the bike", "N", 1.0);
const TYRE_FORCE: Axis = Axis::new("force on the tyre", "N", 1.0);
const RIDER_CAPTION: &str = "Rider models side by side; A integrated springs, B algebraic, C with \
                             the slow vertical motion.";
const TYRE_CAPTION: &str = "The same samples solved with each rider model, and with none.";

/// A line per rider model.
macro_rules! riders {
    ($prefix:literal) => {
        &[
            Series::new(concat!($prefix, "_none"), "no rider"),
            Series::new(concat!($prefix, "_a"), "rider A"),
            Series::new(concat!($prefix, "_b"), "rider B"),
            Series::new(concat!($prefix, "_c"), "rider C"),
        ]
    };
}

/// The rider models in a plot of a situation.
const RIDERS: &[Series] = riders!("rider");

/// A rider model in words, by its name in the tables.
pub(crate) fn rider_label(name: &str) -> String {
    let known = RIDERS.iter().find(|s| s.name.strip_prefix("rider_") == Some(name));
    known.map_or_else(|| format!("rider {}", name.to_uppercase()), |s| s.label.to_owned())
}

/// The forces in one situation, in the order of [`FORCES`].
macro_rules! situation {
    ($name:literal, $title:literal) => {
        situation! { $name, $title:
            "legs", "rider on the pegs (L_z, down)", RIDER_FORCE, RIDER_CAPTION;
            "arms", "rider on the bar (A_x, forward)", RIDER_FORCE, RIDER_CAPTION;
            "load_front", "front load (N_f)", TYRE_FORCE, TYRE_CAPTION;
            "load_rear", "rear load (N_r)", TYRE_FORCE, TYRE_CAPTION;
            "along_front", "front along the chassis (−B_f)", TYRE_FORCE, TYRE_CAPTION;
            "along_rear", "rear along the chassis (D_r − B_r)", TYRE_FORCE, TYRE_CAPTION;
        }
    };
    ($name:literal, $title:literal: $($force:literal, $words:literal, $y:expr, $caption:expr;)*) => {
        [$(Plot {
            section: Section::OffRoad,
            series: RIDERS,
            ..Plot::new(
                concat!($name, "_", $force),
                concat!($title, " · ", $words),
                [TIME, $y],
                $caption,
            )
        }),*]
    };
}

const JUMPS: [Plot; 6] = situation!("jumps", "Jumps");
const WHOOPS: [Plot; 6] = situation!("whoops", "Whoops");
const CORNER: [Plot; 6] = situation!("corner", "Corner");

/// Every plot of a situation, in the order of the page.
pub(crate) const SITUATIONS: [[Plot; 6]; 3] = [JUMPS, WHOOPS, CORNER];

/// One force on the time line: a line per rider model.
macro_rules! panel {
    ($label:literal, $force:literal) => {
        Panel { axis: Axis::new($label, "N", 1.0), series: riders!($force) }
    };
}

/// Panels of the time line that only an off-road session has.
pub(crate) const PANELS: &[Panel] = &[
    Panel { axis: Axis::degrees("pitch, nose up"), series: &[Series::new("pitch_up", "pitch up")] },
    Panel {
        axis: Axis::new("travel", "mm", 1000.0),
        series: &[
            Series::new("fork_travel", "fork travel"),
            Series::new("shock_travel", "shock travel"),
        ],
    },
    panel!("front load", "load_front"),
    panel!("rear load", "load_rear"),
    panel!("front along the chassis", "along_front"),
    panel!("rear along the chassis", "along_rear"),
    panel!("rider on the pegs, down", "legs"),
    panel!("rider on the bar, forward", "arms"),
];

/// Points of a line in a situation.
const POINTS: usize = 500;
/// Longest situation, s.
const LONGEST: f64 = 9.0;

/// The rows of the table `plots` of an off-road session.
pub(crate) fn rows(session: &Session, estimate: &Estimate, segments: &[Segment]) -> Vec<PlotPoint> {
    let mut sheet = Sheet::new(session);
    timeline(&mut sheet, estimate);
    for (plots, window) in situations(segments, session.rate, session.len) {
        let every = window.len().div_ceil(POINTS / 2).max(1);
        for ridden in &estimate.riders {
            let name = format!("rider_{}", ridden.rider.name());
            let Some(series) = RIDERS.iter().find(|s| s.name == name) else { continue };
            for (plot, (_, force)) in plots.iter().zip(FORCES) {
                for start in window.clone().step_by(every) {
                    let places = start..(start + every).min(window.end);
                    for i in extremes(places, &|i| force(ridden, i)) {
                        let value = [Some(force(ridden, i)), None, None];
                        sheet.point(plot, series, session.time(i), value);
                    }
                }
            }
        }
    }
    sheet.finish()
}

fn timeline(sheet: &mut Sheet<'_>, estimate: &Estimate) {
    let step = sheet.session.len.div_ceil(TIMELINE_BINS).max(1);
    let k = &estimate.kinematics;
    for (series, x) in [
        ("velocity_x", &k.xd),
        ("pitch_up", &k.mu),
        ("fork_travel", &k.z_f),
        ("shock_travel", &k.shock),
    ] {
        if x.iter().any(|v| v.is_finite()) {
            sheet.timeline(series, step, &|i| x[i]);
        }
    }
    for ridden in &estimate.riders {
        let rider = ridden.rider.name();
        for (name, force) in FORCES {
            sheet.timeline(format!("{name}_{rider}"), step, &|i| force(ridden, i));
        }
    }
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

type Force = fn(&RiderEstimate, usize) -> f64;

/// Forces that are drawn, N, by the first part of the series' name on the time line.
const FORCES: [(&str, Force); 6] = [
    ("legs", |r, i| r.forces.lz[i]),
    ("arms", |r, i| r.forces.ax[i]),
    ("load_front", |r, i| r.tyres.n_f[i]),
    ("load_rear", |r, i| r.tyres.n_r[i]),
    ("along_front", |r, i| -r.tyres.b_f[i]),
    ("along_rear", |r, i| r.tyres.d_r[i] - r.tyres.b_r[i]),
];

/// The plots of the three situations of the paper with the samples that they show, as far as the
/// session has them.
fn situations(
    segments: &[Segment],
    rate: f64,
    len: usize,
) -> Vec<([Plot; 6], std::ops::Range<usize>)> {
    // whole in the log before cut by its end
    let margin = rate as usize;
    let longest = |kind: ManoeuvreKind| {
        let whole = |s: &Segment| s.start >= margin && s.end + margin <= len;
        let of_kind = segments.iter().filter(|s| s.kind == kind && s.used);
        of_kind.max_by_key(|s| (whole(s), s.end - s.start))
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
        out.push((JUMPS, window(start, end, 0.8, 1.2)));
    }
    if let Some(s) = longest(ManoeuvreKind::Whoops) {
        out.push((WHOOPS, window(s.start, s.end, 0.5, 0.5)));
    }
    if let Some(s) = longest(ManoeuvreKind::Cornering) {
        out.push((CORNER, window(s.start, s.end, 0.3, 0.3)));
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
