//! The loss that models are fitted by: Huber's on block means in standard deviations of their
//! channels, with weak priors (`book/src/diagnosis.md`, section 2.2), and its Gauss-Newton steps.

use std::sync::{Arc, OnceLock};

use nalgebra::{DMatrix, DVector, DVectorView};
use rayon::prelude::*;

use super::gram::Gram;
use super::parameters::{Parameter, Parameters};
use super::residuals::{Blocks, CHANNELS, blocks};
use super::samples::{BLOCK, Samples};
use super::workings::LinearisationCache;

/// Standard deviations at which the loss turns from square to straight.
const HUBER: f64 = 2.5;
/// Largest residual that counts, in standard deviations: a larger one is no noise.
const FARTHEST: f64 = 60.0;
/// Share of a scale for differences.
const STEP: f64 = 0.003;
/// Steps along the same slopes.
const FOLLOWED: usize = 4;
/// Size of a step that ends a fit, in scales: effects' are their usual sizes.
const ARRIVED: f64 = 5e-3;

/// A loss over some parameters.
#[derive(Debug, Clone, Copy)]
pub struct Problem<'a> {
    pub samples: &'a Samples,
    /// Centre of the priors.
    pub start: &'a Parameters,
    /// Standard deviations of the channels.
    pub sigma: [f64; 8],
    pub parameters: &'a [Parameter],
    /// Added to the residuals: noise of a fault-free simulation.
    pub extra: Option<&'a Blocks>,
    /// Manoeuvres that count; all where there is no list.
    pub only: Option<&'a [bool]>,
}

/// Residuals and their derivatives by the parameters, in scales.
#[derive(Debug, Clone)]
pub struct Linear {
    /// `[channel][block]`.
    pub residuals: Blocks,
    /// Per parameter `[channel][block]`.
    pub columns: Vec<Arc<Blocks>>,
    /// Products of the columns, once they were asked for.
    gram: OnceLock<Arc<Gram>>,
}

impl Linear {
    /// The first `count` parameters alone, and one more.
    pub(super) fn with(&self, count: usize, one: usize) -> Linear {
        let kept: Vec<usize> = (0..count).chain([one]).collect();
        let columns = kept.iter().map(|k| self.columns[*k].clone()).collect();
        let gram = self.gram.get().map(|gram| Arc::new(gram.only(&kept)));
        let gram = gram.map(OnceLock::from).unwrap_or_default();
        Linear { residuals: self.residuals.clone(), columns, gram }
    }

    /// Adds to the residuals what a step of the first parameters, in scales, changes to first order.
    pub(super) fn step_by(&mut self, step: &DVector<f64>) {
        for (column, d) in self.columns.iter().zip(step.iter()) {
            for (to, by) in self.residuals.iter_mut().zip(column.iter()) {
                to.iter_mut().zip(by).for_each(|(r, j)| *r += d * j);
            }
        }
    }
}

impl<'a> Problem<'a> {
    /// The loss of every manoeuvre, without simulated noise.
    pub fn new(
        samples: &'a Samples,
        start: &'a Parameters,
        sigma: [f64; 8],
        parameters: &'a [Parameter],
    ) -> Self {
        Problem { samples, start, sigma, parameters, extra: None, only: None }
    }
}

