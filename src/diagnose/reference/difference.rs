//! The difference of one number between some rides of a motorcycle and its others.
//!
//! ```text
//! x_i = m_inside or m_outside + scatter s + the excess of ride i's own error over the usual one
//! s^2 = (nu0 s0^2 + sum of clipped squared residuals) / (nu0 + n - 2)        moderated variance (Smyth 2004)
//! t   = (m_inside - m_outside) / error       Student's t with nu0 + n - 2 degrees of freedom
//! ```
//!
//! With few rides the scatter is mostly what is believed of it ([`Belief`]); with many it is what the rides show. Rides far
//! from the others weigh less (Huber 1964), so that faulted ones do not hide the next, as long as they are fewer than about a
//! third.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::belief::Belief;
use crate::statistics::order::median_of_finite;

/// Degrees of freedom of what is believed of the scatter before any ride is compared.
const BELIEF: f64 = 4.0;
/// Fewest rides on the other side.
pub(crate) const OTHERS: usize = 3;
/// Standard deviations from which on a ride weighs less.
const CLIP: f64 = 1.5;
/// What a clipped squared standard normal is on average.
const CLIPPED: f64 = 0.778_46;
/// Rounds of reweighting.
const ROUNDS: usize = 20;

/// A difference between rides inside and outside of a set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Difference {
    /// Mean inside less mean outside.
    pub size: f64,
    /// Its standard error.
    pub error: f64,
    /// Degrees of freedom of the error.
    pub freedom: f64,
    /// Scatter of a usual ride.
    pub scatter: f64,
    /// Rides that know the number inside and outside.
    pub rides: [usize; 2],
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

    /// What its size over its error exceeds by chance with that probability.
    pub(crate) fn needed(self, chance: f64) -> f64 {
        let quantile = StudentsT::new(0.0, 1.0, self.freedom);
        quantile.map_or(f64::INFINITY, |t| t.inverse_cdf(1.0 - 0.5 * chance))
    }
}

/// The difference of a number with its standard errors by ride; `None` where a side has too few rides that know it. Values
/// that are not numbers are passed over.
pub(crate) fn difference(
    values: &[f64],
    errors: &[f64],
    inside: impl Fn(usize) -> bool,
    belief: Belief,
) -> Option<Difference> {
    let known: Vec<usize> = (0..values.len()).filter(|i| values[*i].is_finite()).collect();
    let (within, others): (Vec<usize>, Vec<usize>) = known.iter().partition(|i| inside(**i));
    if within.is_empty() || others.len() < OTHERS {
        return None;
    }
    let of = |column: &[f64], rides: &[usize]| {
        let values: Vec<f64> = rides.iter().map(|i| column[*i]).collect();
        median_of_finite(&values).unwrap_or(f64::NAN)
    };
    let usual = of(errors, &known);
    let excess = |i: usize| belief.ratio.powi(2) * (errors[i].powi(2) - usual * usual).max(0.0);
    let believed = (belief.ratio * usual).powi(2) + belief.natural.powi(2);
    let freedom = BELIEF + known.len() as f64 - 2.0;
    let mut variance = believed;
    let mut means = [of(values, &within), of(values, &others)];
    let sides = [&within, &others];
    for _ in 0..ROUNDS {
        let mut squares = 0.0;
        for (mean, side) in means.iter_mut().zip(sides) {
            let z = |i: usize, mean: f64| (values[i] - mean) / (variance + excess(i)).sqrt();
            let weight = |i: usize| (CLIP / z(i, *mean).abs().max(CLIP)) / (variance + excess(i));
            let total: f64 = side.iter().map(|i| weight(*i)).sum();
            let next = side.iter().map(|i| weight(*i) * values[*i]).sum::<f64>() / total;
            squares += side.iter().map(|i| z(*i, next).powi(2).min(CLIP * CLIP)).sum::<f64>();
            *mean = next;
        }
        variance = (BELIEF * believed + variance * squares / CLIPPED) / freedom;
    }
    let of_mean =
        |side: &[usize]| side.iter().map(|i| (variance + excess(*i)).recip()).sum::<f64>().recip();
    let error = (of_mean(&within) + of_mean(&others)).sqrt();
    let (size, scatter) = (means[0] - means[1], variance.sqrt());
    let rides = [within.len(), others.len()];
    let is_known = error > 0.0 && error.is_finite() && size.is_finite();
    is_known.then_some(Difference { size, error, freedom, scatter, rides })
}
