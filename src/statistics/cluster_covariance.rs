//! The covariance of a fit whose samples are correlated within manoeuvres.
//!
//! Samples of one manoeuvre share the same biases, so they count almost as one; only the
//! manoeuvres are independent, and they are few. The sandwich below sums scores per manoeuvre,
//! inflates each by what the fit has adapted to it, and gives the degrees of freedom of the result
//! for each coefficient:
//!
//! ```text
//! A_g = J_g' W J_g    u_g = J_g' W r_g    M = (sum A_g)^-1    B_g = M^½ A_g M^½
//! CR3:  e_g = M^-½ (1 - B_g)^-1 M^½ u_g      leave one manoeuvre out, exact for a linear fit
//! CR2:  e_g = M^-½ (1 - B_g)^-½ M^½ u_g      unbiased for equal and independent errors
//! V = P (sum_g e_g e_g') P,   P = (J' psi' J)^-1; without robust weights P = M
//! ```
//! `W` are the weights of the fit, `psi'` the slopes of its psi: a bisquare fit reacts to a
//! change by `psi'`, not by its weights. Only p x p matrices per manoeuvre are needed.
//!
//! The degrees of freedom are Satterthwaite's: those of the chi-square with the mean and the
//! variance that `c' V c` has under a working model. METHOD: two working models, independent
//! errors (Bell & McCaffrey) and errors with a common part per manoeuvre (Imbens & Kolesár),
//! whose share is estimated from the residuals; the smaller figure counts. With them CR2 covers
//! 95 to 98 % in the simulation of `tests/it/fit.rs` (6, 12 and 40 unequal manoeuvres), CR3
//! more than it should and with intervals up to 1.7 times as wide; CR2 is the default.
//!
//! Source: Bell & McCaffrey (2002), Survey Methodology 28; Imbens & Kolesár (2016), REStat 98;
//! Pustejovsky & Tipton (2018), JBES 36; jackknife: MacKinnon, Nielsen & Webb (2023), J. Appl.
//! Econometrics 38.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Smallest part of a direction's information that the other manoeuvres must bring. Below it
/// one manoeuvre alone determines the direction: its residuals there are zero by construction,
/// no sandwich can see its variance, and what depends on it gets no degrees of freedom.
const FLOOR: f64 = 1e-5;

/// Share of a coefficient's variance that may lie in such directions.
const SINGLE_CLUSTER_SHARE: f64 = 1e-3;

/// Why there is no covariance.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// One manoeuvre has no spread.
    #[error("{0} manoeuvre(s): at least two are needed to see how they differ")]
    TooFew(usize),
    /// The inputs do not belong together.
    #[error("{what}: {found} values, expected {expected}")]
    Length { what: &'static str, found: usize, expected: usize },
    /// The Jacobian does not determine all coefficients, or is not finite.
    #[error("the samples do not determine all coefficients")]
    Singular,
}

/// Correction of a manoeuvre's score for what the fit has adapted to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Correction {
    /// Bias-reduced linearisation.
    Cr2,
    /// Leave one manoeuvre out (jackknife).
    Cr3,
}

/// Residuals, weights and derivatives of a fit; everything as long as the Jacobian has rows.
#[derive(Debug, Clone, Copy)]
pub struct Scores<'a> {
    /// Derivative of the residuals, or of the model (the sign does not matter), by each
    /// coefficient; samples x p.
    pub jacobian: &'a DMatrix<f64>,
    /// Measured minus model.
    pub residuals: &'a [f64],
    /// Weights of the fit, prior ones included.
    pub weights: &'a [f64],
    /// Slope of psi at each sample, times the prior weight; `None` for weights that do not
    /// depend on the residuals.
    pub psi_derivatives: Option<&'a [f64]>,
    /// Which manoeuvre each sample is of; any numbers.
    pub clusters: &'a [usize],
}

/// A covariance and what it rests on.
#[derive(Debug, Clone)]
pub struct ClusterCovariance {
    /// p x p, units of the coefficients.
    pub covariance: DMatrix<f64>,
    /// Degrees of freedom of each coefficient's variance; 0 where one manoeuvre alone determines
    /// it; the covariance is then without meaning.
    pub dof: Vec<f64>,
    pub n_clusters: usize,
    /// Data for [`Self::contrast`].
    shape: Option<Shape>,
}

/// Per manoeuvre: what its score adds, and its share of the information.
#[derive(Debug, Clone)]
struct Shape {
    bread: DMatrix<f64>,
    /// Directions that one manoeuvre alone determines, in units of the coefficients' spread.
    lonely: Vec<DVector<f64>>,
    parts: Vec<Part>,
    /// Variance of the part common to a manoeuvre over that of the independent part.
    common: f64,
}

