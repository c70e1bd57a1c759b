//! Derivative and integral of sampled signals.
//!
//! The derivative at a sample is that of the cubic that fits the samples around it best
//! (Savitzky and Golay 1964): an odd FIR kernel about the sample, hence without delay. Within
//! half a window of an end, the cubic of the last whole window is differentiated where the
//! sample lies. Cubics are differentiated exactly; a sine loses little of its amplitude while
//! the window is below half its period.

use nalgebra::{Matrix4, Vector4};

use crate::statistics::runs::next_run;

/// Fewest samples either side of the centre that leave a cubic something to average.
const SMALLEST_HALF: usize = 2;

/// Time derivative of samples at `rate` Hz, by cubics over a window of `window` seconds.
///
/// Each contiguous run is differentiated by itself. In a run shorter than the window the
/// window shrinks to it; runs of fewer than five samples have no derivative (NaN), nor do
/// missing samples.
pub(crate) fn derivative(x: &[f64], rate: f64, window: f64) -> Vec<f64> {
    let mut out = vec![f64::NAN; x.len()];
    let wanted = ((0.5 * window * rate).round() as usize).max(SMALLEST_HALF);
    let mut next = 0;
    while let Some(run) = next_run(x, next) {
        next = run.end;
        let half = wanted.min((run.len() - 1) / 2);
        if half >= SMALLEST_HALF {
            run_derivative(&x[run.clone()], rate, half, &mut out[run]);
        }
    }
    out
}

fn run_derivative(x: &[f64], rate: f64, half: usize, out: &mut [f64]) {
    let (n, width) = (x.len(), 2 * half + 1);
    let dot = |w: &[f64], x: &[f64]| w.iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
    for k in 0..half {
        let w = weights(half, k as f64 - half as f64, rate);
        out[k] = dot(&w, &x[..width]);
        // the far end is the near end, backwards in time
        out[n - 1 - k] = -w.iter().zip(x.iter().rev()).map(|(a, b)| a * b).sum::<f64>();
    }
    let w = weights(half, 0.0, rate);
    for (i, samples) in x.windows(width).enumerate() {
        out[half + i] = dot(&w, samples);
    }
}

/// Weights of samples `-half..=half` that give the best cubic's slope `at` samples from the
/// centre.
fn weights(half: usize, at: f64, rate: f64) -> Vec<f64> {
    let scale = half as f64;
    let powers = |u: f64| Vector4::new(1.0, u, u * u, u * u * u);
    let abscissae = || (0..=2 * half).map(|k| (k as f64 - scale) / scale);
    let normal: Matrix4<f64> =
        abscissae().map(powers).map(|p| p * p.transpose()).fold(Matrix4::zeros(), |a, b| a + b);
    let u = at / scale;
    let slope = Vector4::new(0.0, 1.0, 2.0 * u, 3.0 * u * u) * (rate / scale);
    // five or more distinct abscissae: the normal matrix is regular
    let row = normal.try_inverse().unwrap_or_else(Matrix4::zeros) * slope;
    abscissae().map(|u| row.dot(&powers(u))).collect()
}

/// Integral of samples at `rate` Hz by the trapezoid rule, after their mean is removed (a bias
/// would run away).
///
/// Each contiguous run starts from 0 and loses its own mean; missing samples stay NaN.
pub(crate) fn integral(x: &[f64], rate: f64) -> Vec<f64> {
    let mut out = vec![f64::NAN; x.len()];
    let mut next = 0;
    while let Some(run) = next_run(x, next) {
        next = run.end;
        let samples = &x[run.clone()];
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        let mut sum = 0.0;
        out[run.start] = 0.0;
        for (o, pair) in out[run.start + 1..run.end].iter_mut().zip(samples.windows(2)) {
            sum += (0.5 * (pair[0] + pair[1]) - mean) / rate;
            *o = sum;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f64; 15] = [
        0.0, 0.81235, 1.350285, 1.453319, 1.178944, 0.77559, 0.565787, -0.20553, 0.513788,
        1.558572, 2.62402, 3.409047, 3.757896, 2.733384, 2.587367,
    ];

    /// scipy 1.17.1: `savgol_filter(X, 7, 3, deriv=1, delta=0.01, mode="interp")`.
    const SAVGOL: [f64; 15] = [
        123.695763492063,
        66.278934920635,
        21.76023968254,
        -9.860322222222,
        -27.569955555556,
        -50.913910714286,
        -41.184911904762,
        7.004833333333,
        72.334711507937,
        116.803062301587,
        103.18518968254,
        39.229553174603,
        -3.86340515873,
        -50.874846825397,
        -101.804771825397,
    ];

    /// scipy 1.17.1: `cumulative_trapezoid(X - X.mean(), dx=0.01, initial=0)`.
    const TRAPEZOID: [f64; 15] = [
        0.0,
        -0.011348129333,
        -0.015944833667,
        -0.017336693,
        -0.019585257333,
        -0.025222466667,
        -0.033925461,
        -0.047534055333,
        -0.061402644667,
        -0.066450724,
        -0.060947643333,
        -0.046192187667,
        -0.025767352,
        -0.008720831333,
        0.002473044333,
    ];

    #[test]
    fn derivative_agrees_with_scipy_to_the_ends() {
        for (a, b) in derivative(&X, 100.0, 0.06).iter().zip(SAVGOL) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }

    #[test]
    fn integral_agrees_with_scipy() {
        for (a, b) in integral(&X, 100.0).iter().zip(TRAPEZOID) {
            assert!((a - b).abs() < 1e-11, "{a} {b}");
        }
    }

    #[test]
    fn a_sine_keeps_its_phase() {
        // gains of scipy's `savgol_coeffs(11, 3, deriv=1)` per 2 pi f
        for (f, gain) in [(1.0, 0.999_975_32), (5.0, 0.985_762_27), (10.0, 0.823_065_27)] {
            let w = std::f64::consts::TAU * f;
            let x: Vec<f64> = (0..400).map(|i| (w * f64::from(i) / 100.0).sin()).collect();
            let d = derivative(&x, 100.0, 0.1);
            for (i, got) in d.iter().enumerate().take(395).skip(5) {
                let truth = gain * w * (w * i as f64 / 100.0).cos();
                assert!((got - truth).abs() < 1e-6 * w, "{f} Hz at {i}: {got} {truth}");
            }
        }
    }

    #[test]
    fn runs_are_differentiated_and_integrated_by_themselves() {
        let cubic = |i: usize| (i as f64 / 10.0).powi(3);
        let mut x: Vec<f64> = (0..60).map(cubic).collect();
        x[20..24].fill(f64::NAN);
        x[28] = f64::NAN; // leaves a run of four
        let d = derivative(&x, 10.0, 1.0);
        for i in (0..20).chain(29..60) {
            assert!((d[i] - 3.0 * (i as f64 / 10.0).powi(2)).abs() < 1e-9, "{i}");
        }
        assert!(d[20..29].iter().all(|v| v.is_nan()));
        let s = integral(&x, 10.0);
        assert_eq!((s[0], s[24], s[29]), (0.0, 0.0, 0.0));
        assert!(s[20].is_nan() && s[28].is_nan());
        assert!(derivative(&[], 10.0, 1.0).is_empty() && integral(&[], 10.0).is_empty());
    }
}
