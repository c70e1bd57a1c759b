//! Fits of candidates to block residuals, robust (Huber), with intervals.

use nalgebra::{DMatrix, DVector};

use super::curve::Curve;
use super::residuals::{Block, CHANNELS};
use crate::diagnose::held_out::{FOLDS, sum_over_folds};
use crate::statistics::order::{SD_PER_MAD, median_or_zero};

/// Residuals beyond this many standard deviations count linearly.
const HUBER: f64 = 2.5;
/// Neighbours over which the blocks' scatter is added up: a second.
const LAGS: usize = 10;
/// Largest size of a block in that sum, in robust standard deviations.
const CLIP: f64 = 4.0;
/// Rounds of the joint fit over the candidates with nodes.
const ROUNDS: usize = 12;
/// Most steps of the linear numbers: to the end, and within a search.
const LONG: usize = 30;
const SHORT: usize = 1;
/// Every how many nodes a search looks first, and its halvings after.
const STRIDE: usize = 3;
const GOLDEN: usize = 8;
/// How far a search near a number goes, in its logarithm.
const SEARCH_HALF_WIDTH: f64 = 0.4;
/// Farthest that the bike may be off its file, in standard deviations.
const FARTHEST: f64 = 3.0;
/// Model error of a frequency, as a share of it: a body is not quite a low-pass.
const BODY: f64 = 0.04;
/// The same of a force that changes its sign: what is smoothed is a little less. Simulated rides with 60
/// and 120 N of friction came out at 88 to 100 % of it.
const FRICTION: f64 = 0.08;

/// One candidate with its number; `None` is the base.
pub(crate) type Value = Option<f64>;

/// Residuals, candidates and priors of a fit.
#[derive(Debug, Clone)]
pub(crate) struct Problem {
    /// Where the blocks belong.
    pub blocks: Vec<Block>,
    pub curves: Vec<Curve>,
    /// Errors of the bike file, one standard deviation each: fitted along with everything,
    /// each held to zero by its own uncertainty.
    pub uncertain: Vec<Vec<f64>>,
    /// One over the standard deviation of every block's channel.
    pub weight: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Size of each candidate.
    pub values: Vec<Value>,
    /// Distance of the bike from its file in standard deviations, per uncertain key.
    pub bike: Vec<f64>,
    /// Half the sum of squares, robust, the bike's own included.
    pub loss: f64,
    /// Residuals that are left.
    pub residual: Vec<f64>,
}

/// Where the number of a candidate with nodes is looked for.
#[derive(Debug, Clone, Copy)]
struct Search<'a> {
    /// Place of the candidate.
    j: usize,
    /// Residuals with all other candidates.
    others: &'a [f64],
    /// The number near which to look; `None` looks over all nodes.
    near: Value,
    /// Loss of the fit to be improved.
    loss: f64,
}

/// The columns that are fitted linearly, block by block: the bike's and those of some candidates.
#[derive(Debug, Clone)]
pub(crate) struct Linear {
    /// Candidates among them, after the bike's.
    pub lines: Vec<usize>,
    width: usize,
    /// In standard deviations of the block.
    rows: Vec<f64>,
    /// Inverse of the curvature were no block an outlier: a step with it never overshoots.
    inverse: DMatrix<f64>,
}

fn rho(z: f64) -> f64 {
    let z = z.abs();
    if z <= HUBER { 0.5 * z * z } else { HUBER * (z - 0.5 * HUBER) }
}

fn trust(z: f64) -> f64 {
    (HUBER / z.abs().max(HUBER)).min(1.0)
}

type Used<'a> = &'a (dyn Fn(usize) -> bool + Sync);

impl Problem {
    /// Takes candidates that are lines, forces of the suspension, to show where a wheel is off the ground
    /// only.
    pub(crate) fn off_the_ground(&mut self) {
        for curve in &mut self.curves {
            if let Curve::Line(column) = curve {
                for (c, block) in column.iter_mut().zip(&self.blocks) {
                    if !CHANNELS[block.channel].off_the_ground() {
                        *c = 0.0;
                    }
                }
            }
        }
    }

