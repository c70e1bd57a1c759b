//! Robust nonlinear regression: the bisquare around Levenberg and Marquardt.
//!
//! ```text
//! minimise  sum_i rho(r_i(theta) / s),   s = median|r| / 0.6745, renewed at each reweighting
//! ```
//! A model gives residuals already divided by their expected scale, which may itself depend
//! on the parameters (effective variance, Sampson distance): the sum is minimised whole.
//!
//! METHOD: the objective has local minima, from the outliers and from the model. So from
//! several starts, each: (1) a search on at most [`SEARCH_ROWS`] samples, which half of the
//! samples being bad does not mislead: reweighted least squares where the model can leave
//! samples out ([`Model::thinned`]), else a simplex (argmin, Nelder and Mead) on the tau-scale of
//! their residuals; (2) reweighted least squares (crate levenberg-marquardt, a port of MINPACK)
//! from where the most promising searches ended, and from the start itself where there is only
//! one; (3) the end with the smallest tau-scale over all samples is kept.
//!
//! Bounds are kept by a smooth change of variables ([`super::bounds`]).

use std::cell::RefCell;

use argmin::core::{CostFunction, Executor, State};
use argmin::solver::neldermead::NelderMead;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Owned};

use super::bounds::Bounds;
use super::loss::{TUNING, mad, psi_derivative, tau_scale, weight};

/// Samples that take part in the search for a start.
pub(crate) const SEARCH_ROWS: usize = 300;

pub trait Model {
    fn parameters(&self) -> usize;

    fn len(&self) -> usize;

    /// Residuals at `theta`, each divided by its expected scale where the model knows one.
    fn residuals(&self, theta: &[f64], out: &mut [f64]);

    /// Residuals of some samples only; worth writing where there are many samples.
    fn some_residuals(&self, theta: &[f64], rows: &[usize], out: &mut [f64]) {
        let mut all = vec![0.0; self.len()];
        self.residuals(theta, &mut all);
        for (o, &i) in out.iter_mut().zip(rows) {
            *o = all[i];
        }
    }

    /// The model of some of the samples alone, if that is one; worth writing where a search from
    /// many starts is to be quick.
    fn thinned(&self, _rows: &[usize]) -> Option<Box<dyn Model>> {
        None
    }

    /// Derivative of each residual (row) by each parameter (column); central differences
    /// unless the model knows better.
    fn jacobian(&self, theta: &[f64], out: &mut DMatrix<f64>) {
        let n = self.len();
        let (mut above, mut below) = (vec![0.0; n], vec![0.0; n]);
        let mut at = theta.to_vec();
        for j in 0..theta.len() {
            // the cube root of the precision balances truncation and rounding
            let step = 6e-6 * theta[j].abs().max(1e-3);
            at[j] = theta[j] + step;
            self.residuals(&at, &mut above);
            let high = at[j];
            at[j] = theta[j] - step;
            self.residuals(&at, &mut below);
            let width = high - at[j];
            at[j] = theta[j];
            for (o, (a, b)) in out.column_mut(j).iter_mut().zip(above.iter().zip(&below)) {
                *o = (a - b) / width;
            }
        }
    }
}

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// Fewer residuals than parameters.
    #[error("{samples} samples cannot determine {parameters} parameters")]
    TooFew { samples: usize, parameters: usize },
    /// No start, one of the wrong length, or bounds that exclude everything.
    #[error("start {start}: {message}")]
    Start {
        /// Its place, from 0.
        start: usize,
        message: &'static str,
    },
    /// The residuals are not finite at any start.
    #[error("the model is not finite at any start")]
    NotFinite,
}

const EXCLUDED: Error = Error::Start { start: 0, message: "bounds that exclude everything" };

