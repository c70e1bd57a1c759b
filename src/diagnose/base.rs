//! The base fit: robust Gauss-Newton on block means whose noise is that of correlated samples
//! (`diagnosis.md`, section 2.2).
//!
//! The loss is Huber's at 2.5 standard deviations of a channel's block residual, plus weak Gaussian
//! priors about the start. The standard deviation is the *long-run* one (Newey and West 1987): block
//! means within a manoeuvre are correlated over seconds, and what counts is what they average to.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::attitude;
use super::effects::Effect;
use super::residuals::{Blocks, CHANNELS, Curves, attitudes, blocks, blocks_at};
use super::samples::{BLOCK, Samples};
use super::world::{BASE, Parameter, World};

/// Standard deviations at which the loss turns from square to straight.
const HUBER: f64 = 2.5;
/// What is farther off is no noise at all.
const FARTHEST: f64 = 60.0;
/// Lags of the long-run variance, blocks: 3 s.
const LAGS: usize = 10;
/// Share of a scale for differences.
const STEP: f64 = 0.003;
/// Distance of a base parameter from what is believed, in prior standard deviations, that is too far.
const STRAINED: f64 = 2.5;
/// Steps along the same slopes.
const FOLLOWED: usize = 4;
/// Size of a step that ends a fit, in scales: effects' are their usual sizes.
const ARRIVED: f64 = 5e-3;
/// Gain of a candidate that explains such a strain.
pub const LARGE: f64 = 30.0;
/// Fall of the loss that tells that the optimum was a local one.
const LOCAL: f64 = 8.0;

/// A fitted base model.
#[derive(Debug, Clone)]
pub struct Base {
    /// The world.
    pub world: World,
    /// Where it started, the centre of the priors.
    pub start: World,
    /// Long-run standard deviation of each channel's block residual.
    pub sigma: [f64; 8],
    /// Loss at the end.
    pub loss: f64,
    /// What was free: [`BASE`], and the effects that were taken in.
    pub parameters: Vec<Parameter>,
}

/// Where extensions of a base are looked for.
#[derive(Debug, Clone)]
pub struct Start {
    /// The best that the base can do.
    pub base: Base,
    /// The place from which they are looked for; its loss is the base's, gains count from there.
    pub near: Base,
    /// What leaves noise only.
    pub noise: Base,
    /// What each candidate gains when the base is fitted with it; nothing where the base is believable.
    pub gains: Vec<f64>,
}

/// Fits the base from a start.
pub fn fit(samples: &Samples, start: &World) -> Base {
    fit_with(samples, &start.believed(), start, BASE, None)
}

/// Fits `parameters` from `from`, with priors about `start`; `extra` is added to the residuals.
pub fn fit_with(
    samples: &Samples,
    start: &World,
    from: &World,
    parameters: &[Parameter],
    extra: Option<&Blocks>,
) -> Base {
    let mut world = from.clone();
    let mut problem = Problem { samples, start, sigma: [1.0; 8], parameters, extra, only: None };
    for round in 0..8 {
        // the scale follows the first rounds, then it is the same for everybody
        if round < 4 {
            problem.sigma = noise(samples, &problem.residuals(&world));
        }
        let Some((moved, size)) = problem.advance(&world) else { break };
        world = moved;
        if round >= 4 && size < 1e-3 {
            break;
        }
    }
    let loss = problem.loss(&world);
    let parameters = parameters.to_vec();
    Base { start: start.clone(), sigma: problem.sigma, loss, parameters, world }
}

/// A fit from a world that is nearly right already, along one linearisation: what a null needs.
#[derive(Debug, Clone)]
pub struct Quick {
    /// The fitted base.
    pub base: Base,
    /// The linearisation, of the base's parameters and then of `more`, residuals at the end.
    pub linear: Linear,
}

