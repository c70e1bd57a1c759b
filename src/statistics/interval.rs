//! Confidence intervals: of a coefficient, and of a ratio of two.
//!
//! ```text
//! delta:    theta ± t(dof) se
//! Fieller:  all q with  (a - q b)² <= t² (V_aa - 2 q V_ab + q² V_bb)
//! ```
//! The ratio `a / b` of two estimates has no standard error where `b` may be zero. Fieller's
//! set has the right coverage there too and becomes unbounded, which is the honest answer.
//!
//! Source: Fieller (1954), JRSS B 16; Franz (2007), "Ratios: a short guide to confidence
//! limits and proper use", arXiv:0710.2024.

use statrs::distribution::{Continuous, ContinuousCDF, Normal, StudentsT};

/// An interval that may have no ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Interval {
    Bounded {
        low: f64,
        high: f64,
    },
    /// The data exclude nothing, or only values between two ends: not an interval at all.
    Unbounded,
}

impl Interval {
    /// The ends, if it has any.
    pub(crate) fn ends(self) -> Option<(f64, f64)> {
        match self {
            Interval::Bounded { low, high } => Some((low, high)),
            Interval::Unbounded => None,
        }
    }
}

/// Half width of a 95 % interval in standard errors: the 0.975 quantile of Student's t.
pub fn t95(dof: f64) -> f64 {
    t_quantile(0.975, dof)
}

/// Quantile of Student's t; the normal's above a million degrees of freedom, infinite
/// (nothing is excluded) where `dof` is not positive.
pub(crate) fn t_quantile(probability: f64, dof: f64) -> f64 {
    if dof > 1e6 {
        return Normal::standard().inverse_cdf(probability);
    }
    match StudentsT::new(0.0, 1.0, dof) {
        Ok(t) if probability > 0.5 => {
            upper_quantile(&t, probability).unwrap_or_else(|| t.inverse_cdf(probability))
        }
        Ok(t) => t.inverse_cdf(probability),
        Err(_) => f64::INFINITY.copysign(probability - 0.5),
    }
}

/// A quantile above the median by Newton's method from the normal's. Above the median the distribution function is
/// concave and the normal's quantile lies below the answer, so each step goes up and none goes beyond it. A tenth of the
/// time of the library's inverse; `None` of tails so heavy that steps do not settle.
fn upper_quantile(t: &StudentsT, probability: f64) -> Option<f64> {
    let mut x = Normal::standard().inverse_cdf(probability);
    for _ in 0..20 {
        let step = (probability - t.cdf(x)) / t.pdf(x);
        x += step;
        if step.abs() <= 1e-13 * x {
            return Some(x);
        }
    }
    None
}

/// 95 % interval of an estimate with standard error `se`.
pub(crate) fn delta(estimate: f64, se: f64, dof: f64) -> Interval {
    let half = t95(dof) * se;
    if half.is_finite() && estimate.is_finite() {
        Interval::Bounded { low: estimate - half, high: estimate + half }
    } else {
        Interval::Unbounded
    }
}

/// 95 % interval of `numerator / denominator` by Fieller's theorem.
///
/// `covariance` is `[V_aa, V_ab, V_bb]`. Unbounded where the denominator is not different
/// from zero at this confidence.
pub(crate) fn ratio(numerator: f64, denominator: f64, covariance: [f64; 3], dof: f64) -> Interval {
    ratio_at(numerator, denominator, covariance, t95(dof))
}

/// As [`ratio`], `t` standard errors wide.
pub(crate) fn ratio_at(numerator: f64, denominator: f64, covariance: [f64; 3], t: f64) -> Interval {
    let [v_aa, v_ab, v_bb] = covariance;
    // A q² - 2 B q + C <= 0
    let a = denominator * denominator - t * t * v_bb;
    let b = numerator * denominator - t * t * v_ab;
    let c = numerator * numerator - t * t * v_aa;
    let discriminant = b * b - a * c;
    if !(a > 0.0 && discriminant >= 0.0 && discriminant.is_finite()) {
        return Interval::Unbounded;
    }
    let root = discriminant.sqrt();
    Interval::Bounded { low: (b - root) / a, high: (b + root) / a }
}

/// Standard error of a ratio by the delta method, for where the denominator is well away from
/// zero.
pub(crate) fn ratio_se(numerator: f64, denominator: f64, covariance: [f64; 3]) -> f64 {
    let [v_aa, v_ab, v_bb] = covariance;
    let q = numerator / denominator;
    let variance = v_aa - 2.0 * q * v_ab + q * q * v_bb;
    variance.max(0.0).sqrt() / denominator.abs()
}

