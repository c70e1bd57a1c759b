//! Calibration off-road: what every candidate gains on fault-free simulations, rides on which the base is right.
//!
//! A motocross ride cannot be simulated again: a few centimetres at take-off decide where it lands. So a
//! fault-free simulation is the measured ride with the residuals it would have if the rider were B: the motion
//! is kept and the tyre forces follow, so the equations hold exactly but for
//!
//! - a bike that is not quite as its file says ([`uncertain`](super::uncertain)), drawn anew for each;
//! - what the ride's own residuals scatter when every candidate is free: sensors, ground, whatever
//!   nobody thought of. Each jump, whoops or corner keeps its own, turned over in sign at
//!   random, so that size and colour stay and what they have in common with a candidate does not.
//!
//! A noisier log has noisier fault-free simulations.

use rayon::prelude::*;

use super::candidates::ALL;
use super::fit::{Linear, Problem};
use super::residuals::{CHANNELS, Residuals};
use crate::diagnose::calibration::{Calibration, Cell, Rms, noise_rms, rms, threshold};
use crate::statistics::order::median_or_zero;
use crate::statistics::random::Random;

/// Scale of the scores off-road.
#[derive(Debug, Clone)]
pub struct GainScale {
    /// Root mean square of the root of each candidate's gain.
    pub scale: Vec<f64>,
    /// Largest score of the fault-free simulations that is still usual, in `scale`.
    pub threshold: f64,
}

/// Calibration off-road; `bias` is in the candidates' units, zero for those that are known by their
/// logarithm.
pub(crate) type OffroadCalibration = Calibration<GainScale>;

/// Where fault-free simulations are drawn from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source<'a> {
    pub residuals: &'a Residuals,
    /// Candidates and the bike's uncertainty.
    pub problem: &'a Problem,
    /// Residuals with every candidate free.
    pub scatter: &'a [f64],
    /// Standard deviation of every channel's blocks that the sensors explain.
    pub sensors: &'a [f64; CHANNELS.len()],
    /// Of the random numbers.
    pub seed: u64,
}

/// Gains and residuals of one fault-free simulation.
struct NullGains {
    gains: Vec<f64>,
    values: Vec<f64>,
    sizes: Rms,
}

/// Draws fault-free simulations.
pub(crate) fn calibrate(source: &Source<'_>, nulls: usize) -> OffroadCalibration {
    let problem = source.problem;
    let linear: Vec<Linear> = (0..ALL.len()).map(|j| problem.linear(&[j])).collect();
    let bare = problem.linear(&[]);
    let shown: Vec<NullGains> =
        (0..nulls).into_par_iter().map(|number| source.draw(number, &bare, &linear)).collect();
    let noise_rms = noise_rms(shown.iter().map(|s| &s.sizes), nulls);
    let of = |f: &dyn Fn(&NullGains) -> &[f64], j: usize| -> Vec<f64> {
        shown.iter().map(|s| f(s)[j]).collect()
    };
    let gains: Vec<Vec<f64>> = (0..ALL.len()).map(|j| of(&|s| &s.gains, j)).collect();
    let scale: Vec<f64> = gains
        .iter()
        .map(|g| (g.iter().sum::<f64>() / nulls.max(1) as f64).sqrt().max(1.0))
        .collect();
    let top = |number: usize| -> f64 {
        (0..ALL.len()).map(|j| gains[j][number].sqrt() / scale[j]).fold(0.0, f64::max)
    };
    let mut largest_scores: Vec<f64> = (0..nulls).map(top).collect();
    largest_scores.sort_by(f64::total_cmp);
    let threshold = threshold(largest_scores.clone()).max(1.0);
    largest_scores.iter_mut().for_each(|t| *t /= threshold);
    let bias = (0..ALL.len())
        .map(|j| match problem.curves[j].logarithmic() {
            true => 0.0,
            false => median_or_zero(&of(&|s| &s.values, j)),
        })
        .collect();
    Calibration { bias, nulls, largest_scores, noise_rms, scale: GainScale { scale, threshold } }
}

impl Source<'_> {
    fn draw(&self, number: usize, bare: &Linear, linear: &[Linear]) -> NullGains {
        let Source { residuals, problem, scatter, sensors, seed } = *self;
        let mut random = Random::new(seed, &format!("off-road null {number}"));
        let mut bike = vec![0.0; scatter.len()];
        for column in &problem.uncertain {
            let by = random.normal();
            bike.iter_mut().zip(column).for_each(|(r, c)| *r += by * c);
        }
        let signs: Vec<f64> = (0..residuals.clusters)
            .map(|_| if random.normal() > 0.0 { 1.0 } else { -1.0 })
            .collect();
        let null: Vec<f64> = residuals
            .blocks
            .iter()
            .zip(&bike)
            .zip(scatter)
            .map(|((b, bike), own)| bike + signs[b.cluster] * own)
            .collect();
        let off = problem.fit_with(&null, &[], bare, None, &|_| true);
        let (gains, values) = (0..ALL.len())
            .map(|j| {
                let fit = problem.fit_with(&null, &[j], &linear[j], Some(&off), &|_| true);
                (2.0 * (off.loss - fit.loss).max(0.0), fit.values[j].unwrap_or(0.0))
            })
            .unzip();
        let seen: Vec<f64> = residuals
            .blocks
            .iter()
            .zip(&bike)
            .map(|(b, r)| r + sensors[b.channel] * random.normal())
            .collect();
        let sizes = rms(cells(residuals, &seen).map(|(cell, _, r)| (cell, r)));
        NullGains { gains, values, sizes }
    }
}

impl Calibration<GainScale> {
    /// Score of candidate `j` whose fit gains so much; over one is beyond what fault-free simulations show.
    pub fn score(&self, j: usize, gain: f64) -> f64 {
        gain.max(0.0).sqrt() / self.scale.scale[j] / self.scale.threshold
    }
}

/// Block residuals with their cells and blocks.
pub(crate) fn cells<'a>(
    residuals: &'a Residuals,
    r: &'a [f64],
) -> impl Iterator<Item = (Cell, usize, f64)> + 'a {
    let blocks = residuals.blocks.iter().zip(r).enumerate();
    blocks.map(|(at, (block, r))| ((block.kind, block.channel), at, *r))
}
