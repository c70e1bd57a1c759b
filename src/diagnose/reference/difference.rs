//! The difference of one number between some rides of a motorcycle and its others.
//!
//! ```text
//! x_i = m + d share_i + scatter s + the excess of ride i's own error over the usual one, and of what other effects,
//!       that vary from ride to ride, move it by
//! s^2 = (nu0 s0^2 + sum of clipped squared residuals) / (nu0 + n - 2)        moderated variance (Smyth 2004)
//! t   = d / error       Student's t with nu0 + n - 2 degrees of freedom
//! ```
//!
//! `share` is 1 inside and 0 outside; of a drift it grows with time from 0 to 1.
//!
//! With few rides the scatter is mostly what is believed of it ([`Belief`]); with many it is what the rides show. Rides far
//! from the others weigh less (Huber 1964), so that faulted ones do not hide the next, as long as they are fewer than about a
//! third.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::belief::Belief;
use super::sets::{DRIFT, Kind, OTHERS, Rides};
use crate::statistics::moderated::{CLIP, CLIPPED};
use crate::statistics::order::{median_of_finite, median_or_zero};

/// Most rounds of reweighting.
const ROUNDS: usize = 20;
/// Change in standard deviations from which on it has settled.
const SETTLED: f64 = 1e-13;

/// A difference between rides inside and outside of a set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Difference {
    /// Mean inside less mean outside; of a drift last less first.
    pub size: f64,
    pub error: f64,
    /// Degrees of freedom of the error.
    pub freedom: f64,
    /// Scatter of a usual ride.
    pub scatter: f64,
}

impl Difference {
    /// Over its standard error.
    pub(crate) fn t(self) -> f64 {
        self.size / self.error
    }

    /// Chance of one as large where nothing differs.
    pub(crate) fn chance(self) -> f64 {
        // degrees of freedom are positive
        StudentsT::new(0.0, 1.0, self.freedom).map_or(1.0, |t| 2.0 * t.sf(self.t().abs()))
    }

    /// Half of its 95 % interval.
    pub(crate) fn half_width(self) -> f64 {
        self.needed(0.05) * self.error
    }

    /// Ratio of size to error that chance exceeds with that probability.
    pub(crate) fn needed(self, chance: f64) -> f64 {
        let quantile = StudentsT::new(0.0, 1.0, self.freedom);
        quantile.map_or(f64::INFINITY, |t| t.inverse_cdf(1.0 - 0.5 * chance))
    }
}

/// What the rides of a motorcycle say of a number.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Column<'a> {
    /// By ride; those that are not numbers are passed over.
    pub values: &'a [f64],
    pub errors: &'a [f64],
    /// Variance by ride beyond scatter and errors. Effects that vary from ride to ride move it more than usual. And a change
    /// that was taken out may leave a remainder.
    pub extra_variance: &'a [f64],
}