#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Bisquare constant; infinite means least squares, without search.
    pub tuning: f64,
    /// Smallest scale: differences below it are never outliers; unit of the residuals.
    pub scale_floor: f64,
    /// Reweightings per descent.
    pub max_iterations: usize,
    /// Largest root-mean-square change of the residuals, in scales, at rest.
    pub tolerance: f64,
    /// Iterations of the simplex search from each start; 0 leaves it out.
    pub search_iterations: u64,
    /// Searches that are followed by a descent.
    pub finalists: usize,
    /// Least squares only: share of the sum of squares below which a step's gain is at rest.
    pub least_gain: f64,
}

impl Options {
    pub const DEFAULT: Options = Options {
        tuning: TUNING,
        scale_floor: 0.0,
        max_iterations: 60,
        tolerance: 1e-5,
        search_iterations: 150,
        finalists: 2,
        // that of the crate: as far as numbers go
        least_gain: 30.0 * f64::EPSILON,
    };
}

impl Default for Options {
    fn default() -> Self {
        Options::DEFAULT
    }
}

/// A robust nonlinear fit.
#[derive(Debug, Clone)]
pub struct NonlinearFit {
    pub theta: Vec<f64>,
    /// Residuals at the solution.
    pub residuals: Vec<f64>,
    /// Derivative of the residuals by the parameters at the solution.
    pub jacobian: DMatrix<f64>,
    /// Bisquare weight of each residual, 0 to 1.
    pub weights: Vec<f64>,
    /// Slope of psi at each residual, for [`super::cluster_covariance`].
    pub psi_derivatives: Vec<f64>,
    /// Robust standard deviation of the residuals.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub scale: f64,
    /// Reweightings of the descent that was kept.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub iterations: usize,
    /// Evaluations of all residuals, all descents.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub evaluations: usize,
    /// Which start won, from 0.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub start: usize,
    /// Whether it came to rest.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub converged: bool,
    /// Share of residuals with zero weight.
    pub outlier_fraction: f64,
}

/// Fits a model from one or more starts, within bounds (infinite ones are none).
///
/// # Errors
/// Too few samples, unusable starts, a model that is not finite at any of them.
pub fn fit(
    model: &dyn Model,
    starts: &[Vec<f64>],
    bounds: Option<&[(f64, f64)]>,
    options: &Options,
) -> Result<NonlinearFit, Error> {
    let (n, p) = (model.len(), model.parameters());
    if n < p || p == 0 {
        return Err(Error::TooFew { samples: n, parameters: p });
    }
    let map = Bounds::new(p, bounds).ok_or(EXCLUDED)?;
    let starts = inner_starts(starts, p, &map)?;
    let mut work = Work { model, map: &map, options, r: vec![0.0; n], scratch: vec![0.0; n] };
    let candidates = work.candidates(&starts);
    let mut best: Option<(f64, usize, Descent)> = None;
    let mut evaluations = 0;
    for (start, z) in candidates {
        let known = best.as_ref().map(|(.., descent)| descent.residuals.as_slice());
        let Some(descent) = work.descend(z, known) else { continue };
        evaluations += descent.evaluations;
        if best.as_ref().is_none_or(|(objective, ..)| descent.objective < *objective) {
            best = Some((descent.objective, start, descent));
        }
    }
    let (_, start, descent) = best.ok_or(Error::NotFinite)?;
    let theta = map.outer(descent.z.as_slice());
    let mut jacobian = DMatrix::zeros(n, p);
    model.residuals(&theta, &mut work.r);
    model.jacobian(&theta, &mut jacobian);
    let u = work.r.iter().map(|r| r / descent.scale);
    let weights: Vec<f64> = u.clone().map(|u| weight(u, options.tuning)).collect();
    let psi_derivatives = u.map(|u| psi_derivative(u, options.tuning)).collect();
    let outliers = weights.iter().filter(|w| **w == 0.0).count();
    Ok(NonlinearFit {
        theta,
        jacobian,
        weights,
        psi_derivatives,
        scale: descent.scale,
        iterations: descent.iterations,
        evaluations,
        start,
        converged: descent.converged,
        outlier_fraction: outliers as f64 / n as f64,
        residuals: work.r,
    })
}

