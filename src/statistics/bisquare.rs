//! Robust linear regression: Tukey's bisquare by iteratively reweighted least squares.
//!
//! ```text
//! minimise  sum_i rho(r_i / s),   r = y - X b,   s = median|r| / 0.6745, renewed at each step
//! ```
//! With [`Options::leverage`] the residuals are first divided by `sqrt(1 - h_i)`, `h` the
//! leverages of least squares, as MATLAB `robustfit` does; without it the fit is that of R
//! `MASS::rlm(psi = psi.bisquare)` and statsmodels `RLM(TukeyBiweight)`.
//!
//! METHOD: the start. Two descents, one from least squares and one from a high-breakdown fit
//! ([`super::start`]), and the end point with the smaller S-scale is kept: the second
//! survives outliers that capture the first, the first is the better one where half of the
//! samples carry little information.
//!
//! Cost: O(n p²) per iteration, nothing is allocated within one.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::loss::{self, TUNING, mad_near, s_scale, weight};
use super::start;

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// Fewer samples than coefficients.
    #[error("{samples} samples cannot determine {coefficients} coefficients")]
    TooFew {
        /// Samples with positive weight.
        samples: usize,
        /// Coefficients asked for.
        coefficients: usize,
    },
    /// A column is not as long as the others.
    #[error("column {column} has {found} samples, expected {expected}")]
    Length {
        /// Its place, from 0.
        column: usize,
        found: usize,
        /// Length of `y`.
        expected: usize,
    },
    /// NaN or infinite input.
    #[error("sample {row} is not finite")]
    NotFinite {
        /// Its place, from 0.
        row: usize,
    },
    /// The columns do not determine all coefficients.
    #[error("column {column} is zero or a combination of the columns before it")]
    Collinear {
        /// Its place, from 0.
        column: usize,
    },
}

/// Where the descent starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// From least squares only, as other programs do.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    LeastSquares,
    /// From least squares and from a high-breakdown fit; the better end counts.
    Robust,
}

#[derive(Debug, Clone, Copy)]
pub struct Options<'a> {
    /// Divide residuals by `sqrt(1 - h)`.
    pub leverage: bool,
    /// Bisquare constant; infinite means least squares.
    pub tuning: f64,
    /// Smallest scale, unit of `y`: differences below it are never outliers.
    pub scale_floor: f64,
    /// Reweightings per descent.
    pub max_iterations: usize,
    /// Largest root-mean-square change of the fitted values, in scales, at rest.
    pub tolerance: f64,
    /// Relative precision (1 / variance) of each sample; not negative, zero leaves it out.
    pub prior_weights: Option<&'a [f64]>,
    pub start: Start,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Options {
            leverage: true,
            tuning: TUNING,
            scale_floor: 0.0,
            max_iterations: 100,
            tolerance: 1e-7,
            prior_weights: None,
            start: Start::Robust,
        }
    }
}

#[derive(Debug, Clone)]
pub struct Fit {
    /// One per column, unit of `y` over that of the column.
    pub coefficients: Vec<f64>,
    /// Bisquare weight of each sample, 0 to 1 (prior weights not included).
    pub weights: Vec<f64>,
    /// `y - X b`, unit of `y`.
    pub residuals: Vec<f64>,
    /// Slope of psi at each sample, for [`super::cluster_covariance`].
    pub psi_derivatives: Vec<f64>,
    /// Robust standard deviation of the residuals, unit of `y` (at prior weight 1).
    pub scale: f64,
    /// Reweightings of the descent that was kept.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub iterations: usize,
    /// Whether it came to rest.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub converged: bool,
    /// Share of samples with zero weight.
    pub outlier_fraction: f64,
    /// Weighted share of the variance about the mean that is explained.
    pub r_squared: f64,
}

/// Fits `y = sum_j b_j x_j`; `x` are the columns, an intercept is a column of ones.
///
/// # Errors
/// Columns of different length, samples that are not finite, too few samples, collinear
/// columns.
pub fn linear(x: &[&[f64]], y: &[f64], options: &Options<'_>) -> Result<Fit, Error> {
    check(x, y, options.prior_weights)?;
    let mut descent = Descent::new(x, y, options)?;
    let from_least_squares = descent.run(None, None)?;
    let robust = options.tuning.is_finite() && options.start == Start::Robust;
    let candidate = if robust {
        let root: Option<Vec<f64>> =
            options.prior_weights.map(|w| w.iter().map(|w| w.sqrt()).collect());
        start::coefficients(x, y, root.as_deref())
    } else {
        None
    };
    let chosen = match candidate.map(|b| descent.run(Some(b), Some(&from_least_squares))) {
        Some(Ok(other)) if descent.is_better(&other, &from_least_squares) => other,
        _ => from_least_squares,
    };
    Ok(descent.finish(chosen))
}

