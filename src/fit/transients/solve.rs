//! The fit: Gauss-Newton with priors and Huber's weights, and how well it knows the tyres.

use nalgebra::{DMatrix, DVector};

use super::model::Model;
use super::noise::{Attitude, Noise, PARTS, Scales};
use super::parameters::*;
use crate::fit::variation::Source;
use crate::statistics::blocked;
use crate::statistics::interval::t95;

/// Huber's threshold, in standard deviations.
const HUBER: f64 = 2.0;
/// Most steps.
const STEPS: usize = 30;
/// How often a step that makes the fit worse is halved.
const HALVINGS: usize = 6;
/// Steps after which the noise is scaled by what it shows.
const RESCALED: std::ops::RangeInclusive<usize> = 1..=2;
/// Most stretches that the noise is scaled by.
const MOST: usize = 6;
/// A step of which the square, in standard deviations of the result, is below this comes to rest.
const REST: f64 = 1e-2;
/// A fit that moves anything that was known before by more standard deviations explains a ride by what cannot be. Rides of both
/// simulators moved a delay by 4.8 at most; an accelerometer 25 cm above where it was taken to be moved lengths by 10 to 20.
const FARTHEST: f64 = 7.0;
/// Numbers that stretches are taken to have adapted to, in the sandwich.
const ADAPTED: usize = 2;

/// Numbers of the result: of each tyre [`OUT`].
pub(crate) const OUTPUTS: usize = 4;
/// Which of a tyre's numbers are results.
pub(crate) const OUT: [usize; 2] = [LN_STIFFNESS, RATIO];

/// A fit that came to rest.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The parameters.
    pub theta: Vec<f64>,
    /// Covariance of the results that the ride's own noise makes: of each tyre logarithm of the stiffness and ratio.
    pub noise: DMatrix<f64>,
    /// What one standard deviation of each thing that was known before changes the results by.
    pub shifts: Vec<(Source, [f64; OUTPUTS])>,
    /// Stretches.
    pub stretches: usize,
    /// Samples.
    pub samples: usize,
    /// Time in which the lean changes fast, s.
    pub fast: f64,
    /// Whether steep corners took part, for want of other changes of lean.
    pub steep: bool,
    /// Share of the residuals with less than full weight.
    pub outliers: f64,
    /// Scales of the noise.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub scale: Scales,
}

impl Fitted {
    /// Variance of a combination of the results, with everything that is unknown.
    pub fn variance(&self, contrast: &[f64; OUTPUTS]) -> f64 {
        let c = DVector::from_row_slice(contrast);
        let own = (c.transpose() * &self.noise * &c)[0];
        let shift =
            |s: &[f64; OUTPUTS]| -> f64 { s.iter().zip(contrast).map(|(a, b)| a * b).sum() };
        own + self.shifts.iter().map(|(_, s)| shift(s).powi(2)).sum::<f64>()
    }
}

/// Whitened residuals and derivatives of every stretch.
struct Whitened {
    residuals: Vec<DVector<f64>>,
    slopes: Vec<DMatrix<f64>>,
}

/// Fits; `None` where it does not come to rest.
pub(crate) fn fit(model: &Model<'_>, parameters: &Prior) -> Option<Fitted> {
    let p = parameters.len();
    let mut theta = parameters.mean.clone();
    let mut scale = Scales::default();
    let mut attitude = Attitude::new(model, &theta);
    let mut factors = factors(model, &scale, &attitude)?;
    let prior = DVector::from_iterator(p, parameters.sd.iter().map(|sd| 1.0 / (sd * sd)));
    for step in 0..STEPS {
        let at = whiten(model, parameters, &theta, &factors);
        let (information, gradient, _) = normal(&at, &theta, parameters, &prior);
        let change = information.cholesky()?.solve(&gradient);
        theta = stepped(model, parameters, &theta, &change, &factors)?;
        if RESCALED.contains(&step) {
            scale = rescaled(model, &at, &factors, scale, &attitude);
            attitude = Attitude::new(model, &theta);
            factors = self::factors(model, &scale, &attitude)?;
            continue;
        }
        if step > *RESCALED.end() && gradient.dot(&change) < REST {
            let at = whiten(model, parameters, &theta, &factors);
            return result(&at, theta, parameters, &prior, model, scale);
        }
    }
    None
}

