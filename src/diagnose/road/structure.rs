//! Structure that no candidate explains: a residual as a function of a variable of the ride
//! (`book/src/diagnosis.md`, section 2.6).
//!
//! A term is a channel's residual as a straight line and a parabola of a covariate (Legendre
//! polynomials on its range), the model's parameters re-fitted along with it to first order. Its gain
//! counts in units of what the same term gains in fault-free simulations.

use nalgebra::{DMatrix, DVector};

use super::gram::{Row, counted, entering, gathered};
use super::problem::{Linear, Problem};
use super::residuals::CHANNELS;
use super::samples::{BLOCK, Samples};

/// Variables that structure is looked for over.
pub(crate) const COVARIATES: [&str; 10] = [
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
const MIN_BLOCKS: usize = 30;

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
    let (weights, pulls) = problem.weighed(linear);
    let columns = &linear.columns[..problem.parameters.len()];
    for channel in 0..CHANNELS.len() {
        // rows that are nil whatever the parameters say nothing
        let mut rows = counted(&weights[channel]);
        rows.retain(|(i, _)| linear.residuals[channel][*i] != 0.0);
        let sides: Vec<Option<Side>> =
            covariates.iter().map(|x| Side::of(x, &rows, &pulls[channel])).collect();
        let shapes: Vec<DVector<f64>> =
            sides.iter().flatten().flat_map(|side| side.weighted.clone()).collect();
        let inside = entering(columns, channel);
        let slopes = gathered(columns, channel, &inside, &rows).transpose();
        let shown = match shapes.is_empty() {
            true => DMatrix::zeros(inside.len(), 0),
            false => slopes * DMatrix::from_columns(&shapes) / problem.sigma[channel],
        };
        let mut place = 0;
        for (covariate, side) in sides.iter().enumerate() {
            let gain = side.as_ref().and_then(|side| {
                let mut cross = DMatrix::zeros(columns.len(), 2);
                for (k, &i) in inside.iter().enumerate() {
                    (cross[(i, 0)], cross[(i, 1)]) = (shown[(k, place)], shown[(k, place + 1)]);
                }
                place += 2;
                side.gain(cross, &inverse)
            });
            out.push(Term { channel, covariate, gain: gain.unwrap_or(0.0) });
        }
    }
    out
}

/// A term on its own: line and parabola of a covariate.
struct Side {
    /// Times the weights of the rows, nil where the covariate is not known.
    weighted: [DVector<f64>; 2],
    own: DMatrix<f64>,
    pull: DVector<f64>,
}

impl Side {
    /// `pulls` are weighted residuals by block; `None` where there is too little.
    fn of(x: &[f64], rows: &[Row], pulls: &[f64]) -> Option<Self> {
        let mut sizes: Vec<f64> = rows.iter().map(|(i, _)| x[*i]).collect();
        sizes.retain(|x| x.is_finite());
        if sizes.len() < MIN_BLOCKS {
            return None;
        }
        let (last, off) = (sizes.len() - 1, sizes.len() / 100);
        let low = *sizes.select_nth_unstable_by(off, f64::total_cmp).1;
        let high = *sizes.select_nth_unstable_by(last - off, f64::total_cmp).1;
        if high - low < 1e-9 * high.abs().max(1e-9) {
            return None;
        }
        let mut weighted = [DVector::zeros(rows.len()), DVector::zeros(rows.len())];
        let (mut own, mut pull) = (DMatrix::zeros(2, 2), DVector::zeros(2));
        for (row, (i, weight)) in rows.iter().enumerate().filter(|(_, (i, _))| x[*i].is_finite()) {
            let u = (2.0 * (x[*i] - low) / (high - low) - 1.0).clamp(-1.0, 1.0);
            let g = [u, 1.5 * u * u - 0.5];
            for p in 0..2 {
                weighted[p][row] = weight * g[p];
                pull[p] -= g[p] * pulls[*i];
                for q in 0..2 {
                    own[(p, q)] += weight * g[p] * g[q];
                }
            }
        }
        Some(Side { weighted, own, pull })
    }

    /// Fall of twice the loss beside parameters that it has products `cross` with.
    fn gain(
        &self,
        cross: DMatrix<f64>,
        inverse: &nalgebra::Cholesky<f64, nalgebra::Dyn>,
    ) -> Option<f64> {
        let projected = &self.own - cross.transpose() * inverse.solve(&cross);
        // a hundredth of what the term would be alone: next to nothing is left beside the parameters
        let ridge = 0.01 * self.own.trace();
        let factor = (projected + DMatrix::identity(2, 2) * ridge).cholesky()?;
        Some(self.pull.dot(&factor.solve(&self.pull)))
    }
}
