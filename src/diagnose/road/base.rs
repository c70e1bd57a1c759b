//! The base fit: robust Gauss-Newton on block means whose noise is that of correlated samples
//! (`book/src/diagnosis.md`, section 2.2).
//!
//! The loss is Huber's at 2.5 standard deviations of a channel's block residual, plus weak Gaussian
//! priors about the start. The standard deviation is the *long-run* one (Newey and West 1987): block
//! means within a manoeuvre are correlated over seconds, and what counts is what they average to.

use rayon::prelude::*;

use super::parameters::{BASE, Parameter, Parameters};
use super::problem::{Linear, Problem};
use super::residuals::Blocks;
use super::samples::{BLOCK, Samples};
use crate::simulate::effects::Effect;

/// Most Gauss-Newton rounds of a fit; most end earlier.
const ROUNDS: usize = 16;
/// Lags of the long-run variance, blocks: 3 s.
const LAGS: usize = 10;
/// Distance of a nominal parameter from its prior centre, in prior standard deviations, from which the fit is
/// implausible.
const IMPLAUSIBLE_DISTANCE: f64 = 2.5;
/// Smallest gain of a candidate that makes an implausible fit plausible.
pub(crate) const PLAUSIBLE_GAIN: f64 = 30.0;
/// Fall of the loss along the first slopes, over the gain that explains a strain, below which a candidate will not get
/// there.
const HOPELESS: f64 = 0.1;
/// Share of the largest fall of the loss along the first slopes below which a candidate is not followed to its optimum.
const FAR: f64 = 0.1;
/// Most sets of slopes of the fit with every effect free.
const TIMES: usize = 5;
/// Fall of the noise from one set of slopes to the next that tells of a large effect in it.
const LARGE: f64 = 1.25;
/// Fall of the loss that tells that the optimum was a local one.
const LOCAL: f64 = 8.0;

/// A fitted nominal model.
#[derive(Debug, Clone)]
pub struct Base {
    pub values: Parameters,
    /// Where it started, the centre of the priors.
    pub start: Parameters,
    /// Long-run standard deviation of each channel's block residual.
    pub sigma: [f64; 8],
    /// Loss at the end.
    pub loss: f64,
    /// Fitted parameters: [`BASE`], and the effects in the model.
    pub parameters: Vec<Parameter>,
}

/// Where extensions of a base are looked for.
#[derive(Debug, Clone)]
pub struct Start {
    /// The best that the base can do.
    pub base: Base,
    /// The place from which they are looked for; its loss is the base's, gains count from there.
    pub near: Base,
    /// The model whose residuals define the noise.
    pub noise: Base,
    /// Gain of each candidate when the nominal model is fitted with it, and its size in usual sizes; empty if the nominal
    /// fit is plausible.
    pub gains: Vec<(f64, f64)>,
}

/// Fits the base from a start.
pub fn fit(samples: &Samples, start: &Parameters) -> Base {
    fit_with(samples, &start.prior_centre(), start, BASE, None)
}

/// Fits `parameters` from `from`, with priors about `start`; `extra` is added to the residuals.
pub fn fit_with(
    samples: &Samples,
    start: &Parameters,
    from: &Parameters,
    parameters: &[Parameter],
    extra: Option<&Blocks>,
) -> Base {
    let mut values = from.clone();
    let mut problem = Problem { extra, ..Problem::new(samples, start, [1.0; 8], parameters) };
    let mut loss = None;
    for round in 0..ROUNDS {
        let mut linear = problem.linear(&values);
        // the scale follows the first rounds, then it is the same for everybody
        if round < 4 {
            problem.sigma = noise(samples, &linear.residuals);
        }
        let moved = problem.descend(&mut linear, &values);
        loss = moved.as_ref().map(|(moved, _)| problem.loss_of(&linear.residuals, moved));
        let Some((moved, size)) = moved else { break };
        values = moved;
        if round >= 4 && size < 1e-3 {
            break;
        }
    }
    let loss = loss.unwrap_or_else(|| problem.loss(&values));
    let parameters = parameters.to_vec();
    Base { start: start.clone(), sigma: problem.sigma, loss, parameters, values }
}

/// A fit from parameters that are nearly right already, along one linearisation: what a fault-free simulation
/// needs.
#[derive(Debug, Clone)]
pub struct Quick {
    pub base: Base,
    /// The linearisation, of the base's parameters and then of `more`, residuals at the end.
    pub linear: Linear,
}