#[derive(Debug, Clone)]
struct Part {
    /// `A_g`.
    information: DMatrix<f64>,
    /// `K_g`: the coefficients' change per score.
    response: DMatrix<f64>,
    /// `J_g' W 1`: what a common error does.
    common: DVector<f64>,
}

impl ClusterCovariance {
    /// Standard error and degrees of freedom of `sum_j c_j b_j`.
    pub fn contrast(&self, c: &[f64]) -> (f64, f64) {
        let c = DVector::from_column_slice(c);
        let variance = (&self.covariance * &c).dot(&c).max(0.0);
        let dof = match &self.shape {
            Some(shape) => shape.dof(&c).min(self.n_clusters as f64 - 1.0),
            None => self.n_clusters as f64 - 1.0,
        };
        (variance.sqrt(), dof)
    }

    /// Of two coefficients of which the first is exact, and the second has the only one of `second` where that is known.
    pub(crate) fn with_exact(second: Option<&Self>, n_clusters: usize) -> Self {
        let (variance, dof) = second.map_or((0.0, 0.0), |c| (c.covariance[(0, 0)], c.dof[0]));
        let mut covariance = DMatrix::zeros(2, 2);
        covariance[(1, 1)] = variance;
        let of_first = n_clusters.saturating_sub(1) as f64;
        ClusterCovariance { covariance, dof: vec![of_first, dof], n_clusters, shape: None }
    }

    /// Standard error of each coefficient.
    pub fn std_errors(&self) -> Vec<f64> {
        self.covariance.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect()
    }
}

/// The CR2 sandwich, the one whose intervals are honest for few unequal manoeuvres.
///
/// # Errors
/// Inputs of different length, fewer than two manoeuvres, a singular Jacobian.
pub fn sandwich(scores: &Scores<'_>) -> Result<ClusterCovariance, Error> {
    sandwich_with(scores, Correction::Cr2)
}

/// As [`sandwich`], with the correction of choice.
///
/// # Errors
/// As [`sandwich`].
pub(crate) fn sandwich_with(
    scores: &Scores<'_>,
    correction: Correction,
) -> Result<ClusterCovariance, Error> {
    let sums = Sums::of(scores)?;
    let p = scores.jacobian.ncols();
    let n_clusters = sums.information.len();
    let total = sums.information.iter().fold(DMatrix::zeros(p, p), |a, b| a + b);
    // coefficients of unlike size: work in units that make the diagonal one
    let unit = DVector::from_fn(p, |j, _| 1.0 / total[(j, j)].sqrt());
    if !unit.iter().all(|u| u.is_finite() && *u > 0.0) {
        return Err(Error::Singular);
    }
    let units = DMatrix::from_diagonal(&unit);
    let (half, minus_half) = roots(&(&units * &total * &units))?;
    let inverse = &units * &half * &half * &units;
    let bread = match &sums.slope {
        Some(slope) => reaction(slope, &sums, &inverse),
        None => inverse.clone(),
    };

    let mut meat = DMatrix::zeros(p, p);
    let mut parts = Vec::with_capacity(n_clusters);
    let mut lonely = Vec::new();
    for g in 0..n_clusters {
        let share = &half * &units * &sums.information[g] * &units * &half;
        let eigen = SymmetricEigen::new(share);
        let gain = eigen.eigenvalues.map(|b| {
            let rest = (1.0 - b).max(FLOOR);
            match correction {
                Correction::Cr3 => 1.0 / rest,
                Correction::Cr2 => 1.0 / rest.sqrt(),
            }
        });
        let inflate =
            &eigen.eigenvectors * DMatrix::from_diagonal(&gain) * eigen.eigenvectors.transpose();
        for (k, _) in eigen.eigenvalues.iter().enumerate().filter(|(_, b)| 1.0 - **b < FLOOR) {
            lonely.push(&units * &half * eigen.eigenvectors.column(k));
        }
        // u = D^-1 u', u' the score in the new units
        let score_gain = unscale(&(&minus_half * inflate * &half), &unit);
        let response = &bread * score_gain;
        let moved = &response * &sums.score[g];
        meat += &moved * moved.transpose();
        parts.push(Part {
            information: sums.information[g].clone(),
            response,
            common: sums.common[g].clone(),
        });
    }
    let shape = Shape { bread: inverse, lonely, parts, common: sums.common_share };
    let ceiling = n_clusters as f64 - 1.0;
    let dof = (0..p)
        .map(|j| shape.dof(&DVector::from_fn(p, |k, _| f64::from(j == k))).min(ceiling))
        .collect();
    Ok(ClusterCovariance { covariance: meat, dof, n_clusters, shape: Some(shape) })
}

