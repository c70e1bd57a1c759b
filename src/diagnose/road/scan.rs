//! Score of every candidate at the nominal optimum, with the nominal model fitted along to first order
//! (`book/src/diagnosis.md`, section 2.3).
//!
//! ```text
//! K = S_bb^-1 S_bj,   I_j = S_jj - S_jb K,   u_g = b_gj - K' b_gb
//! delta_j = (I_j + 1/9)^-1 sum_g u_g,        se_j^2 = sum_g (u_g - I_gj delta_j)^2 / (I_j + 1/9)^2
//! ```
//! `g` runs over manoeuvres; sizes are in usual sizes of the effect.

use nalgebra::DMatrix;

use super::base::Base;
use super::gram::{counted, entering, gathered};
use super::parameters::Parameter;
use super::problem::{Linear, Problem};
use super::residuals::CHANNELS;
use super::samples::{BLOCK, Samples};
use crate::simulate::effects::Effect;

/// One candidate, to first order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Estimated size, in usual ones.
    pub delta: f64,
    /// Its standard error from the manoeuvres' own scatter.
    pub std_error: f64,
    /// Fall of twice the loss.
    pub gain: f64,
    /// Information on the size with the nominal model fitted too: `1/sqrt` of it is a standard deviation.
    pub information: f64,
}

/// Scores every effect.
pub fn scan(samples: &Samples, base: &Base, effects: &[Effect]) -> Vec<Score> {
    let parameters: Vec<Parameter> =
        base.parameters.iter().copied().chain(effects.iter().map(Effect::parameter)).collect();
    let problem = Problem::new(samples, &base.start, base.sigma, &parameters);
    let mut linear = problem.linear(&base.values);
    let values = base.problem(samples).relax(&mut linear, &base.values);
    scores(samples, &Base { values, ..base.clone() }, &parameters, &linear)
}

/// Scores of the parameters beyond the nominal model's, from a linearisation in all of them at the nominal values.
pub(crate) fn scores(
    samples: &Samples,
    base: &Base,
    parameters: &[Parameter],
    linear: &Linear,
) -> Vec<Score> {
    let problem = Problem::new(samples, &base.start, base.sigma, parameters);
    let (p, b) = (parameters.len(), base.parameters.len());
    let (whole, _) = problem.accumulate(linear);
    // priors are observations, too: a parameter far from its prior is evidence for the effect that brings it back
    let priors: Vec<(f64, f64)> =
        base.parameters.iter().map(|p| problem.prior(p, &base.values)).collect();
    let mut base_matrix = whole.view((0, 0), (b, b)).into_owned();
    for (k, parameter) in base.parameters.iter().enumerate() {
        base_matrix[(k, k)] += 1.0 / (parameter.prior * parameter.prior);
    }
    let Some(inverse) = base_matrix.cholesky() else {
        let none = Score { delta: 0.0, std_error: f64::INFINITY, gain: 0.0, information: 0.0 };
        return vec![none; p - b];
    };
    let weights = -inverse.solve(&whole.view((0, b), (b, p - b)));
    let shown = pulls_by_manoeuvre(samples, &problem, linear, &weights);
    (b..p)
        .zip(shown)
        .map(|(j, mut pulls)| {
            let weights = weights.column(j - b);
            pulls.extend(priors.iter().zip(weights.iter()).map(|((z, weight), share)| {
                let row = share * weight;
                (-row * z, row * row)
            }));
            let prior = parameters[j].prior;
            let (sum, information) =
                pulls.iter().fold((0.0, 0.0), |(u, i), (pull, own)| (u + pull, i + own));
            let curvature = information + 1.0 / (prior * prior);
            let delta = sum / curvature;
            // scatter about the effect: about zero, the effect would inflate its own standard error
            let scatter: f64 = pulls.iter().map(|(pull, own)| (pull - own * delta).powi(2)).sum();
            Score {
                delta,
                std_error: scatter.sqrt() / curvature,
                gain: sum * sum / curvature,
                information,
            }
        })
        .collect()
}

/// Downhill pull and curvature of every manoeuvre along each effect's column, plus its `weights` of the nominal
/// columns.
fn pulls_by_manoeuvre(
    samples: &Samples,
    problem: &Problem<'_>,
    linear: &Linear,
    weights: &DMatrix<f64>,
) -> Vec<Vec<(f64, f64)>> {
    let (b, effects) = weights.shape();
    let mut out = vec![vec![(0.0, 0.0); samples.manoeuvres.len()]; effects];
    let (counts, pulls) = problem.weighed(linear);
    for c in 0..CHANNELS.len() {
        let inside = entering(&linear.columns[..b + effects], c);
        let mixed = DMatrix::from_fn(inside.len(), effects, |k, j| match inside[k] {
            i if i < b => weights[(i, j)],
            i => f64::from(i == b + j),
        });
        let rows = counted(&counts[c]);
        let shown = gathered(&linear.columns, c, &inside, &rows) * mixed;
        let sigma = problem.sigma[c];
        let mut first = 0;
        for (m, (_, range)) in samples.manoeuvres.iter().enumerate() {
            let own = rows[first..].iter().take_while(|(b, _)| *b < range.end / BLOCK).count();
            let places = first..first + own;
            first += own;
            for (j, sums) in out.iter_mut().enumerate() {
                let column = shown.column(j);
                for row in places.clone() {
                    let (block, weight) = rows[row];
                    let r = column[row] / sigma;
                    sums[m].0 -= r * pulls[c][block];
                    sums[m].1 += weight * r * r;
                }
            }
        }
    }
    out
}