/// Fits `fitted` from a model whose own ride it is, or one near by; `more` is linearised along with it,
/// `disturb` may add to what is added to the residuals.
pub(crate) fn fit_quick(
    samples: &Samples,
    model: &Base,
    fitted: &[Parameter],
    more: &[Parameter],
    mut extra: Blocks,
    disturb: impl FnOnce(&Linear, &mut Blocks),
) -> Quick {
    let (prior, start) = (&model.start, &model.values);
    let all: Vec<Parameter> = fitted.iter().chain(more).copied().collect();
    let mut problem = Problem::new(samples, prior, [1.0; 8], &all);
    let mut linear = problem.linear_of_means(start);
    disturb(&linear, &mut extra);
    problem.extra = Some(&extra);
    problem.add_extra(&mut linear.residuals);
    problem.parameters = fitted;
    let mut values = start.clone();
    let mut factor = None;
    let mut exact = true;
    for round in 0..5 {
        // the scale follows the first rounds, as in the fit of a real ride
        if round < 3 {
            problem.sigma = noise(samples, &linear.residuals);
            factor = None;
        }
        let (matrix, gradient) = problem.normal_of(&linear, &values, factor.is_none());
        let solver = match factor.take().or_else(|| matrix.cholesky()) {
            Some(solver) => solver,
            None => break,
        };
        let step = solver.solve(&gradient);
        factor = Some(solver);
        values = problem.stepped(&values, &step, 1.0);
        // what the scale is learnt from need not be exact
        if round < 2 {
            linear.step_by(&step);
            exact = false;
            continue;
        }
        linear.residuals = problem.residuals(&values);
        exact = true;
        if step.amax() < 1e-3 && round >= 3 {
            break;
        }
    }
    let base = Base {
        loss: match exact {
            true => problem.loss_of(&linear.residuals, &values),
            false => problem.loss(&values),
        },
        start: prior.clone(),
        sigma: problem.sigma,
        parameters: fitted.to_vec(),
        values,
    };
    Quick { base, linear }
}

impl Base {
    /// The loss whose optimum it is.
    pub fn problem<'a>(&'a self, samples: &'a Samples) -> Problem<'a> {
        Problem::new(samples, &self.start, self.sigma, &self.parameters)
    }

    /// The slopes of the base's parameters and of more, where it is, and their products.
    pub(super) fn linear_with(&self, samples: &Samples, more: &[Parameter]) -> Linear {
        let parameters: Vec<Parameter> = self.parameters.iter().chain(more).copied().collect();
        let problem = Problem::new(samples, &self.start, self.sigma, &parameters);
        let linear = problem.linear(&self.values);
        problem.accumulate(&linear);
        linear
    }

    /// The base with more free parameters, its noise and priors kept; slopes are made at most `times`.
    pub fn extended(&self, samples: &Samples, more: &[Parameter], times: usize) -> Base {
        self.extended_along(None, samples, more, times)
    }

    /// The same where the slopes of all of them are known already.
    pub(super) fn extended_along(
        &self,
        known: Option<Linear>,
        samples: &Samples,
        more: &[Parameter],
        times: usize,
    ) -> Base {
        let parameters: Vec<Parameter> = self.parameters.iter().chain(more).copied().collect();
        let problem = Problem::new(samples, &self.start, self.sigma, &parameters);
        let (values, loss) = problem.optimum_along(known, &self.values, times);
        Base { values, loss, start: self.start.clone(), sigma: self.sigma, parameters }
    }

    /// The model with every effect free, and the noise that it leaves: what it explains is no noise.
    pub(super) fn with_everything(&self, samples: &Samples, effects: &[Effect]) -> Base {
        let known = &self.parameters;
        let more: Vec<Parameter> = effects
            .iter()
            .map(Effect::parameter)
            .filter(|p| known.iter().all(|k| k.name != p.name))
            .collect();
        let with_noise = |free: Base| {
            let sigma = noise(samples, &free.problem(samples).residuals(&free.values));
            Base { sigma, ..free }
        };
        // one set of slopes: the noise that is left need not be exact, but a large effect must not be in it
        let mut free = with_noise(self.extended(samples, &more, 1));
        for _ in 1..TIMES {
            let next = with_noise(free.extended(samples, &[], 1));
            let fell = free.sigma.iter().zip(next.sigma).any(|(before, now)| *before > LARGE * now);
            if !fell {
                break;
            }
            free = next;
        }
        free
    }

    /// The model with the noise that it leaves, fitted with that again.
    #[must_use]
    pub fn with_own_noise(&self, samples: &Samples) -> Base {
        let mut problem = self.problem(samples);
        let mut values = self.values.clone();
        let mut linear = problem.linear(&values);
        for _ in 0..4 {
            problem.sigma = noise(samples, &linear.residuals);
            let Some((moved, _)) = problem.descend(&mut linear, &values) else { break };
            values = moved;
        }
        let (values, loss) = problem.optimum(&values, 4);
        Base { values, loss, sigma: problem.sigma, ..self.clone() }
    }