/// Degrees of freedom of a sum of independent variances by Welch and Satterthwaite; `parts`
/// are `(standard error, degrees of freedom)`, infinite for what is known from outside.
pub(crate) fn combined_dof(parts: &[(f64, f64)]) -> f64 {
    let total: f64 = parts.iter().map(|(s, _)| s * s).sum();
    let below: f64 = parts.iter().map(|(s, dof)| s.powi(4) / dof).sum();
    if below > 0.0 { total * total / below } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_pcg::Pcg64;

    #[test]
    fn the_own_inverse_is_the_librarys() {
        for dof in [0.6, 1.0, 1.7, 2.0, 3.3, 7.9, 25.0, 400.0, 9e5] {
            for probability in [0.6, 0.9, 0.975, 0.999] {
                let library =
                    StudentsT::new(0.0, 1.0, dof).expect("positive").inverse_cdf(probability);
                let own = t_quantile(probability, dof);
                assert!(
                    (own / library - 1.0).abs() < 1e-9,
                    "{dof}, {probability}: {own}, {library}"
                );
            }
        }
    }

    #[test]
    fn t_quantiles_as_in_the_tables() {
        // Student's t, two-sided 95 %: any textbook's table
        for (dof, t) in [(1.0, 12.706), (2.0, 4.303), (5.0, 2.571), (10.0, 2.228), (30.0, 2.042)] {
            assert!((t95(dof) - t).abs() < 6e-4, "{dof}: {}", t95(dof));
        }
        // scipy 1.17.1: scipy.stats.t.ppf(0.975, 3.7)
        assert!((t95(3.7) - 2.867_520_707_19).abs() < 1e-6, "{}", t95(3.7));
        assert!((t95(1e9) - 1.959_964).abs() < 1e-5);
        assert_eq!(t95(0.0), f64::INFINITY);
        assert_eq!(delta(1.0, 0.1, f64::NAN), Interval::Unbounded);
    }

    #[test]
    fn ratio_of_uncorrelated_estimates_by_hand() {
        // a = 10, b = 5, se 1 each, t = 2: 21 q² - 100 q + 96 = 0
        let Some((low, high)) = ratio_at(10.0, 5.0, [1.0, 0.0, 1.0], 2.0).ends() else {
            panic!("bounded")
        };
        let root = (100.0_f64 * 100.0 - 4.0 * 21.0 * 96.0).sqrt();
        assert!((low - (100.0 - root) / 42.0).abs() < 1e-12);
        assert!((high - (100.0 + root) / 42.0).abs() < 1e-12);
        // with a sure denominator it is the plain interval
        assert_eq!(ratio_at(10.0, 5.0, [1.0, 0.0, 0.0], 2.0).ends(), Some((1.6, 2.4)));
        // a denominator within 2 standard errors of zero excludes nothing
        assert_eq!(ratio_at(10.0, 1.9, [1.0, 0.0, 1.0], 2.0), Interval::Unbounded);
        assert_eq!(ratio(f64::NAN, 1.0, [1.0, 0.0, 1.0], 5.0), Interval::Unbounded);
    }

    #[test]
    fn coverage_stays_right_where_the_delta_interval_fails() {
        // a = 1, b = 3 se: the delta interval is skewed the wrong way
        let (a, b) = (1.0, 3.0);
        let mut rng = Pcg64::seed_from_u64(7);
        let (mut fieller, mut plain, n) = (0, [0, 0], 20_000);
        for _ in 0..n {
            let z: f64 = rng.sample(StandardNormal);
            let y: f64 = rng.sample(StandardNormal);
            let (a1, b1) = (a + 0.4 * (0.6 * z + 0.8 * y), b + z);
            let covariance = [0.16, 0.24, 1.0];
            fieller += usize::from(
                ratio(a1, b1, covariance, f64::INFINITY)
                    .ends()
                    .is_none_or(|(low, high)| (low..=high).contains(&(a / b))),
            );
            let se = ratio_se(a1, b1, covariance);
            let (low, high) = (a1 / b1 - 1.96 * se, a1 / b1 + 1.96 * se);
            plain[0] += usize::from(a / b < low);
            plain[1] += usize::from(a / b > high);
        }
        let share = fieller as f64 / n as f64;
        // a little above 95 %: a set that excludes only a middle piece is reported as unbounded
        assert!((0.945..0.97).contains(&share), "{share}");
        assert!(plain[0].abs_diff(plain[1]) as f64 > 0.01 * n as f64, "{plain:?}");
    }

    #[test]
    fn sums_of_variances() {
        assert_eq!(combined_dof(&[(2.0, 7.0), (0.0, 1.0)]), 7.0);
        // two equal ones: the degrees add up
        assert!((combined_dof(&[(1.0, 6.0), (1.0, 6.0)]) - 12.0).abs() < 1e-12);
        assert_eq!(combined_dof(&[(1.0, f64::INFINITY)]), f64::INFINITY);
    }
}
