//! Calibration against nulls: what every candidate scores on rides in which nothing is wrong
//! (`diagnosis.md`, section 2.4).
//!
//! The measured ride is ridden again on the fitted model, the base or one with the causes that are named
//! already ([`rides`](super::null_simulation)), given all the
//! noise it has, and put through the whole of fit and scan. What a candidate shows there is bias of
//! the method and noise, not an effect.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::base::Base;
use super::generic::{self, Term};
use super::null_simulation::Rides;
use super::parameters::{Parameter, Parameters};
use super::residuals::Blocks;
use super::samples::{BLOCK, Samples};
use super::scan::{Score, scores};
use crate::contract::manoeuvre::ManoeuvreKind;
use crate::effects::{Effect, PRIOR};
use crate::statistics::order::{SD_PER_MAD, median_or_zero};

/// Largest detection limit that is one, in usual sizes.
pub const SEEN: f64 = 4.0;
/// What a bias is uncertain by, as a share of it: it is as right as the noise that nulls are given.
const BIASED: f64 = 0.2;
/// Share of the nulls whose largest score lies below the threshold.
const QUANTILE: f64 = 0.95;

/// What candidates score where nothing is wrong.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// Mean size that a null shows, per effect: the method's bias.
    pub bias: Vec<f64>,
    /// Spread between nulls, per effect.
    pub spread: Vec<f64>,
    /// Share of a true size that the estimates show, per effect: the prior holds them back where the
    /// ride says little.
    pub response: Vec<f64>,
    /// What the manoeuvres' own scatter usually says in a null, per effect.
    pub scatter: Vec<f64>,
    /// Thresholds of the largest `|z|`, with and without the manoeuvres' own scatter.
    pub threshold: [f64; 2],
    /// Mean gain of every generic term in nulls, in the order of [`generic::terms`].
    pub usual: Vec<f64>,
    /// Threshold of the largest term, in usual gains.
    pub structure: f64,
    /// How many nulls.
    pub nulls: usize,
    /// Largest score of each null, each judged like a real ride.
    pub tops: Vec<f64>,
    /// Mean and largest rms of the nulls' residuals, by kind and channel.
    pub floor: BTreeMap<(ManoeuvreKind, usize), [f64; 2]>,
    /// What each null's fit made of the model that was ridden.
    pub fits: Vec<Parameters>,
}

/// A candidate against its nulls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibrated {
    /// Size less bias, in usual ones.
    pub delta: f64,
    /// Standard deviation of it: of the nulls or of the manoeuvres, whichever is larger.
    pub std_error: f64,
    /// Over one is beyond what nulls show.
    pub score: f64,
}

impl Calibration {
    /// Simulates nulls of a ride and scores them: `rides` are on `model`, the base alone or with the
    /// effects that were taken in, and whatever else a candidate shows there is none of its own.
    pub fn new(rides: &Rides<'_>, model: &Base, effects: &[Effect], nulls: usize) -> Self {
        let more: Vec<Parameter> = effects.iter().map(Effect::parameter).collect();
        let all: Vec<Parameter> = model.parameters.iter().chain(&more).copied().collect();
        let scored: Vec<(Vec<Score>, Rms, Vec<Term>, Parameters)> = (0..nulls)
            .into_par_iter()
            .map(|number| {
                let (samples, quick) = rides.fit(number, model, &model.parameters, &more);
                let scores = scores(&samples, &quick.base, &all, &quick.linear);
                let terms = generic::terms(&samples, &quick.base.problem(&samples), &quick.linear);
                (scores, rms(&samples, &quick.linear.residuals), terms, quick.base.world)
            })
            .collect();
        let mut sizes = Vec::with_capacity(nulls);
        let mut terms = Vec::with_capacity(nulls);
        let mut scores = Vec::with_capacity(nulls);
        let mut fits = Vec::with_capacity(nulls);
        for (score, size, term, fit) in scored {
            scores.push(score);
            sizes.push(size);
            terms.push(term);
            fits.push(fit);
        }
        let scored = scores;
        let mut calibration = Self::of(&scored, effects.len());
        calibration.left(&terms);
        for sizes in sizes {
            for (key, (size, _)) in sizes {
                let floor = calibration.floor.entry(key).or_insert([0.0, 0.0]);
                floor[0] += size / nulls as f64;
                floor[1] = floor[1].max(size);
            }
        }
        let tops = scored.iter().map(|s| {
            (0..effects.len()).map(|j| calibration.judge(j, &s[j]).score).fold(0.0, f64::max)
        });
        calibration.tops = tops.collect();
        calibration.fits = fits;
        calibration
    }