fn check(x: &[&[f64]], y: &[f64], prior: Option<&[f64]>) -> Result<(), Error> {
    let expected = y.len();
    let columns = x.iter().copied().chain(prior);
    for (column, values) in columns.clone().enumerate() {
        if values.len() != expected {
            return Err(Error::Length { column, found: values.len(), expected });
        }
    }
    for values in columns.chain([y]) {
        if let Some(row) = values.iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite { row });
        }
    }
    let samples = prior.map_or(expected, |w| w.iter().filter(|w| **w > 0.0).count());
    if samples < x.len() || x.is_empty() {
        return Err(Error::TooFew { samples, coefficients: x.len() });
    }
    Ok(())
}

/// Where one descent ended.
struct End {
    b: Vec<f64>,
    iterations: usize,
    converged: bool,
    scale: f64,
}

/// The data and the buffers of all descents.
struct Descent<'a> {
    x: &'a [&'a [f64]],
    y: &'a [f64],
    options: &'a Options<'a>,
    /// Factor that standardises a residual before the scale: sqrt(prior) / sqrt(1 - h).
    factor: Vec<f64>,
    /// Smallest scale of the residuals.
    floor: f64,
    residuals: Vec<f64>,
    standard: Vec<f64>,
    weights: Vec<f64>,
    scratch: Vec<f64>,
    normal: DMatrix<f64>,
    right: DVector<f64>,
    /// Root of the diagonal of the unweighted normal matrix: the columns' sizes.
    size: Vec<f64>,
}

