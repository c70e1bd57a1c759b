//! How large the largest score is by chance alone.
//!
//! The false-alarm rate is stated, the threshold follows: of series of independent Gaussian
//! sessions, whose spread is estimated by the same [`scan::robust_tau`], one bike in a hundred has
//! any score of any coefficient above it. Coefficients that go together make it rarer.

use std::collections::BTreeMap;

use statrs::distribution::{ContinuousCDF, Normal};

use super::scan::{self, Shape, Sums};
use crate::statistics::random::Random;

/// Share of bikes to which nothing has happened and yet an event is reported, per search.
pub const FALSE_ALARMS: f64 = 0.01;

/// Draws of the simulation: 5 of 500 lie beyond the fifth largest.
const DRAWS: usize = 499;

/// Up to so many sessions the threshold is simulated; above, the spread is known well enough for
/// Bonferroni's bound.
const SIMULATED: usize = 128;

/// Thresholds already found, by sessions and coefficients.
#[derive(Debug, Default)]
pub struct Limits(BTreeMap<(usize, usize), f64>);

impl Limits {
    /// The threshold for the largest score of `p` coefficients over `n` sessions.
    pub fn get(&mut self, n: usize, p: usize) -> f64 {
        let p = p.max(1).next_power_of_two();
        // fewer sessions know the spread less well: down is the safe side
        let n = if n > 16 { n / 4 * 4 } else { n };
        *self.0.entry((n, p)).or_insert_with(|| {
            if n > SIMULATED {
                return normal_limit(FALSE_ALARMS / (scan::shapes(n).len() * p) as f64);
            }
            simulated(n, p)
        })
    }
}

/// What a standard normal exceeds, on either side, with that probability.
pub fn normal_limit(probability: f64) -> f64 {
    Normal::standard().inverse_cdf(1.0 - probability / 2.0)
}

fn simulated(n: usize, p: usize) -> f64 {
    let shapes = scan::shapes(n);
    let times: Vec<f64> = (0..n).map(|i| i as f64).collect();
    let none = vec![0.0; n];
    let mut random = Random::new(0, &format!("fleet threshold {n} {p}"));
    let mut largest: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let mut most: f64 = 0.0;
            for _ in 0..p {
                let values: Vec<f64> = (0..n).map(|_| random.normal()).collect();
                let tau2 = scan::robust_tau(&values, &none).powi(2);
                let sums = Sums::new(&values, &vec![tau2; n], &times);
                let best = |m: f64, s: &Shape| m.max(sums.score(*s).abs());
                most = shapes.iter().fold(most, best);
            }
            most
        })
        .collect();
    largest.sort_by(f64::total_cmp);
    let beyond = ((DRAWS + 1) as f64 * FALSE_ALARMS) as usize;
    largest[DRAWS - beyond]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_to_try_needs_a_larger_score() {
        let mut limits = Limits::default();
        let (few, many, long) = (limits.get(20, 1), limits.get(20, 8), limits.get(400, 8));
        assert!(3.0 < few && few < many, "{few} {many}");
        assert!((4.5..6.5).contains(&long), "{long}");
        assert!((normal_limit(0.05) - 1.959_964).abs() < 1e-5);
    }
}
