//! A channel of a log on a common, even clock, and what is known of it without any physics.

use nalgebra::{DMatrix, DVector};

use crate::ingest::raw::Column;
use crate::statistics::angles::unwrap_circle;
use crate::statistics::order;

/// Rate of the common clock, Hz.
pub(super) const RATE: f64 = 20.0;
/// Most points of the common clock: 40 minutes.
const MAX_POINTS: usize = 48_000;
/// Usual steps between samples that are bridged, ...
const BRIDGED: f64 = 3.5;
/// ... at least so long, s.
const BRIDGE: f64 = 0.35;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock {
    /// Its first point, s.
    pub start: f64,
    pub len: usize,
}

impl Clock {
    /// The clock of logs between two times, s.
    pub(crate) fn between(start: f64, end: f64) -> Self {
        let len = ((end - start) * RATE).max(0.0).min(MAX_POINTS as f64) as usize;
        Clock { start, len }
    }
}

/// A channel on the common clock.
#[derive(Debug, Clone)]
pub(crate) struct Signal {
    /// By point of the clock, in the log's unit; NaN where there is none.
    pub x: Vec<f64>,
    /// Smallest and largest sample.
    pub extent: [f64; 2],
    /// Number of different values, at most 50.
    pub distinct: usize,
    /// Whether all samples are whole numbers.
    pub whole: bool,
    /// Smallest step between different samples.
    pub step: f64,
}

impl Signal {
    /// Of a channel's samples; `None` where it holds no number.
    pub(crate) fn of(column: &Column, clock: Clock) -> Option<Self> {
        let mut stamps: Vec<(f64, f64)> = Vec::with_capacity(column.values.len());
        for (&t, &x) in column.time.iter().zip(&column.values) {
            let later = stamps.last().is_none_or(|last| t > last.0);
            if t.is_finite() && x.is_finite() && later {
                stamps.push((t, x));
            }
        }
        let mut sorted: Vec<f64> = stamps.iter().map(|s| s.1).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let extent = [*sorted.first()?, *sorted.last()?];
        let whole = sorted.iter().all(|x| x.fract() == 0.0);
        sorted.dedup();
        let steps = sorted.windows(2).map(|w| w[1] - w[0]);
        let step = steps.fold(f64::INFINITY, f64::min);
        let distinct = sorted.len().min(50);
        let x = placed(&binned(&stamps), clock);
        Some(Signal { x, extent, distinct, whole, step })
    }

    /// Whether it never changes.
    pub(crate) fn constant(&self) -> bool {
        self.distinct < 2
    }
}

/// Means of the samples within each period of the common clock, each at the mean of its stamps.
fn binned(stamps: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let place = |t: f64| (t * RATE).floor();
    let mean = |bin: &[(f64, f64)]| {
        let n = bin.len() as f64;
        (bin.iter().map(|s| s.0).sum::<f64>() / n, bin.iter().map(|s| s.1).sum::<f64>() / n)
    };
    stamps.chunk_by(|a, b| place(a.0) == place(b.0)).map(mean).collect()
}

/// On straight lines between samples; NaN in gaps.
fn placed(stamps: &[(f64, f64)], clock: Clock) -> Vec<f64> {
    let mut steps: Vec<f64> = stamps.windows(2).map(|w| w[1].0 - w[0].0).collect();
    let limit = order::median(&mut steps).map_or(BRIDGE, |p| BRIDGE.max(BRIDGED * p));
    let mut right = 0;
    let at = |i: usize| {
        let t = clock.start + i as f64 / RATE;
        while right < stamps.len() && stamps[right].0 < t {
            right += 1;
        }
        let (Some(b), Some(a)) = (stamps.get(right), stamps.get(right.wrapping_sub(1))) else {
            return f64::NAN;
        };
        if b.0 - a.0 > limit {
            return f64::NAN;
        }
        a.1 + (t - a.0) / (b.0 - a.0) * (b.1 - a.1)
    };
    (0..clock.len).map(at).collect()
}

/// Mean over `half` points either side (the outermost count half), NaN where one is missing: of a rate it is the
/// change of its integral over that time.
pub(super) fn mean(x: &[f64], half: usize) -> Vec<f64> {
    let (mut sums, mut missing) = (vec![0.0; x.len() + 1], vec![0_u32; x.len() + 1]);
    for (i, v) in x.iter().enumerate() {
        sums[i + 1] = sums[i] + if v.is_finite() { *v } else { 0.0 };
        missing[i + 1] = missing[i] + u32::from(!v.is_finite());
    }
    let at = |i: usize| {
        if i < half || i + half >= x.len() || missing[i + half + 1] > missing[i - half] {
            return f64::NAN;
        }
        let ends = 0.5 * (x[i - half] + x[i + half]);
        (sums[i + half + 1] - sums[i - half] - ends) / (2 * half).max(1) as f64
    };
    (0..x.len()).map(at).collect()
}

