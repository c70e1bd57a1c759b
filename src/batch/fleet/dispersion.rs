//! Dispersion of a coefficient over sessions: plain functions over slices.

use crate::statistics::order::{SD_PER_MAD, median as median_of};

/// Above so many points the slope is taken over half-range pairs only: all pairs would be
/// quadratic work.
const ALL_PAIRS: usize = 1500;

/// Fewest points for a drift.
const DRIFT_FROM: usize = 3;

/// Robust standard deviation, `1.4826 * median |x - median|`; nothing of a single value.
pub(crate) fn robust_sd(values: &[f64], median: f64) -> Option<f64> {
    if values.len() < 2 {
        return None;
    }
    let mut deviations: Vec<f64> = values.iter().map(|x| (x - median).abs()).collect();
    median_of(&mut deviations).map(|mad| SD_PER_MAD * mad)
}

pub(crate) fn root_mean_square(values: &[f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    Some((values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt())
}

/// Standard deviation between sessions beyond what their standard errors explain: the
/// moment estimator `tau` of DerSimonian and Laird (1986).
///
/// ```text
/// w_i = 1 / e_i^2     Q = sum w_i (x_i - xbar_w)^2
/// tau^2 = max(0, (Q - (k - 1)) / (sum w - sum w^2 / sum w))
/// ```
///
/// `errors` are positive and as many as `values`. Nothing of fewer than two.
pub(crate) fn between_sd(values: &[f64], errors: &[f64]) -> Option<f64> {
    if values.len() < 2 {
        return None;
    }
    let weights: Vec<f64> = errors.iter().map(|e| 1.0 / (e * e)).collect();
    let total: f64 = weights.iter().sum();
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    let mean = weights.iter().zip(values).map(|(w, x)| w * x).sum::<f64>() / total;
    let q: f64 = weights.iter().zip(values).map(|(w, x)| w * (x - mean).powi(2)).sum();
    let tau2 = (q - (values.len() - 1) as f64) / (total - squares / total);
    tau2.is_finite().then(|| tau2.max(0.0).sqrt())
}

/// Theil-Sen slope: the median of the slopes of all pairs whose times differ.
///
/// Of very many points only the pairs half the range apart take part (Theil's incomplete
/// method). Nothing of fewer than three points, or where all times are the same.
pub(crate) fn theil_sen(times: &[f64], values: &[f64]) -> Option<f64> {
    if times.len() < DRIFT_FROM {
        return None;
    }
    let mut points: Vec<(f64, f64)> = times.iter().copied().zip(values.iter().copied()).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let slope = |a: (f64, f64), b: (f64, f64)| (b.0 > a.0).then(|| (b.1 - a.1) / (b.0 - a.0));
    let mut slopes: Vec<f64> = if points.len() <= ALL_PAIRS {
        let pairs = |i: usize| points[i + 1..].iter().map(move |b| (i, *b));
        (0..points.len()).flat_map(pairs).filter_map(|(i, b)| slope(points[i], b)).collect()
    } else {
        let half = points.len().div_ceil(2);
        points.iter().zip(&points[half..]).filter_map(|(a, b)| slope(*a, *b)).collect()
    };
    median_of(&mut slopes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Option<f64>, b: f64) {
        let a = a.expect("a value");
        assert!((a - b).abs() <= 1e-9 * b.abs().max(1.0), "{a} is not {b}");
    }

    #[test]
    fn one_wild_session_does_not_widen_the_robust_spread() {
        close(robust_sd(&[1.0, 2.0, 3.0, 4.0, 500.0], 3.0), 1.4826);
        assert_eq!(robust_sd(&[1.0], 1.0), None);
    }

    #[test]
    fn a_line_has_its_slope_in_spite_of_a_third_of_outliers() {
        let times: Vec<f64> = (0..30).map(f64::from).collect();
        let values: Vec<f64> =
            times.iter().map(|t| if t % 4.0 == 1.0 { 1e3 } else { 5.0 - 0.25 * t }).collect();
        close(theil_sen(&times, &values), -0.25);
        assert_eq!(theil_sen(&[1.0, 1.0, 1.0], &[1.0, 2.0, 3.0]), None);
        assert_eq!(theil_sen(&[1.0, 2.0], &[1.0, 2.0]), None);
    }

    /// The 13 BCG vaccine trials of Colditz et al. (1994): log relative risks and variances from
    /// the counts (vaccinated ill, well; control ill, well). Published by the R package metafor:
    /// `rma(yi, vi, data = dat.bcg, method = "DL")` gives Q = 152.2330, tau^2 = 0.3088.
    #[test]
    fn between_trials_as_published() {
        let counts: [[f64; 4]; 13] = [
            [4., 119., 11., 128.],
            [6., 300., 29., 274.],
            [3., 228., 11., 209.],
            [62., 13536., 248., 12619.],
            [33., 5036., 47., 5761.],
            [180., 1361., 372., 1079.],
            [8., 2537., 10., 619.],
            [505., 87886., 499., 87892.],
            [29., 7470., 45., 7232.],
            [17., 1699., 65., 1600.],
            [186., 50448., 141., 27197.],
            [5., 2493., 3., 2338.],
            [27., 16886., 29., 17825.],
        ];
        let effect = |[a, b, c, d]: [f64; 4]| ((a / (a + b)) / (c / (c + d))).ln();
        let error = |[a, b, c, d]: [f64; 4]| (1. / a - 1. / (a + b) + 1. / c - 1. / (c + d)).sqrt();
        let (x, e) = (counts.map(effect), counts.map(error));
        let tau = between_sd(&x, &e).expect("tau");
        assert!((tau * tau - 0.3088).abs() < 5e-5, "{}", tau * tau);
    }

    #[test]
    fn no_spread_beyond_the_errors_is_none() {
        close(between_sd(&[1.0, 1.01, 0.99], &[0.1, 0.1, 0.1]), 0.0);
        assert_eq!(between_sd(&[1.0], &[0.1]), None);
    }

    /// `scipy.stats.theilslopes(y, x)` and `1.4826 * median_abs_deviation(y)`, scipy 1.17.1.
    #[test]
    fn slope_and_spread_as_scipy_has_them() {
        let x = [0.5, 3.25, 1.0, 7.5, 6.0, 6.0, 9.75, 12.0, 15.5];
        let y = [1.02, 1.3, 0.95, 1.71, 9.0, 1.6, 1.95, 2.25, 2.4];
        close(theil_sen(&x, &y), 0.100_540_540_540_540_54);
        close(robust_sd(&y, 1.71), 0.800_604);
    }

    #[test]
    fn many_points_take_the_short_way_to_the_same_slope() {
        let times: Vec<f64> = (0..4001).map(f64::from).collect();
        let values: Vec<f64> = times.iter().map(|t| 2.0 * t + (t * 0.7).sin()).collect();
        let slope = theil_sen(&times, &values).expect("slope");
        assert!((slope - 2.0).abs() < 1e-3, "{slope}");
    }
}
