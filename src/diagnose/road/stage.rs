//! A stage of the search on the road: a model, and what candidates and structure show on fault-free simulations
//! of it.

use std::sync::Arc;

use rayon::prelude::*;

use super::base::Base;
use super::kept::{Key, Memo};
use super::null_calibration::{NullScores, RoadCalibration, calibrate_keeping};
use super::null_simulation::NullSimulation;
use super::other_machines::shown;
use super::parameters::{Parameter, Parameters};
use super::problem::Linear;
use super::samples::Samples;
use super::scan::{Score, scan};
use super::structure::{self, Term};
use crate::diagnose::cause::{Candidate, Cause, Estimate, Judged};
use crate::diagnose::tuning::RoadTuning;
use crate::simulate::effects::Effect;
use crate::statistics::order::{SD_PER_MAD, median_or_zero};

/// Most steps to the sizes that are simulated.
const TIMES_SIMULATED: usize = 3;

/// A ride with all its candidates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ride<'a> {
    pub samples: &'a Samples,
    pub effects: &'a [Effect],
    pub tuning: &'a RoadTuning,
}

impl Ride<'_> {
    /// A candidate by its place.
    pub(crate) fn candidate(&self, place: usize) -> Candidate {
        let effect = &self.effects[place];
        Candidate {
            place,
            name: effect.name,
            parameter: effect.name,
            sentence: effect.sentence,
            opposite: effect.opposite,
            unit: effect.unit,
            separate_by: effect.separate_by,
            typical: effect.typical,
            bounds: effect.bounds,
        }
    }

    /// Fitted parameter of a candidate.
    pub(crate) fn parameter(&self, candidate: &Candidate) -> Parameter {
        self.effects[candidate.place].parameter()
    }

    /// Size of a candidate in a model, in its unit, less its value in the nominal model.
    pub(crate) fn size(&self, candidate: &Candidate, model: &Base) -> f64 {
        let p = self.parameter(candidate);
        p.get(&model.values) - p.get(&model.start)
    }

    fn effects_of(&self, places: &[usize]) -> Vec<Effect> {
        places.iter().map(|&place| self.effects[place]).collect()
    }
}

/// Results shared by several searches of one ride with different constants; by default nothing is kept.
#[derive(Debug, Default)]
pub(crate) struct DiagnosisCache<'a> {
    /// Models fitted to the ride.
    models: Memo<Base>,
    /// Scores to first order on a model.
    scores: Memo<Vec<Score>>,
    /// The ride simulated on a model.
    simulations: Memo<NullSimulation<'a>>,
    /// Scores of fault-free simulations.
    null_scores: Memo<NullScores>,
}

impl DiagnosisCache<'_> {
    /// A cache that keeps all results.
    pub(crate) fn keeping() -> Self {
        DiagnosisCache {
            models: Memo::keeping(),
            scores: Memo::keeping(),
            simulations: Memo::keeping(),
            null_scores: Memo::keeping(),
        }
    }

    /// [`Base::extended`] by some candidates; `slopes` are the derivatives by all parameters, if known.
    pub(crate) fn extended(
        &self,
        ride: &Ride<'_>,
        model: &Base,
        more: &[Candidate],
        slopes: Option<Linear>,
    ) -> Arc<Base> {
        let names: Vec<&str> = more.iter().map(|c| c.name).collect();
        self.models.get_or(&(key_of(model), names), || {
            let more: Vec<Parameter> = more.iter().map(|c| ride.parameter(c)).collect();
            model.extended_along(slopes, ride.samples, &more, 8)
        })
    }

    /// [`scan`] of some candidates.
    pub(crate) fn scan(
        &self,
        ride: &Ride<'_>,
        model: &Base,
        effects: &[Effect],
    ) -> Arc<Vec<Score>> {
        let made_from = (key_of(model), names(effects));
        self.scores.get_or(&made_from, || scan(ride.samples, model, effects))
    }
}

/// Key of a model, from its values.
fn key_of(model: &Base) -> Key {
    let Base { start, values, sigma, loss, parameters } = model;
    let names: Vec<&str> = parameters.iter().map(|p| p.name).collect();
    Key::of(&(start, values, sigma, loss, names))
}

/// Key of the results of fault-free simulations for effects beside a model.
fn key_of_shown(noise_of: Key, simulated: &Parameters, model: &Base, effects: &[Effect]) -> Key {
    Key::of(&(noise_of, simulated, key_of(model), names(effects)))
}

fn names(effects: &[Effect]) -> Vec<&'static str> {
    effects.iter().map(|e| e.name).collect()
}

/// A model, and what candidates and structure show on fault-free simulations of it.
#[derive(Debug)]
pub(crate) struct Stage<'a> {
    /// The base, or the base with causes.
    pub model: Base,
    /// Fault-free simulations with the noise that the model leaves.
    pub simulation: Arc<NullSimulation<'a>>,
    /// The model that their noise was learnt from.
    pub noise_of: Key,
    /// Simulated parameters: the model, with sizes for which fits give the model's sizes.
    pub simulated: Parameters,
    /// Places of the candidates that are not in the model.
    pub open: Vec<usize>,
    /// Their scores to first order.
    pub scores: Vec<Score>,
    /// Their calibration by fault-free simulations, in the order of `open`.
    pub calibration: RoadCalibration,
    /// Gain of each when an implausible nominal fit is repeated with it, and its size in usual sizes; empty where
    /// the nominal fit is plausible.
    pub strain_gains: Vec<(f64, f64)>,
}

