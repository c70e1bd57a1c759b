//! Calibration on the road: what candidates and residual structure show on fault-free simulations
//! (`book/src/diagnosis.md`, section 2.4).
//!
//! The ride is simulated on the fitted model, nominal or with causes, with its own noise ([`NullSimulation`]). Each
//! simulation passes through fit and scan like the ride. A score there is bias of the method or noise, not an effect.

use std::sync::Arc;

use rayon::prelude::*;

use super::base::Base;
use super::kept::{Key, Memo};
use super::null_simulation::NullSimulation;
use super::other_machines::shown;
use super::other_machines::structure as usual_structure;
use super::parameters::{Parameter, Parameters};
use super::residuals::Blocks;
use super::residuals::CHANNELS;
use super::samples::{BLOCK, Samples};
use super::scan::{Score, scores};
use super::structure::{self, Term};
use crate::contract::verdict::ALARM_ROAD;
use crate::diagnose::calibration::{Calibration, Cell, NoiseRms, Rms, noise_rms, rms, threshold};
use crate::simulate::effects::{Effect, PRIOR};
use crate::statistics::order::{SD_PER_MAD, median_or_zero};

/// Largest detection limit, in usual sizes, of an effect that a ride can identify: beyond that no size
/// within the bounds would be seen.
pub(crate) const LARGEST_LIMIT: f64 = 4.0;
/// Detection limit of an effect, in standard deviations of its size.
const LIMIT: f64 = 3.3;
/// Uncertainty of a bias, as a share of it: it depends on the noise of the fault-free simulations.
const BIAS_ERROR: f64 = 0.2;
/// Factor on the threshold of the score without the manoeuvres' own scatter (`1.4 t2` of section 2.4); set by the
/// prototype.
const PLAIN: f64 = 1.4;

/// Scale of scores and structure on the road. Sizes are in usual sizes.
#[derive(Debug, Clone)]
pub struct SizeScale {
    /// Standard deviation of the size between fault-free simulations, per candidate.
    pub spread: Vec<f64>,
    /// Share of a true size that the estimates show, per candidate: the prior holds them back where the
    /// ride says little.
    pub response: Vec<f64>,
    /// Standard deviation of the size on fault-free rides of other machines beyond `spread` (`x_j`), per candidate.
    pub unmodelled: Vec<f64>,
    /// Share of that response that rides of other machines have, per candidate.
    pub size_share: Vec<f64>,
    /// Median standard error from the manoeuvres' own scatter, per candidate.
    pub scatter: Vec<f64>,
    /// Thresholds of the largest `|z|`, with and without the manoeuvres' own scatter.
    pub threshold: [f64; 2],
    /// Scale of residual structure.
    pub structure: StructureScale,
    /// Fit to each fault-free simulation: parameters, to be compared with the simulated ones.
    pub fits: Vec<Parameters>,
}

/// Scale of residual structure.
#[derive(Debug, Clone)]
pub struct StructureScale {
    /// Mean gain of every term on fault-free simulations, in the order of [`structure::terms`].
    pub usual: Vec<f64>,
    /// Threshold of the most unusual term, in usual gains.
    pub threshold: f64,
}

/// Calibration on the road; `bias` is in usual sizes.
pub(crate) type RoadCalibration = Calibration<SizeScale>;

/// A candidate against its fault-free simulations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibrated {
    /// Size less bias, in usual ones.
    pub delta: f64,
    /// Standard error of it: of the fault-free simulations or of the manoeuvres, whichever is larger.
    pub std_error: f64,
    /// Score; 19 of 20 fault-free simulations stay below 1.
    pub score: f64,
}

/// Scores, structure and fit of one fault-free simulation.
#[derive(Debug)]
pub(crate) struct NullScores {
    scores: Vec<Score>,
    sizes: Rms,
    terms: Vec<Term>,
    pub fit: Parameters,
}

impl NullScores {
    /// Scores of effects beside a model on the fault-free simulation of a number.
    pub(crate) fn of(
        simulation: &NullSimulation<'_>,
        model: &Base,
        effects: &[Effect],
        number: usize,
    ) -> Self {
        let more: Vec<Parameter> = effects.iter().map(Effect::parameter).collect();
        let all: Vec<Parameter> = model.parameters.iter().chain(&more).copied().collect();
        let (samples, quick) = simulation.fit(number, model, &model.parameters, &more);
        let problem = quick.base.problem(&samples);
        NullScores {
            scores: scores(&samples, &quick.base, &all, &quick.linear),
            sizes: rms(cells(&samples, &quick.linear.residuals).map(|(cell, _, r)| (cell, r))),
            terms: structure::terms(&samples, &problem, &quick.linear),
            fit: quick.base.values,
        }
    }
}

