//! A linear bisquare fit together with what its manoeuvres say about it.

use nalgebra::{DMatrix, DVector};

use super::bisquare::{self, Options};
use super::cluster_covariance::{ClusterCovariance, Scores, sandwich};
use super::loss::robust_spread;

/// Share of the average manoeuvre's information that one needs to speak for itself.
const OWN_VOICE: f64 = 0.1;

/// How a fit was reached and how far it can be trusted.
#[derive(Debug, Clone, Default)]
pub struct Quality {
    /// Manoeuvres.
    pub n_clusters: usize,
    /// Samples.
    pub n_samples: usize,
    /// Robust standard deviation of the residuals.
    pub scale: f64,
    /// Share of zero weights.
    pub outlier_fraction: f64,
    /// Share of variance explained.
    pub r_squared: f64,
}

/// Coefficients with covariance from clusters and dispersion between them.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The coefficients.
    pub theta: Vec<f64>,
    /// Robust weights of the samples: frozen when inputs are varied.
    pub weights: Vec<f64>,
    /// From manoeuvre clusters; `None` where there are too few.
    pub covariance: Option<ClusterCovariance>,
    /// Robust spread between manoeuvres, each alone with the other coefficients held.
    pub dispersion: Vec<Option<f64>>,
    /// Of the fit.
    pub quality: Quality,
}

/// Number of different manoeuvres; samples of one are contiguous or share their number.
pub fn count(clusters: &[usize]) -> usize {
    let mut seen: Vec<usize> = clusters.to_vec();
    seen.sort_unstable();
    seen.dedup();
    seen.len()
}

/// Fits robustly; `None` where the samples cannot carry the columns. Residuals well below
/// `floor` (unit of `y`) are never outliers, however small the others are: a clean ride must not
/// lose its most telling samples to the small imperfections of the algebra.
pub fn fit(columns: &[&[f64]], y: &[f64], clusters: &[usize], floor: f64) -> Option<Fitted> {
    let options = Options { scale_floor: floor, ..Options::default() };
    let fit = bisquare::linear(columns, y, &options).ok()?;
    let jacobian = DMatrix::from_fn(y.len(), columns.len(), |i, j| columns[j][i]);
    let covariance = sandwich(&Scores {
        jacobian: &jacobian,
        residuals: &fit.residuals,
        weights: &fit.weights,
        psi_derivatives: Some(&fit.psi_derivatives),
        clusters,
    })
    .ok();
    let dispersion =
        dispersion(&jacobian, &fit.residuals, &fit.weights, clusters, &fit.coefficients);
    Some(Fitted {
        theta: fit.coefficients,
        covariance,
        dispersion,
        quality: Quality {
            n_clusters: count(clusters),
            n_samples: y.len(),
            scale: fit.scale,
            outlier_fraction: fit.outlier_fraction,
            r_squared: fit.r_squared,
        },
        weights: fit.weights,
    })
}

/// Least squares with weights that are given: how a fit follows a small change of its inputs.
pub fn refit(columns: &[&[f64]], y: &[f64], weights: &[f64]) -> Option<Vec<f64>> {
    let p = columns.len();
    let mut a = DMatrix::zeros(p, p);
    let mut b = DVector::zeros(p);
    for j in 0..p {
        for k in 0..=j {
            let sum: f64 =
                weights.iter().zip(columns[j]).zip(columns[k]).map(|((w, x), z)| w * x * z).sum();
            a[(j, k)] = sum;
            a[(k, j)] = sum;
        }
        b[j] = weights.iter().zip(columns[j]).zip(y).map(|((w, x), y)| w * x * y).sum();
    }
    Some(a.cholesky()?.solve(&b).iter().copied().collect())
}

/// Robust spread between manoeuvres of each coefficient: `b_j` of a manoeuvre alone, the others
/// held at the common fit. Manoeuvres that hardly excite it do not count.
pub fn dispersion(
    jacobian: &DMatrix<f64>,
    residuals: &[f64],
    weights: &[f64],
    clusters: &[usize],
    theta: &[f64],
) -> Vec<Option<f64>> {
    let last = clusters.iter().copied().max().unwrap_or(0);
    (0..theta.len())
        .map(|j| {
            let mut pull = vec![0.0; last + 1];
            let mut information = vec![0.0; last + 1];
            for (i, &g) in clusters.iter().enumerate() {
                let x = jacobian[(i, j)];
                pull[g] += weights[i] * x * residuals[i];
                information[g] += weights[i] * x * x;
            }
            let heard: Vec<f64> = information.iter().copied().filter(|&a| a > 0.0).collect();
            let enough = OWN_VOICE * heard.iter().sum::<f64>() / heard.len().max(1) as f64;
            let alone: Vec<f64> = (0..=last)
                .filter(|&g| information[g] > enough && information[g] > 0.0)
                .map(|g| theta[j] + pull[g] / information[g])
                .collect();
            robust_spread(&alone)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refit_with_the_same_inputs_changes_nothing() {
        let x: Vec<f64> = (0..60).map(|i| f64::from(i) * 0.1).collect();
        let ones = vec![1.0; 60];
        let y: Vec<f64> = x
            .iter()
            .enumerate()
            .map(|(i, x)| 2.0 + 3.0 * x + 0.01 * ((i * 7 % 11) as f64))
            .collect();
        let clusters: Vec<usize> = (0..60).map(|i| i / 6).collect();
        let fit = fit(&[&ones, &x], &y, &clusters, 0.0).expect("fit");
        let again = refit(&[&ones, &x], &y, &fit.weights).expect("refit");
        // leverage-adjusted weights are not exactly at their own fixed point
        assert!((again[1] - fit.theta[1]).abs() < 1e-6, "{again:?} {:?}", fit.theta);
        assert_eq!(fit.quality.n_clusters, 10);
    }
}
