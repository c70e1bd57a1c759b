//! `mu_x(s)` of one tyre from braking (and, at the rear, driving): eq. 28.
//!
//! The slip ratio has an error of its own, that of the velocity over the speed. Part of it is
//! slow, the same through a manoeuvre: that offset `e_g` is estimated with the curve (a random
//! effect with the velocity's own spread as its prior). The rest weighs the samples by the
//! effective variance, which follows the curve's slope as it is fitted:
//!
//! ```text
//! r   = (mu - mu_x(s) + mu_x'(s) (1 + s)/v e_g) / sqrt(sigma_mu^2 + (mu_x'(s) sigma_s)^2)
//! r_g = e_g / sigma_v
//! ```
//! Without both the slip stiffness comes out too small (errors in variables), and the deficit is
//! blamed on something else later.

use nalgebra::{DMatrix, DVector};

use crate::contract::coefficient::Coefficient;
use crate::statistics::cluster_covariance::{
    ClusterCovariance, Correction, Scores, sandwich, sandwich_with,
};
use crate::statistics::clustered_fit::{Quality, Uncertainty, count, dispersion};
use crate::statistics::loss::tau_scale;
use crate::statistics::nonlinear::{self, Model, NonlinearFit, Options};
use crate::statistics::order::quantile;
use crate::tyre::MagicFormula;

/// The fitted parameters in their order; the last one only of a tyre that was driven as well as
/// braked.
pub(crate) const PARAMETERS: [Coefficient; 5] =
    [Coefficient::MfB, Coefficient::MfC, Coefficient::MfD, Coefficient::MfE1, Coefficient::MfE2];

/// Place of the odd curvature, where it is fitted.
pub(crate) const E2: usize = 4;

/// The curve of fitted parameters.
pub(crate) fn curve(theta: &[f64]) -> MagicFormula {
    MagicFormula {
        b: theta[0],
        c: theta[1],
        d: theta[2],
        e1: theta[3],
        e2: theta.get(E2).copied().unwrap_or(0.0),
    }
}

/// Whether a coefficient belongs to the friction curve.
pub fn is_of_curve(coefficient: Coefficient) -> bool {
    coefficient == Coefficient::PeakSlip || PARAMETERS.contains(&coefficient)
}

/// Samples of one tyre.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rows {
    pub slip: Vec<f64>,
    /// `Fx / Fz`.
    pub friction: Vec<f64>,
    /// Forward speed, m/s.
    pub speed: Vec<f64>,
    /// Expected error of the friction.
    pub friction_error: Vec<f64>,
    /// Manoeuvre; after the samples' come one for each manoeuvre's offset row.
    pub clusters: Vec<usize>,
    /// Expected error of the velocity, m/s.
    pub velocity_error: f64,
    /// Share of it that changes within a manoeuvre.
    fast_share: f64,
    /// Whether the tyre was driven as well as braked: then `e1` and `e2` are both determined.
    pub both_signs: bool,
    /// Index of each sample's manoeuvre among those there are.
    group: Vec<usize>,
    groups: usize,
}

/// Share of a satellite's velocity error that changes within a manoeuvre.
const FAST_SHARE: f64 = 0.4;
/// Residuals count no more than this for a manoeuvre's offset: outliers must not move it.
const CLIP: f64 = 2.0;
/// Most coefficients of a curve.
const MAX_COEFFICIENTS: usize = PARAMETERS.len();

impl Rows {
    /// Residual of a sample without its manoeuvre's offset, and its derivative by the offset.
    fn residual_and_lever(&self, formula: &MagicFormula, i: usize) -> (f64, f64) {
        let (s, v) = (self.slip[i], self.speed[i]);
        let (value, slope) = formula.value_and_slope(s);
        let from_slip = slope * self.fast_share * self.velocity_error / v;
        // plain root: neither part is near the ends of the number range
        let sigma =
            (self.friction_error[i] * self.friction_error[i] + from_slip * from_slip).sqrt();
        ((self.friction[i] - value) / sigma, slope * (1.0 + s) / v / sigma)
    }

    /// No samples yet; the expected error of the velocity (m/s).
    pub fn with_error(velocity_error: f64) -> Self {
        Rows { velocity_error, fast_share: FAST_SHARE, ..Rows::default() }
    }