/// The step, or the largest half, quarter and so on of it that makes the fit no worse: full ones of a slalom through slow
/// and fast cones went to and fro for ever. `None` where none is finite.
fn stepped(
    model: &Model<'_>,
    parameters: &Prior,
    theta: &[f64],
    change: &DVector<f64>,
    factors: &[DMatrix<f64>],
) -> Option<Vec<f64>> {
    let by = |share: f64| -> Vec<f64> {
        theta.iter().zip(change.iter()).map(|(t, d)| t + share * d).collect()
    };
    let before = loss(model, parameters, theta, factors);
    let mut share = 1.0;
    for _ in 0..HALVINGS {
        if loss(model, parameters, &by(share), factors) <= before {
            break;
        }
        share *= 0.5;
    }
    let there = by(share);
    there.iter().all(|t| t.is_finite()).then_some(there)
}

/// Huber's loss of the whitened residuals, twice, with that of what was known before.
fn loss(model: &Model<'_>, parameters: &Prior, theta: &[f64], factors: &[DMatrix<f64>]) -> f64 {
    let residuals = model.at(theta);
    let all = model.columns.len();
    let channels = model.residuals.len();
    let known = theta.iter().zip(&parameters.mean).zip(&parameters.sd);
    let mut out: f64 = known.map(|((t, m), sd)| ((t - m) / sd).powi(2)).sum();
    for (stretch, factor) in model.columns.stretches().zip(factors) {
        let n = stretch.len();
        let of = |i: usize| residuals[i / n * all + stretch.start + i % n];
        let mut own = DVector::from_iterator(channels * n, (0..channels * n).map(of));
        factor.solve_lower_triangular_mut(&mut own);
        let huber = |r: &f64| {
            let r = r.abs();
            if r <= HUBER { r * r } else { HUBER * (2.0 * r - HUBER) }
        };
        out += own.iter().map(huber).sum::<f64>();
    }
    out
}

fn factors(model: &Model<'_>, scale: &Scales, attitude: &Attitude) -> Option<Vec<DMatrix<f64>>> {
    let of = |s| Noise::new(model, &s, attitude).factor(scale);
    model.columns.stretches().map(of).collect()
}

fn whiten(
    model: &Model<'_>,
    parameters: &Prior,
    theta: &[f64],
    factors: &[DMatrix<f64>],
) -> Whitened {
    let (residuals, slopes) = model.linear(theta, &parameters.sd);
    let all = model.columns.len();
    let channels = model.residuals.len();
    let mut out = Whitened { residuals: Vec::new(), slopes: Vec::new() };
    for (stretch, factor) in model.columns.stretches().zip(factors) {
        let n = stretch.len();
        let mut block = DMatrix::zeros(channels * n, slopes.len() + 1);
        for (j, column) in slopes.iter().chain([&residuals]).enumerate() {
            for a in 0..channels {
                let from = &column[a * all + stretch.start..a * all + stretch.end];
                block.view_mut((a * n, j), (n, 1)).copy_from_slice(from);
            }
        }
        blocked::solve_lower(factor, &mut block);
        out.residuals.push(block.column(slopes.len()).into_owned());
        out.slopes.push(block.columns(0, slopes.len()).into_owned());
    }
    out
}