    /// The linear columns for some candidates; those that are no lines are left out.
    pub(crate) fn linear(&self, included: &[usize]) -> Linear {
        let lines: Vec<usize> = included
            .iter()
            .copied()
            .filter(|&j| matches!(self.curves[j], Curve::Line(_)))
            .collect();
        let columns: Vec<&[f64]> = self
            .uncertain
            .iter()
            .map(Vec::as_slice)
            .chain(lines.iter().filter_map(|&j| match &self.curves[j] {
                Curve::Line(column) => Some(column.as_slice()),
                Curve::Nodes { .. } => None,
            }))
            .collect();
        let width = columns.len();
        let mut rows = Vec::with_capacity(width * self.blocks.len());
        let mut h = DMatrix::<f64>::zeros(width, width);
        for (i, w) in self.weight.iter().enumerate() {
            let at = rows.len();
            rows.extend(columns.iter().map(|c| w * c[i]));
            let row = &rows[at..];
            for a in 0..width {
                for b in 0..=a {
                    h[(a, b)] += row[a] * row[b];
                }
            }
        }
        for a in 0..width {
            // a candidate that changes nothing stays where it is
            h[(a, a)] += if a < self.uncertain.len() { 1.0 } else { 1e-9 };
            for b in 0..a {
                h[(b, a)] = h[(a, b)];
            }
        }
        let inverse = h.try_inverse().unwrap_or_else(|| DMatrix::zeros(width, width));
        Linear { lines, width, rows, inverse }
    }

    /// Loss at linear numbers and its gradient there.
    fn slope(
        &self,
        r: &[f64],
        linear: &Linear,
        x: &[f64],
        used: Used<'_>,
        gradient: &mut DVector<f64>,
    ) -> f64 {
        let own = self.uncertain.len();
        let mut loss = 0.5 * x[..own].iter().map(|x| x * x).sum::<f64>();
        gradient.fill(0.0);
        gradient.iter_mut().zip(&x[..own]).for_each(|(g, x)| *g = *x);
        let g = gradient.as_mut_slice();
        for (i, row) in linear.rows.chunks_exact(linear.width.max(1)).enumerate() {
            if !used(self.blocks[i].cluster) {
                continue;
            }
            let mut z = self.weight[i] * r[i];
            for (c, x) in row.iter().zip(x) {
                z += c * x;
            }
            loss += rho(z);
            let d = trust(z) * z;
            for (g, c) in g.iter_mut().zip(row) {
                *g += d * c;
            }
        }
        loss
    }

    /// Moves the linear numbers [`SHORT`] safe steps and returns the loss there.
    fn few_steps(&self, r: &[f64], linear: &Linear, x: &mut [f64], used: Used<'_>) -> f64 {
        let own = self.uncertain.len();
        let mut gradient = DVector::<f64>::zeros(linear.width);
        for _ in 0..SHORT {
            self.slope(r, linear, x, used, &mut gradient);
            let by = &linear.inverse * &gradient;
            x.iter_mut().zip(by.iter()).for_each(|(x, by)| *x -= by);
            x[..own].iter_mut().for_each(|x| *x = x.clamp(-FARTHEST, FARTHEST));
        }
        self.slope(r, linear, x, used, &mut gradient)
    }

    /// Moves the linear numbers to their best and returns the loss there.
    fn converge(&self, r: &[f64], linear: &Linear, x: &mut [f64], used: Used<'_>) -> f64 {
        let own = self.uncertain.len();
        let mut gradient = DVector::<f64>::zeros(linear.width);
        let mut loss = self.slope(r, linear, x, used, &mut gradient);
        let Some(curvature) = self.curvature(r, linear, x, used).cholesky() else { return loss };
        // the curvature hardly changes on the way; where it does, the safe one goes on
        let mut safe = false;
        for _ in 0..LONG {
            let by = if safe { &linear.inverse * &gradient } else { curvature.solve(&gradient) };
            let mut next: Vec<f64> = x.iter().zip(by.iter()).map(|(x, by)| x - by).collect();
            next[..own].iter_mut().for_each(|x| *x = x.clamp(-FARTHEST, FARTHEST));
            let mut there = DVector::<f64>::zeros(linear.width);
            let reached = self.slope(r, linear, &next, used, &mut there);
            let won = loss - reached;
            if won > 0.0 {
                x.copy_from_slice(&next);
                (loss, gradient) = (reached, there);
            }
            if won < 0.005 {
                if safe {
                    break;
                }
                safe = true;
            }
        }
        loss
    }

    /// Second derivative of the loss with respect to the linear numbers, outliers left out.
    fn curvature(&self, r: &[f64], linear: &Linear, x: &[f64], used: Used<'_>) -> DMatrix<f64> {
        let width = linear.width;
        let mut h = vec![0.0; width * width];
        for (i, row) in linear.rows.chunks_exact(width.max(1)).enumerate() {
            if !used(self.blocks[i].cluster) {
                continue;
            }
            let mut z = self.weight[i] * r[i];
            for (c, x) in row.iter().zip(x) {
                z += c * x;
            }
            let t = trust(z);
            for (a, line) in h.chunks_exact_mut(width).enumerate() {
                let d = t * row[a];
                for (h, c) in line[..=a].iter_mut().zip(row) {
                    *h += d * c;
                }
            }
        }
        let own = self.uncertain.len();
        DMatrix::from_fn(width, width, |a, b| {
            let prior = if a != b {
                0.0
            } else if a < own {
                1.0
            } else {
                1e-9
            };
            h[a.max(b) * width + a.min(b)] + prior
        })
    }