    /// The same where the error is white noise, as of wheel speeds.
    pub fn with_white_error(velocity_error: f64) -> Self {
        Rows { velocity_error, fast_share: 1.0, ..Rows::default() }
    }

    /// To be called once the samples are in: numbers the manoeuvres and adds their rows.
    pub fn index(&mut self) {
        let mut names = self.clusters.clone();
        names.sort_unstable();
        names.dedup();
        self.group = self.clusters.iter().map(|c| names.partition_point(|name| name < c)).collect();
        self.groups = names.len();
        self.clusters.extend(names);
    }

    /// Deepest slip ratio of each manoeuvre that braked, the deepest first.
    fn deepest(&self) -> Vec<f64> {
        let mut deepest = vec![0.0_f64; self.groups];
        for (slip, group) in self.slip.iter().zip(&self.group) {
            deepest[*group] = deepest[*group].min(*slip);
        }
        deepest.retain(|s| *s < 0.0);
        deepest.sort_by(f64::total_cmp);
        deepest
    }

    /// Number of samples, without the manoeuvres' own rows.
    pub fn samples(&self) -> usize {
        self.slip.len()
    }
}

impl Model for Rows {
    fn parameters(&self) -> usize {
        if self.both_signs { MAX_COEFFICIENTS } else { MAX_COEFFICIENTS - 1 }
    }

    fn len(&self) -> usize {
        self.slip.len() + self.groups
    }

    fn residuals(&self, theta: &[f64], out: &mut [f64]) {
        let formula = curve(theta);
        let n = self.samples();
        let mut offsets = vec![(0.0, 1.0 / self.velocity_error.powi(2)); self.groups];
        let mut lever = vec![0.0; n];
        for i in 0..n {
            (out[i], lever[i]) = self.residual_and_lever(&formula, i);
            let sum = &mut offsets[self.group[i]];
            sum.0 -= lever[i] * out[i].clamp(-CLIP, CLIP);
            sum.1 += lever[i] * lever[i];
        }
        for i in 0..n {
            let (top, bottom) = offsets[self.group[i]];
            out[i] += lever[i] * top / bottom;
        }
        for (g, (top, bottom)) in offsets.into_iter().enumerate() {
            out[n + g] = top / bottom / self.velocity_error;
        }
    }

    /// With the offset rows of the manoeuvres that remain.
    fn thinned(&self, rows: &[usize]) -> Option<Box<dyn Model>> {
        let mut out = Rows {
            both_signs: self.both_signs,
            velocity_error: self.velocity_error,
            fast_share: self.fast_share,
            ..Rows::default()
        };
        for &i in rows.iter().filter(|i| **i < self.samples()) {
            out.slip.push(self.slip[i]);
            out.friction.push(self.friction[i]);
            out.speed.push(self.speed[i]);
            out.friction_error.push(self.friction_error[i]);
            out.clusters.push(self.clusters[i]);
        }
        out.index();
        Some(Box::new(out))
    }

    /// By the chain rule through curve, expected error and offsets.
    fn jacobian(&self, theta: &[f64], out: &mut DMatrix<f64>) {
        let formula = curve(theta);
        let (n, p) = (self.samples(), theta.len());
        let mut offsets = vec![Offset::new(self.velocity_error); self.groups];
        let mut levers = Vec::with_capacity(n);
        for i in 0..n {
            let (s, v) = (self.slip[i], self.speed[i]);
            let point = formula.point(s);
            let spread = self.fast_share * self.velocity_error / v;
            let sigma = (self.friction_error[i].powi(2) + (point.slope * spread).powi(2)).sqrt();
            let r = (self.friction[i] - point.value) / sigma;
            let arm = (1.0 + s) / v / sigma;
            let lever = arm * point.slope;
            let inside = if r.abs() < CLIP { 1.0 } else { 0.0 };
            let sum = &mut offsets[self.group[i]];
            sum.top -= lever * r.clamp(-CLIP, CLIP);
            sum.bottom += lever * lever;
            let mut lever_by = [0.0; MAX_COEFFICIENTS];
            for j in 0..p {
                // relative change of the expected error
                let wider = point.slope * point.slope_by[j] * (spread / sigma).powi(2);
                let r_by = -point.value_by[j] / sigma - r * wider;
                lever_by[j] = arm * point.slope_by[j] - lever * wider;
                sum.top_by[j] -= lever_by[j] * r.clamp(-CLIP, CLIP) + lever * inside * r_by;
                sum.bottom_by[j] += 2.0 * lever * lever_by[j];
                out[(i, j)] = r_by;
            }
            levers.push((lever, lever_by));
        }
        for sum in &mut offsets {
            sum.divide();
        }
        for (i, (lever, lever_by)) in levers.into_iter().enumerate() {
            let Offset { top: offset, top_by: offset_by, .. } = &offsets[self.group[i]];
            for j in 0..p {
                out[(i, j)] += lever_by[j] * offset + lever * offset_by[j];
            }
        }
        for (g, sum) in offsets.iter().enumerate() {
            for j in 0..p {
                out[(n + g, j)] = sum.top_by[j] / self.velocity_error;
            }
        }
    }
}

