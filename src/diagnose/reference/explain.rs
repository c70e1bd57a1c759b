//! Which cause explains how some rides of a motorcycle differ from its others: the whole vector of numbers at once.
//!
//! ```text
//! gain of an effect = max over its size d of  sum_p rho(t_p) - rho((D_p - d T_p) / s_p) - (d / prior)^2 / 2
//! rho(t) = (nu + 1) / 2 log(1 + t^2 / nu)          minus the logarithm of Student's t
//! ```
//!
//! `D` are the differences with their errors `s`, `T` is what a unit of the effect moves each number by, which follows from
//! the rides ([`estimates`](crate::diagnose::road::estimates)). So an effect that a ride cannot tell from another tyre still explains a
//! crown that moves from one ride to the next. A parameter of the nominal model explains its own difference only.

use super::difference::Difference;
use super::numbers::History;
use super::sets::Rides;
use crate::simulate::effects::{Effect, PRIOR};

/// Rounds of reweighting.
const ROUNDS: usize = 20;

/// A cause that is fitted to the differences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Candidate {
    /// Its place in the history's numbers.
    pub number: usize,
    /// Its size that explains most.
    pub size: f64,
    /// Gain, as a difference of log-likelihoods.
    pub gain: f64,
}

/// Shift of each number per unit of an effect, the mean over some rides.
pub(crate) fn trace(history: &History, effect: usize, rides: &Rides) -> Vec<f64> {
    let own = || (0..history.len()).map(|i| (i, rides.share(i))).filter(|(_, s)| *s != 0.0);
    let all: f64 = own().map(|(_, share)| share).sum();
    let of_effect = history.traces.iter().find(|(number, _)| *number == effect);
    let mean = |p: usize| match of_effect {
        Some((_, by_ride)) => own().map(|(i, share)| share * by_ride[i][p]).sum::<f64>() / all,
        None => 0.0,
    };
    (0..history.numbers.len()).map(mean).collect()
}

/// Every candidate, that which explains most first.
pub(crate) fn candidates(
    history: &History,
    differences: &[Option<Difference>],
    rides: &Rides,
) -> Vec<Candidate> {
    let of = |(number, d): (usize, &Option<Difference>)| {
        let difference = (*d)?;
        Some(match history.numbers[number].effect {
            None => Candidate { number, size: difference.size, gain: rho(difference, 0.0) },
            Some(effect) => {
                let trace = trace(history, number, rides);
                explained(number, effect, difference, differences, &trace)
            }
        })
    };
    let mut all: Vec<Candidate> = differences.iter().enumerate().filter_map(of).collect();
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    all
}

/// Minus the logarithm of the likelihood of a difference that something moved by `moved`.
fn rho(d: Difference, moved: f64) -> f64 {
    let t = (d.size - moved) / d.error;
    0.5 * (d.freedom + 1.0) * (t * t / d.freedom).ln_1p()
}

/// An effect at its best size.
fn explained(
    number: usize,
    effect: &Effect,
    own: Difference,
    differences: &[Option<Difference>],
    trace: &[f64],
) -> Candidate {
    let moved = || differences.iter().zip(trace).filter_map(|(d, t)| Some(((*d)?, *t)));
    let believed = PRIOR * effect.typical.abs();
    let gain = |size: f64| -> f64 {
        let sum: f64 = moved().map(|(d, t)| rho(d, 0.0) - rho(d, size * t)).sum();
        sum - 0.5 * (size / believed).powi(2)
    };
    let refined = |mut size: f64| {
        for _ in 0..ROUNDS {
            let (mut top, mut bottom) = (0.0, 0.0);
            for (d, t) in moved() {
                let rest = (d.size - size * t) / d.error;
                let weight = (d.freedom + 1.0) / (d.freedom + rest * rest) / d.error.powi(2);
                top += weight * t * d.size;
                bottom += weight * t * t;
            }
            size = if bottom > 0.0 { top / bottom } else { 0.0 };
        }
        size
    };
    // its own number may say it, or the numbers of the nominal model
    let start = {
        let (top, bottom) = moved().fold((0.0, 0.0), |(top, bottom), (d, t)| {
            let weight = d.error.powi(-2);
            (top + weight * t * d.size, bottom + weight * t * t)
        });
        if bottom > 0.0 { top / bottom } else { 0.0 }
    };
    let best = [0.0, refined(own.size), refined(start)].map(|size| Candidate {
        number,
        size,
        gain: gain(size),
    });
    best.into_iter().max_by(|a, b| a.gain.total_cmp(&b.gain)).unwrap_or(best[0])
}