fn inner_starts(starts: &[Vec<f64>], p: usize, map: &Bounds) -> Result<Vec<Vec<f64>>, Error> {
    if starts.is_empty() {
        return Err(Error::Start { start: 0, message: "there is none" });
    }
    starts
        .iter()
        .enumerate()
        .map(|(start, theta)| {
            if theta.len() != p {
                return Err(Error::Start { start, message: "wrong number of parameters" });
            }
            if !theta.iter().all(|t| t.is_finite()) {
                return Err(Error::Start { start, message: "not finite" });
            }
            Ok(map.inner(theta))
        })
        .collect()
}

/// Where one descent ended, in inner variables.
struct Descent {
    z: DVector<f64>,
    objective: f64,
    scale: f64,
    iterations: usize,
    evaluations: usize,
    converged: bool,
    residuals: Vec<f64>,
}

struct Work<'a> {
    model: &'a dyn Model,
    map: &'a Bounds,
    options: &'a Options,
    r: Vec<f64>,
    scratch: Vec<f64>,
}

impl Work<'_> {
    fn robust(&self) -> bool {
        self.options.tuning.is_finite()
    }

    /// Starts worth a descent, with the number of the start each came from.
    fn candidates(&self, starts: &[Vec<f64>]) -> Vec<(usize, Vec<f64>)> {
        let plain = || starts.iter().cloned().enumerate().collect();
        if !self.robust() || self.options.search_iterations == 0 {
            return plain();
        }
        let rows = search_rows(self.model.len());
        if let Some(thin) = self.model.thinned(&rows) {
            return self.searched_by_descent(&*thin, starts);
        }
        let objective = Objective::new(self.model, self.map, self.options.scale_floor, rows);
        let mut searched = Vec::with_capacity(starts.len());
        let mut first: Option<(f64, usize)> = None;
        for (k, z) in starts.iter().enumerate() {
            let at_start = objective.value(z);
            if at_start.is_finite() && first.is_none_or(|(best, _)| at_start < best) {
                first = Some((at_start, k));
            }
            if let Some((value, z)) = simplex(&objective, z, self.options.search_iterations) {
                searched.push((value, k, z));
            }
        }
        let mut out = self.finalists(searched);
        if starts.len() == 1 {
            out.extend(first.map(|(_, k)| (k, starts[k].clone())));
        }
        if out.is_empty() { plain() } else { out }
    }

    /// The same, found by rough descents over some of the samples.
    fn searched_by_descent(&self, thin: &dyn Model, starts: &[Vec<f64>]) -> Vec<(usize, Vec<f64>)> {
        let n = thin.len();
        let options = Options { max_iterations: 20, tolerance: 1e-3, ..*self.options };
        let (r, scratch) = (vec![0.0; n], vec![0.0; n]);
        let mut work = Work { model: thin, map: self.map, options: &options, r, scratch };
        // judged by all samples: the few may not show which of two minima is the lower one
        let (mut all, mut scratch) = (self.r.clone(), self.scratch.clone());
        let ends = starts.iter().enumerate().filter_map(|(k, z)| {
            let z = work.descend(z.clone(), None)?.z.as_slice().to_vec();
            self.model.residuals(&self.map.outer(&z), &mut all);
            let finite = all.iter().all(|r| r.is_finite());
            let floor = self.options.scale_floor;
            finite.then(|| (tau_scale(&all, floor, &mut scratch), k, z))
        });
        let out = self.finalists(ends.collect());
        if out.is_empty() { starts.iter().cloned().enumerate().collect() } else { out }
    }

    /// The most promising ends of searches (tau-scale, start, place), without the scales.
    fn finalists(&self, mut searched: Vec<(f64, usize, Vec<f64>)>) -> Vec<(usize, Vec<f64>)> {
        searched.sort_by(|a, b| a.0.total_cmp(&b.0));
        // searches that met need one descent only
        searched.dedup_by(|b, a| b.0 <= a.0 * (1.0 + 1e-4));
        searched.truncate(self.options.finalists.max(1));
        searched.into_iter().map(|(_, k, z)| (k, z)).collect()
    }

    /// Reweighted least squares from `z`; `None` where the model is not finite there, or where
    /// it comes to residuals that are known already, those of another descent.
    fn descend(&mut self, z: Vec<f64>, known: Option<&[f64]>) -> Option<Descent> {
        let p = z.len();
        let mut theta = self.map.outer(&z);
        self.model.residuals(&theta, &mut self.r);
        if !self.r.iter().all(|r| r.is_finite()) {
            return None;
        }
        let floor = self.options.scale_floor.max(f64::MIN_POSITIVE);
        let mut z = DVector::from_vec(z);
        let mut scale = mad(&self.r, &mut self.scratch).max(floor);
        let mut before = self.r.clone();
        let (mut iterations, mut evaluations, mut converged) = (0, 1, false);
        let mut root_weights = vec![1.0; self.r.len()];
        let solver = if self.robust() {
            // the weights change anyway: a rough solve per reweighting, the last ones are exact
            // because little remains to be done
            LevenbergMarquardt::new().with_ftol(1e-2).with_xtol(1e-7).with_patience(10)
        } else {
            LevenbergMarquardt::new().with_ftol(self.options.least_gain).with_patience(400)
        };
        while iterations < self.options.max_iterations {
            if self.robust() {
                for (w, r) in root_weights.iter_mut().zip(&self.r) {
                    *w = weight(r / scale, self.options.tuning).sqrt();
                }
            }
            let cap = 1e3 * scale.max(self.r.iter().fold(0.0, |m, r| r.abs().max(m)));
            let problem = Weighted {
                model: self.model,
                map: self.map,
                theta: theta.clone(),
                z: z.clone(),
                root_weights: &root_weights,
                known: RefCell::new((theta.clone(), std::mem::take(&mut self.r))),
                cap,
            };
            let (problem, report) = solver.minimize(problem);
            evaluations += report.number_of_evaluations;
            problem.know();
            z = problem.z;
            theta = problem.theta;
            self.r = problem.known.into_inner().1;
            if !self.r.iter().all(|r| r.is_finite()) {
                return None;
            }
            iterations += 1;
            scale = mad(&self.r, &mut self.scratch).max(floor);
            let same = |known: &[f64]| {
                let apart = self.r.iter().zip(known).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
                apart <= (1e-3 * scale).powi(2) * self.r.len() as f64
            };
            if known.is_some_and(same) {
                return None;
            }
            if !self.robust() {
                converged = report.termination.was_successful();
                break;
            }
            let mut moved = 0.0;
            for ((b, r), w) in before.iter_mut().zip(&self.r).zip(&root_weights) {
                moved += (w * (*b - r)).powi(2);
                *b = *r;
            }
            if (moved / self.r.len() as f64).sqrt() <= self.options.tolerance * scale {
                converged = true;
                break;
            }
        }
        let objective = if self.robust() {
            tau_scale(&self.r, self.options.scale_floor, &mut self.scratch)
        } else {
            self.r.iter().map(|r| r * r).sum()
        };
        debug_assert_eq!(theta.len(), p);
        let residuals = self.r.clone();
        Some(Descent { z, objective, scale, iterations, evaluations, converged, residuals })
    }
}