/// Numerator and denominator of a manoeuvre's offset, and their derivatives by the coefficients.
#[derive(Debug, Clone)]
struct Offset {
    top: f64,
    bottom: f64,
    top_by: [f64; MAX_COEFFICIENTS],
    bottom_by: [f64; MAX_COEFFICIENTS],
}

impl Offset {
    fn new(velocity_error: f64) -> Self {
        let bottom = 1.0 / velocity_error.powi(2);
        Offset {
            top: 0.0,
            bottom,
            top_by: [0.0; MAX_COEFFICIENTS],
            bottom_by: [0.0; MAX_COEFFICIENTS],
        }
    }

    /// Makes `top` the offset, and `top_by` its derivatives.
    fn divide(&mut self) {
        self.top /= self.bottom;
        for (top, bottom) in self.top_by.iter_mut().zip(self.bottom_by) {
            *top = (*top - self.top * bottom) / self.bottom;
        }
    }
}

/// A fitted friction curve.
#[derive(Debug, Clone)]
pub struct Friction {
    pub formula: MagicFormula,
    /// In the order of [`PARAMETERS`].
    pub theta: Vec<f64>,
    /// Their covariance from manoeuvres.
    pub covariance: Option<ClusterCovariance>,
    /// The same by leaving out one manoeuvre at a time, for the shape factors.
    pub shape_covariance: Option<ClusterCovariance>,
    /// Robust spread between manoeuvres.
    pub dispersion: Vec<Option<f64>>,
    /// Of the fit; the scale is in units of friction.
    pub quality: Quality,
    /// Robust weight of each sample.
    pub weights: Vec<f64>,
    /// `(J' psi' J)^-1 J' W`: change of the coefficients per change of the residuals, but for the sign.
    response: DMatrix<f64>,
    residuals: Vec<f64>,
    /// Coefficients of another curve that describes the samples as well.
    pub(super) other: Option<Vec<f64>>,
    /// Lowest and highest slip ratio of the samples (their 1 % and 99 % quantiles).
    pub slip_range: [f64; 2],
    /// Deepest slip ratio of each manoeuvre that braked, the deepest first.
    pub deepest: Vec<f64>,
}

/// Relative residual of a tyre's friction when the paper's form is fitted to another form's curve near its
/// peak: published motorcycle tyres in the forms of Pacejka (2012), standard deviation.
const FORM_ERROR: f64 = 0.0005;
/// Place of `e1`.
const CURVATURE: usize = 3;
/// A robust scale of the residuals no larger than this over the smallest one belongs to a curve that is as good.
const AS_GOOD: f64 = 1.02;
/// Starts of the search: `b`, `c` and `e1`.
const STARTS: [(f64, f64, f64); 4] =
    [(10.0, 1.5, 0.2), (20.0, 1.3, 0.5), (6.0, 1.7, -0.5), (14.0, 1.6, -1.0)];
/// Bounds of the parameters in their order.
const BOUNDS: [(f64, f64); MAX_COEFFICIENTS] =
    [(1.0, 80.0), (1.0, 2.4), (0.1, 2.5), (-6.0, 1.0), (-4.0, 4.0)];

/// Residuals are in units of their expected error: less than half of it is never an outlier.
const OPTIONS: Options = Options { scale_floor: 0.5, ..Options::DEFAULT };