/// Fits `fitted` from a model whose own ride it is, or one near by; `more` is linearised along with it,
/// `disturb` may add to what is added to the residuals.
pub fn fit_quick(
    samples: &Samples,
    model: &Base,
    fitted: &[Parameter],
    more: &[Parameter],
    mut extra: Blocks,
    disturb: impl FnOnce(&Linear, &mut Blocks),
) -> Quick {
    let (prior, start) = (&model.start, &model.world);
    let all: Vec<Parameter> = fitted.iter().chain(more).copied().collect();
    let mut problem = Problem {
        samples,
        start: prior,
        sigma: [1.0; 8],
        parameters: &all,
        extra: None,
        only: None,
    };
    let mut linear = problem.linear(start);
    disturb(&linear, &mut extra);
    problem.extra = Some(&extra);
    problem.add_extra(&mut linear.residuals);
    problem.parameters = fitted;
    let mut world = start.clone();
    let mut factor = None;
    for round in 0..5 {
        // the scale follows the first rounds, as in the fit of a real ride
        if round < 3 {
            problem.sigma = noise(samples, &linear.residuals);
            factor = None;
        }
        let (matrix, gradient) = problem.normal_of(&linear, &world, factor.is_none());
        let solver = match factor.take().or_else(|| matrix.cholesky()) {
            Some(solver) => solver,
            None => break,
        };
        let step = solver.solve(&gradient);
        factor = Some(solver);
        world = problem.moved(&world, &step, 1.0);
        // what the scale is learnt from need not be exact
        if round < 2 {
            linear.follow(&step);
            continue;
        }
        linear.residuals = problem.residuals(&world);
        if step.amax() < 1e-3 && round >= 3 {
            break;
        }
    }
    let base = Base {
        loss: problem.loss(&world),
        start: prior.clone(),
        sigma: problem.sigma,
        parameters: fitted.to_vec(),
        world,
    };
    Quick { base, linear }
}

impl Base {
    /// The loss whose optimum it is.
    pub fn problem<'a>(&'a self, samples: &'a Samples) -> Problem<'a> {
        Problem {
            samples,
            start: &self.start,
            sigma: self.sigma,
            parameters: &self.parameters,
            extra: None,
            only: None,
        }
    }

    /// The base with more free parameters, its noise and priors kept; slopes are made at most `times`.
    pub fn extended(&self, samples: &Samples, more: &[Parameter], times: usize) -> Base {
        let parameters: Vec<Parameter> = self.parameters.iter().chain(more).copied().collect();
        let problem = Problem {
            samples,
            start: &self.start,
            sigma: self.sigma,
            parameters: &parameters,
            extra: None,
            only: None,
        };
        let world = problem.optimum(&self.world, times);
        let loss = problem.loss(&world);
        Base { world, loss, start: self.start.clone(), sigma: self.sigma, parameters }
    }

    /// The model with the noise that it leaves, fitted with that again.
    #[must_use]
    pub fn settled(&self, samples: &Samples) -> Base {
        let mut problem = self.problem(samples);
        let mut world = self.world.clone();
        let mut linear = problem.linear(&world);
        for _ in 0..4 {
            problem.sigma = noise(samples, &linear.residuals);
            let Some((moved, _)) = problem.follow(&mut linear, &world) else { break };
            world = moved;
        }
        let world = problem.optimum(&world, 4);
        let loss = problem.loss(&world);
        Base { world, loss, sigma: problem.sigma, ..self.clone() }
    }

