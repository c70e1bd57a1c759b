//! Between sessions: how much values differ beyond what their standard errors explain.
//!
//! ```text
//! y_i = level_i + b_i + e_i,   b_i ~ (0, tau^2),  e_i ~ (0, se_i^2) known
//! sum w_i^2 (r_i^2 - (tau^2 + se_i^2 - h_i)) = 0,   w_i = 1 / (tau^2 + se_i^2)        point
//! Q(tau^2) = sum w_i r_i^2 ~ chi-squared with k - q degrees of freedom                 interval
//! ```
//!
//! `r` are residuals of the weighted fit, `h` the variances of the fitted levels. The first is the
//! restricted likelihood's score with its expectation taken residual by residual; precise
//! sessions count most, as they know most of `tau`. The interval is where `Q` lies between its 2.5 % and
//! 97.5 % (Viechtbauer 2007, "Q-profile").

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::levels::{self, Level};

/// Fewest degrees of freedom that a spread is told from.
const FREEDOM: usize = 3;

/// Spread between sessions of one coefficient.
#[derive(Debug, Clone, PartialEq)]
pub struct Components {
    /// Standard deviation between sessions, `tau`.
    pub sd: f64,
    /// 95 % interval.
    pub low: f64,
    /// 95 % interval.
    pub high: f64,
    /// Degrees of freedom.
    pub freedom: usize,
    /// Variance of `tau^2`: `2 / sum w^2`.
    pub variance: f64,
}

/// Values with their standard errors, NaN passed over, and the columns of their level as
/// [`levels::fit`] takes them.
#[derive(Debug, Clone)]
pub struct Part<'a> {
    /// Values.
    pub values: &'a [f64],
    /// Standard errors.
    pub errors: &'a [f64],
    /// Columns.
    pub columns: Vec<Vec<f64>>,
}

impl Part<'_> {
    /// Residual and variance of each value, and the level, at a given `tau^2`.
    fn fit(&self, tau2: f64) -> Option<(Vec<usize>, Vec<f64>, Level)> {
        let variances: Vec<f64> = self.errors.iter().map(|e| tau2 + e * e).collect();
        let level = levels::fit(self.values, &variances, &self.columns)?;
        let known = (0..self.values.len()).filter(|i| self.values[*i].is_finite()).collect();
        Some((known, variances, level))
    }

    fn score(&self, tau2: f64) -> Option<f64> {
        let (known, v, level) = self.fit(tau2)?;
        let term = |i: usize| {
            let r = self.values[i] - level.fitted[i];
            (r * r - v[i] + level.variance[i]) / (v[i] * v[i])
        };
        Some(known.into_iter().map(term).sum())
    }

    fn q(&self, tau2: f64) -> Option<f64> {
        let (known, v, level) = self.fit(tau2)?;
        Some(known.into_iter().map(|i| (self.values[i] - level.fitted[i]).powi(2) / v[i]).sum())
    }

    /// Largest squared residual: no `tau^2` lies far beyond it.
    fn most(&self) -> Option<f64> {
        let (known, _, level) = self.fit(0.0)?;
        let squares = known.into_iter().map(|i| (self.values[i] - level.fitted[i]).powi(2));
        Some(squares.fold(f64::MIN_POSITIVE, f64::max))
    }
}

/// Where a function that falls through zero does so, from 0 up; 0 where it starts below.
fn root(most: f64, f: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    if f(0.0)? <= 0.0 {
        return Some(0.0);
    }
    let (mut low, mut high) = (0.0, most);
    for _ in 0..60 {
        if f(high)? <= 0.0 {
            break;
        }
        (low, high) = (high, 4.0 * high);
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if f(middle)? > 0.0 { low = middle } else { high = middle }
    }
    Some(high)
}

/// The components; `None` of fewer than three degrees of freedom.
pub fn between(part: &Part<'_>) -> Option<Components> {
    let (known, _, level) = part.fit(0.0)?;
    let freedom = level.freedom;
    if freedom < FREEDOM {
        return None;
    }
    let most = part.most()?;
    let tau2 = root(most, |t| part.score(t))?;
    let chi = ChiSquared::new(freedom as f64).ok()?;
    let bound = |share: f64| root(most, |t| Some(part.q(t)? - chi.inverse_cdf(share)));
    let squares: f64 = known.iter().map(|i| (tau2 + part.errors[*i].powi(2)).powi(-2)).sum();
    Some(Components {
        sd: tau2.sqrt(),
        low: bound(0.975)?.sqrt(),
        high: bound(0.025)?.sqrt(),
        freedom,
        variance: 2.0 / squares,
    })
}

/// One spread for several bikes, each with its own levels: the same equation, summed over them.
/// `None` where no bike has enough.
pub fn common(parts: &[&Part<'_>]) -> Option<f64> {
    let enough = |p: &&&Part<'_>| p.fit(0.0).is_some_and(|f| f.2.freedom >= FREEDOM);
    let parts: Vec<&&Part<'_>> = parts.iter().filter(enough).collect();
    let most = parts.iter().filter_map(|p| p.most()).fold(f64::NAN, f64::max);
    if !most.is_finite() {
        return None;
    }
    root(most, |t| Some(parts.iter().filter_map(|p| p.score(t)).sum())).map(f64::sqrt)
}