    /// Fits the included candidates and the bike together, from scratch or from another fit.
    pub(crate) fn fit(&self, bare: &[f64], included: &[usize], start: Option<&Fit>) -> Fit {
        self.fit_with(bare, included, &self.linear(included), start, &|_| true)
    }

    /// As [`fit`](Self::fit), with the linear columns made before and on some clusters only.
    pub(crate) fn fit_with(
        &self,
        bare: &[f64],
        included: &[usize],
        linear: &Linear,
        start: Option<&Fit>,
        used: Used<'_>,
    ) -> Fit {
        let nodes: Vec<usize> =
            included.iter().copied().filter(|&j| self.curves[j].logarithmic()).collect();
        let mut values: Vec<Value> = vec![None; self.curves.len()];
        let mut x = vec![0.0; linear.width];
        if let Some(start) = start {
            nodes.iter().for_each(|&j| values[j] = start.values[j]);
            x[..self.uncertain.len()].copy_from_slice(&start.bike);
            for (x, &j) in x[self.uncertain.len()..].iter_mut().zip(&linear.lines) {
                *x = start.values[j].unwrap_or(0.0);
            }
        }
        let others = |values: &[Value], but: Option<usize>| {
            let mut r = bare.to_vec();
            for &k in nodes.iter().filter(|&&k| Some(k) != but) {
                if let Some(value) = values[k] {
                    self.curves[k].add(value, &mut r);
                }
            }
            r
        };
        let mut loss = self.converge(&others(&values, None), linear, &mut x, used);
        for round in 0..ROUNDS {
            let before = loss;
            for &j in &nodes {
                // one that started at the base may leave it in the first round
                let near = values[j];
                if near.is_none() && round > 0 {
                    continue;
                }
                let r = others(&values, Some(j));
                let from = Search { j, others: &r, near, loss };
                if let Some((value, reached)) = self.search(&from, linear, &mut x, used) {
                    (values[j], loss) = (Some(value), reached);
                }
            }
            if before - loss < 0.05 || nodes.len() + linear.width < 2 {
                break;
            }
        }
        let mut residual = others(&values, None);
        for ((r, w), row) in
            residual.iter_mut().zip(&self.weight).zip(linear.rows.chunks_exact(linear.width.max(1)))
        {
            *r += row.iter().zip(&x).map(|(c, x)| c * x).sum::<f64>() / w;
        }
        let own = self.uncertain.len();
        for (&j, x) in linear.lines.iter().zip(&x[own..]) {
            values[j] = Some(*x);
        }
        x.truncate(own);
        Fit { values, bike: x, loss, residual }
    }

    /// A better number of a candidate with nodes than one with this loss, and its loss: over all of
    /// them, or near one.
    fn search(
        &self,
        from: &Search<'_>,
        linear: &Linear,
        x: &mut [f64],
        used: Used<'_>,
    ) -> Option<(f64, f64)> {
        let Search { j, others, near, loss } = *from;
        let Curve::Nodes { at: nodes, .. } = &self.curves[j] else { return None };
        let mut trial = vec![0.0; others.len()];
        let mut start = x.to_vec();
        let mut at = |log: f64| {
            trial.copy_from_slice(others);
            self.curves[j].add(log.exp(), &mut trial);
            self.few_steps(&trial, linear, &mut start, used)
        };
        let last = nodes.len() - 1;
        let (low, high) = match near {
            Some(value) => (value.ln() - SEARCH_HALF_WIDTH, value.ln() + SEARCH_HALF_WIDTH),
            None => {
                let tried: Vec<(f64, f64)> =
                    nodes.iter().step_by(STRIDE).map(|n| (*n, at(*n))).collect();
                let best =
                    tried.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(nodes[0], |t| t.0);
                let by = STRIDE as f64 * (nodes[1] - nodes[0]);
                (best - by, best + by)
            }
        };
        let (mut low, mut high) = (low.max(nodes[0]), high.min(nodes[last]));
        // golden section
        let share = 0.381_966;
        let (mut a, mut b) = (low + share * (high - low), high - share * (high - low));
        let (mut at_a, mut at_b) = (at(a), at(b));
        for _ in 0..GOLDEN {
            if at_a < at_b {
                (high, b, at_b) = (b, a, at_a);
                a = low + share * (high - low);
                at_a = at(a);
            } else {
                (low, a, at_a) = (a, b, at_b);
                b = high - share * (high - low);
                at_b = at(b);
            }
        }
        let value = if at_a < at_b { a.exp() } else { b.exp() };
        let mut r = others.to_vec();
        self.curves[j].add(value, &mut r);
        let found = self.converge(&r, linear, &mut start, used);
        (found < loss).then(|| {
            x.copy_from_slice(&start);
            (value, found)
        })
    }

