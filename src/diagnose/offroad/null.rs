//! Calibration against nulls: what every candidate gains on rides in which the base is right.
//!
//! A null is the measured ride with the residuals it would have if the rider were B: the motion is
//! kept and the tyre forces follow, so the equations hold exactly but for
//!
//! - a bike that is not quite as its file says ([`uncertain`](super::uncertain)), drawn anew for each;
//! - what the ride's own residuals scatter when every candidate is free: sensors, ground, whatever
//!   nobody thought of. Each jump, whoops or corner keeps its own, turned over in sign at
//!   random, so that size and colour stay and what they have in common with a candidate does not.
//!
//! A noisier log has noisier nulls. A motocross ride cannot be ridden again in a simulator: a few
//! centimetres at take-off decide where it lands.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::effects::ALL;
use super::fit::{Linear, Problem};
use super::residuals::{CHANNELS, Residuals};
use crate::contract::manoeuvre::ManoeuvreKind;
use crate::statistics::order::median_or_zero;
use crate::statistics::random::Random;

/// Share of the nulls whose largest score lies below the threshold.
const QUANTILE: f64 = 0.95;

/// What candidates gain where nothing is wrong.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// Root mean square of the root of each candidate's gain.
    pub scale: Vec<f64>,
    /// Middle of each candidate's number; zero for those without a middle.
    pub bias: Vec<f64>,
    /// Largest score of the nulls that is still usual.
    pub threshold: f64,
    /// Largest score of each null, each judged like the real ride.
    pub tops: Vec<f64>,
    /// Mean and largest root mean square of the residuals that sensors and bike file explain, by kind and
    /// channel.
    pub floor: BTreeMap<(ManoeuvreKind, usize), [f64; 2]>,
}

impl Calibration {
    /// Draws nulls. `left` are the residuals with every candidate free, `sensors` the standard deviation of
    /// every channel's blocks that the sensors explain.
    pub fn new(
        residuals: &Residuals,
        problem: &Problem,
        left: &[f64],
        sensors: &[f64; CHANNELS.len()],
        nulls: usize,
        seed: u64,
    ) -> Self {
        let linear: Vec<Linear> = (0..ALL.len()).map(|j| problem.linear(&[j])).collect();
        let bare = problem.linear(&[]);
        let drawn: Vec<Drawn> = (0..nulls)
            .into_par_iter()
            .map(|number| {
                let mut random = Random::new(seed, &format!("off-road null {number}"));
                let mut bike = vec![0.0; left.len()];
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
                    .zip(left)
                    .map(|((b, bike), left)| bike + signs[b.cluster] * left)
                    .collect();
                let off = problem.fit_with(&null, &[], &bare, None, &|_| true);
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
                Drawn { gains, values, sizes: rms(residuals, &seen) }
            })
            .collect();
        let mut floor: BTreeMap<(ManoeuvreKind, usize), [f64; 2]> = BTreeMap::new();
        for (key, (size, _)) in drawn.iter().flat_map(|d| &d.sizes) {
            let floor = floor.entry(*key).or_insert([0.0, 0.0]);
            floor[0] += size / nulls as f64;
            floor[1] = floor[1].max(*size);
        }
        let of = |f: &dyn Fn(&Drawn, usize) -> f64| -> Vec<Vec<f64>> {
            (0..ALL.len()).map(|j| drawn.iter().map(|d| f(d, j)).collect()).collect()
        };
        let gains = of(&|d, j| d.gains[j]);
        let values = of(&|d, j| d.values[j]);
        let scale: Vec<f64> = gains
            .iter()
            .map(|g| (g.iter().sum::<f64>() / nulls.max(1) as f64).sqrt().max(1.0))
            .collect();
        let top = |number: usize| -> f64 {
            (0..ALL.len()).map(|j| gains[j][number].sqrt() / scale[j]).fold(0.0, f64::max)
        };
        let mut tops: Vec<f64> = (0..nulls).map(top).collect();
        tops.sort_by(f64::total_cmp);
        let place = QUANTILE * (nulls as f64 - 1.0).max(0.0);
        let (low, share) = (place.floor() as usize, place.fract());
        let at = |k: usize| tops.get(k.min(nulls.saturating_sub(1))).copied().unwrap_or(1.0);
        // the nulls are few and set their own scale: a little more
        let threshold = ((1.0 + 1.0 / nulls.max(1) as f64)
            * (at(low) + share * (at(low + 1) - at(low))))
        .max(1.0);
        tops.iter_mut().for_each(|t| *t /= threshold);
        let bias = (0..ALL.len())
            .map(|j| if problem.curves[j].logarithmic() { 0.0 } else { median_or_zero(&values[j]) })
            .collect();
        Calibration { scale, bias, threshold, tops, floor }
    }

    /// Score of candidate `j` whose fit gains so much; over one is beyond what nulls show.
    pub fn score(&self, j: usize, gain: f64) -> f64 {
        gain.max(0.0).sqrt() / self.scale[j] / self.threshold
    }

    /// Share of the nulls in which some candidate scores as much or more.
    pub fn false_alarm_rate(&self, score: f64) -> f64 {
        let over = self.tops.iter().filter(|t| **t >= score).count();
        over as f64 / self.tops.len().max(1) as f64
    }
}

/// What one null shows.
struct Drawn {
    gains: Vec<f64>,
    values: Vec<f64>,
    sizes: Sizes,
}

/// Root mean squares and numbers of blocks.
type Sizes = BTreeMap<(ManoeuvreKind, usize), (f64, usize)>;

/// Root mean square and number of the residuals, by kind and channel.
pub fn rms(residuals: &Residuals, r: &[f64]) -> BTreeMap<(ManoeuvreKind, usize), (f64, usize)> {
    let mut out = Sizes::new();
    for (block, r) in residuals.blocks.iter().zip(r) {
        let entry = out.entry((block.kind, block.channel)).or_default();
        entry.0 += r * r;
        entry.1 += 1;
    }
    out.values_mut().for_each(|(sum, n)| *sum = (*sum / *n as f64).sqrt());
    out
}
