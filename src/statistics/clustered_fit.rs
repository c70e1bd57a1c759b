//! A linear bisquare fit with its covariance from clusters of correlated samples (manoeuvres).

use nalgebra::{DMatrix, DVector};

use super::bisquare::{self, Options};
use super::cluster_covariance::{ClusterCovariance, Scores, sandwich};
use super::loss::robust_spread;

/// Least share of the average cluster's information about a coefficient that a cluster needs to
/// count for the spread between clusters.
const MIN_INFORMATION: f64 = 0.1;

/// How a fit was reached and how far it can be trusted.
#[derive(Debug, Clone, Default)]
pub struct Quality {
    /// Clusters that took part.
    pub n_clusters: usize,
    /// Samples that took part.
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
    /// The coefficients, in the order of the columns.
    pub theta: Vec<f64>,
    /// Robust weights of the samples; [`refit`] holds them.
    pub weights: Vec<f64>,
    /// From clusters; `None` where there are too few.
    pub covariance: Option<ClusterCovariance>,
    /// Robust spread between clusters, see [`dispersion`].
    pub dispersion: Vec<Option<f64>>,
    pub quality: Quality,
}

/// How well a fit knows one quantity.
#[derive(Debug, Clone, Default)]
pub struct Uncertainty {
    /// From clusters, in the unit of the quantity squared; NaN where it is not known.
    pub variance: f64,
    /// Degrees of freedom of the variance; 0 where it is not known.
    pub dof: f64,
    /// Robust spread between clusters, in the unit of the quantity.
    pub dispersion: Option<f64>,
    /// Of the fit; no samples where nothing was fitted.
    pub quality: Quality,
}

impl Fitted {
    /// How well a coefficient times `scale` is known.
    pub fn uncertainty(&self, coefficient: usize, scale: f64) -> Uncertainty {
        let j = coefficient;
        let (variance, dof) =
            self.covariance.as_ref().map_or((f64::NAN, 0.0), |c| (c.covariance[(j, j)], c.dof[j]));
        Uncertainty {
            variance: variance * scale * scale,
            dof,
            dispersion: self.dispersion[j].map(|d| d * scale),
            quality: self.quality.clone(),
        }
    }
}

/// Number of different clusters among the samples' cluster numbers.
pub(crate) fn count(clusters: &[usize]) -> usize {
    let mut seen: Vec<usize> = clusters.to_vec();
    seen.sort_unstable();
    seen.dedup();
    seen.len()
}

/// Fits `y = columns b` robustly; `None` where the samples do not determine the columns. Residuals
/// well below `floor` (unit of `y`) are never outliers, however small the others are: a clean ride
/// must not lose its most informative samples to the small imperfections of the algebra.
pub(crate) fn fit(columns: &[&[f64]], y: &[f64], clusters: &[usize], floor: f64) -> Option<Fitted> {
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

/// As [`fit`], of rows that are not known equally well: each is multiplied by its scale, one over what it scatters
/// more than the best. Scales of nothing are all one. Weights are those of the rows as they are given.
pub(crate) fn fit_scaled(
    columns: &[&[f64]],
    y: &[f64],
    scales: &[f64],
    clusters: &[usize],
    floor: f64,
) -> Option<Fitted> {
    if scales.is_empty() {
        return fit(columns, y, clusters, floor);
    }
    let scaled = |x: &[f64]| -> Vec<f64> { x.iter().zip(scales).map(|(x, s)| x * s).collect() };
    let own: Vec<Vec<f64>> = columns.iter().map(|x| scaled(x)).collect();
    let own: Vec<&[f64]> = own.iter().map(Vec::as_slice).collect();
    let mut fitted = fit(&own, &scaled(y), clusters, floor)?;
    fitted.weights.iter_mut().zip(scales).for_each(|(w, s)| *w *= s * s);
    Some(fitted)
}

/// Least squares with given weights: the coefficients of a fit whose inputs have changed a little.
/// `None` where the columns are not independent.
pub(crate) fn refit(columns: &[&[f64]], y: &[f64], weights: &[f64]) -> Option<Vec<f64>> {
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

/// Robust spread between clusters of each coefficient: that of the values which each cluster would
/// give if the other coefficients were held at the common fit. Clusters that hardly excite the
/// coefficient do not count.
pub(crate) fn dispersion(
    jacobian: &DMatrix<f64>,
    residuals: &[f64],
    weights: &[f64],
    clusters: &[usize],
    theta: &[f64],
) -> Vec<Option<f64>> {
    let last = clusters.iter().copied().max().unwrap_or(0);
    (0..theta.len())
        .map(|j| {
            let mut score = vec![0.0; last + 1];
            let mut information = vec![0.0; last + 1];
            for (i, &g) in clusters.iter().enumerate() {
                let x = jacobian[(i, j)];
                score[g] += weights[i] * x * residuals[i];
                information[g] += weights[i] * x * x;
            }
            let positive: Vec<f64> = information.iter().copied().filter(|&a| a > 0.0).collect();
            let enough =
                MIN_INFORMATION * positive.iter().sum::<f64>() / positive.len().max(1) as f64;
            let of_clusters: Vec<f64> = (0..=last)
                .filter(|&g| information[g] > enough && information[g] > 0.0)
                .map(|g| theta[j] + score[g] / information[g])
                .collect();
            robust_spread(&of_clusters)
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

    /// Half of the rows scatter six times as much as the others: who knows that is nearer to the truth, and his interval
    /// holds it.
    #[test]
    fn rows_that_are_known_worse_weigh_less() {
        let (n, rides) = (240, 60);
        let [mut own, mut plain, mut held] = [0.0, 0.0, 0.0];
        for ride in 0..rides {
            let mut random = crate::statistics::random::Random::new(ride, "rows known worse");
            let x: Vec<f64> = (0..n).map(|_| random.between(-1.0, 1.0)).collect();
            let sd: Vec<f64> = (0..n).map(|i| if i / 8 % 2 == 0 { 0.1 } else { 0.6 }).collect();
            let y: Vec<f64> =
                x.iter().zip(&sd).map(|(x, sd)| 2.0 * x + sd * random.normal()).collect();
            let clusters: Vec<usize> = (0..n).map(|i| i / 8).collect();
            let scales: Vec<f64> = sd.iter().map(|sd| 0.1 / sd).collect();
            let scaled = fit_scaled(&[&x], &y, &scales, &clusters, 0.0).expect("fit");
            own += (scaled.theta[0] - 2.0).powi(2);
            plain += (fit(&[&x], &y, &clusters, 0.0).expect("fit").theta[0] - 2.0).powi(2);
            let se = scaled.covariance.as_ref().map_or(f64::NAN, |c| c.covariance[(0, 0)].sqrt());
            held += f64::from((scaled.theta[0] - 2.0).abs() < 2.0 * se);
            let again = refit(&[&x], &y, &scaled.weights).expect("refit");
            assert!((again[0] - scaled.theta[0]).abs() < 1e-3, "{again:?} {:?}", scaled.theta);
        }
        assert!(own < 0.7 * plain, "{own} {plain}");
        assert!(held > 0.88 * rides as f64, "{held} of {rides}");
    }
}
