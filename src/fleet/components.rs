//! Between sessions: how much values differ beyond what their standard errors explain.
//!
//! ```text
//! y_i = level_i + b_i + e_i,   b_i ~ (0, tau^2),  e_i ~ (0, se_i^2) known
//! Q(tau^2) = sum (y_i - level_i)^2 / (tau^2 + se_i^2) = k - q       Paule and Mandel (1982)
//! ```
//!
//! `Q` at the truth is chi-squared with `k - q` degrees of freedom: the interval is where it lies
//! between the distribution's 2.5 % and 97.5 % (Viechtbauer 2007, "Q-profile").

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::levels::{self, Level};

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
    /// Root mean square of the standard errors.
    pub within: f64,
}

/// The components; values that are NaN are passed over, `columns` as [`levels::fit`] takes them.
/// `None` of fewer than three degrees of freedom.
pub fn between(values: &[f64], errors: &[f64], columns: &[Vec<f64>]) -> Option<Components> {
    let fit = |tau2: f64| -> Option<(f64, Level)> {
        let variances: Vec<f64> = errors.iter().map(|e| tau2 + e * e).collect();
        let level = levels::fit(values, &variances, columns)?;
        let q = (0..values.len())
            .filter(|i| values[*i].is_finite())
            .map(|i| (values[i] - level.fitted[i]).powi(2) / variances[i])
            .sum();
        Some((q, level))
    };
    let (q, level) = fit(0.0)?;
    let freedom = level.freedom;
    if freedom < 3 || !q.is_finite() {
        return None;
    }
    let known: Vec<usize> = (0..values.len()).filter(|i| values[*i].is_finite()).collect();
    let within =
        (known.iter().map(|i| errors[*i].powi(2)).sum::<f64>() / known.len() as f64).sqrt();
    let most = known.iter().map(|i| (values[*i] - level.fitted[*i]).powi(2)).fold(0.0, f64::max);
    // Q falls with tau^2; where it meets the target
    let solve = |target: f64| -> Option<f64> {
        if q <= target {
            return Some(0.0);
        }
        let (mut low, mut high) = (0.0, most.max(f64::MIN_POSITIVE));
        while fit(high)?.0 > target {
            high *= 4.0;
        }
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if fit(middle)?.0 > target { low = middle } else { high = middle }
        }
        Some(high.sqrt())
    };
    let chi = ChiSquared::new(freedom as f64).ok()?;
    Some(Components {
        sd: solve(freedom as f64)?,
        low: solve(chi.inverse_cdf(0.975))?,
        high: solve(chi.inverse_cdf(0.025))?,
        freedom,
        within,
    })
}

/// Spread between sessions of one coefficient over several bikes: the root mean square, weighted by degrees
/// of freedom. `None` of none.
pub fn pooled<'a>(bikes: impl Iterator<Item = &'a Components>) -> Option<f64> {
    let (top, bottom) = bikes
        .fold((0.0, 0.0), |(t, b), k| (t + k.freedom as f64 * k.sd * k.sd, b + k.freedom as f64));
    (bottom > 0.0).then(|| (top / bottom).sqrt())
}
