//! Every candidate's score at the base optimum, the base re-fitted along with it to first order
//! (`book/src/diagnosis.md`, section 2.3).
//!
//! ```text
//! K = S_bb^-1 S_bj,   I_j = S_jj - S_jb K,   u_g = b_gj - K' b_gb
//! delta_j = (I_j + 1/9)^-1 sum_g u_g,        se_j^2 = sum_g (u_g - I_gj delta_j)^2 / (I_j + 1/9)^2
//! ```
//! `g` runs over manoeuvres; sizes are in the effect's usual one.

use super::base::Base;
use super::parameters::Parameter;
use super::problem::{Linear, Problem};
use super::samples::{BLOCK, Samples};
use crate::effects::Effect;

/// One candidate, to first order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Estimated size, in usual ones.
    pub delta: f64,
    /// Its standard error from the manoeuvres' own scatter.
    pub std_error: f64,
    /// Fall of twice the loss.
    pub gain: f64,
    /// What the ride knows of it once the base is fitted too: `1/sqrt` is a standard deviation.
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

/// Scores of the parameters beyond the base's, from a linearisation of them all whose residuals are those at
/// the base's values.
pub fn scores(
    samples: &Samples,
    base: &Base,
    parameters: &[Parameter],
    linear: &Linear,
) -> Vec<Score> {
    let problem = Problem::new(samples, &base.start, base.sigma, parameters);
    let (p, b) = (parameters.len(), base.parameters.len());
    let (whole, _) = problem.accumulate(linear);
    // the priors are observations of the base: what strains them is evidence of what relieves them
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
    (b..p)
        .map(|j| {
            let k = inverse.solve(&whole.view((0, j), (b, 1)).into_owned());
            let weights: Vec<f64> = k.iter().map(|x| -x).chain([1.0]).collect();
            let columns: Vec<usize> = (0..b).chain([j]).collect();
            let pulls: Vec<(f64, f64)> = samples
                .manoeuvres
                .iter()
                .map(|(_, range)| {
                    let blocks = range.start / BLOCK..range.end / BLOCK;
                    problem.along(linear, blocks, &columns, &weights)
                })
                .chain(priors.iter().zip(&weights).map(|((z, weight), share)| {
                    let row = share * weight;
                    (-row * z, row * row)
                }))
                .collect();
            let prior = parameters[j].prior;
            let (sum, information) =
                pulls.iter().fold((0.0, 0.0), |(u, i), (pull, own)| (u + pull, i + own));
            let curvature = information + 1.0 / (prior * prior);
            let delta = sum / curvature;
            // the manoeuvres' scatter about the effect, not about nothing: it would inflate itself
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