impl<'a> Descent<'a> {
    fn new(x: &'a [&'a [f64]], y: &'a [f64], options: &'a Options<'a>) -> Result<Self, Error> {
        let (n, p) = (y.len(), x.len());
        let weights = options.prior_weights.map_or_else(|| vec![1.0; n], <[f64]>::to_vec);
        let mut this = Descent {
            x,
            y,
            options,
            factor: weights.iter().map(|w| w.sqrt()).collect(),
            floor: 0.0,
            residuals: vec![0.0; n],
            standard: vec![0.0; n],
            weights,
            scratch: vec![0.0; n],
            normal: DMatrix::zeros(p, p),
            right: DVector::zeros(p),
            size: vec![1.0; p],
        };
        this.floor = options.scale_floor.max(1e-9 * this.spread_of_y());
        let cholesky = this.factorise()?;
        if options.leverage {
            this.adjust_for_leverage(&cholesky);
        }
        Ok(this)
    }

    /// Weighted standard deviation of `y`.
    fn spread_of_y(&self) -> f64 {
        let sum: f64 = self.weights.iter().sum();
        let mean = dot(&self.weights, self.y) / sum;
        let square: f64 =
            self.weights.iter().zip(self.y).map(|(w, y)| w * (y - mean).powi(2)).sum();
        (square / sum).sqrt().max(mean.abs()).max(f64::MIN_POSITIVE)
    }

    /// Cholesky factor of `X' W X`, columns scaled to unit size.
    fn factorise(&mut self) -> Result<Cholesky<f64, Dyn>, Error> {
        let p = self.x.len();
        for a in 0..p {
            for b in 0..=a {
                let sum = triple(&self.weights, self.x[a], self.x[b]);
                self.normal[(a, b)] = sum;
                self.normal[(b, a)] = sum;
            }
            self.size[a] = self.normal[(a, a)].sqrt();
            if self.size[a].is_nan() || self.size[a] == 0.0 {
                return Err(Error::Collinear { column: a });
            }
        }
        for a in 0..p {
            for b in 0..p {
                self.normal[(a, b)] /= self.size[a] * self.size[b];
            }
        }
        let small = |c: &Cholesky<f64, Dyn>| (0..p).find(|&a| c.l_dirty()[(a, a)] < 1e-7);
        match Cholesky::new(self.normal.clone()) {
            Some(c) => match small(&c) {
                None => Ok(c),
                Some(column) => Err(Error::Collinear { column }),
            },
            None => Err(Error::Collinear { column: p - 1 }),
        }
    }

    /// Divides the factors by `sqrt(1 - h)`; a sample that is its own fit keeps 1 - h = 1e-6.
    fn adjust_for_leverage(&mut self, cholesky: &Cholesky<f64, Dyn>) {
        let inverse = cholesky.inverse();
        let p = self.x.len();
        for (i, factor) in self.factor.iter_mut().enumerate() {
            let mut h = 0.0;
            for a in 0..p {
                for b in 0..p {
                    h +=
                        self.x[a][i] / self.size[a] * inverse[(a, b)] * self.x[b][i] / self.size[b];
                }
            }
            h *= self.weights[i];
            *factor /= (1.0 - h).max(1e-6).sqrt();
        }
    }

    fn residuals(&mut self, b: &[f64]) {
        self.residuals.copy_from_slice(self.y);
        for (column, &b) in self.x.iter().zip(b) {
            for (r, v) in self.residuals.iter_mut().zip(*column) {
                *r -= b * v;
            }
        }
        for (s, (r, f)) in self.standard.iter_mut().zip(self.residuals.iter().zip(&self.factor)) {
            *s = r * f;
        }
    }

    /// Scale of the residuals; `guess` is one that may be near.
    fn scale(&mut self, guess: f64) -> f64 {
        let p = if self.options.leverage { self.x.len() } else { 0 };
        mad_near(&self.standard, p, guess, &mut self.scratch).max(self.floor)
    }

    fn reweigh(&mut self, scale: f64) {
        let c = self.options.tuning;
        for (w, s) in self.weights.iter_mut().zip(&self.standard) {
            *w = weight(s / scale, c);
        }
        if let Some(prior) = self.options.prior_weights {
            for (w, p) in self.weights.iter_mut().zip(prior) {
                *w *= p;
            }
        }
    }

    /// One solve: moves `b` and returns the root mean square change of the fitted values.
    fn step(&mut self, b: &mut [f64]) -> Result<f64, Error> {
        let cholesky = self.factorise()?;
        for (a, column) in self.x.iter().enumerate() {
            self.right[a] = triple(&self.weights, column, &self.residuals) / self.size[a];
        }
        let right = self.right.clone();
        cholesky.solve_mut(&mut self.right);
        let moved = right.dot(&self.right).max(0.0);
        for (a, b) in b.iter_mut().enumerate() {
            *b += self.right[a] / self.size[a];
        }
        let sum: f64 = self.weights.iter().sum();
        Ok((moved / sum).sqrt())
    }

    /// Reweights until the fit rests, from `b` or from least squares; or until it is where
    /// another descent ended: the rest of the way is known then.
    fn run(&mut self, b: Option<Vec<f64>>, known: Option<&End>) -> Result<End, Error> {
        let mut b = match b {
            Some(b) => {
                self.residuals(&b);
                b
            }
            None => {
                match self.options.prior_weights {
                    Some(prior) => self.weights.copy_from_slice(prior),
                    None => self.weights.fill(1.0),
                }
                let mut b = vec![0.0; self.x.len()];
                self.residuals(&b);
                for _ in 0..2 {
                    // the second solve only mends the rounding of the first
                    self.step(&mut b)?;
                    self.residuals(&b);
                }
                b
            }
        };
        let mut scale = self.scale(f64::NAN);
        let (mut iterations, mut converged) = (0, self.options.tuning.is_infinite());
        while !converged && iterations < self.options.max_iterations {
            self.reweigh(scale);
            let moved = self.step(&mut b)?;
            self.residuals(&b);
            scale = self.scale(scale);
            iterations += 1;
            converged = moved <= self.options.tolerance * scale
                || known.is_some_and(|end| self.are_one(&b, end));
        }
        Ok(End { b, iterations, converged, scale })
    }

    /// Whether the fitted values of `a` and `end` differ by less than a thousandth of the scale.
    fn are_one(&self, a: &[f64], end: &End) -> bool {
        let apart = a.iter().zip(&end.b).zip(&self.size);
        let apart: f64 = apart.map(|((a, b), size)| ((a - b) * size).abs()).sum();
        apart <= 1e-3 * end.scale * (self.y.len() as f64).sqrt()
    }

    /// Whether `a` ended elsewhere than `b`, and at a smaller S-scale.
    fn is_better(&mut self, a: &End, b: &End) -> bool {
        if self.are_one(&a.b, b) {
            return false;
        }
        self.residuals(&a.b);
        let of_a = s_scale(&self.standard, &mut self.scratch);
        self.residuals(&b.b);
        of_a < s_scale(&self.standard, &mut self.scratch)
    }

    fn finish(mut self, end: End) -> Fit {
        self.residuals(&end.b);
        self.reweigh(end.scale);
        let c = self.options.tuning;
        let weights: Vec<f64> = self.standard.iter().map(|s| weight(s / end.scale, c)).collect();
        let psi_derivatives =
            self.standard.iter().map(|s| loss::psi_derivative(s / end.scale, c)).collect();
        let n = self.y.len() as f64;
        let outlier_fraction = weights.iter().filter(|w| **w == 0.0).count() as f64 / n;
        let sum: f64 = self.weights.iter().sum();
        let mean = dot(&self.weights, self.y) / sum;
        let rest = triple(&self.weights, &self.residuals, &self.residuals);
        let all: f64 = self.weights.iter().zip(self.y).map(|(w, y)| w * (y - mean).powi(2)).sum();
        Fit {
            coefficients: end.b,
            weights,
            residuals: self.residuals,
            psi_derivatives,
            scale: end.scale,
            iterations: end.iterations,
            converged: end.converged,
            outlier_fraction,
            r_squared: if all > 0.0 { 1.0 - rest / all } else { f64::NAN },
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Sum of `w a b`, in four lanes so that the compiler can vectorise it.
fn triple(w: &[f64], a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (w4, wr) = w.as_chunks::<4>();
    let (a4, ar) = a.as_chunks::<4>();
    let (b4, br) = b.as_chunks::<4>();
    for ((w, a), b) in w4.iter().zip(a4).zip(b4) {
        for k in 0..4 {
            lanes[k] += w[k] * a[k] * b[k];
        }
    }
    let rest: f64 = wr.iter().zip(ar).zip(br).map(|((w, a), b)| w * a * b).sum();
    lanes.iter().sum::<f64>() + rest
}
