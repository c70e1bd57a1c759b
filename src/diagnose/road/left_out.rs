//! Fits to all manoeuvres but a fifth of them, which tell how well a model fits what it has not seen.

use std::collections::BTreeMap;

use super::base::Base;
use super::parameters::{Parameter, Parameters};
use super::problem::{Linear, Problem};
use super::samples::Samples;
use crate::diagnose::held_out::{FOLDS, sum_over_folds};

/// Size of an effect, found on the whole ride.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SizedCause {
    /// The parameter that it moves.
    pub parameter: Parameter,
    /// Its size over that which a fit gives it.
    pub share: f64,
    /// 95 % interval of the size.
    pub interval: [f64; 2],
}

/// A model with the slopes that serve its fits without a fold: a fold less moves the optimum little.
#[derive(Debug)]
pub(crate) struct LeftOut<'a> {
    model: &'a Base,
    samples: &'a Samples,
    linear: Linear,
    /// Fold of each manoeuvre: manoeuvres of each kind in turn.
    pub fold_of: Vec<usize>,
}

impl<'a> LeftOut<'a> {
    /// The folds of a ride.
    pub(crate) fn new(model: &'a Base, samples: &'a Samples) -> Self {
        let mut seen = BTreeMap::new();
        let fold = |kind| {
            let count: &mut usize = seen.entry(kind).or_default();
            *count += 1;
            (*count - 1) % FOLDS
        };
        let fold_of = samples.manoeuvres.iter().map(|(kind, _)| *kind).map(fold).collect();
        let problem = model.problem(samples);
        let linear = problem.linear(&model.values);
        // the folds share them
        problem.accumulate(&linear);
        LeftOut { model, samples, linear, fold_of }
    }

    /// The model fitted without a fold, and its residuals in all manoeuvres.
    fn fit_without(&self, out: usize) -> (Parameters, Linear) {
        let kept: Vec<bool> = self.fold_of.iter().map(|f| *f != out).collect();
        let problem = Problem { only: Some(&kept), ..self.model.problem(self.samples) };
        let (mut values, mut linear) = (self.model.values.clone(), self.linear.clone());
        for _ in 0..3 {
            let Some((moved, _)) = problem.descend(&mut linear, &values) else { break };
            values = moved;
        }
        (values, linear)
    }

    /// The model fitted without a fold. Where effects were found they get what was found: the
    /// fold's fit over the share that fits give, within the interval, beyond which a small share tells nothing. The
    /// base is fitted beside them.
    pub(crate) fn without(&self, out: usize, found: &[SizedCause]) -> Parameters {
        let (mut values, _) = self.fit_without(out);
        if found.is_empty() {
            return values;
        }
        let start = &self.model.start;
        for SizedCause { parameter: p, share, interval: [low, high] } in found {
            let size = (share * (p.get(&values) - p.get(start))).clamp(*low, *high);
            p.set(&mut values, p.get(start) + size);
        }
        let kept: Vec<bool> = self.fold_of.iter().map(|f| *f != out).collect();
        let parameters: Vec<Parameter> = self
            .model
            .parameters
            .iter()
            .copied()
            .filter(|p| found.iter().all(|f| f.parameter.name != p.name))
            .collect();
        let sigma = self.model.sigma;
        let problem = Problem::new(self.samples, start, sigma, &parameters);
        Problem { only: Some(&kept), ..problem }.optimum(&values, 2).0
    }

    /// Loss on the manoeuvres left out, over all folds.
    pub(crate) fn loss(&self) -> f64 {
        sum_over_folds(|out| {
            let (_, linear) = self.fit_without(out);
            let left: Vec<bool> = self.fold_of.iter().map(|f| *f == out).collect();
            let problem = Problem { only: Some(&left), ..self.model.problem(self.samples) };
            problem.misfit_of(&linear.residuals)
        })
    }
}
