//! Partial pooling: a session with little data borrows strength from its siblings.
//!
//! ```text
//! B = se^2 / (se^2 + tau^2) * (f - 2) / f          shrinkage: the siblings' weight
//! pooled = B level + (1 - B) y
//! variance = se^2 (1 - B) + B^2 var(level) + (y - level)^2 var(B),  var(B) = B^2 var(tau^2) / (se^2 + tau^2)^2
//! ```
//!
//! Empirical Bayes after Morris (1983), for unequal errors; `f` is the degrees of freedom of `tau`, the last term
//! is for `tau` being an estimate. Siblings are the sessions of the same bike on the same level: after a
//! tyre swap, those after it. A session that an event excludes (an outlier, a wrong bike file) has none and keeps its value.

use super::components::Components;
use super::history::History;
use super::levels;

/// A session's value with its siblings' help.
#[derive(Debug, Clone, PartialEq)]
pub struct Pooled {
    /// Session's value, shrunk towards the motorcycle's other sessions.
    pub value: f64,
    pub error: f64,
    /// The siblings' weight, 0 to 1.
    pub shrinkage: f64,
}

/// Pooled values of coefficient `c` by session, poorly determined ones too; `None` where there is no value.
///
/// Without `components` (too few sessions) every value stays as it is, with shrinkage 0.
pub(crate) fn pool(
    history: &History,
    c: usize,
    columns: &[Vec<f64>],
    components: Option<&Components>,
) -> Vec<Option<Pooled>> {
    let own = |i: usize| {
        let determined = history.values[c][i].is_finite();
        let (values, errors) = match determined {
            true => (&history.values, &history.errors),
            false => (&history.poor, &history.poor_errors),
        };
        values[c][i].is_finite().then(|| (values[c][i], errors[c][i], determined))
    };
    let tau2 = components.map_or(f64::NAN, |k| k.sd * k.sd);
    let tau2_variance = components.map_or(f64::NAN, |k| k.variance);
    let variances: Vec<f64> = history.errors[c].iter().map(|e| tau2 + e * e).collect();
    let level = components.and_then(|k| {
        levels::fit(&history.values[c], &variances, columns).map(|level| (k.freedom as f64, level))
    });
    (0..history.sessions.len())
        .map(|i| {
            let (value, error, determined) = own(i)?;
            let unpooled = Pooled { value, error, shrinkage: 0.0 };
            let Some((f, level)) = &level else { return Some(unpooled) };
            let (mean, spread) = (level.fitted[i], level.variance[i]);
            if !mean.is_finite() || (determined && spread > 0.999 * variances[i]) {
                return Some(unpooled);
            }
            let b = error * error / (error * error + tau2) * (f - 2.0) / f;
            let variance = error * error * (1.0 - b)
                + b * b * spread
                + b * b * (value - mean).powi(2) * tau2_variance / (error * error + tau2).powi(2);
            if !variance.is_finite() {
                return Some(unpooled);
            }
            Some(Pooled {
                value: b * mean + (1.0 - b) * value,
                error: variance.sqrt(),
                shrinkage: b,
            })
        })
        .collect()
}