/// Calibration by `nulls` fault-free simulations of `model`, the nominal model or one with causes. A score of any other
/// candidate there is bias or noise.
pub fn calibrate(
    simulation: &NullSimulation<'_>,
    model: &Base,
    effects: &[Effect],
    nulls: usize,
) -> RoadCalibration {
    calibrate_keeping(&Memo::default(), Key::of(&""), simulation, model, effects, nulls)
}

/// As [`calibrate`], with the scores of earlier calls from `kept`. `key` stands for simulation, model and effects.
pub(crate) fn calibrate_keeping(
    kept: &Memo<NullScores>,
    key: Key,
    simulation: &NullSimulation<'_>,
    model: &Base,
    effects: &[Effect],
    nulls: usize,
) -> RoadCalibration {
    let show = |number| NullScores::of(simulation, model, effects, number);
    let rides: Vec<Arc<NullScores>> = (0..nulls)
        .into_par_iter()
        .map(|number| kept.get_or(&(key, number), || show(number)))
        .collect();
    let scores: Vec<&[Score]> = rides.iter().map(|s| s.scores.as_slice()).collect();
    let terms: Vec<&[Term]> = rides.iter().map(|s| s.terms.as_slice()).collect();
    let noise_rms = noise_rms(rides.iter().map(|s| &s.sizes), nulls);
    let mut out = of_scores(&scores, effects.len(), StructureScale::of(&terms), noise_rms);
    out.scale.unmodelled = effects.iter().map(|e| shown(e.name).sd).collect();
    out.scale.size_share = effects.iter().map(|e| shown(e.name).size_share).collect();
    let top = |scores: &&[Score]| {
        (0..effects.len()).map(|j| out.judge(j, &scores[j]).score).fold(0.0, f64::max)
    };
    out.largest_scores = scores.iter().map(top).collect();
    for (bias, effect) in out.bias.iter_mut().zip(effects) {
        *bias *= shown(effect.name).bias_share;
    }
    out.scale.fits = rides.iter().map(|s| s.fit.clone()).collect();
    out
}

/// Calibration from the scores of all candidates on each fault-free simulation.
fn of_scores(
    scored: &[&[Score]],
    effects: usize,
    structure: StructureScale,
    noise_rms: NoiseRms,
) -> RoadCalibration {
    let nulls = scored.len();
    let all = |f: fn(&Score) -> f64| -> Vec<Vec<f64>> {
        (0..effects).map(|j| scored.iter().map(|s| f(&s[j])).collect()).collect()
    };
    let deltas = all(|s| s.delta);
    let bias: Vec<f64> = deltas.iter().map(|x| median_or_zero(x)).collect();
    let spread: Vec<f64> =
        deltas.iter().zip(&bias).map(|(x, bias)| spread_about(x, *bias).max(1e-9)).collect();
    // never zero: without response the detection limit is huge, and the effect is not identifiable
    let response: Vec<f64> = all(|s| s.information / (s.information + PRIOR.powi(-2)))
        .iter()
        .map(|shares| median_or_zero(shares).max(1e-15))
        .collect();
    let largest = |with_scatter: bool| {
        let top = |s: &&[Score]| {
            let z = |j: usize| {
                let own = if with_scatter { s[j].std_error } else { 0.0 };
                ((s[j].delta - bias[j]) / spread[j].max(own)).abs()
            };
            (0..effects)
                .filter(|&j| LIMIT * spread[j] / response[j] < LARGEST_LIMIT)
                .map(z)
                .fold(0.0, f64::max)
        };
        threshold(scored.iter().map(top).collect())
    };
    let scale = SizeScale {
        threshold: [largest(true), largest(false)],
        scatter: all(|s| s.std_error).iter().map(|x| median_or_zero(x)).collect(),
        unmodelled: vec![0.0; spread.len()],
        size_share: vec![1.0; spread.len()],
        spread,
        response,
        structure,
        fits: Vec::new(),
    };
    Calibration { bias, nulls, largest_scores: Vec::new(), noise_rms, scale }
}