/// Fits eq. 28; `None` where the samples cannot carry it.
pub fn fit(rows: &Rows) -> Option<Friction> {
    let p = rows.parameters();
    let mut sizes: Vec<f64> = rows.friction.iter().map(|m| m.abs()).collect();
    let peak = quantile(&mut sizes, 0.98)?.clamp(0.2, 2.0);
    let starts: Vec<Vec<f64>> =
        STARTS.iter().map(|&(b, c, e)| vec![b, c, peak, e, 0.0][..p].to_vec()).collect();
    fit_from(rows, &starts, &OPTIONS)
}

/// The same of samples that have changed little since a fit: from its curve, without a search.
pub(crate) fn fit_near(rows: &Rows, before: &Friction) -> Option<Friction> {
    let mut start = before.theta.clone();
    start.resize(rows.parameters(), 0.0);
    fit_from(rows, &[start], &Options { search_iterations: 0, ..OPTIONS })
}

fn fit_from(rows: &Rows, starts: &[Vec<f64>], options: &Options) -> Option<Friction> {
    let p = rows.parameters();
    if rows.samples() < 10 * p {
        return None;
    }
    let fit = nonlinear::fit(rows, starts, Some(&BOUNDS[..p]), options).ok()?;
    let other = other_valley(rows, &fit, options);
    let scores = Scores {
        jacobian: &fit.jacobian,
        residuals: &fit.residuals,
        weights: &fit.weights,
        psi_derivatives: Some(&fit.psi_derivatives),
        clusters: &rows.clusters,
    };
    let covariance = sandwich(&scores).ok();
    // METHOD: b, c and the curvatures trade against each other along a bent valley; there the
    // linearised CR2 is too narrow (78 % instead of 95 % in the simulated study), leaving out
    // one manoeuvre at a time is not
    let shape_covariance = sandwich_with(&scores, Correction::Cr3).ok();
    let negative: Vec<f64> = fit.residuals.iter().map(|r| -r).collect();
    let dispersion = dispersion(&fit.jacobian, &negative, &fit.weights, &rows.clusters, &fit.theta);
    let formula = curve(&fit.theta);
    let response = response(&fit, rows.len())?;
    let quality = quality(rows, &formula, &fit);
    let mut slip = rows.slip.clone();
    let slip_range = [quantile(&mut slip, 0.01)?, quantile(&mut slip, 0.99)?];
    let deepest = rows.deepest();
    Some(Friction {
        formula,
        theta: fit.theta,
        covariance,
        shape_covariance,
        dispersion,
        quality,
        weights: fit.weights,
        response,
        residuals: fit.residuals,
        slip_range,
        deepest,
        other,
    })
}

/// METHOD: a blunt curve of large curvature and a sharp one of little fit the same samples: two minima, of which
/// chance chooses. The linearised covariance knows the one; what is known covers both.
///
/// The end of a descent from the other side, where it is one of its own and as good.
fn other_valley(rows: &Rows, fit: &NonlinearFit, options: &Options) -> Option<Vec<f64>> {
    let mut start = fit.theta.clone();
    let (b, c, e) = match start[CURVATURE] > 0.5 {
        true => (1.35, 0.75, 0.1),
        false => (0.75, 1.3, 0.87),
    };
    start[0] *= b;
    start[1] = (start[1] * c).clamp(1.05, 2.3);
    start[CURVATURE] = e;
    // half the way there is all that is asked
    let options = Options { search_iterations: 0, tolerance: 1e-3, ..*options };
    let bounds = &BOUNDS[..rows.parameters()];
    let other = nonlinear::fit(rows, &[start], Some(bounds), &options).ok()?;
    let mut scratch = vec![0.0; rows.len()];
    let mut size =
        |fit: &NonlinearFit| tau_scale(&fit.residuals, options.scale_floor, &mut scratch);
    (size(&other) < AS_GOOD * size(fit)).then_some(other.theta)
}

/// See [`Friction::response`]; `n` rows.
fn response(fit: &NonlinearFit, n: usize) -> Option<DMatrix<f64>> {
    let p = fit.theta.len();
    let mut information = DMatrix::zeros(p, p);
    let mut weighted = DMatrix::zeros(p, n);
    for i in 0..n {
        for j in 0..p {
            weighted[(j, i)] = fit.jacobian[(i, j)] * fit.weights[i];
            for k in 0..p {
                information[(j, k)] +=
                    fit.jacobian[(i, j)] * fit.jacobian[(i, k)] * fit.psi_derivatives[i];
            }
        }
    }
    information.lu().solve(&weighted)
}

