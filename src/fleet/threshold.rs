//! How large the largest score is by chance alone.
//!
//! The false-alarm rate is stated, the threshold follows: of series of independent Gaussian
//! sessions, whose spread is estimated by the same [`scan::robust_tau`], one bike in a hundred has
//! any score of any coefficient above it. Coefficients that go together make it rarer.
//!
//! How rare a larger score is follows from the tail: where the threshold is simulated that of Student's t with half as many
//! degrees of freedom as sessions, which is what differences of neighbours know of a spread; beyond, Bonferroni's bound.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use super::scan::{self, Shape, Sums};
use crate::statistics::random::Random;

/// Share of bikes to which nothing has happened and yet an event is reported, per search.
pub(crate) const FALSE_ALARMS: f64 = 0.01;

/// Draws of the simulation: 5 of 500 lie beyond the fifth largest.
const DRAWS: usize = 499;

/// Up to so many sessions the threshold is simulated; above, the spread is known well enough for
/// Bonferroni's bound.
const SIMULATED: usize = 128;

/// Degrees of freedom of a spread that differences of neighbours tell, per session.
const SPREAD: f64 = 0.5;

/// Thresholds already found, by sessions and coefficients; bikes that are searched side by side share them.
#[derive(Debug, Default)]
pub(crate) struct Limits(Mutex<BTreeMap<(usize, usize), f64>>);

impl Limits {
    /// The threshold for the largest score of `p` coefficients over `n` sessions.
    pub(crate) fn get(&self, n: usize, p: usize) -> f64 {
        let (n, p) = rounded(n, p);
        // a panic elsewhere leaves whole entries
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        *known.entry((n, p)).or_insert_with(|| {
            if n > SIMULATED {
                return normal_limit(FALSE_ALARMS / (scan::shapes(n).len() * p) as f64);
            }
            simulated(n, p)
        })
    }

    /// Chance that the largest score of `p` coefficients over `n` sessions is beyond `score` where nothing has happened.
    pub(crate) fn chance(&self, score: f64, n: usize, p: usize) -> f64 {
        let limit = self.get(n, p);
        let (n, p) = rounded(n, p);
        if n > SIMULATED {
            let one = 2.0 * Normal::standard().sf(score);
            return (one * (scan::shapes(n).len() * p) as f64).min(1.0);
        }
        let Ok(t) = StudentsT::new(0.0, 1.0, SPREAD * n as f64) else { return 1.0 };
        (FALSE_ALARMS * t.sf(score) / t.sf(limit)).min(1.0)
    }
}

/// As thresholds are kept.
fn rounded(n: usize, p: usize) -> (usize, usize) {
    // fewer sessions know the spread less well: down is the safe side
    (if n > 16 { n / 4 * 4 } else { n }, p.max(1).next_power_of_two())
}

/// Limit that a standard normal variable exceeds, on either side, with that probability.
pub(crate) fn normal_limit(probability: f64) -> f64 {
    Normal::standard().inverse_cdf(1.0 - probability / 2.0)
}

fn simulated(n: usize, p: usize) -> f64 {
    let shapes = scan::shapes(n);
    let times: Vec<f64> = (0..n).map(|i| i as f64).collect();
    let mut random = Random::new(0, &format!("fleet threshold {n} {p}"));
    let mut largest: Vec<f64> = (0..DRAWS)
        .map(|_| (0..p).fold(0.0, |m: f64, _| m.max(largest(&mut random, &shapes, &times))))
        .collect();
    largest.sort_by(f64::total_cmp);
    let beyond = ((DRAWS + 1) as f64 * FALSE_ALARMS) as usize;
    largest[DRAWS - beyond]
}

/// The largest score of a series to which nothing has happened.
fn largest(random: &mut Random, shapes: &[Shape], times: &[f64]) -> f64 {
    let n = times.len();
    let values: Vec<f64> = (0..n).map(|_| random.normal()).collect();
    let tau2 = scan::robust_tau(&values, &vec![0.0; n]).powi(2);
    let sums = Sums::new(&values, &vec![tau2; n], times);
    shapes.iter().fold(0.0, |m: f64, s| m.max(sums.score(*s).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_to_try_needs_a_larger_score() {
        let limits = Limits::default();
        let (few, many, long) = (limits.get(20, 1), limits.get(20, 8), limits.get(400, 8));
        assert!(3.0 < few && few < many, "{few} {many}");
        assert!((4.5..6.5).contains(&long), "{long}");
        assert!((normal_limit(0.05) - 1.959_964).abs() < 1e-5);
    }

    /// Scores that chance makes once in a thousand are not rarer than that.
    #[test]
    fn the_chance_of_a_score_is_not_understated() {
        const DRAWN: usize = 6000;
        let limits = Limits::default();
        for n in [12, 28, 60] {
            let shapes = scan::shapes(n);
            let times: Vec<f64> = (0..n).map(|i| i as f64).collect();
            let mut random = Random::new(5, &format!("chance {n}"));
            let beyond = (0..DRAWN)
                .filter(|_| limits.chance(largest(&mut random, &shapes, &times), n, 1) < 1e-3)
                .count();
            assert!(beyond <= 2 * DRAWN / 1000, "{n} sessions: {beyond} of {DRAWN}");
        }
        assert!((limits.chance(limits.get(400, 8), 400, 8) / FALSE_ALARMS - 1.0).abs() < 1e-6);
        assert!((limits.chance(limits.get(20, 8), 20, 8) / FALSE_ALARMS - 1.0).abs() < 1e-6);
    }
}
