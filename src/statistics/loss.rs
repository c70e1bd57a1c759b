//! Tukey's bisquare and the robust scales that go with it.
//!
//! ```text
//! u = r / s
//! rho(u) = c²/6 (1 - (1 - (u/c)²)³),  |u| <= c, else c²/6
//! psi(u) = rho'(u) = u w(u)
//! w(u)   = (1 - (u/c)²)²,             |u| <= c, else 0
//! ```
//! With `c` infinite these become least squares: rho = u²/2, w = 1.
//!
//! Source: Beaton & Tukey (1974), Technometrics 16; scales: Maronna, Martin, Yohai &
//! Salibián-Barrera, "Robust Statistics", 2nd ed. (2019), sections 2.5 and 5.4.

use super::order::median;

/// Tuning constant that gives 95 % efficiency on normal errors.
pub const TUNING: f64 = 4.685;

/// Median of |z| of a standard normal, rounded as in MATLAB and R.
pub(crate) const MAD_NORMAL: f64 = 0.6745;

/// Bisquare weight of a standardised residual.
#[inline]
pub(crate) fn weight(u: f64, tuning: f64) -> f64 {
    let v = u / tuning;
    if v.abs() < 1.0 { (1.0 - v * v).powi(2) } else { 0.0 }
}

/// Derivative of the bisquare's psi at a standardised residual.
#[inline]
pub(crate) fn psi_derivative(u: f64, tuning: f64) -> f64 {
    let v2 = (u / tuning).powi(2);
    if v2 < 1.0 { (1.0 - v2) * (1.0 - 5.0 * v2) } else { 0.0 }
}

/// Median absolute residual about zero over 0.6745: the residuals' standard deviation if they
/// were normal. `scratch` is at least as long as `residuals`.
pub(crate) fn mad(residuals: &[f64], scratch: &mut [f64]) -> f64 {
    mad_beyond(residuals, 0, scratch)
}

/// As [`mad`], without the `p - 1` smallest of the absolute residuals, which a fit of `p`
/// coefficients can make zero at will (MATLAB `robustfit`, `madsigma`).
pub(crate) fn mad_beyond(residuals: &[f64], p: usize, scratch: &mut [f64]) -> f64 {
    mad_near(residuals, p, f64::NAN, scratch)
}

/// As [`mad_beyond`], the sooner the nearer `guess` is to the result: only what is between
/// three quarters and four thirds of it is put in order. The result is the same.
pub(crate) fn mad_near(residuals: &[f64], p: usize, guess: f64, scratch: &mut [f64]) -> f64 {
    let n = residuals.len();
    let skip = if n > p { p.saturating_sub(1) } else { 0 };
    let rest = n - skip;
    if rest > 64 && guess > 0.0 {
        let (low, high) = (0.75 * guess * MAD_NORMAL, guess * MAD_NORMAL / 0.75);
        let (mut below, mut found) = (0, 0);
        for r in residuals {
            let a = r.abs();
            // without a branch: which of them it is cannot be predicted
            scratch[found] = a;
            below += usize::from(a < low);
            found += usize::from(a >= low && a < high);
        }
        // places of the middle one, or of the two in the middle
        let (first, last) = (skip + (rest - 1) / 2, skip + rest / 2);
        if first >= below && last < below + found {
            let inside = &mut scratch[..found];
            let (left, &mut upper, _) = inside.select_nth_unstable_by(last - below, f64::total_cmp);
            let lower = match last - first {
                0 => upper,
                _ => left.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            };
            return 0.5 * (lower + upper) / MAD_NORMAL;
        }
    }
    let scratch = &mut scratch[..n];
    for (s, r) in scratch.iter_mut().zip(residuals) {
        *s = r.abs();
    }
    if skip == 0 {
        return median(scratch).unwrap_or(f64::NAN) / MAD_NORMAL;
    }
    scratch.select_nth_unstable_by(skip, f64::total_cmp);
    median(&mut scratch[skip..]).unwrap_or(f64::NAN) / MAD_NORMAL
}

