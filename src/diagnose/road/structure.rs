//! Structure that no candidate explains: what is left of a channel over a variable of the ride
//! (`book/src/diagnosis.md`, section 2.6).
//!
//! A term is a channel's residual as a straight line and a parabola of a covariate (Legendre
//! polynomials on its range), the model's parameters re-fitted along with it to first order. Its gain
//! counts in units of what the same term gains in null simulations.

use nalgebra::{DMatrix, DVector};

use super::problem::{Linear, Problem};
use super::residuals::CHANNELS;
use super::samples::{BLOCK, Samples};

/// Variables that structure is looked for over.
pub const COVARIATES: [&str; 10] = [
    "speed",
    "roll",
    "size of roll",
    "roll rate",
    "front pressure",
    "rear pressure",
    "acceleration",
    "time",
    "heat of the stop",
    "heading",
];

/// Fewest blocks of a channel that a term is made from.
const FEWEST: usize = 30;

/// Structure of one channel over one covariate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term {
    /// Index into [`CHANNELS`].
    pub channel: usize,
    /// Index into [`COVARIATES`].
    pub covariate: usize,
    /// Fall of twice the loss; zero where the term cannot be formed.
    pub gain: f64,
}

impl Term {
    /// In words.
    pub fn description(&self) -> String {
        format!("{} over {}", CHANNELS[self.channel], COVARIATES[self.covariate])
    }
}

/// Block means of the covariates.
fn covariates(s: &Samples) -> Vec<Vec<f64>> {
    let mean = |value: &dyn Fn(usize) -> f64| -> Vec<f64> {
        (0..s.blocks())
            .map(|b| (b * BLOCK..(b + 1) * BLOCK).map(value).sum::<f64>() / BLOCK as f64)
            .collect()
    };
    vec![
        mean(&|i| s.v[i]),
        mean(&|i| s.roll[i]),
        mean(&|i| s.roll[i].abs()),
        mean(&|i| s.rolld[i]),
        mean(&|i| s.pressure[0][i]),
        mean(&|i| s.pressure[1][i]),
        mean(&|i| s.vd[i]),
        mean(&|i| s.time[i]),
        mean(&|i| s.brakes[i].whole.stop),
        mean(&|i| s.along[i]),
    ]
}

/// Every term's gain at a model's optimum; `linear` has the model's parameters first.
pub fn terms(samples: &Samples, problem: &Problem<'_>, linear: &Linear) -> Vec<Term> {
    let (mut matrix, _) = problem.accumulate(linear);
    for (k, parameter) in problem.parameters.iter().enumerate() {
        matrix[(k, k)] += 1.0 / (parameter.prior * parameter.prior);
    }
    let Some(inverse) = matrix.cholesky() else { return Vec::new() };
    let covariates = covariates(samples);
    let mut out = Vec::with_capacity(CHANNELS.len() * covariates.len());
    for channel in 0..CHANNELS.len() {
        for (covariate, x) in covariates.iter().enumerate() {
            let gain = term(problem, linear, channel, x, &inverse).unwrap_or(0.0);
            out.push(Term { channel, covariate, gain });
        }
    }
    out
}

fn term(
    problem: &Problem<'_>,
    linear: &Linear,
    channel: usize,
    x: &[f64],
    inverse: &nalgebra::Cholesky<f64, nalgebra::Dyn>,
) -> Option<f64> {
    let rows: Vec<(usize, f64, f64)> = (0..x.len())
        .filter(|&i| x[i].is_finite())
        .filter_map(|i| problem.weigh(linear, channel, i).map(|(z, weight)| (i, z, weight)))
        // rows that are nil whatever the parameters say nothing
        .filter(|(_, z, _)| *z != 0.0)
        .collect();
    if rows.len() < FEWEST {
        return None;
    }
    let mut sizes: Vec<f64> = rows.iter().map(|(i, _, _)| x[*i]).collect();
    let (last, off) = (sizes.len() - 1, sizes.len() / 100);
    let low = *sizes.select_nth_unstable_by(off, f64::total_cmp).1;
    let high = *sizes.select_nth_unstable_by(last - off, f64::total_cmp).1;
    if high - low < 1e-9 * high.abs().max(1e-9) {
        return None;
    }
    let b = problem.parameters.len();
    let mut cross = DMatrix::zeros(b, 2);
    let mut own = DMatrix::zeros(2, 2);
    let mut pull = DVector::zeros(2);
    let sigma = problem.sigma[channel];
    let mut weighted = Vec::with_capacity(rows.len());
    for (i, z, weight) in rows {
        let u = (2.0 * (x[i] - low) / (high - low) - 1.0).clamp(-1.0, 1.0);
        let g = [u, 1.5 * u * u - 0.5];
        for p in 0..2 {
            pull[p] -= weight * g[p] * z;
            for q in 0..2 {
                own[(p, q)] += weight * g[p] * g[q];
            }
        }
        weighted.push((i, g.map(|g| weight * g / sigma)));
    }
    for (k, column) in linear.columns[..b].iter().enumerate() {
        let column = &column[channel];
        let sum = weighted
            .iter()
            .fold([0.0; 2], |[a, b], (i, [p, q])| [a + p * column[*i], b + q * column[*i]]);
        cross[(k, 0)] = sum[0];
        cross[(k, 1)] = sum[1];
    }
    let projected = &own - cross.transpose() * inverse.solve(&cross);
    // a hundredth of what the term would be alone: next to nothing is left beside the parameters
    let ridge = 0.01 * own.trace();
    let solved = (projected + DMatrix::identity(2, 2) * ridge).cholesky()?.solve(&pull);
    Some(pull.dot(&solved))
}