/// The difference of a number; `None` where too few rides know it. Of a drift it is that of the last ride from the first.
pub(crate) fn difference(column: Column<'_>, rides: &Rides, belief: Belief) -> Option<Difference> {
    let Column { values, errors, extra_variance } = column;
    let known: Vec<usize> = (0..values.len()).filter(|i| values[*i].is_finite()).collect();
    let share = |i: &usize| rides.share(*i);
    let (others, within): (Vec<usize>, Vec<usize>) = known.iter().partition(|i| share(i) == 0.0);
    let is_drift = rides.kind == Kind::Drift;
    let is_few = match is_drift {
        true => known.len() < DRIFT,
        false => within.len() < rides.least_known() || others.len() < OTHERS,
    };
    if is_few {
        return None;
    }
    let of = |column: &[f64], rides: &[usize]| {
        let values: Vec<f64> = rides.iter().map(|i| column[*i]).collect();
        median_of_finite(&values).unwrap_or(f64::NAN)
    };
    let usual = of(errors, &known);
    let believed = (belief.ratio * usual).powi(2) + belief.natural.powi(2);
    let freedom = belief.freedom + known.len() as f64 - 2.0;
    let excess = |i: usize| {
        belief.ratio.powi(2) * (errors[i].powi(2) - usual * usual).max(0.0) + extra_variance[i]
    };
    let mut points: Vec<Point> = known
        .iter()
        .map(|i| Point { value: values[*i], share: share(i), excess: excess(*i), weight: 0.0 })
        .collect();
    let mut variance = believed;
    // value of a ride: start + share * size
    let (mut start, mut size) = match is_drift {
        true => usual_line(values, &known, share),
        false => (of(values, &others), of(values, &within) - of(values, &others)),
    };
    for _ in 0..ROUNDS {
        let before = [start, size, variance];
        points.iter_mut().for_each(|p| p.weight = (variance + p.excess).recip());
        let line = Line::through(points.iter().map(|p| (p.clipped(start, size), p.share, p.value)));
        (start, size) = (line.start(), line.size());
        let square = |p: &Point| (p.residual(start, size).powi(2) * p.weight).min(CLIP * CLIP);
        let squares: f64 = points.iter().map(square).sum();
        variance = (belief.freedom * believed + variance * squares / CLIPPED) / freedom;
        let scale = variance.sqrt();
        let is_same = |now: f64, before: f64, scale: f64| (now - before).abs() <= SETTLED * scale;
        if is_same(start, before[0], scale)
            && is_same(size, before[1], scale)
            && is_same(variance, before[2], variance)
        {
            break;
        }
    }
    let plain = points.iter().map(|p| ((variance + p.excess).recip(), p.share, p.value));
    let by_day = rides.by_day * belief.natural.powi(2);
    let error = Line::through(plain).error().hypot(by_day.sqrt());
    let scatter = variance.sqrt();
    let is_known = error > 0.0 && error.is_finite() && size.is_finite();
    is_known.then_some(Difference { size, error, freedom, scatter })
}

/// A ride that knows the number.
struct Point {
    value: f64,
    share: f64,
    /// Variance beyond the scatter of a usual ride.
    excess: f64,
    /// Inverse variance.
    weight: f64,
}

impl Point {
    fn residual(&self, start: f64, size: f64) -> f64 {
        self.value - start - self.share * size
    }

    /// Weight, less for rides far from the line.
    fn clipped(&self, start: f64, size: f64) -> f64 {
        let square = self.residual(start, size).powi(2) * self.weight;
        // most rides are near, and need no root
        if square > CLIP * CLIP { CLIP / square.sqrt() * self.weight } else { self.weight }
    }
}

/// Sums of a weighted line `start + x * size`.
#[derive(Default)]
struct Line {
    w: f64,
    wx: f64,
    wxx: f64,
    wy: f64,
    wxy: f64,
}

impl Line {
    /// Through points of weight, `x` and value.
    fn through(points: impl Iterator<Item = (f64, f64, f64)>) -> Self {
        points.fold(Line::default(), |s, (w, x, y)| Line {
            w: s.w + w,
            wx: s.wx + w * x,
            wxx: s.wxx + w * x * x,
            wy: s.wy + w * y,
            wxy: s.wxy + w * x * y,
        })
    }

    fn determinant(&self) -> f64 {
        self.w * self.wxx - self.wx * self.wx
    }

    fn size(&self) -> f64 {
        (self.w * self.wxy - self.wx * self.wy) / self.determinant()
    }

    fn start(&self) -> f64 {
        (self.wy - self.wx * self.size()) / self.w
    }

    /// Standard error of the size where the weights are inverse variances.
    fn error(&self) -> f64 {
        (self.w / self.determinant()).sqrt()
    }
}

/// Start and size of a line that odd rides do not move: the median of the slopes of all pairs (Theil 1950, Sen 1968).
fn usual_line(values: &[f64], known: &[usize], share: impl Fn(&usize) -> f64) -> (f64, f64) {
    let mut slopes = Vec::new();
    for (k, i) in known.iter().enumerate() {
        for j in &known[k + 1..] {
            let apart = share(j) - share(i);
            if apart != 0.0 {
                slopes.push((values[*j] - values[*i]) / apart);
            }
        }
    }
    let size = median_or_zero(&slopes);
    let starts: Vec<f64> = known.iter().map(|i| values[*i] - share(i) * size).collect();
    (median_or_zero(&starts), size)
}