    /// Twice the loss on clusters left out, of candidates and bike fitted to the others, over [`FOLDS`]
    /// fits. `whole` is the fit to all of them.
    pub(crate) fn held_out(&self, bare: &[f64], included: &[usize], whole: &Fit) -> f64 {
        let linear = self.linear(included);
        sum_over_folds(|fold| {
            // a lap may have as many events as there are folds
            let left_out = |c: usize| (c + c / FOLDS) % FOLDS == fold;
            let fit = self.fit_with(bare, included, &linear, Some(whole), &|c| !left_out(c));
            let mut sum = 0.0;
            for ((r, w), b) in fit.residual.iter().zip(&self.weight).zip(&self.blocks) {
                if left_out(b.cluster) {
                    sum += 2.0 * rho(r * w);
                }
            }
            sum
        })
    }

    /// Standard deviations of the included candidates' numbers (of their logarithms for nodes): from the
    /// clusters' own scatter and from what the bike file is uncertain by.
    pub(crate) fn std_errors(&self, fit: &Fit, included: &[usize]) -> Vec<f64> {
        let slopes: Vec<Vec<f64>> = included
            .iter()
            .map(|&j| match fit.values[j] {
                Some(value) => self.curves[j].slope(value),
                None => vec![0.0; fit.residual.len()],
            })
            .collect();
        let columns: Vec<&[f64]> = slopes
            .iter()
            .map(Vec::as_slice)
            .chain(self.uncertain.iter().map(Vec::as_slice))
            .collect();
        let (p, width) = (included.len(), columns.len());
        let clusters = self.blocks.iter().map(|b| b.cluster + 1).max().unwrap_or(1);
        let mut h = DMatrix::<f64>::zeros(width, width);
        let mut scores = vec![DVector::<f64>::zeros(width); clusters];
        for (i, block) in self.blocks.iter().enumerate() {
            let w = self.weight[i];
            let t = trust(fit.residual[i] * w) * w * w;
            for a in 0..width {
                let d = t * columns[a][i];
                scores[block.cluster][a] += d * fit.residual[i];
                for b in 0..width {
                    h[(a, b)] += d * columns[b][i];
                }
            }
        }
        let mut middle = DMatrix::<f64>::zeros(width, width);
        let few = clusters as f64 / (clusters as f64 - 1.0).max(1.0);
        for score in &scores {
            middle += few * score * score.transpose();
        }
        for a in p..width {
            h[(a, a)] += 1.0;
            middle[(a, a)] += 1.0;
        }
        let Some(inverse) = h.try_inverse() else { return vec![f64::INFINITY; p] };
        let v = &inverse * middle * &inverse;
        included
            .iter()
            .enumerate()
            .map(|(a, &j)| {
                let model = match fit.values[j] {
                    Some(_) if self.curves[j].logarithmic() => BODY,
                    Some(value) => FRICTION * value.abs(),
                    None => 0.0,
                };
                v[(a, a)].max(0.0).sqrt().hypot(model)
            })
            .collect()
    }
}

/// Long-run standard deviation of every channel's blocks: what their mean scatters by, times the root
/// of their number. One for a channel without blocks.
pub(crate) fn long_run(blocks: &[Block], r: &[f64]) -> [f64; 7] {
    std::array::from_fn(|c| {
        let own: Vec<usize> = (0..blocks.len()).filter(|&i| blocks[i].channel == c).collect();
        if own.is_empty() {
            return 1.0;
        }
        let values: Vec<f64> = own.iter().map(|&i| r[i]).collect();
        let centre = median_or_zero(&values);
        let off: Vec<f64> = values.iter().map(|v| (v - centre).abs()).collect();
        let sigma = (SD_PER_MAD * median_or_zero(&off)).max(1e-9);
        let z: Vec<f64> =
            values.iter().map(|v| ((v - centre) / sigma).clamp(-CLIP, CLIP)).collect();
        let n = z.len() as f64;
        let plain = z.iter().map(|v| v * v).sum::<f64>() / n;
        let mut sum = plain;
        for lag in 1..=LAGS {
            let share = 1.0 - lag as f64 / (LAGS + 1) as f64;
            let products: f64 = (lag..z.len())
                .filter(|&i| blocks[own[i]].cluster == blocks[own[i - lag]].cluster)
                .map(|i| z[i] * z[i - lag])
                .sum();
            sum += 2.0 * share * products / n;
        }
        sigma * sum.max(plain).sqrt()
    })
}

/// Weights of every block from the channels' standard deviations: what they scatter by, at least what the
/// sensors do.
pub(crate) fn weights(blocks: &[Block], scatter: &[f64; 7], sensors: &[f64; 7]) -> Vec<f64> {
    blocks.iter().map(|b| 1.0 / scatter[b.channel].max(sensors[b.channel])).collect()
}