/// Information, gradient and the score of each stretch.
fn normal(
    at: &Whitened,
    theta: &[f64],
    parameters: &Prior,
    prior: &DVector<f64>,
) -> (DMatrix<f64>, DVector<f64>, Vec<DVector<f64>>) {
    let mut information = DMatrix::from_diagonal(prior);
    let mut gradient = DVector::from_iterator(
        theta.len(),
        theta.iter().zip(&parameters.mean).zip(prior.iter()).map(|((t, m), w)| -w * (t - m)),
    );
    let mut scores = Vec::new();
    for (residuals, slopes) in at.residuals.iter().zip(&at.slopes) {
        let mut weighted = slopes.clone();
        for (i, mut row) in weighted.row_iter_mut().enumerate() {
            row *= weight(residuals[i]);
        }
        information.gemm(1.0, &weighted.transpose(), slopes, 1.0);
        let score = -weighted.tr_mul(residuals);
        gradient += &score;
        scores.push(score);
    }
    (information, gradient, scores)
}

fn weight(residual: f64) -> f64 {
    if residual.abs() <= HUBER { 1.0 } else { HUBER / residual.abs() }
}

/// Scales of the noise by the residuals of some of the stretches.
fn rescaled(
    model: &Model<'_>,
    at: &Whitened,
    factors: &[DMatrix<f64>],
    scale: Scales,
    attitude: &Attitude,
) -> Scales {
    let every = factors.len().div_ceil(MOST);
    let mut sums = [[0.0; 2]; PARTS];
    for (k, stretch) in model.columns.stretches().enumerate().step_by(every) {
        let noise = Noise::new(model, &stretch, attitude);
        // outliers count as far as they have weight
        let kept = at.residuals[k].map(|r| r * weight(r).sqrt());
        let shares = noise.shares(&factors[k], &kept);
        for (sum, share) in sums.iter_mut().zip(shares) {
            (0..2).for_each(|m| sum[m] += share[m]);
        }
    }
    scale.updated(&sums)
}

fn result(
    at: &Whitened,
    theta: Vec<f64>,
    parameters: &Prior,
    prior: &DVector<f64>,
    model: &Model<'_>,
    scale: Scales,
) -> Option<Fitted> {
    let far = |((t, m), sd): ((&f64, &f64), &f64)| (t - m).abs() > FARTHEST * sd;
    if theta.iter().zip(&parameters.mean).zip(&parameters.sd).any(far) {
        return None;
    }
    let (information, _, scores) = normal(at, &theta, parameters, prior);
    let covariance = information.clone().cholesky()?.inverse();
    let outputs: Vec<usize> =
        (0..2).flat_map(|k| OUT.iter().map(move |j| k * OF_TYRE + j)).collect();
    let rows = DMatrix::from_fn(OUTPUTS, theta.len(), |i, j| covariance[(outputs[i], j)]);
    let data = &information - DMatrix::from_diagonal(prior);
    let of_model = &rows * data * rows.transpose();
    let n = scores.len();
    let mut of_scores = DMatrix::zeros(OUTPUTS, OUTPUTS);
    for score in &scores {
        let moved = &rows * score;
        of_scores += &moved * moved.transpose();
    }
    of_scores *= n as f64 / n.saturating_sub(ADAPTED).max(1) as f64;
    let few = (t95(n as f64 - 1.0) / t95(f64::INFINITY)).powi(2);
    let widened: Vec<f64> = (0..OUTPUTS)
        .map(|i| (few * of_scores[(i, i)] / of_model[(i, i)]).max(1.0).sqrt())
        .collect();
    let noise =
        DMatrix::from_fn(OUTPUTS, OUTPUTS, |i, j| of_model[(i, j)] * widened[i] * widened[j]);
    let shifts = (0..theta.len())
        .map(|j| {
            let mut shift = [0.0; OUTPUTS];
            shift.iter_mut().enumerate().for_each(|(i, s)| *s = rows[(i, j)] / parameters.sd[j]);
            (parameters.sources[j].clone(), shift)
        })
        .collect();
    let all: usize = at.residuals.iter().map(|r| r.len()).sum();
    let light = at.residuals.iter().flat_map(|r| r.iter()).filter(|r| r.abs() > HUBER).count();
    Some(Fitted {
        theta,
        noise,
        shifts,
        stretches: n,
        samples: model.columns.len(),
        fast: model.columns.fast(),
        steep: false,
        outliers: light as f64 / all.max(1) as f64,
        scale,
    })
}