    /// The base as a start for its extensions.
    ///
    /// A large effect drags the base to where no motorcycle is, and what is linear about that place is
    /// not about the truth. Where a parameter is that strained, extensions are looked for from where
    /// the candidate that gains most leaves the base, and noise is what that candidate leaves. Where
    /// the base alone is better off from there it was in a local optimum (`diagnosis.md`, section
    /// 2.5.5).
    #[must_use]
    pub fn believable(self, samples: &Samples, effects: &[Effect]) -> Start {
        let as_it_is =
            |base: Base| Start { near: base.clone(), noise: base.clone(), base, gains: Vec::new() };
        let problem = self.problem(samples);
        let strain = |p: &Parameter| problem.prior(p, &self.world).0.abs();
        if self.parameters.iter().map(strain).fold(0.0, f64::max) < STRAINED {
            return as_it_is(self);
        }
        let refits: Vec<(&Effect, f64, Base)> = effects
            .par_iter()
            .map(|effect| (effect, self.extended(samples, &[effect.parameter()], 8)))
            .map(|(effect, refit)| (effect, 2.0 * (self.loss - refit.loss), refit))
            .collect();
        let gains: Vec<f64> = refits.iter().map(|(_, gain, _)| *gain).collect();
        let best = refits
            .into_iter()
            .filter(|(effect, _, refit)| effect.possible(effect.parameter().get(&refit.world)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((effect, _, refit)) = best.filter(|(_, gain, _)| *gain > LARGE) else {
            return as_it_is(self);
        };
        let p = effect.parameter();
        let mut world = refit.world.clone();
        p.set(&mut world, p.get(&self.start));
        let sigma = noise(samples, &problem.residuals(&refit.world));
        let from = |world: &World| {
            let base = Base { world: world.clone(), sigma, ..self.clone() };
            Base { loss: base.problem(samples).loss(world), ..base }.extended(samples, &[], 8)
        };
        let [stayed, moved] = [&self.world, &world].map(from);
        let base = if stayed.loss - moved.loss > LOCAL { moved } else { stayed };
        let near = Base { world, ..base.clone() };
        let noise = Base { world: refit.world, ..base.clone() };
        Start { base, near, noise, gains }
    }

    /// Loss on each fold of manoeuvres of a model that was fitted without it.
    pub fn held_out(&self, samples: &Samples, folds: usize) -> f64 {
        let mut seen = std::collections::BTreeMap::new();
        // manoeuvres of each kind in turn
        let fold: Vec<usize> = samples
            .manoeuvres
            .iter()
            .map(|(kind, _)| {
                let count: &mut usize = seen.entry(*kind).or_default();
                *count += 1;
                (*count - 1) % folds
            })
            .collect();
        // a fold less moves the optimum little: one linearisation serves them all
        let linear = self.problem(samples).linear(&self.world);
        (0..folds)
            .into_par_iter()
            .map(|out| {
                let kept: Vec<bool> = fold.iter().map(|f| *f != out).collect();
                let left: Vec<bool> = kept.iter().map(|k| !k).collect();
                let problem = |only| Problem {
                    samples,
                    start: &self.start,
                    sigma: self.sigma,
                    parameters: &self.parameters,
                    extra: None,
                    only: Some(only),
                };
                let (mut world, mut linear) = (self.world.clone(), linear.clone());
                for _ in 0..3 {
                    let problem = problem(kept.as_slice());
                    let Some((moved, _)) = problem.follow(&mut linear, &world) else { break };
                    world = moved;
                }
                problem(left.as_slice()).misfit_of(&linear.residuals)
            })
            .sum()
    }
}

/// A loss over some parameters.
#[derive(Debug, Clone, Copy)]
pub struct Problem<'a> {
    /// What was measured.
    pub samples: &'a Samples,
    /// Centre of the priors.
    pub start: &'a World,
    /// Standard deviations of the channels.
    pub sigma: [f64; 8],
    /// What is free.
    pub parameters: &'a [Parameter],
    /// Added to the residuals: noise of a simulated null.
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
    pub columns: Arc<[Blocks]>,
}

impl Linear {
    /// Takes the residuals along a step of the first parameters, to first order.
    fn follow(&mut self, step: &DVector<f64>) {
        for (column, d) in self.columns.iter().zip(step.iter()) {
            for (to, by) in self.residuals.iter_mut().zip(column) {
                to.iter_mut().zip(by).for_each(|(r, j)| *r += d * j);
            }
        }
    }
}

impl Problem<'_> {
    /// Block residuals in a world.
    pub fn residuals(&self, world: &World) -> Blocks {
        let mut out = blocks(self.samples, world);
        self.add_extra(&mut out);
        out
    }