    /// What is known of the candidates at some places.
    #[must_use]
    pub fn only(&self, places: &[usize]) -> Self {
        let of = |x: &[f64]| places.iter().map(|&j| x[j]).collect();
        Calibration {
            bias: of(&self.bias),
            spread: of(&self.spread),
            response: of(&self.response),
            scatter: of(&self.scatter),
            ..self.clone()
        }
    }

    /// Nulls without candidates, which are judged as others do.
    #[must_use]
    pub fn judging_as(self, other: &Calibration) -> Self {
        let Calibration { usual, structure, nulls, floor, fits, .. } = self;
        Calibration { usual, structure, nulls, floor, fits, ..other.clone() }
    }

    /// Learns what generic terms gain in nulls.
    fn left(&mut self, terms: &[Vec<Term>]) {
        let n = terms.len() as f64;
        let count = terms.iter().map(Vec::len).min().unwrap_or(0);
        self.usual = (0..count)
            // two degrees of freedom gain two by chance
            .map(|k| (terms.iter().map(|t| t[k].gain).sum::<f64>() / n).max(2.0))
            .collect();
        // each null is held against the others, as a ride is against all of them: its own gain would
        // count in the mean that it is measured by, and the threshold come out too low
        let sums: Vec<f64> = (0..count).map(|k| terms.iter().map(|t| t[k].gain).sum()).collect();
        let unusual = |own: &Vec<Term>| {
            let times = (0..count).map(|k| {
                let others = (sums[k] - own[k].gain) / (n - 1.0).max(1.0);
                own[k].gain / others.max(2.0)
            });
            times.fold(0.0, f64::max)
        };
        let tops: Vec<f64> = terms.iter().map(unusual).collect();
        self.structure = quantile(tops);
    }

    /// The most unusual term and how many usual gains it has.
    pub fn largest(&self, terms: &[Term]) -> (Option<Term>, f64) {
        terms
            .iter()
            .zip(&self.usual)
            .map(|(t, usual)| (Some(*t), t.gain / usual))
            .fold((None, 0.0), |best, own| if own.1 > best.1 { own } else { best })
    }

    fn of(scored: &[Vec<Score>], effects: usize) -> Self {
        let nulls = scored.len();
        let of = |j: usize| -> Vec<f64> { scored.iter().map(|s| s[j].delta).collect() };
        let bias: Vec<f64> = (0..effects).map(|j| median_or_zero(&of(j))).collect();
        let spread: Vec<f64> = (0..effects)
            .map(|j| {
                let x = of(j);
                let mean = x.iter().sum::<f64>() / nulls as f64;
                let sd = (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>()
                    / (nulls as f64 - 1.0).max(1.0))
                .sqrt();
                let off: Vec<f64> = x.iter().map(|v| (v - bias[j]).abs()).collect();
                (0.5 * (sd + SD_PER_MAD * median_or_zero(&off))).max(1e-9)
            })
            .collect();
        let response: Vec<f64> = (0..effects)
            .map(|j| {
                let shares: Vec<f64> = scored
                    .iter()
                    .map(|s| s[j].information / (s[j].information + PRIOR.powi(-2)))
                    .collect();
                // far below the least spread: of what nulls know nothing nothing is seen
                median_or_zero(&shares).max(1e-15)
            })
            .collect();
        let largest = |scatter: bool| {
            let tops: Vec<f64> = scored
                .iter()
                .map(|s| {
                    let z = |j: usize| {
                        let own = if scatter { s[j].std_error } else { 0.0 };
                        ((s[j].delta - bias[j]) / spread[j].max(own)).abs()
                    };
                    (0..effects)
                        .filter(|&j| 3.3 * spread[j] / response[j] < SEEN)
                        .map(z)
                        .fold(0.0, f64::max)
                })
                .collect();
            quantile(tops)
        };
        Calibration {
            threshold: [largest(true), largest(false)],
            scatter: (0..effects)
                .map(|j| median_or_zero(&scored.iter().map(|s| s[j].std_error).collect::<Vec<_>>()))
                .collect(),
            bias,
            spread,
            response,
            nulls,
            usual: Vec::new(),
            structure: f64::INFINITY,
            tops: Vec::new(),
            floor: BTreeMap::new(),
            fits: Vec::new(),
        }
    }