    /// The base as a start for its extensions.
    ///
    /// A large effect drags the base to where no motorcycle is, and what is linear about that place is
    /// not about the truth. Where a parameter is that implausible, extensions are looked for from where
    /// the candidate that gains most leaves the base, and noise is what that candidate leaves. Where
    /// the base alone is better off from there it was in a local optimum (`book/src/diagnosis.md`, section
    /// 2.5).
    #[must_use]
    pub fn starting_point(self, samples: &Samples, effects: &[Effect]) -> Start {
        let as_it_is =
            |base: Base| Start { near: base.clone(), noise: base.clone(), base, gains: Vec::new() };
        let problem = self.problem(samples);
        let strain = |p: &Parameter| problem.prior(p, &self.values).0.abs();
        if self.parameters.iter().map(strain).fold(0.0, f64::max) < IMPLAUSIBLE_DISTANCE {
            return as_it_is(self);
        }
        let more: Vec<Parameter> = effects.iter().map(Effect::parameter).collect();
        let (linear, own) = (self.linear_with(samples, &more), self.parameters.len());
        let first: Vec<Base> = effects
            .par_iter()
            .enumerate()
            .map(|(k, effect)| {
                let linear = Some(linear.with(own, own + k));
                self.extended_along(linear, samples, &[effect.parameter()], 1)
            })
            .collect();
        // what gains next to nothing along the first slopes, or far less than another, is not followed further
        let fall = |refit: &Base| self.loss - refit.loss;
        let largest = first.iter().map(fall).fold(0.0, f64::max);
        let least = (HOPELESS * PLAUSIBLE_GAIN).max(FAR * largest);
        let refits: Vec<(&Effect, f64, Base)> = effects
            .par_iter()
            .zip(first)
            .map(|(effect, refit)| match fall(&refit) > least {
                true => (effect, refit.extended(samples, &[], 7)),
                false => (effect, refit),
            })
            .map(|(effect, refit)| (effect, 2.0 * fall(&refit), refit))
            .collect();
        let sized = |(effect, gain, refit): &(&Effect, f64, Base)| {
            let p = effect.parameter();
            (*gain, (p.get(&refit.values) - p.get(&refit.start)) / p.scale)
        };
        let gains: Vec<(f64, f64)> = refits.iter().map(sized).collect();
        let best = refits
            .into_iter()
            .filter(|(effect, _, refit)| effect.in_bounds(effect.parameter().get(&refit.values)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((effect, _, refit)) = best.filter(|(_, gain, _)| *gain > PLAUSIBLE_GAIN) else {
            return as_it_is(self);
        };
        let p = effect.parameter();
        let mut values = refit.values.clone();
        p.set(&mut values, p.get(&self.start));
        let sigma = noise(samples, &problem.residuals(&refit.values));
        let from = |values: &Parameters| {
            let base = Base { values: values.clone(), sigma, ..self.clone() };
            Base { loss: base.problem(samples).loss(values), ..base }.extended(samples, &[], 8)
        };
        let [stayed, moved] = [&self.values, &values].map(from);
        let base = if stayed.loss - moved.loss > LOCAL { moved } else { stayed };
        let near = Base { values, ..base.clone() };
        let noise = Base { values: refit.values, ..base.clone() };
        Start { base, near, noise, gains }
    }
}

/// Long-run standard deviation of each channel's block means within manoeuvres.
pub fn noise(samples: &Samples, found: &Blocks) -> [f64; 8] {
    std::array::from_fn(|c| {
        let column = &found[c];
        let mut sizes: Vec<f64> =
            column.iter().filter(|r| r.is_finite()).map(|r| r.abs()).collect();
        if sizes.is_empty() {
            return 1.0;
        }
        sizes.sort_by(f64::total_cmp);
        // a median absolute deviation limits what a few wild blocks can do
        let limit = 4.0 * 1.4826 * sizes[sizes.len() / 2].max(1e-9);
        let clipped = |b: usize| column[b].clamp(-limit, limit);
        let (mut sums, mut n) = ([0.0; LAGS + 1], 0.0);
        for (_, range) in &samples.manoeuvres {
            let (first, last) = (range.start / BLOCK, range.end / BLOCK);
            for b in first..last {
                if !column[b].is_finite() {
                    continue;
                }
                n += 1.0;
                for (lag, sum) in sums.iter_mut().enumerate() {
                    if b >= first + lag && column[b - lag].is_finite() {
                        *sum += clipped(b) * clipped(b - lag);
                    }
                }
            }
        }
        let bartlett = |lag: usize| 1.0 - lag as f64 / (LAGS + 1) as f64;
        let long: f64 =
            sums[0] + 2.0 * (1..=LAGS).map(|lag| bartlett(lag) * sums[lag]).sum::<f64>();
        (long.max(0.2 * sums[0]) / n).sqrt().max(1e-9)
    })
}