impl<'a> Stage<'a> {
    /// The stage after a cause has joined the model. The noise is estimated again, as the model fits better.
    ///
    /// Fault-free simulations of it show what sizes its causes have. Candidates are recalibrated only where
    /// the calibration of the previous stage suggests a further cause: it costs the most time.
    pub(crate) fn next(
        ride: &Ride<'_>,
        memory: &DiagnosisCache<'a>,
        model: &Base,
        open: Vec<usize>,
        before: &Stage<'a>,
        named: &[Cause],
    ) -> Self {
        // what is simulated to find the sizes serves the calibration, too
        let own = DiagnosisCache::keeping();
        let memory = if memory.null_scores.is_keeping() { memory } else { &own };
        let tuning = ride.tuning;
        let count = before.calibration.nulls.min(tuning.nulls_of_stage);
        let sigma = model.sigma;
        let own_noise = || model.with_own_noise(ride.samples);
        let model = memory.models.get_or(&("own noise", key_of(model)), own_noise);
        let model = Base::clone(&model);
        let quieter = sigma.iter().zip(model.sigma).map(|(before, now)| now / before);
        let quieter = quieter.fold(1.0, f64::min);
        let (simulation, noise_of) = match quieter < tuning.quieter {
            true => {
                let learnt = || before.simulation.with_noise_of(&model);
                let own = key_of(&model);
                (memory.simulations.get_or(&("noise of", own), learnt), own)
            }
            false => (before.simulation.clone(), before.noise_of),
        };
        let riding = |values: &Parameters| {
            let with = || simulation.with_parameters(values);
            memory.simulations.get_or(&(noise_of, values), with)
        };
        let simulation = riding(&model.values);
        let fits = |values: &Parameters, count: usize| -> Vec<Parameters> {
            let simulation = riding(values);
            let key = key_of_shown(noise_of, values, &model, &[]);
            let fit = |number: usize| {
                let show = || NullScores::of(&simulation, &model, &[], number);
                memory.null_scores.get_or(&(key, number), show).fit.clone()
            };
            (0..count).into_par_iter().map(fit).collect()
        };
        let simulated = simulated(ride, &model, fits, count, named);
        let simulation = match simulated == model.values {
            true => simulation,
            false => riding(&simulated),
        };
        // first scores by the previous calibration, which scores a channel that is quieter now too low
        let place = |e: &usize| before.open.iter().position(|b| b == e);
        let places: Vec<usize> = open.iter().filter_map(place).collect();
        let effects = ride.effects_of(&open);
        let scores = memory.scan(ride, &model, &effects).to_vec();
        let calibration = before.calibration.only(&places);
        let strain_gains = Vec::new();
        let mut stage = Stage {
            model,
            simulation,
            noise_of,
            simulated,
            open,
            scores,
            calibration,
            strain_gains,
        };
        let largest = stage.judge(ride).iter().map(|j| j.score).fold(0.0, f64::max);
        let alarming = largest > tuning.look * quieter;
        let effects = if alarming { effects.as_slice() } else { &[] };
        let Stage { simulation, model, .. } = &stage;
        let key = key_of_shown(noise_of, &stage.simulated, model, effects);
        let calibration =
            calibrate_keeping(&memory.null_scores, key, simulation, model, effects, count);
        stage.calibration = match alarming {
            true => calibration,
            false => calibration.judging_as(&stage.calibration),
        };
        stage
    }

    pub(crate) fn judge(&self, ride: &Ride<'_>) -> Vec<Judged> {
        let judged = |(k, (place, score)): (usize, (&usize, &Score))| {
            let (strained, size) = self.strain_gains.get(k).copied().unwrap_or((0.0, 0.0));
            let makes_plausible = strained > super::base::PLAUSIBLE_GAIN;
            // an implausible fit is too far from the truth for a linearisation: the fit with the candidate is used
            let score = match makes_plausible {
                true => {
                    Score { delta: size, std_error: self.calibration.scale.scatter[k], ..*score }
                }
                false => *score,
            };
            let calibrated = self.calibration.judge(k, &score);
            let candidate = ride.candidate(*place);
            let unit = candidate.typical.abs();
            let (value, std_error) = (calibrated.delta * unit, calibrated.std_error * unit);
            Judged {
                candidate,
                estimate: Some(Estimate::linear(value, std_error)),
                bias: self.calibration.bias[k] * unit,
                score: calibrated.score,
                gain: score.gain.max(strained),
                makes_plausible,
            }
        };
        self.open.iter().zip(&self.scores).enumerate().map(judged).collect()
    }

