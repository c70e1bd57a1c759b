//! Calibration by fault-free simulations: the scores of all candidates and the residuals on rides that the model
//! describes completely (`book/src/diagnosis.md`, section 2.4).

use std::collections::BTreeMap;

use crate::segment::manoeuvre::ManoeuvreKind;

/// Share of the fault-free simulations whose largest score lies below the threshold.
const QUANTILE: f64 = 0.95;

/// A kind of manoeuvre and the index of a channel of residuals.
pub(crate) type Cell = (ManoeuvreKind, usize);

/// Root mean square and number of the residuals in each cell.
pub(crate) type Rms = BTreeMap<Cell, (f64, usize)>;

/// Mean and largest root mean square of the residuals of fault-free simulations in each cell.
pub(crate) type NoiseRms = BTreeMap<Cell, [f64; 2]>;

/// Scores and residuals of fault-free simulations; `S` is the spread and threshold of scores.
#[derive(Debug, Clone)]
pub struct Calibration<S> {
    /// Median size in fault-free simulations, per candidate: the bias of the method.
    pub bias: Vec<f64>,
    /// Number of fault-free simulations.
    pub nulls: usize,
    /// Largest score of each simulation, judged like the ride.
    pub largest_scores: Vec<f64>,
    /// Noise-only rms: mean and largest of the residuals per cell.
    pub noise_rms: NoiseRms,
    /// Spread and threshold by which sizes become scores.
    pub scale: S,
}

impl<S> Calibration<S> {
    /// Share of the fault-free simulations in which some candidate scores as much or more.
    pub fn false_alarm_rate(&self, score: f64) -> f64 {
        let over = self.largest_scores.iter().filter(|t| **t >= score).count();
        over as f64 / self.nulls.max(1) as f64
    }
}

/// Score that a share of `QUANTILE` of the simulations stays below; infinite without simulations.
pub(crate) fn threshold(mut largest_scores: Vec<f64>) -> f64 {
    if largest_scores.is_empty() {
        return f64::INFINITY;
    }
    largest_scores.sort_by(f64::total_cmp);
    let place = QUANTILE * (largest_scores.len() as f64 - 1.0);
    let (low, share) = (place.floor() as usize, place.fract());
    let high = largest_scores[(low + 1).min(largest_scores.len() - 1)];
    // a few simulations that set their own bias and spread: the threshold is raised by 1/n
    (1.0 + 1.0 / largest_scores.len() as f64)
        * (largest_scores[low] + share * (high - largest_scores[low]))
}

/// Root mean square of the residuals in each cell.
pub fn rms(residuals: impl Iterator<Item = (Cell, f64)>) -> Rms {
    let mut out = Rms::new();
    for (cell, r) in residuals {
        let sum = out.entry(cell).or_default();
        sum.0 += r * r;
        sum.1 += 1;
    }
    out.values_mut().for_each(|(sum, n)| *sum = (*sum / *n as f64).sqrt());
    out
}

/// Noise-only rms of `nulls` fault-free simulations.
pub(crate) fn noise_rms<'a>(sizes: impl Iterator<Item = &'a Rms>, nulls: usize) -> NoiseRms {
    let mut out = NoiseRms::new();
    for (cell, (size, _)) in sizes.flatten() {
        let rms = out.entry(*cell).or_insert([0.0, 0.0]);
        rms[0] += size / nulls as f64;
        rms[1] = rms[1].max(*size);
    }
    out
}

/// Correlation of the pairs that are finite; 0 where either does not vary.
pub(crate) fn correlation(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let pairs: Vec<(f64, f64)> = pairs.filter(|(x, r)| x.is_finite() && r.is_finite()).collect();
    let n = pairs.len() as f64;
    let (mx, mr) = pairs.iter().fold((0.0, 0.0), |(a, b), (x, r)| (a + x / n, b + r / n));
    let (mut xx, mut rr, mut xr) = (0.0, 0.0, 0.0);
    for (x, r) in pairs {
        xx += (x - mx) * (x - mx);
        rr += (r - mr) * (r - mr);
        xr += (x - mx) * (r - mr);
    }
    if xx * rr > 0.0 { xr / (xx * rr).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_is_a_little_above_the_quantile() {
        assert_eq!(threshold(Vec::new()), f64::INFINITY);
        assert_eq!(threshold(vec![3.0]), 6.0);
        // 0.95 of the way over 20 steps, and a twenty-first more
        let largest_scores: Vec<f64> = (0..=20).rev().map(f64::from).collect();
        assert!((threshold(largest_scores) - 19.0 * (1.0 + 1.0 / 21.0)).abs() < 1e-12);
    }
}