    /// Detection limit of effect `j`, in usual sizes: 3.3 standard deviations of nulls over the
    /// response, at which half are named.
    pub fn limit(&self, j: usize) -> f64 {
        3.3 * self.error(j, 0.0) / self.response[j]
    }

    /// Standard deviation of a size: that of nulls or of the manoeuvres, and what the bias is
    /// uncertain by.
    fn error(&self, j: usize, own: f64) -> f64 {
        self.spread[j].max(own).hypot(BIASED * self.bias[j])
    }

    /// Whether an effect that can be would be seen in such a ride.
    pub fn sees(&self, j: usize) -> bool {
        self.limit(j) < SEEN
    }

    /// A real ride's score of effect `j`.
    pub fn judge(&self, j: usize, score: &Score) -> Calibrated {
        let delta = score.delta - self.bias[j];
        let std_error = self.error(j, score.std_error);
        let robust = (delta / std_error).abs() / self.threshold[0];
        // manoeuvres that scatter more than in nulls (pads, gusts) make nulls too sure
        let more = (score.std_error / self.scatter[j].max(f64::MIN_POSITIVE)).max(1.0);
        let plain = (delta / (more * self.error(j, 0.0))).abs() / (1.4 * self.threshold[1]);
        let score = if self.sees(j) { robust.max(plain) } else { 0.0 };
        Calibrated { delta, std_error, score }
    }
}

/// The threshold that a share of [`QUANTILE`] of nulls stays below.
fn quantile(mut tops: Vec<f64>) -> f64 {
    if tops.is_empty() {
        return f64::INFINITY;
    }
    tops.sort_by(f64::total_cmp);
    let place = QUANTILE * (tops.len() as f64 - 1.0);
    let (low, share) = (place.floor() as usize, place.fract());
    let high = tops[(low + 1).min(tops.len() - 1)];
    // the nulls are few and set their own bias and spread: a little more
    (1.0 + 1.0 / tops.len() as f64) * (tops[low] + share * (high - tops[low]))
}

/// Root mean square and number of the residuals, by kind and channel.
pub type Rms = BTreeMap<(ManoeuvreKind, usize), (f64, usize)>;

/// Root mean squares of block residuals.
pub fn rms(samples: &Samples, found: &Blocks) -> Rms {
    let mut sums: Rms = BTreeMap::new();
    for (kind, range) in &samples.manoeuvres {
        for (c, column) in found.iter().enumerate() {
            for r in &column[range.start / BLOCK..range.end / BLOCK] {
                if r.is_finite() {
                    let sum = sums.entry((*kind, c)).or_default();
                    sum.0 += r * r;
                    sum.1 += 1;
                }
            }
        }
    }
    sums.values_mut().for_each(|(sum, n)| *sum = (*sum / *n as f64).sqrt());
    sums
}

/// Correlation of the pairs that are known; 0 where either does not vary.
pub fn correlation(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
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