/// How well the curve describes the friction itself, without the manoeuvres' offsets.
fn quality(rows: &Rows, formula: &MagicFormula, fit: &NonlinearFit) -> Quality {
    let residuals = (0..rows.samples()).map(|i| rows.friction[i] - formula.value(rows.slip[i]));
    let weights = &fit.weights[..rows.samples()];
    let kept: f64 = weights.iter().sum();
    let mean = weighted_mean(&rows.friction, weights);
    let left: f64 = residuals.zip(weights).map(|(r, w)| w * r * r).sum();
    let whole: f64 = rows.friction.iter().zip(weights).map(|(y, w)| w * (y - mean).powi(2)).sum();
    Quality {
        n_clusters: count(&rows.clusters),
        n_samples: rows.samples(),
        scale: (left / kept).sqrt(),
        outlier_fraction: fit.outlier_fraction,
        r_squared: 1.0 - left / whole,
    }
}

impl Friction {
    /// The coefficients when the samples change a little, robust weights held: one Gauss-Newton step
    /// from the solution.
    pub fn refit_with_fixed_weights(&self, rows: &Rows) -> Vec<f64> {
        let mut now = vec![0.0; rows.len()];
        rows.residuals(&self.theta, &mut now);
        let change: DVector<f64> =
            DVector::from_iterator(now.len(), now.iter().zip(&self.residuals).map(|(a, b)| a - b));
        // the residual is data minus model: its Jacobian carries a minus
        let step = &self.response * change;
        self.theta.iter().zip(step.iter()).map(|(t, s)| t - s).collect()
    }

    /// Slip of the friction peak, and its derivative by each fitted parameter; `None` of a curve
    /// without a peak.
    pub fn peak_slip(&self) -> Option<(f64, Vec<f64>)> {
        let peak = self.formula.peak_slip()?;
        let gradient = (0..self.theta.len())
            .map(|j| {
                let step = 1e-4 * self.theta[j].abs().max(0.1);
                let at = |sign: f64| {
                    let mut theta = self.theta.clone();
                    theta[j] += sign * step;
                    curve(&theta).peak_slip().unwrap_or(peak)
                };
                (at(1.0) - at(-1.0)) / (2.0 * step)
            })
            .collect();
        Some((peak, gradient))
    }

    /// How well a coefficient of the curve is known; `None` of any other, and where the curve has
    /// none.
    pub fn uncertainty(&self, coefficient: Coefficient) -> Option<Uncertainty> {
        let mut contrast = vec![0.0; self.theta.len()];
        let mut dispersion = None;
        if coefficient == Coefficient::PeakSlip {
            contrast = self.peak_slip()?.1;
        } else {
            let j = PARAMETERS.iter().position(|c| *c == coefficient)?;
            *contrast.get_mut(j)? = 1.0;
            dispersion = self.dispersion[j];
        }
        let form = match coefficient {
            Coefficient::PeakSlip => self.flat_peak()?,
            _ => 0.0,
        };
        let covariance = match coefficient {
            Coefficient::PeakSlip | Coefficient::MfD => &self.covariance,
            _ => &self.shape_covariance,
        };
        let (se, dof) = covariance.as_ref().map_or((f64::NAN, 0.0), |c| c.contrast(&contrast));
        let valley = self.to_other_valley(coefficient).unwrap_or(0.0);
        let variance = se * se + form * form + valley * valley;
        Some(Uncertainty { variance, dof, dispersion, quality: self.quality.clone() })
    }

    /// Half the way of a coefficient to the other curve that describes the samples as well.
    fn to_other_valley(&self, coefficient: Coefficient) -> Option<f64> {
        let other = self.other.as_ref()?;
        let change = match coefficient {
            Coefficient::PeakSlip => curve(other).peak_slip()? - self.formula.peak_slip()?,
            _ => {
                let j = PARAMETERS.iter().position(|c| *c == coefficient)?;
                other.get(j)? - self.theta.get(j)?
            }
        };
        Some(0.5 * change)
    }