/// `D^-1 m D`, `D` the diagonal of `unit`.
fn unscale(m: &DMatrix<f64>, unit: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] / unit[i] * unit[j])
}

/// Root of the inverse and of a positive definite matrix.
fn roots(m: &DMatrix<f64>) -> Result<(DMatrix<f64>, DMatrix<f64>), Error> {
    let eigen = SymmetricEigen::new(m.clone());
    let largest = eigen.eigenvalues.max();
    if !(largest.is_finite() && eigen.eigenvalues.min() > 1e-13 * largest) {
        return Err(Error::Singular);
    }
    let v = &eigen.eigenvectors;
    let with =
        |f: fn(f64) -> f64| v * DMatrix::from_diagonal(&eigen.eigenvalues.map(f)) * v.transpose();
    Ok((with(|x| 1.0 / x.sqrt()), with(f64::sqrt)))
}

/// Inverse of the summed psi slopes. Where a few odd samples make it indefinite or larger
/// than can be, the weights' inverse times the mean ratio of weight and slope.
fn reaction(slope: &DMatrix<f64>, sums: &Sums, inverse: &DMatrix<f64>) -> DMatrix<f64> {
    let ratio = sums.mean_ratio.clamp(1.0, 4.0);
    let fallback = || inverse * ratio;
    let Some(cholesky) = slope.clone().cholesky() else { return fallback() };
    let candidate = cholesky.inverse();
    let sound =
        (0..slope.nrows()).all(|j| (0.8..8.0).contains(&(candidate[(j, j)] / inverse[(j, j)])));
    if sound { candidate } else { fallback() }
}

/// Sums over each manoeuvre's samples.
struct Sums {
    information: Vec<DMatrix<f64>>,
    score: Vec<DVector<f64>>,
    common: Vec<DVector<f64>>,
    slope: Option<DMatrix<f64>>,
    mean_ratio: f64,
    common_share: f64,
}

impl Sums {
    fn of(s: &Scores<'_>) -> Result<Self, Error> {
        let (n, p) = s.jacobian.shape();
        let lengths = [
            ("residuals", s.residuals.len()),
            ("weights", s.weights.len()),
            ("clusters", s.clusters.len()),
            ("psi derivatives", s.psi_derivatives.map_or(n, <[f64]>::len)),
        ];
        if let Some(&(what, found)) = lengths.iter().find(|(_, found)| *found != n) {
            return Err(Error::Length { what, found, expected: n });
        }
        let mut names: Vec<usize> =
            (0..n).filter(|&i| s.weights[i] > 0.0).map(|i| s.clusters[i]).collect();
        names.sort_unstable();
        names.dedup();
        if names.len() < 2 {
            return Err(Error::TooFew(names.len()));
        }
        let count = names.len();
        let mut information = vec![DMatrix::zeros(p, p); count];
        let mut score = vec![DVector::zeros(p); count];
        let mut common = vec![DVector::zeros(p); count];
        let mut slope = DMatrix::zeros(p, p);
        // of the whitened residuals: sums, sums of squares, sums of weights, of their squares
        let mut white = vec![[0.0_f64; 3]; count];
        let mut row = vec![0.0; p];
        let (mut sum_weight, mut sum_slope) = (0.0, 0.0);
        let mut g = 0;
        for i in 0..n {
            let (w, r) = (s.weights[i], s.residuals[i]);
            let derivative = s.psi_derivatives.map_or(w, |d| d[i]);
            for (j, v) in row.iter_mut().enumerate() {
                *v = s.jacobian[(i, j)];
            }
            sum_slope += derivative;
            if derivative != 0.0 {
                for a in 0..p {
                    for b in 0..=a {
                        slope[(a, b)] += derivative * row[a] * row[b];
                    }
                }
            }
            if w == 0.0 {
                continue;
            }
            sum_weight += w;
            if names[g] != s.clusters[i] {
                g = names.binary_search(&s.clusters[i]).map_err(|_| Error::Singular)?;
            }
            for a in 0..p {
                score[g][a] += w * r * row[a];
                common[g][a] += w * row[a];
                for b in 0..=a {
                    information[g][(a, b)] += w * row[a] * row[b];
                }
            }
            white[g][0] += w * r;
            white[g][1] += w * r * r;
            white[g][2] += w;
        }
        for m in information.iter_mut().chain([&mut slope]) {
            m.fill_upper_triangle_with_lower_triangle();
        }
        Ok(Sums {
            information,
            score,
            common,
            slope: s.psi_derivatives.map(|_| slope),
            mean_ratio: if sum_slope > 0.0 { sum_weight / sum_slope } else { 1.0 },
            common_share: common_share(&white),
        })
    }
}