impl Problem<'_> {
    /// Block residuals under some parameters.
    pub fn residuals(&self, values: &Parameters) -> Blocks {
        let mut out = blocks(self.samples, values);
        self.add_extra(&mut out);
        out
    }

    pub(super) fn add_extra(&self, out: &mut Blocks) {
        for (column, extra) in out.iter_mut().zip(self.extra.into_iter().flatten()) {
            column.iter_mut().zip(extra).for_each(|(r, e)| *r += e);
        }
    }

    /// One Gauss-Newton step with halving, and its size in scales; `None` when it leads nowhere. Slopes may have been
    /// made near by; residuals are those at `values`, and then of where it leads to.
    pub(super) fn descend(
        &self,
        linear: &mut Linear,
        values: &Parameters,
    ) -> Option<(Parameters, f64)> {
        let (matrix, gradient) = self.normal_of(linear, values, true);
        let step = matrix.cholesky()?.solve(&gradient);
        let before = self.loss_of(&linear.residuals, values);
        let mut share = 1.0;
        while share > 1e-3 {
            let tried = self.stepped(values, &step, share);
            let residuals = self.residuals(&tried);
            if self.loss_of(&residuals, &tried) <= before {
                linear.residuals = residuals;
                return Some((tried, share * step.amax()));
            }
            share *= 0.5;
        }
        None
    }

    /// The optimum near some values and the loss there: slopes are made anew at most `times`, and between that followed
    /// as long as they lead on.
    pub(super) fn optimum(&self, from: &Parameters, times: usize) -> (Parameters, f64) {
        self.optimum_along(None, from, times)
    }

    /// The same where the slopes at `from` are known; they count among those that are made.
    pub(super) fn optimum_along(
        &self,
        mut known: Option<Linear>,
        from: &Parameters,
        times: usize,
    ) -> (Parameters, f64) {
        let mut values = from.clone();
        let mut loss = None;
        for _ in 0..times {
            let mut linear = known.take().unwrap_or_else(|| self.linear(&values));
            let (mut first, mut last) = (0.0_f64, f64::INFINITY);
            for _ in 0..FOLLOWED {
                let Some((moved, size)) = self.descend(&mut linear, &values) else { break };
                values = moved;
                first = first.max(size);
                if size < ARRIVED || size > 0.5 * last {
                    break;
                }
                last = size;
            }
            loss = Some(self.loss_of(&linear.residuals, &values));
            if first < ARRIVED {
                break;
            }
        }
        let loss = loss.unwrap_or_else(|| self.loss(&values));
        (values, loss)
    }

    /// Takes a linearisation's residuals to the optimum of this problem's parameters, the first of its
    /// columns, to first order; gives the values there.
    pub fn relax(&self, linear: &mut Linear, values: &Parameters) -> Parameters {
        let (matrix, gradient) = self.normal_of(linear, values, true);
        let Some(factor) = matrix.cholesky() else { return values.clone() };
        let step = factor.solve(&gradient);
        linear.step_by(&step);
        self.stepped(values, &step, 1.0)
    }

    pub(super) fn stepped(
        &self,
        values: &Parameters,
        step: &DVector<f64>,
        share: f64,
    ) -> Parameters {
        let mut out = values.clone();
        for (p, d) in self.parameters.iter().zip(step.iter()) {
            p.set(&mut out, p.get(values) + share * d * p.scale);
        }
        out
    }

    /// Distance of a parameter from the start, in prior standard deviations, and its weight.
    pub(super) fn prior(&self, p: &Parameter, values: &Parameters) -> (f64, f64) {
        let weight = 1.0 / p.prior;
        (weight * (p.get(values) - p.get(self.start)) / p.scale, weight)
    }

    /// The loss at some values, priors included.
    pub fn loss(&self, values: &Parameters) -> f64 {
        self.loss_of(&self.residuals(values), values)
    }

    /// The same of residuals that are known.
    pub(super) fn loss_of(&self, found: &Blocks, values: &Parameters) -> f64 {
        let priors = self.parameters.iter().map(|p| self.prior(p, values).0);
        self.misfit_of(found) + priors.map(|z| 0.5 * z * z).sum::<f64>()
    }

    /// The residuals' part of the loss.
    pub(super) fn misfit_of(&self, found: &Blocks) -> f64 {
        let mut loss = 0.0;
        for range in self.ranges() {
            for (column, sigma) in found.iter().zip(self.sigma) {
                for r in column[range.clone()].iter().filter(|r| r.is_finite()) {
                    let z = (r / sigma).abs();
                    loss += if z <= HUBER { 0.5 * z * z } else { HUBER * (z - 0.5 * HUBER) };
                }
            }
        }
        loss
    }

    /// Blocks of the manoeuvres that count.
    fn ranges(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        self.samples
            .manoeuvres
            .iter()
            .enumerate()
            .filter(|(k, _)| self.only.is_none_or(|only| only[*k]))
            .map(|(_, (_, range))| range.start / BLOCK..range.end / BLOCK)
    }

    /// Residuals and derivatives, by differences.
    pub fn linear(&self, values: &Parameters) -> Linear {
        let workings = LinearisationCache::of(self.samples, values);
        let columns = self.columns(|p| workings.column(p, STEP));
        self.linear_of(workings.blocks, columns)
    }

    /// The same with derivatives of the residuals of block means, where these tell enough: a third of the work. They
    /// are within some per cent of [`linear`](Self::linear)'s, so that a fit near by ends at the same place; one that
    /// has far to go may end in another optimum.
    pub fn linear_of_means(&self, values: &Parameters) -> Linear {
        let means = self.samples.means();
        let whole = LinearisationCache::of(self.samples, values);
        let of_means = LinearisationCache::of(&means, values);
        let columns = self.columns(|p| match p.reach.within_blocks {
            true => whole.column(p, STEP),
            false => of_means.column(p, STEP),
        });
        self.linear_of(whole.blocks, columns)
    }

    fn columns(&self, of: impl Fn(&Parameter) -> Blocks + Sync) -> Vec<Arc<Blocks>> {
        self.parameters.par_iter().map(|p| Arc::new(of(p))).collect()
    }

    fn linear_of(&self, mut residuals: Blocks, columns: Vec<Arc<Blocks>>) -> Linear {
        self.add_extra(&mut residuals);
        Linear { residuals, columns, gram: OnceLock::new() }
    }

    /// A block residual in standard deviations and its weight; `None` where it does not count.
    pub fn weigh(&self, linear: &Linear, c: usize, b: usize) -> Option<(f64, f64)> {
        let z = linear.residuals[c][b] / self.sigma[c];
        if !z.is_finite() || z.abs() > FARTHEST {
            return None;
        }
        Some((z, if z.abs() <= HUBER { 1.0 } else { HUBER / z.abs() }))
    }

    /// Weights of the blocks that count, and weighted residuals in standard deviations; of others nil.
    pub fn weighed(&self, linear: &Linear) -> (Blocks, Blocks) {
        let nil = || -> Blocks { std::array::from_fn(|c| vec![0.0; linear.residuals[c].len()]) };
        let (mut weights, mut pulls) = (nil(), nil());
        for range in self.ranges() {
            for c in 0..CHANNELS.len() {
                for b in range.clone() {
                    let Some((z, weight)) = self.weigh(linear, c, b) else { continue };
                    weights[c][b] = weight;
                    pulls[c][b] = weight * z;
                }
            }
        }
        (weights, pulls)
    }

    /// Curvature and downhill direction of the weighted residuals, without the priors.
    pub fn accumulate(&self, linear: &Linear) -> (DMatrix<f64>, DVector<f64>) {
        let (weights, pulls) = self.weighed(linear);
        let (columns, p) = (&linear.columns, self.parameters.len());
        let gram = linear.gram.get_or_init(|| Arc::new(Gram::of(columns, &weights)));
        (gram.under(&weights, columns, &self.sigma, p), self.downhill(linear, &pulls))
    }

    fn downhill(&self, linear: &Linear, pulls: &Blocks) -> DVector<f64> {
        DVector::from_fn(self.parameters.len(), |i, _| {
            let in_channel = |(c, pull): (usize, &Vec<f64>)| {
                let column = DVectorView::from_slice(&linear.columns[i][c], pull.len());
                column.dot(&DVectorView::from_slice(pull, pull.len())) / self.sigma[c]
            };
            -pulls.iter().enumerate().map(in_channel).sum::<f64>()
        })
    }

    /// Downhill pull and curvature of some blocks along a combination of columns.
    pub fn along(
        &self,
        linear: &Linear,
        range: std::ops::Range<usize>,
        columns: &[usize],
        weights: &[f64],
    ) -> (f64, f64) {
        let (mut pull, mut curvature) = (0.0, 0.0);
        let mut row = vec![0.0; range.len()];
        for c in 0..CHANNELS.len() {
            row.fill(0.0);
            for (&k, weight) in columns.iter().zip(weights) {
                let column = &linear.columns[k][c][range.clone()];
                row.iter_mut().zip(column).for_each(|(r, x)| *r += weight * x);
            }
            for (r, b) in row.iter().zip(range.clone()) {
                let Some((z, weight)) = self.weigh(linear, c, b) else { continue };
                let r = r / self.sigma[c];
                pull -= weight * r * z;
                curvature += weight * r * r;
            }
        }
        (pull, curvature)
    }

    /// Share of what a column shows that is in one channel.
    pub fn share(&self, column: &Blocks, channel: usize) -> f64 {
        let shown = |c: usize| {
            let sizes = column[c].iter().map(|x| x / self.sigma[c]).filter(|x| x.is_finite());
            sizes.map(|x| x * x).sum::<f64>()
        };
        let all: f64 = (0..CHANNELS.len()).map(shown).sum();
        shown(channel) / all.max(f64::MIN_POSITIVE)
    }

    /// Curvature and downhill direction of a linearisation with the priors, parameters in their scales;
    /// without the curvature where it is not asked for.
    pub(super) fn normal_of(
        &self,
        linear: &Linear,
        values: &Parameters,
        curved: bool,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let p = self.parameters.len();
        let (mut matrix, mut gradient) = match curved {
            true => self.accumulate(linear),
            false => (DMatrix::zeros(p, p), self.downhill(linear, &self.weighed(linear).1)),
        };
        for (i, parameter) in self.parameters.iter().enumerate() {
            let (z, weight) = self.prior(parameter, values);
            gradient[i] -= weight * z;
            matrix[(i, i)] += weight * weight;
        }
        (matrix, gradient)
    }
}
