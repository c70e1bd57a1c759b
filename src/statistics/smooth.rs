//! One smoother for every signal: derivatives are gradients of the smoothed signal, so that signals and
//! their derivatives have lost the same (`book/src/diagnosis.md`, section 5, pitfall 4).

use std::ops::Range;

use super::runs::runs;

/// Window of the smoother, s.
pub(crate) const WINDOW: f64 = 0.21;
/// Samples that are smoothed together: their sums stay in registers.
const CHUNK: usize = 8;

/// Smooths each contiguous run by the parabola that fits the samples around best (Savitzky and Golay
/// 1964); towards the ends of a run the window shrinks. Missing samples stay missing.
pub fn smooth(x: &[f64], rate: f64) -> Vec<f64> {
    let mut out = vec![f64::NAN; x.len()];
    let wanted = (0.5 * WINDOW * rate).floor().max(1.0) as usize;
    let weights: Vec<Vec<f64>> = (0..=wanted).map(weights).collect();
    for Range { start, end } in runs(x) {
        let whole =
            (start + wanted).min(end)..end.saturating_sub(wanted).max(start + wanted).min(end);
        for i in (start..whole.start).chain(whole.end..end) {
            let half = wanted.min(i - start).min(end - 1 - i);
            let near = &x[i - half..=i + half];
            out[i] = near.iter().zip(&weights[half]).map(|(x, w)| x * w).sum();
        }
        // weight by weight over a few samples: their sums need not wait for each other
        let (own, last) = out[whole.clone()].as_chunks_mut::<CHUNK>();
        let mut first = whole.start.saturating_sub(wanted);
        for out in own {
            let near = &x[first..first + 2 * wanted + CHUNK];
            let mut sums = [0.0; CHUNK];
            for (k, w) in weights[wanted].iter().enumerate() {
                let Some(near) = near[k..].first_chunk::<CHUNK>() else { break };
                for (sum, x) in sums.iter_mut().zip(near) {
                    *sum += x * w;
                }
            }
            *out = sums;
            first += CHUNK;
        }
        for (sum, near) in last.iter_mut().zip(x[first..].windows(2 * wanted + 1)) {
            *sum = near.iter().zip(&weights[wanted]).map(|(x, w)| x * w).sum();
        }
    }
    out
}

/// Weights of samples `-half..=half` that give the best parabola's value at the centre.
fn weights(half: usize) -> Vec<f64> {
    if half < 2 {
        // a parabola through three samples, or one: the sample itself
        return (0..=2 * half).map(|k| if k == half { 1.0 } else { 0.0 }).collect();
    }
    let m = half as f64;
    let scale = (2.0 * m - 1.0) * (2.0 * m + 1.0) * (2.0 * m + 3.0);
    (0..=2 * half)
        .map(|k| {
            let u = k as f64 - m;
            3.0 * (3.0 * m * m + 3.0 * m - 1.0 - 5.0 * u * u) / scale
        })
        .collect()
}

/// Mean over a window (s), taken twice; towards the ends the window shrinks. For motions that are slower than
/// the noise of their sensor; missing samples spread, so bridge them first.
pub(crate) fn mean_twice(x: &[f64], rate: f64, window: f64) -> Vec<f64> {
    let half = (0.5 * window * rate) as usize;
    let mean = |x: &[f64]| -> Vec<f64> {
        let mut sum = 0.0;
        let mut sums = vec![0.0; x.len() + 1];
        for (after, x) in sums[1..].iter_mut().zip(x) {
            sum += x;
            *after = sum;
        }
        let end = |i: usize| {
            let half = half.min(i).min(x.len() - 1 - i);
            (sums[i + half + 1] - sums[i - half]) / (2 * half + 1) as f64
        };
        let (first, last) =
            (half.min(x.len()), x.len().saturating_sub(half).max(half.min(x.len())));
        let width = (2 * half + 1) as f64;
        let mut means = Vec::with_capacity(x.len());
        means.extend((0..first).map(end));
        let after = sums.get(2 * half + 1..).unwrap_or_default();
        means.extend(after.iter().zip(&sums).map(|(after, before)| (after - before) / width));
        means.extend((last..x.len()).map(end));
        means
    };
    mean(&mean(x))
}

/// Central differences; one-sided at the ends of a run.
pub(crate) fn gradient(x: &[f64], rate: f64) -> Vec<f64> {
    let mut out = vec![f64::NAN; x.len()];
    for Range { start, end } in runs(x) {
        if end - start < 2 {
            continue;
        }
        for i in start..end {
            let (a, b) = (i.saturating_sub(1).max(start), (i + 1).min(end - 1));
            out[i] = (x[b] - x[a]) * rate / (b - a) as f64;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_scipy_inside() {
        // scipy 1.17.1: savgol_filter(x, 5, 2, mode="interp"), x = k^3 - 4 k
        let x: Vec<f64> = (-4..=4).map(|k| f64::from(k * k * k - 4 * k)).collect();
        let rate = 2.6 / (0.5 * WINDOW); // half a window of two samples
        let y = smooth(&x, rate);
        // a parabola reproduces cubics at its centre
        for k in 2..7 {
            assert!((y[k] - x[k]).abs() < 1e-12, "{k}");
        }
        let noise = [1.0, -1.0, 2.0, 0.0, 3.0];
        let centre = smooth(&noise, rate)[2];
        let scipy = (-3.0 - 12.0 + 34.0 - 9.0) / 35.0; // weights -3, 12, 17, 12, -3
        assert!((centre - scipy).abs() < 1e-12);
    }

    #[test]
    fn many_samples_are_smoothed_as_each_is() {
        let x: Vec<f64> = (0..1000).map(|i| f64::from(i * i % 997)).collect();
        let y = smooth(&x, 100.0);
        let own = weights(10);
        for i in 10..990 {
            let sum: f64 = x[i - 10..=i + 10].iter().zip(&own).map(|(x, w)| x * w).sum();
            assert_eq!(y[i], sum, "{i}");
        }
    }

    #[test]
    fn runs_are_smoothed_by_themselves() {
        let mut x: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.5).collect();
        x[60..70].fill(f64::NAN);
        let y = smooth(&x, 100.0);
        let d = gradient(&y, 100.0);
        for i in (0..60).chain(70..200) {
            assert!((y[i] - x[i]).abs() < 1e-9 && (d[i] - 50.0).abs() < 1e-6, "{i}");
        }
        assert!(y[60..70].iter().chain(&d[60..70]).all(|v| v.is_nan()));
    }
}