/// The weighted problem as the solver wants it, in inner variables.
struct Weighted<'a> {
    model: &'a dyn Model,
    map: &'a Bounds,
    theta: Vec<f64>,
    z: DVector<f64>,
    root_weights: &'a [f64],
    /// Residuals, and of which parameters: the solver begins and ends where they are known.
    known: RefCell<(Vec<f64>, Vec<f64>)>,
    /// Stands for a residual that is not finite, so that the step is refused, not the fit.
    cap: f64,
}

impl Weighted<'_> {
    /// Sees to it that the residuals are those of the parameters.
    fn know(&self) {
        let (at, r) = &mut *self.known.borrow_mut();
        if *at != self.theta {
            self.model.residuals(&self.theta, r);
            at.copy_from_slice(&self.theta);
        }
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Weighted<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, z: &DVector<f64>) {
        self.z.copy_from(z);
        self.map.outer_into(z.as_slice(), &mut self.theta);
    }

    fn params(&self) -> DVector<f64> {
        self.z.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.know();
        let mut out = DVector::from_column_slice(&self.known.borrow().1);
        for (r, w) in out.iter_mut().zip(self.root_weights) {
            // a row without weight has no information, whatever its residual has become
            *r = if *w == 0.0 {
                0.0
            } else if r.is_finite() {
                *r * w
            } else {
                self.cap
            };
        }
        Some(out)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let mut out = DMatrix::zeros(self.root_weights.len(), self.theta.len());
        self.model.jacobian(&self.theta, &mut out);
        for (j, mut column) in out.column_iter_mut().enumerate() {
            let slope = self.map.slope(j, self.z[j]);
            for (v, w) in column.iter_mut().zip(self.root_weights) {
                *v = if *w > 0.0 && v.is_finite() { *v * w * slope } else { 0.0 };
            }
        }
        Some(out)
    }
}