    /// The residual structure: the term that gains most beyond its usual gain, the size of the most unusual term over the
    /// threshold of fault-free simulations, and the linearisation in which it was found.
    pub(crate) fn structure(&self, samples: &Samples) -> (Option<(Term, f64)>, Linear) {
        let problem = self.model.problem(samples);
        let linear = problem.linear(&self.model.values);
        let terms = structure::terms(samples, &problem, &linear);
        let (most, times) = self.calibration.scale.structure.most_unusual(&terms);
        (most.map(|term| (term, times)), linear)
    }
}

/// Parameters to simulate, so that fits to the simulations return the sizes of the model's own fit. A fit may return
/// only half of a true size, and the other half must not look like another cause. `fits` gives the fits to fault-free
/// simulations with some parameters. The returned share depends on the size, so a large one needs several steps.
fn simulated(
    ride: &Ride<'_>,
    model: &Base,
    fits: impl Fn(&Parameters, usize) -> Vec<Parameters>,
    count: usize,
    named: &[Cause],
) -> Parameters {
    let tuning = ride.tuning;
    let first = count.min(tuning.nulls_of_sizes);
    let mut simulated = model.values.clone();
    for _ in 0..TIMES_SIMULATED {
        let fits = fits(&simulated, first);
        let sizes = true_sizes(ride, model, &simulated, &fits, named);
        let before = simulated.clone();
        let mut off = false;
        for (cause, size) in named.iter().zip(&sizes) {
            let p = ride.parameter(&cause.candidate);
            let [low, high] = cause.candidate.bounds;
            let (size, zero) = (size.value.clamp(low, high), p.get(&model.start));
            off |= (size - (p.get(&before) - zero)).abs() > tuning.off_size * size.abs();
            p.set(&mut simulated, zero + size);
        }
        if !off {
            return before;
        }
        simulated = refit_with_fixed_sizes(ride, model, &simulated, named);
    }
    simulated
}

/// Parameters of a model whose causes have the sizes of `sizes`, all others fitted again with these sizes fixed. The
/// fit around a size that is too small would make up for the difference.
fn refit_with_fixed_sizes(
    ride: &Ride<'_>,
    model: &Base,
    sizes: &Parameters,
    named: &[Cause],
) -> Parameters {
    let is_cause =
        |p: &Parameter| named.iter().any(|c| ride.parameter(&c.candidate).name == p.name);
    let parameters = model.parameters.iter().filter(|p| !is_cause(p)).copied().collect();
    let fixed = Base { values: sizes.clone(), parameters, ..model.clone() };
    fixed.extended(ride.samples, &[], 3).values
}

/// Sizes and their errors, corrected by simulations of the model, where the true sizes are known.
///
/// A fit returns a share of a true size, as noise in a regressor attenuates it, plus a bias. `fits` are the fits to these
/// simulations; they show both.
pub(crate) fn true_sizes(
    ride: &Ride<'_>,
    model: &Base,
    simulated: &Parameters,
    fits: &[Parameters],
    named: &[Cause],
) -> Vec<Estimate> {
    let RoadTuning { share_prior, model_error, .. } = *ride.tuning;
    let (start, count) = (&model.start, fits.len() as f64);
    let of = |cause: &Cause| {
        let p = ride.parameter(&cause.candidate);
        let fitted = ride.size(&cause.candidate, model);
        let truth = p.get(simulated) - p.get(start);
        let own: Vec<f64> = fits.iter().map(|fit| p.get(fit) - p.get(start)).collect();
        let (centre, sd) = centre_and_spread(&own);
        // rides have only a share of the simulations' bias
        let whole = cause.bias / shown(cause.candidate.name).bias_share;
        let centre = centre - (whole - cause.bias);
        // the share and its precision; a size within its noise does not show it, and the prior decides
        let precision = (truth / (1.25 * sd)).powi(2) * count;
        let prior = share_prior.powi(-2);
        let seen = precision * (centre - cause.bias) / truth;
        let share = ((seen + prior) / (precision + prior)).clamp(0.3, 2.0);
        let value = truth + (fitted - centre) / share;
        let scatter = cause.std_error().max(sd) / share;
        let of_share = (value - truth) / share / (precision + prior).sqrt();
        match value.is_finite() {
            true => Estimate::linear(value, scatter.hypot(of_share).hypot(model_error * value)),
            // the model cannot be simulated: the fit's own size
            false => {
                Estimate::linear(fitted - cause.bias, cause.std_error().hypot(model_error * fitted))
            }
        }
    };
    named.iter().map(of).collect()
}

/// Median of sizes, and the mean of their two standard deviations: the plain and the robust one.
fn centre_and_spread(sizes: &[f64]) -> (f64, f64) {
    let count = sizes.len() as f64;
    let centre = median_or_zero(sizes);
    let off: Vec<f64> = sizes.iter().map(|x| (x - centre).abs()).collect();
    let spread = SD_PER_MAD * median_or_zero(&off);
    let mean = sizes.iter().sum::<f64>() / count;
    let square = sizes.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    (centre, 0.5 * ((square / (count - 1.0).max(1.0)).sqrt() + spread))
}
