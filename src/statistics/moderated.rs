//! Variances of many small groups that learn from each other: empirical Bayes (Smyth 2004, robustly as Phipson et al. 2016).
//!
//! ```text
//! log s_g^2 = log s_0^2 + error of the group + spread between groups
//! d_0       : degrees of freedom with trigamma(d_0 / 2) = variance of that spread
//! ```

use statrs::function::gamma::digamma;

use super::order::median_of_finite;

/// Standard deviations from which on a residual counts no more.
pub(crate) const CLIP: f64 = 1.5;
/// Mean of a squared standard normal variable that is clipped there.
pub(crate) const CLIPPED: f64 = 0.778_46;
/// Median of a squared standard normal variable.
const MEDIAN: f64 = 0.454_94;
/// Rounds of the robust variance.
const ROUNDS: usize = 30;
/// Degrees of freedom of what is believed of a variance before other groups are seen.
pub(crate) const BELIEF: f64 = 4.0;
/// Least and most degrees of freedom that groups can give.
const FREEDOM: [f64; 2] = [1.0, 10.0];
/// Groups that the spread of [`BELIEF`] counts as.
const BELIEVED_GROUPS: f64 = 3.0;

/// A variance as a group has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GroupVariance {
    /// Logarithm of the variance over the one that is believed.
    pub log: f64,
    /// Its degrees of freedom.
    pub freedom: f64,
}

impl GroupVariance {
    /// Logarithm without the bias of few degrees of freedom.
    fn unbiased(self) -> f64 {
        let half = 0.5 * self.freedom;
        self.log - digamma(half) + half.ln()
    }

    /// Variance of the logarithm.
    fn variance(self) -> f64 {
        trigamma(0.5 * self.freedom)
    }
}

/// Factor on the believed standard deviation, and degrees of freedom of what is then believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scatter {
    pub factor: f64,
    pub freedom: f64,
}

impl Default for Scatter {
    fn default() -> Self {
        Scatter { factor: 1.0, freedom: BELIEF }
    }
}

/// What groups teach of the variance of another one. The belief counts as one group more, with a factor of 1; without
/// groups it is left as it is.
pub(crate) fn learnt(groups: &[GroupVariance]) -> Scatter {
    let n = groups.len() as f64;
    if groups.is_empty() {
        return Scatter::default();
    }
    let mean = groups.iter().map(|g| g.unbiased()).sum::<f64>() / n;
    let squares: f64 = groups.iter().map(|g| (g.unbiased() - mean).powi(2)).sum();
    let noise = groups.iter().map(|g| g.variance()).sum::<f64>() * (n - 1.0) / n;
    let believed = BELIEVED_GROUPS * trigamma(0.5 * BELIEF);
    let least = trigamma(0.5 * FREEDOM[1]);
    let spread = ((squares - noise + believed) / (n - 1.0 + BELIEVED_GROUPS)).max(least);
    let weights = || groups.iter().map(|g| (spread + g.variance()).recip());
    let top: f64 = groups.iter().zip(weights()).map(|(g, w)| w * g.unbiased()).sum();
    let log = top / (weights().sum::<f64>() + spread.recip());
    let freedom = (2.0 * inverse_trigamma(spread)).clamp(FREEDOM[0], FREEDOM[1]);
    Scatter { factor: (0.5 * log).exp(), freedom }
}

/// Variance of residuals of mean 0, given as squares, that a few large ones do not move (Huber 1964); `None` of no
/// residuals, or if more than half are 0.
pub(crate) fn clipped_variance(squares: &[f64]) -> Option<f64> {
    let mut variance = median_of_finite(squares)? / MEDIAN;
    for _ in 0..ROUNDS {
        let sum: f64 = squares.iter().map(|s| (s / variance).min(CLIP * CLIP)).sum();
        variance *= sum / (CLIPPED * squares.len() as f64);
    }
    (variance > 0.0 && variance.is_finite()).then_some(variance)
}

/// Second derivative of the logarithm of the gamma function, of a positive number.
pub(crate) fn trigamma(mut x: f64) -> f64 {
    let mut sum = 0.0;
    while x < 8.0 {
        sum += (x * x).recip();
        x += 1.0;
    }
    // asymptotic series
    let y = (x * x).recip();
    sum + 0.5 * y + (1.0 + y * (1.0 / 6.0 - y * (1.0 / 30.0 - y / 42.0))) / x
}

/// The number of which [`trigamma`] is a positive number: Newton's rule on its inverse, from below (Smyth 2004).
fn inverse_trigamma(value: f64) -> f64 {
    let mut x = 0.5 + value.recip();
    for _ in 0..50 {
        let now = trigamma(x);
        let slope = (trigamma(x * (1.0 + 1e-5)) - now) / (x * 1e-5);
        let step = now * (1.0 - now / value) / slope;
        x += step;
        if step.abs() < 1e-8 * x {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    #[test]
    fn trigamma_is_that_of_the_tables_and_its_inverse_leads_back() {
        let pi2 = std::f64::consts::PI.powi(2);
        for (x, known) in [(1.0, pi2 / 6.0), (0.5, pi2 / 2.0), (2.0, pi2 / 6.0 - 1.0)] {
            assert!((trigamma(x) - known).abs() < 1e-9, "{x}: {} for {known}", trigamma(x));
            assert!((inverse_trigamma(known) - x).abs() < 1e-5, "{x}: {}", inverse_trigamma(known));
        }
    }

    #[test]
    fn a_few_large_residuals_do_not_move_a_variance() {
        let mut random = Random::new(1, "residuals");
        let mut squares: Vec<f64> = (0..2000).map(|_| (3.0 * random.normal()).powi(2)).collect();
        let clean = clipped_variance(&squares).expect("a variance");
        assert!((clean / 9.0 - 1.0).abs() < 0.1, "{clean}");
        squares.iter_mut().take(100).for_each(|s| *s = 1e6);
        let moved = clipped_variance(&squares).expect("a variance");
        assert!(moved / clean < 1.25, "{moved} of {clean}");
        assert_eq!(clipped_variance(&[]), None);
        assert_eq!(clipped_variance(&[0.0, 0.0, 0.0, 1.0]), None);
    }

    /// Groups of ten values each: their common factor is found, and whether they agree.
    #[test]
    fn groups_teach_the_variance_and_how_far_it_holds() {
        let groups = |spread: f64| -> Vec<GroupVariance> {
            let mut random = Random::new(2, "groups");
            let of = |random: &mut Random| {
                let sd = 5.0 * (spread * random.normal()).exp();
                let squares: f64 = (0..10).map(|_| (sd * random.normal()).powi(2)).sum();
                GroupVariance { log: (squares / 10.0).ln(), freedom: 10.0 }
            };
            (0..30).map(|_| of(&mut random)).collect()
        };
        let alike = learnt(&groups(0.0));
        assert!((4.4..5.4).contains(&alike.factor) && alike.freedom > 6.0, "{alike:?}");
        let apart = learnt(&groups(1.0));
        assert!(apart.freedom < 2.0, "{apart:?}");
        // one group is no more than the belief beside it
        let one = learnt(&groups(0.0)[..1]);
        assert!((1.5..3.5).contains(&one.factor) && one.freedom < 5.0, "{one:?}");
        assert_eq!(learnt(&[]), Scatter::default());
    }
}