    fn add_extra(&self, out: &mut Blocks) {
        for (column, extra) in out.iter_mut().zip(self.extra.into_iter().flatten()) {
            column.iter_mut().zip(extra).for_each(|(r, e)| *r += e);
        }
    }

    /// One Gauss-Newton step with halving, and its size in scales; `None` when it leads nowhere.
    pub fn advance(&self, world: &World) -> Option<(World, f64)> {
        self.follow(&mut self.linear(world), world)
    }

    /// The same along slopes that may have been made near by; residuals are those of the world, and
    /// then of where it leads to.
    fn follow(&self, linear: &mut Linear, world: &World) -> Option<(World, f64)> {
        let (matrix, gradient) = self.normal_of(linear, world, true);
        let step = matrix.cholesky()?.solve(&gradient);
        let before = self.loss_of(&linear.residuals, world);
        let mut share = 1.0;
        while share > 1e-3 {
            let tried = self.moved(world, &step, share);
            let residuals = self.residuals(&tried);
            if self.loss_of(&residuals, &tried) <= before {
                linear.residuals = residuals;
                return Some((tried, share * step.amax()));
            }
            share *= 0.5;
        }
        None
    }

    /// The optimum near a world: slopes are made anew at most `times`, and between that followed as
    /// long as they lead on.
    fn optimum(&self, from: &World, times: usize) -> World {
        let mut world = from.clone();
        for _ in 0..times {
            let mut linear = self.linear(&world);
            let (mut first, mut last) = (0.0_f64, f64::INFINITY);
            for _ in 0..FOLLOWED {
                let Some((moved, size)) = self.follow(&mut linear, &world) else { break };
                world = moved;
                first = first.max(size);
                if size < ARRIVED || size > 0.5 * last {
                    break;
                }
                last = size;
            }
            if first < ARRIVED {
                break;
            }
        }
        world
    }

    /// Takes a linearisation's residuals to the optimum of this problem's parameters, the first of its
    /// columns, to first order.
    pub fn relax(&self, linear: &mut Linear, world: &World) {
        let (matrix, gradient) = self.normal_of(linear, world, true);
        let Some(factor) = matrix.cholesky() else { return };
        let step = factor.solve(&gradient);
        linear.follow(&step);
    }

    fn moved(&self, world: &World, step: &DVector<f64>, share: f64) -> World {
        let mut out = world.clone();
        for (p, d) in self.parameters.iter().zip(step.iter()) {
            p.set(&mut out, p.get(world) + share * d * p.scale);
        }
        out
    }

    /// Distance of a parameter from the start, in prior standard deviations, and its weight.
    fn prior(&self, p: &Parameter, world: &World) -> (f64, f64) {
        let weight = 1.0 / p.prior;
        (weight * (p.get(world) - p.get(self.start)) / p.scale, weight)
    }

    /// The loss of a world, priors included.
    pub fn loss(&self, world: &World) -> f64 {
        self.loss_of(&self.residuals(world), world)
    }

    /// The same of residuals that are known.
    fn loss_of(&self, found: &Blocks, world: &World) -> f64 {
        let priors = self.parameters.iter().map(|p| self.prior(p, world).0);
        self.misfit_of(found) + priors.map(|z| 0.5 * z * z).sum::<f64>()
    }