/// Mean of the plain and the robust standard deviation.
fn spread_about(x: &[f64], centre: f64) -> f64 {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    let square = x.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    let sd = (square / (n - 1.0).max(1.0)).sqrt();
    let off: Vec<f64> = x.iter().map(|v| (v - centre).abs()).collect();
    0.5 * (sd + SD_PER_MAD * median_or_zero(&off))
}

impl StructureScale {
    fn of(terms: &[&[Term]]) -> Self {
        let n = terms.len() as f64;
        let count = terms.iter().map(|t| t.len()).min().unwrap_or(0);
        let usual = (0..count)
            // two degrees of freedom gain two by chance
            .map(|k| (terms.iter().map(|t| t[k].gain).sum::<f64>() / n).max(2.0))
            .collect();
        // each is compared with the others, as a ride is with all of them: its own gain would
        // count in the mean that it is measured by, and the threshold come out too low
        let sums: Vec<f64> = (0..count).map(|k| terms.iter().map(|t| t[k].gain).sum()).collect();
        let unusual = |own: &&[Term]| {
            let times = (0..count).map(|k| {
                let others = (sums[k] - own[k].gain) / (n - 1.0).max(1.0);
                own[k].gain / others.max(2.0)
            });
            times.fold(0.0, f64::max)
        };
        StructureScale { usual, threshold: threshold(terms.iter().map(unusual).collect()) }
    }

    /// The term that gains most beyond its usual gain on other machines, and how many times the threshold the most
    /// unusual one has.
    pub fn most_unusual(&self, terms: &[Term]) -> (Option<Term>, f64) {
        let bars = CHANNELS.map(usual_structure);
        let usual = || terms.iter().zip(&self.usual).map(|(t, usual)| (t, bars[t.channel] * usual));
        // the most unusual term tells that there is something, the one that gains most beyond its
        // usual what it goes with
        let times = usual().map(|(t, usual)| t.gain / usual).fold(0.0, f64::max);
        let most = usual().max_by(|a, b| (a.0.gain - a.1).total_cmp(&(b.0.gain - b.1)));
        (most.filter(|_| times > 0.0).map(|(t, _)| *t), times / self.threshold)
    }
}

impl Calibration<SizeScale> {
    /// Calibration of the candidates at some places.
    #[must_use]
    pub fn only(&self, places: &[usize]) -> Self {
        let of = |x: &[f64]| places.iter().map(|&j| x[j]).collect();
        let scale = SizeScale {
            spread: of(&self.scale.spread),
            response: of(&self.scale.response),
            scatter: of(&self.scale.scatter),
            unmodelled: of(&self.scale.unmodelled),
            size_share: of(&self.scale.size_share),
            ..self.scale.clone()
        };
        Calibration { bias: of(&self.bias), scale, ..self.clone() }
    }

    /// Fault-free simulations without candidates, which are judged as others do.
    #[must_use]
    pub fn judging_as(self, other: &Self) -> Self {
        let SizeScale { structure, fits, .. } = self.scale;
        let scale = SizeScale { structure, fits, ..other.scale.clone() };
        Calibration { nulls: self.nulls, noise_rms: self.noise_rms, scale, ..other.clone() }
    }

    /// Detection limit of candidate `j`, in usual sizes: 3.3 standard errors over the response.
    pub fn limit(&self, j: usize) -> f64 {
        LIMIT * self.error(j, 0.0) / self.scale.response[j]
    }

    /// Standard error of a size: that of fault-free simulations or of the manoeuvres, what the bias is uncertain
    /// by, and what the nominal model's own errors show.
    fn error(&self, j: usize, own: f64) -> f64 {
        let beyond = (BIAS_ERROR * self.bias[j]).hypot(self.scale.unmodelled[j]);
        self.scale.spread[j].max(own).hypot(beyond)
    }

    /// The calibration if further riding gave `times` as much information on candidate `j`; what other motorcycles
    /// show of it stays.
    #[must_use]
    pub fn with_information(&self, j: usize, times: f64) -> Self {
        let mut out = self.clone();
        let SizeScale { response, spread, scatter, .. } = &mut out.scale;
        // the response is I / (I + 1/9), the scatter of sizes is as sqrt(I) / (I + 1/9)
        let before = response[j];
        response[j] = times * before / (1.0 + (times - 1.0) * before);
        let share = response[j] / (before * times.sqrt());
        spread[j] *= share;
        scatter[j] *= share;
        out
    }