/// Rate of change over `half` points either side, per second; NaN where one is missing.
pub(super) fn change(x: &[f64], half: usize) -> Vec<f64> {
    let at = |i: usize| match (i.checked_sub(half).map(|a| x[a]), x.get(i + half)) {
        (Some(a), Some(b)) => (b - a) * RATE / (2 * half) as f64,
        _ => f64::NAN,
    };
    (0..x.len()).map(at).collect()
}

/// The same, `delay` (s) earlier: what a channel would have been without its delay.
pub(super) fn earlier(x: &[f64], delay: f64) -> Vec<f64> {
    if delay == 0.0 {
        return x.to_vec();
    }
    let at = |i: usize| {
        let place = i as f64 + delay * RATE;
        if place < 0.0 {
            return f64::NAN;
        }
        let (low, part) = (place.floor() as usize, place.fract());
        match (x.get(low), x.get(low + 1)) {
            (Some(a), _) if part < 1e-9 => *a,
            (Some(a), Some(b)) => a + part * (b - a),
            _ => f64::NAN,
        }
    };
    (0..x.len()).map(at).collect()
}

/// An angle without the jumps of a circle.
pub(super) fn unwrapped(x: &[f64], circle: f64) -> Vec<f64> {
    let mut out = x.to_vec();
    unwrap_circle(&mut out, circle);
    out
}

/// A straight line through points, those far off it left out of slope and offset.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub slope: f64,
    pub offset: f64,
    /// Correlation, all points.
    pub r: f64,
    /// Root mean square off the line, without those far off.
    pub rms: f64,
}

/// Fewest points of a line: 10 s.
const MIN_POINTS: usize = 200;

/// `y = slope x + offset` over the points where both are numbers; `None` of fewer than 10 s, or where one is constant.
pub(super) fn line(x: &[f64], y: &[f64]) -> Option<Line> {
    let points: Vec<(f64, f64)> = x
        .iter()
        .zip(y)
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .map(|(x, y)| (*x, *y))
        .collect();
    let (slope, offset, r) = least_squares(&points)?;
    let off: Vec<f64> = points.iter().map(|(x, y)| y - slope * x - offset).collect();
    let limit = 3.0 * order::spread_about(&off, 0.0);
    let near: Vec<(f64, f64)> =
        points.iter().zip(&off).filter(|(_, o)| o.abs() <= limit).map(|(p, _)| *p).collect();
    let (slope, offset) = least_squares(&near).map_or((slope, offset), |f| (f.0, f.1));
    let kept = if near.len() >= MIN_POINTS { &near } else { &points };
    let square = |p: &(f64, f64)| (p.1 - slope * p.0 - offset).powi(2);
    let rms = (kept.iter().map(square).sum::<f64>() / kept.len() as f64).sqrt();
    Some(Line { slope, offset, r, rms })
}

fn least_squares(points: &[(f64, f64)]) -> Option<(f64, f64, f64)> {
    if points.len() < MIN_POINTS {
        return None;
    }
    let n = points.len() as f64;
    let (mx, my) =
        (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in points {
        xx += (x - mx) * (x - mx);
        xy += (x - mx) * (y - my);
        yy += (y - my) * (y - my);
    }
    if !(xx > 0.0 && yy > 0.0) {
        return None;
    }
    let slope = xy / xx;
    Some((slope, my - slope * mx, xy / (xx * yy).sqrt()))
}

/// `x` where a condition holds, NaN elsewhere.
pub(super) fn masked(x: &[f64], keep: impl Fn(usize) -> bool) -> Vec<f64> {
    x.iter().enumerate().map(|(i, v)| if keep(i) { *v } else { f64::NAN }).collect()
}

/// The value below which a share of the finite ones lies; NaN where there are none.
pub(super) fn quantile(x: &[f64], share: f64) -> f64 {
    order::quantile(&mut order::finite(x.iter().copied()), share).unwrap_or(f64::NAN)
}

/// Coefficients of `y` on some columns by least squares, and their standard errors; `None` of too few points, or
/// where the columns say the same. Neighbouring points are not independent: they count as a tenth.
pub(super) fn regression(
    columns: &[Vec<f64>],
    y: &[f64],
    keep: impl Fn(usize) -> bool,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let k = columns.len();
    let rows: Vec<usize> = (0..y.len())
        .filter(|&i| keep(i) && y[i].is_finite() && columns.iter().all(|c| c[i].is_finite()))
        .collect();
    if rows.len() < MIN_POINTS / 2 {
        return None;
    }
    let (mut normal, mut right) = (DMatrix::<f64>::zeros(k, k), DVector::<f64>::zeros(k));
    for &i in &rows {
        let row = DVector::from_iterator(k, columns.iter().map(|c| c[i]));
        right += &row * y[i];
        normal += &row * row.transpose();
    }
    let inverse = normal.try_inverse()?;
    let found = &inverse * right;
    let off = |i: usize| y[i] - (0..k).map(|a| found[a] * columns[a][i]).sum::<f64>();
    let left: f64 = rows.iter().map(|&i| off(i).powi(2)).sum();
    let variance = 10.0 * left / rows.len() as f64;
    let error = (0..k).map(|a| (variance * inverse[(a, a)]).sqrt()).collect();
    Some((found.iter().copied().collect(), error))
}