/// Variance of what a manoeuvre's residuals have in common over that of the rest, from the
/// spread of the manoeuvres' means (analysis of variance, unequal sizes).
fn common_share(white: &[[f64; 3]]) -> f64 {
    let total: f64 = white.iter().map(|w| w[1]).sum();
    let between: f64 = white.iter().map(|[s, _, w]| s * s / w).sum();
    // weights are about one each, so they stand for numbers of samples
    let samples: f64 = white.iter().map(|w| w[2]).sum();
    let groups = white.len() as f64;
    let within = (total - between) / (samples - groups).max(1.0);
    let size = samples / groups;
    let common = (between / groups - within) / size;
    if within > 0.0 { (common / within).clamp(0.0, 1e3) } else { 0.0 }
}

impl Shape {
    /// Satterthwaite's degrees of freedom of the variance of `c' b`.
    fn dof(&self, c: &DVector<f64>) -> f64 {
        let spread = (&self.bread * c).dot(c);
        let alone: f64 = self.lonely.iter().map(|v| v.dot(c).powi(2)).sum();
        if alone.is_nan() || alone > SINGLE_CLUSTER_SHARE * spread {
            return 0.0;
        }
        let independent = self.dof_with(c, 0.0);
        if self.common > 0.0 { independent.min(self.dof_with(c, self.common)) } else { independent }
    }

    /// With `s_g = c' K_g u_g` a linear form of the errors: `tr(G)² / tr(G²)`, `G` the
    /// covariance of all `s_g`, errors being independent plus `common` times a shared one.
    ///
    /// ```text
    /// d_g = K_g' c,  a_g = A_g d_g,  t_g = d_g' c_g,  v_g = (a_g, t_g c_g),  c_g = J_g' W 1
    /// G = diag(d_g' a_g + common t_g²) + V K V'
    /// K = [ -B + common B S B   -common B ]        B the bread, S = sum c_g c_g'
    ///     [      -common B           0    ]
    /// ```
    /// Diagonal plus low rank: both traces cost O(G p²), and no G x G matrix is ever made.
    fn dof_with(&self, c: &DVector<f64>, common: f64) -> f64 {
        let p = c.len();
        let width = if common > 0.0 { 2 * p } else { p };
        let mut core = DMatrix::zeros(width, width);
        core.view_mut((0, 0), (p, p)).copy_from(&-&self.bread);
        if common > 0.0 {
            let mut sum = DMatrix::zeros(p, p);
            self.parts.iter().for_each(|part| sum.ger(1.0, &part.common, &part.common, 1.0));
            let whole = common * &self.bread * sum * &self.bread - &self.bread;
            core.view_mut((0, 0), (p, p)).copy_from(&whole);
            let side = -common * &self.bread;
            core.view_mut((0, p), (p, p)).copy_from(&side);
            core.view_mut((p, 0), (p, p)).copy_from(&side);
        }
        let mut gram = DMatrix::<f64>::zeros(width, width);
        let (mut d, mut v) = (vec![0.0; p], vec![0.0; width]);
        let (mut trace, mut square) = (0.0, 0.0);
        for part in &self.parts {
            for (j, d) in d.iter_mut().enumerate() {
                *d = (0..p).map(|k| part.response[(k, j)] * c[k]).sum();
            }
            for j in 0..p {
                v[j] = (0..p).map(|k| part.information[(j, k)] * d[k]).sum();
            }
            let mut own: f64 = d.iter().zip(&v).map(|(d, a)| d * a).sum();
            if common > 0.0 {
                let shared: f64 = d.iter().zip(part.common.iter()).map(|(d, t)| d * t).sum();
                own += common * shared * shared;
                for j in 0..p {
                    v[p + j] = shared * part.common[j];
                }
            }
            let mut inner = 0.0;
            for j in 0..width {
                for k in 0..width {
                    gram[(k, j)] += v[k] * v[j];
                    inner += core[(k, j)] * v[k] * v[j];
                }
            }
            trace += own + inner;
            square += own * (own + 2.0 * inner);
        }
        let turned = core * gram;
        square += turned.dot(&turned.transpose());
        if square > 0.0 { trace * trace / square } else { f64::NAN }
    }
}

#[cfg(test)]
mod tests;