/// The samples that take part in the search.
fn search_rows(n: usize) -> Vec<usize> {
    let m = n.min(SEARCH_ROWS);
    // a golden-ratio shift within each of m equal stretches: even, but no fixed beat
    (0..m)
        .map(|k| {
            let (from, to) = (k * n / m, (k + 1) * n / m);
            from + ((k as f64 * 0.618_033_988_75).fract() * (to - from) as f64) as usize
        })
        .collect()
}

/// Tau-scale of some samples' residuals, as argmin wants it.
struct Objective<'a> {
    model: &'a dyn Model,
    map: &'a Bounds,
    floor: f64,
    rows: Vec<usize>,
}

impl<'a> Objective<'a> {
    fn new(model: &'a dyn Model, map: &'a Bounds, floor: f64, rows: Vec<usize>) -> Self {
        Objective { model, map, floor, rows }
    }

    fn value(&self, z: &[f64]) -> f64 {
        let mut r = vec![0.0; self.rows.len()];
        let mut scratch = vec![0.0; self.rows.len()];
        self.model.some_residuals(&self.map.outer(z), &self.rows, &mut r);
        if r.iter().all(|r| r.is_finite()) {
            tau_scale(&r, self.floor, &mut scratch)
        } else {
            f64::INFINITY
        }
    }
}

impl CostFunction for &Objective<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, z: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        Ok(self.value(z))
    }
}

/// Simplex search from `z`: `(tau-scale, where)`.
fn simplex(objective: &Objective<'_>, z: &[f64], iterations: u64) -> Option<(f64, Vec<f64>)> {
    let mut corners = vec![z.to_vec()];
    for j in 0..z.len() {
        let mut corner = z.to_vec();
        let (low, high) = objective.map.of(j);
        corner[j] += if low.is_finite() && high.is_finite() {
            // towards the middle
            if z[j] > 0.0 { -0.3 } else { 0.3 }
        } else {
            0.15 * z[j].abs().max(0.1)
        };
        corners.push(corner);
    }
    let solver = NelderMead::new(corners).with_sd_tolerance(1e-9).ok()?;
    let run = Executor::new(objective, solver).configure(|s| s.max_iters(iterations)).run().ok()?;
    let state = run.state();
    let value = state.get_best_cost();
    let z = state.get_best_param()?.clone();
    value.is_finite().then_some((value, z))
}