    /// How far from the fitted peak the curve is lower by no more than [`FORM_ERROR`]: so far the peak of
    /// a tyre of another form may be.
    fn flat_peak(&self) -> Option<f64> {
        let peak = self.formula.peak_slip()?;
        let friction = |sigma: f64| -self.formula.value(-sigma / (1.0 + sigma));
        let step = 0.1 * peak;
        let around = 0.5 * (friction(peak - step) + friction(peak + step));
        let fall = (friction(peak) - around) / friction(peak);
        Some(step * (FORM_ERROR / fall.max(FORM_ERROR)).sqrt())
    }
}

fn weighted_mean(x: &[f64], w: &[f64]) -> f64 {
    let total: f64 = w.iter().sum();
    x.iter().zip(w).map(|(x, w)| x * w).sum::<f64>() / total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    /// Three manoeuvres on a known curve, each with an offset of its own and an outlier.
    fn rows() -> Rows {
        let truth = MagicFormula { b: 13.0, c: 1.5, d: 1.0, e1: 0.2, e2: -0.1 };
        let mut rows = Rows::with_error(0.05);
        for i in 0..240 {
            let s = 0.3 * (f64::from(i) * 0.37).sin();
            let v = 8.0 + f64::from(i % 17);
            let jitter = 0.02 * (f64::from(i) * 1.7).sin();
            rows.slip.push(s);
            rows.speed.push(v);
            rows.friction_error.push(0.02);
            let outlier = if i % 50 == 7 { 0.4 } else { 0.0 };
            rows.friction.push(truth.value(s + 0.002 * f64::from(i / 80 - 1)) + jitter + outlier);
            rows.clusters.push(i as usize / 80);
        }
        rows.both_signs = true;
        rows.index();
        rows
    }

    #[test]
    fn the_jacobian_is_that_of_differences() {
        let rows = rows();
        let theta = [11.0, 1.6, 1.1, 0.1, 0.05];
        let mut exact = DMatrix::zeros(rows.len(), 5);
        rows.jacobian(&theta, &mut exact);
        let at = |j: usize, step: f64| {
            let mut moved = theta;
            moved[j] += step;
            let mut r = vec![0.0; rows.len()];
            rows.residuals(&moved, &mut r);
            r
        };
        for j in 0..5 {
            let (up, down) = (at(j, 1e-6), at(j, -1e-6));
            for i in 0..rows.len() {
                let difference = (up[i] - down[i]) / 2e-6;
                let error = (exact[(i, j)] - difference).abs();
                assert!(error < 1e-5 * (1.0 + difference.abs()), "{i} {j}: {difference}");
            }
        }
    }

    /// Rides on a known curve: braking manoeuvres at a few speeds that just pass the peak.
    fn ride(truth: &MagicFormula, seed: u64) -> Rows {
        let mut random = Random::new(seed, "friction");
        let mut rows = Rows::with_error(0.02);
        for manoeuvre in 0..8 {
            let off = 0.02 * random.normal();
            for i in 0..60 {
                let s = -0.003 - 0.17 * (f64::from(i) / 59.0).powi(3);
                let v = 20.0 - 0.1 * f64::from(i);
                let read = s + (off + 0.02 * random.normal()) / v;
                rows.slip.push(read);
                rows.speed.push(v);
                rows.friction_error.push(0.01);
                rows.friction.push(truth.value(s) + 0.01 * random.normal());
                rows.clusters.push(manoeuvre);
            }
        }
        rows.index();
        rows
    }

    #[test]
    fn the_shape_of_a_curve_that_just_passes_its_peak_is_known_as_well_as_said() {
        let truth = MagicFormula { b: 12.3, c: 1.6, d: 1.0, e1: 0.36, e2: 0.0 };
        let held = |seed: u64| {
            let fit = fit(&ride(&truth, seed))?;
            let known = fit.uncertainty(Coefficient::MfC)?;
            let half = 2.4 * known.variance.sqrt(); // 7 degrees of freedom
            Some((fit.formula.c - truth.c).abs() < half)
        };
        let held = (0..20).filter(|seed| held(*seed) == Some(true)).count();
        assert!(held >= 16, "{held} of 20");
    }
}