    /// Whether candidate `j` would show in such a ride at a size within its bounds.
    pub fn is_identifiable(&self, j: usize) -> bool {
        self.limit(j) < LARGEST_LIMIT
    }

    /// Size of candidate `j` whose score is on average that of a cause, in usual sizes: half of the effects of that
    /// size are identified.
    pub fn identified_half(&self, j: usize) -> f64 {
        let SizeScale { response, size_share, scatter, .. } = &self.scale;
        ALARM_ROAD / self.score_of(j, size_share[j] * response[j], scatter[j])
    }

    /// A real ride's score of candidate `j`.
    pub fn judge(&self, j: usize, score: &Score) -> Calibrated {
        let delta = score.delta - self.bias[j];
        let std_error = self.error(j, score.std_error);
        let own = self.score_of(j, delta, score.std_error);
        let score = if self.is_identifiable(j) { own } else { 0.0 };
        Calibrated { delta, std_error, score }
    }

    /// Score of an estimated size of candidate `j` without bias, whose standard error by the scatter of the
    /// manoeuvres is `own`; both in usual sizes.
    pub fn score_of(&self, j: usize, delta: f64, own: f64) -> f64 {
        let SizeScale { scatter, threshold, .. } = &self.scale;
        let robust = (delta / self.error(j, own)).abs() / threshold[0];
        // manoeuvres that scatter more than in fault-free simulations (pads, gusts) make those too sure
        let more = (own / scatter[j].max(f64::MIN_POSITIVE)).max(1.0);
        let plain = (delta / (more * self.error(j, 0.0))).abs() / (PLAIN * threshold[1]);
        robust.max(plain)
    }
}

/// The finite block residuals with their cells and blocks.
pub fn cells<'a>(
    samples: &'a Samples,
    found: &'a Blocks,
) -> impl Iterator<Item = (Cell, usize, f64)> + 'a {
    samples.manoeuvres.iter().flat_map(move |(kind, range)| {
        let blocks = range.start / BLOCK..range.end / BLOCK;
        found.iter().enumerate().flat_map(move |(c, column)| {
            let own = blocks.clone().map(|b| (b, column[b])).filter(|(_, r)| r.is_finite());
            own.map(move |(b, r)| ((*kind, c), b, r))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Candidates that others show less, and more, than noise.
    fn calibration() -> RoadCalibration {
        let scale = SizeScale {
            spread: vec![0.3, 0.1],
            response: vec![0.9, 0.6],
            unmodelled: vec![0.1, 0.4],
            size_share: vec![1.0, 0.5],
            scatter: vec![0.2, 0.5],
            threshold: [3.0, 2.5],
            structure: StructureScale { usual: Vec::new(), threshold: 1.0 },
            fits: Vec::new(),
        };
        let (bias, noise_rms) = (vec![0.1, -0.2], NoiseRms::new());
        Calibration { bias, nulls: 24, largest_scores: Vec::new(), noise_rms, scale }
    }

    #[test]
    fn a_size_that_is_identified_half_of_the_time_scores_as_a_cause_must() {
        let calibration = calibration();
        for j in 0..2 {
            let SizeScale { response, size_share, scatter, .. } = &calibration.scale;
            let shown = size_share[j] * response[j] * calibration.identified_half(j);
            let delta = shown + calibration.bias[j];
            let score = Score { delta, std_error: scatter[j], gain: 0.0, information: 1.0 };
            let judged = calibration.judge(j, &score);
            assert!((judged.score - ALARM_ROAD).abs() < 1e-12, "{judged:?}");
        }
    }

    #[test]
    fn four_times_the_information_halves_a_limit_of_noise_but_not_one_of_other_motorcycles() {
        let calibration = calibration();
        let [before, after] = [1.0, 4.0]
            .map(|times| [0, 1].map(|j| calibration.with_information(j, times).identified_half(j)));
        assert!((before[0] - calibration.identified_half(0)).abs() < 1e-12);
        let falls = [0, 1].map(|j| after[j] / before[j]);
        assert!((0.45..0.65).contains(&falls[0]) && falls[1] > falls[0] + 0.1, "{falls:?}");
    }
}