/// Tuning constant and level of the S-scale: breakdown point one half.
const S_TUNING: f64 = 1.547_645;
/// Tuning constant of the second loss of the tau-scale: 95 % efficiency.
const TAU_TUNING: f64 = 6.08;
/// One over the mean of that loss on normal residuals (quadrature, scipy 1.17.1).
const TAU_CONSISTENT: f64 = 2.168_011_892;

/// S-scale of residuals: half of them may be bad. Which of two fits of the same data is the
/// better one is judged by it. `scratch` as for [`mad`].
///
/// ```text
/// mean rho1(r / s) = max(rho1) / 2        s by fixed-point iteration from the MAD
/// ```
/// Source: Rousseeuw & Yohai (1984), Springer LNS 26.
pub(crate) fn s_scale(residuals: &[f64], scratch: &mut [f64]) -> f64 {
    let n = residuals.len() as f64;
    let start = mad(residuals, scratch);
    if !(start > 0.0 && start.is_finite()) {
        return start;
    }
    let target = 0.5 * S_TUNING * S_TUNING / 6.0;
    let mut s = start;
    for _ in 0..50 {
        let mean = sum_of_rho(residuals, s, S_TUNING) / n;
        let ratio = (mean / target).sqrt();
        s *= ratio;
        if (ratio - 1.0).abs() < 1e-5 || s <= 1e-12 * start {
            break;
        }
    }
    s
}

/// Sum of [`rho`] of residuals over their scale, in four lanes so that the compiler can vectorise it; `tuning` is finite.
fn sum_of_rho(residuals: &[f64], scale: f64, tuning: f64) -> f64 {
    let per_unit = 1.0 / (scale * tuning);
    let lost = |r: f64| {
        let near = (1.0 - (r * per_unit).powi(2)).max(0.0);
        1.0 - near * near * near
    };
    let mut lanes = [0.0; 4];
    let (fours, rest) = residuals.as_chunks::<4>();
    for four in fours {
        for k in 0..4 {
            lanes[k] += lost(four[k]);
        }
    }
    let rest: f64 = rest.iter().map(|r| lost(*r)).sum();
    tuning * tuning / 6.0 * (lanes.iter().sum::<f64>() + rest)
}

/// Tau-scale of residuals: bounded like the S-scale, yet almost as precise as a standard
/// deviation on normal errors, hence smoother to search on. `scratch` as for [`mad`].
///
/// ```text
/// tau² = s² mean rho2(r / s) / E rho2(z)  s the S-scale, z standard normal
/// ```
/// The S-scale is taken no smaller than `floor`: on a clean ride the last digit of the many easy
/// samples must not buy the loss of the few informative ones.
///
/// Source: Yohai & Zamar (1988), JASA 83.
pub(crate) fn tau_scale(residuals: &[f64], floor: f64, scratch: &mut [f64]) -> f64 {
    let s = s_scale(residuals, scratch).max(floor);
    if !(s > 0.0 && s.is_finite()) {
        return s;
    }
    let mean = sum_of_rho(residuals, s, TAU_TUNING);
    // so that it is the standard deviation of normal residuals
    s * (TAU_CONSISTENT * mean / residuals.len() as f64).sqrt()
}

