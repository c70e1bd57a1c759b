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
use crate::statistics::search;

/// Fewest degrees of freedom that a spread is estimated from.
const FREEDOM: usize = 3;

/// Spread between sessions of one coefficient.
#[derive(Debug, Clone, PartialEq)]
pub struct Components {
    /// Standard deviation between sessions, `tau`.
    pub sd: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
    /// Degrees of freedom.
    pub freedom: usize,
    /// Variance of `tau^2`: `2 / sum w^2`.
    pub variance: f64,
}

/// Values with their standard errors, NaN passed over, and the columns of their level as
/// [`levels::fit`] takes them.
#[derive(Debug, Clone)]
pub(crate) struct Part<'a> {
    /// A value per session, NaN where there is none.
    pub values: &'a [f64],
    /// Standard error of each value.
    pub errors: &'a [f64],
    /// Columns of the level, each as long as the values.
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
    search::root(|x| f(x).unwrap_or(f64::NAN), low, high, 1e-12 * high)
}

/// The components; `None` of fewer than three degrees of freedom.
pub(crate) fn between(part: &Part<'_>) -> Option<Components> {
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

/// Only the point: [`Components::sd`].
pub(crate) fn sd(part: &Part<'_>) -> Option<f64> {
    root(part.most()?, |t| part.score(t)).map(f64::sqrt)
}

/// One spread for several bikes, each with its own levels: the same equation, summed over them.
/// `None` where no bike has enough.
pub(crate) fn common(parts: &[&Part<'_>]) -> Option<f64> {
    let enough = |p: &&&Part<'_>| p.fit(0.0).is_some_and(|f| f.2.freedom >= FREEDOM);
    let parts: Vec<&&Part<'_>> = parts.iter().filter(enough).collect();
    let most = parts.iter().filter_map(|p| p.most()).fold(f64::NAN, f64::max);
    if !most.is_finite() {
        return None;
    }
    root(most, |t| Some(parts.iter().filter_map(|p| p.score(t)).sum())).map(f64::sqrt)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part<'a>(values: &'a [f64], errors: &'a [f64]) -> Part<'a> {
        Part { values, errors, columns: vec![vec![1.0; values.len()]] }
    }

    /// Equal errors: the sample variance less theirs, and its chi-squared interval, 4 degrees of freedom.
    #[test]
    fn with_equal_errors_it_is_the_sample_variance_less_theirs() {
        let values = [1.0, 2.0, 3.0, 4.0, 5.0];
        let found = between(&part(&values, &[0.5; 5])).expect("components");
        assert!((found.sd - 2.25_f64.sqrt()).abs() < 1e-6, "{found:?}");
        assert!((found.low - (10.0_f64 / 11.143_287 - 0.25).sqrt()).abs() < 1e-5, "{found:?}");
        assert!((found.high - (10.0_f64 / 0.484_418_6 - 0.25).sqrt()).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn errors_that_explain_all_leave_nothing_and_few_values_say_nothing() {
        let found = between(&part(&[1.0, 1.01, 0.99, 1.0, 1.02], &[0.1; 5])).expect("components");
        assert_eq!((found.sd, found.low), (0.0, 0.0));
        assert_eq!(between(&part(&[1.0, 2.0, 3.0], &[0.1; 3])), None);
        assert_eq!(between(&part(&[f64::NAN; 9], &[0.1; 9])), None);
    }

    #[test]
    fn one_spread_for_bikes_of_different_level() {
        let (a, b) = ([1.0, 2.0, 3.0, 4.0, 5.0], [101.0, 102.0, 103.0, 104.0, 105.0]);
        let (a, b) = (part(&a, &[0.5; 5]), part(&b, &[0.5; 5]));
        assert!((common(&[&a, &b]).expect("sd") - 1.5).abs() < 1e-6);
        assert_eq!(common(&[]), None);
    }
}