    /// The residuals' part of the loss.
    fn misfit_of(&self, found: &Blocks) -> f64 {
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
    pub fn linear(&self, world: &World) -> Linear {
        let known = attitudes(self.samples, world);
        let mut curves = Curves::Keep(vec![[[f64::NAN; 3]; 2]; self.samples.len()]);
        let here = blocks_at(self.samples, world, Some(&known), &mut curves);
        let points = match curves {
            Curves::Keep(points) => points,
            _ => Vec::new(),
        };
        let lies = attitude::key(world);
        let columns = self
            .parameters
            .par_iter()
            .map(|parameter| {
                let mut near = world.clone();
                parameter.set(&mut near, parameter.get(world) + STEP * parameter.scale);
                let same = attitude::key(&near) == lies;
                let attitudes = same.then_some(known.as_slice());
                let mut curves = match near.friction == world.friction {
                    true => Curves::Known(&points),
                    false => Curves::Unknown,
                };
                let mut column = blocks_at(self.samples, &near, attitudes, &mut curves);
                for (there, here) in column.iter_mut().zip(&here) {
                    there.iter_mut().zip(here).for_each(|(t, h)| *t = (*t - h) / STEP);
                }
                column
            })
            .collect();
        let mut residuals = here;
        self.add_extra(&mut residuals);
        Linear { residuals, columns }
    }

    /// A block residual in standard deviations and its weight; `None` where it does not count.
    pub fn weigh(&self, linear: &Linear, c: usize, b: usize) -> Option<(f64, f64)> {
        let z = linear.residuals[c][b] / self.sigma[c];
        if !z.is_finite() || z.abs() > FARTHEST {
            return None;
        }
        Some((z, if z.abs() <= HUBER { 1.0 } else { HUBER / z.abs() }))
    }

    /// Adds the weighted rows of some blocks to a curvature's upper half and a downhill direction.
    pub fn accumulate(
        &self,
        linear: &Linear,
        range: std::ops::Range<usize>,
        matrix: &mut DMatrix<f64>,
        gradient: &mut DVector<f64>,
    ) {
        let p = self.parameters.len();
        let mut row = vec![0.0; p];
        // most parameters enter few channels
        let mut inside: Vec<usize> = Vec::with_capacity(p);
        for c in 0..CHANNELS.len() {
            let sigma = self.sigma[c];
            inside.clear();
            inside.extend((0..p).filter(|&i| {
                linear.columns[i][c][range.clone()].iter().any(|x| *x != 0.0 && x.is_finite())
            }));
            for b in range.clone() {
                let Some((z, weight)) = self.weigh(linear, c, b) else { continue };
                for &i in &inside {
                    row[i] = linear.columns[i][c][b] / sigma;
                }
                for (k, &i) in inside.iter().enumerate() {
                    let own = weight * row[i];
                    gradient[i] -= own * z;
                    // columns lie together
                    let column = &mut matrix.as_mut_slice()[i * p..(i + 1) * p];
                    for &j in &inside[..=k] {
                        column[j] += own * row[j];
                    }
                }
            }
        }
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

    /// Adds the weighted rows of some blocks to a downhill direction.
    fn pull(&self, linear: &Linear, range: std::ops::Range<usize>, gradient: &mut DVector<f64>) {
        for c in 0..CHANNELS.len() {
            let sigma = self.sigma[c];
            for b in range.clone() {
                let Some((z, weight)) = self.weigh(linear, c, b) else { continue };
                for (slope, column) in gradient.iter_mut().zip(linear.columns.iter()) {
                    *slope -= weight * column[c][b] / sigma * z;
                }
            }
        }
    }

    /// Curvature and downhill direction of a linearisation with the priors, parameters in their scales;
    /// without the curvature where it is not asked for.
    fn normal_of(
        &self,
        linear: &Linear,
        world: &World,
        curved: bool,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let p = self.parameters.len();
        let mut matrix = DMatrix::zeros(p, p);
        let mut gradient = DVector::zeros(p);
        for range in self.ranges() {
            if curved {
                self.accumulate(linear, range, &mut matrix, &mut gradient);
            } else {
                self.pull(linear, range, &mut gradient);
            }
        }
        for (i, parameter) in self.parameters.iter().enumerate() {
            let (z, weight) = self.prior(parameter, world);
            gradient[i] -= weight * z;
            matrix[(i, i)] += weight * weight;
        }
        matrix.fill_lower_triangle_with_upper_triangle();
        (matrix, gradient)
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