/// Robust standard deviation of a few values about their own centre: Qn, the first quartile
/// of all pairwise distances, made unbiased for small samples. `None` below two values.
///
/// Source: Rousseeuw & Croux (1993), JASA 88; factors: Croux & Rousseeuw (1992), COMPSTAT 1.
pub(crate) fn robust_spread(values: &[f64]) -> Option<f64> {
    const SMALL: [f64; 8] = [0.399, 0.994, 0.512, 0.844, 0.611, 0.857, 0.669, 0.872];
    let n = values.len();
    if n < 2 {
        return None;
    }
    let mut distances = Vec::with_capacity(n * (n - 1) / 2);
    for (i, a) in values.iter().enumerate() {
        distances.extend(values[..i].iter().map(|b| (a - b).abs()));
    }
    let h = n / 2 + 1;
    let k = h * (h - 1) / 2;
    let (_, &mut kth, _) = distances.select_nth_unstable_by(k - 1, f64::total_cmp);
    let m = n as f64;
    let factor = match n {
        2..=9 => SMALL[n - 2],
        _ if n % 2 == 1 => m / (m + 1.4),
        _ => m / (m + 3.8),
    };
    Some(2.2219 * factor * kth)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bisquare loss of a standardised residual; near zero it is u²/2.
    fn rho(u: f64, tuning: f64) -> f64 {
        if tuning.is_infinite() {
            return 0.5 * u * u;
        }
        let v2 = (u / tuning).powi(2);
        let top = tuning * tuning / 6.0;
        if v2 < 1.0 { top * (1.0 - (1.0 - v2).powi(3)) } else { top }
    }
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_pcg::Pcg64;

    fn normal(n: usize, seed: u64) -> Vec<f64> {
        let mut rng = Pcg64::seed_from_u64(seed);
        (0..n).map(|_| rng.sample(StandardNormal)).collect()
    }

    #[test]
    fn psi_is_the_slope_of_rho_and_its_derivative_that_of_psi() {
        let h = 1e-5;
        for u in [-5.0, -3.1, -0.4, 0.0, 0.7, 2.2, 4.6, 4.8] {
            let slope = (rho(u + h, TUNING) - rho(u - h, TUNING)) / (2.0 * h);
            assert!((slope - u * weight(u, TUNING)).abs() < 1e-8);
            let psi = |u: f64| u * weight(u, TUNING);
            let bend = (psi(u + h) - psi(u - h)) / (2.0 * h);
            assert!((bend - psi_derivative(u, TUNING)).abs() < 1e-6, "{u}");
        }
        assert_eq!(weight(1e9, f64::INFINITY), 1.0);
        assert_eq!(psi_derivative(1e9, f64::INFINITY), 1.0);
        assert_eq!(rho(3.0, f64::INFINITY), 4.5);
    }

    #[test]
    fn the_mad_does_not_depend_on_the_guess() {
        for (n, p) in [(1001, 0), (1000, 1), (1001, 2), (1000, 3), (70, 2), (3, 2), (2, 2)] {
            let r = normal(n, n as u64);
            let mut scratch = vec![0.0; n];
            let mut sorted: Vec<f64> = r.iter().map(|r| r.abs()).collect();
            sorted.sort_by(f64::total_cmp);
            if n > p {
                sorted.drain(..p.saturating_sub(1));
            }
            let m = sorted.len();
            let expected = 0.5 * (sorted[(m - 1) / 2] + sorted[m / 2]) / MAD_NORMAL;
            for guess in [f64::NAN, 0.0, 1e-9, 0.8, 0.95, 1.0, 1.1, 1.3, 1e9, f64::INFINITY] {
                assert_eq!(mad_near(&r, p, guess, &mut scratch), expected, "{n} {p} {guess}");
            }
        }
    }

    #[test]
    fn scales_are_one_on_normal_residuals_and_survive_outliers() {
        let mut r = normal(20_000, 1);
        let mut scratch = vec![0.0; r.len()];
        assert!((mad(&r, &mut scratch) - 1.0).abs() < 0.02);
        assert!((s_scale(&r, &mut scratch) - 1.0).abs() < 0.02);
        assert!((tau_scale(&r, 0.0, &mut scratch) - 1.0).abs() < 0.02);
        for x in r.iter_mut().take(6_000) {
            *x = 1e6;
        }
        assert!(mad(&r, &mut scratch) < 1.7);
        assert!(s_scale(&r, &mut scratch) < 2.5);
        assert!(tau_scale(&r, 0.0, &mut scratch) < 6.0);
    }

    #[test]
    fn spread_is_unbiased_for_few_normal_values() {
        for n in [2, 3, 5, 8, 12, 25] {
            let all = normal(n * 4000, n as u64);
            let mean = all.chunks(n).filter_map(robust_spread).sum::<f64>() / 4000.0;
            assert!((mean - 1.0).abs() < 0.05, "n = {n}: {mean}");
        }
        assert_eq!(robust_spread(&[1.0]), None);
        // one wild value of nine hardly moves it
        let mut nine = [1.0, 1.2, 0.9, 1.1, 1.05, 0.95, 1.15, 0.98, 1.02];
        let calm = robust_spread(&nine).unwrap_or(f64::NAN);
        nine[3] = 1e6;
        assert!(robust_spread(&nine).unwrap_or(f64::NAN) < 2.0 * calm);
    }
}
