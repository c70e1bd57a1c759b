//! How well the fitted curves are known at one abscissa: what charts draw around them.
//!
//! One source with the table `coefficients`: the same variance of the manoeuvres, the same changes by what is upstream and
//! the same degrees of freedom give the interval of a coefficient and the band of the curve that it belongs to. Where
//! a curve is a coefficient times a known function, its band is the coefficient's interval times that function.
//!
//! METHOD: the errors that the form of the model adds to the Magic Formula's factors belong to factors that no ride tells
//! apart; the curve has those of its height (`mf_d`) and of its slips (`peak_slip`).

use super::coefficients::{Estimate, estimate, quotient, together};
use super::cornering::{C1, C3, CT, K_X};
use super::friction::{self, PARAMETERS};
use super::solution::{Solution, Upstream};
use super::transients::join::NOISE;
use crate::contract::bike::Axle;
use crate::contract::coefficient::{Coefficient as C, Id, Part};
use crate::contract::error_source::MODEL;
use crate::fit::coasting::{DRAG, ROLLING};
use crate::statistics::cluster_covariance::ClusterCovariance;
use crate::statistics::clustered_fit::{Fitted, Uncertainty};
use crate::statistics::interval::delta;
use crate::store::tables::rows::{Coefficient, Status};

/// Place of the curve's height among its factors.
const HEIGHT: usize = 2;

/// A curve at one abscissa.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Band {
    pub value: f64,
    /// 95 % interval with all that the curve depends on; `None` where the ride does not bound it.
    pub interval: Option<[f64; 2]>,
    /// The part of it that comes from the scatter between manoeuvres.
    pub scatter: Option<[f64; 2]>,
}

impl Band {
    /// The same in another unit.
    #[must_use]
    pub(crate) fn times(self, factor: f64) -> Self {
        let scaled = |ends: [f64; 2]| {
            let [a, b] = ends.map(|end| factor * end);
            [a.min(b), a.max(b)]
        };
        Band {
            value: factor * self.value,
            interval: self.interval.map(scaled),
            scatter: self.scatter.map(scaled),
        }
    }
}

/// The bands of one session's fits.
#[derive(Debug)]
pub(crate) struct Bands<'a> {
    solution: &'a Solution,
    upstream: Vec<&'a Upstream>,
    /// Rows of the table, with what was added to them after the fit.
    rows: &'a [Coefficient],
}

impl<'a> Bands<'a> {
    /// Of a solution and the rows that the table has of it.
    pub(crate) fn new(solution: &'a Solution, rows: &'a [Coefficient]) -> Self {
        Bands { solution, upstream: solution.upstream.iter().collect(), rows }
    }

    /// Longitudinal friction at a slip ratio.
    pub(crate) fn friction(&self, k: usize, slip: f64) -> Option<Band> {
        let fit = self.solution.fits.friction[k].as_ref()?;
        let (value, slope) = fit.formula.value_and_slope(slip);
        let at = |theta: &[f64]| friction::curve(theta).value(slip);
        let gradient: Vec<f64> = (0..fit.theta.len())
            .map(|j| {
                let step = 1e-4 * fit.theta[j].abs().max(0.1);
                let moved = |sign: f64| {
                    let mut theta = fit.theta.clone();
                    theta[j] += sign * step;
                    at(&theta)
                };
                (moved(1.0) - moved(-1.0)) / (2.0 * step)
            })
            .collect();
        let (se, dof) = fit.covariance.as_ref().map_or((f64::NAN, 0.0), |c| c.contrast(&gradient));
        // the shape is less well known than linearisation says, as in the shape factors' own rows; at the peak it is nothing
        let mut shape = gradient.clone();
        shape[HEIGHT] = 0.0;
        let of_shape = |c: &ClusterCovariance| c.contrast(&shape).0.powi(2);
        let [usual, left_out] =
            [&fit.covariance, &fit.shape_covariance].map(|c| c.as_ref().map_or(0.0, of_shape));
        let more = (left_out - usual).max(0.0);
        let valley = fit.other.as_ref().map_or(0.0, |other| 0.5 * (at(other) - value));
        let variance = se * se + more + valley * valley;
        let own = Uncertainty { variance, dof, quality: fit.quality.clone(), dispersion: None };
        let axle = Axle::BOTH[k];
        let change = |u: &Upstream| -> f64 {
            let of = |c: C| u.change.values[(axle, c)];
            if u.source.name == MODEL {
                let share = |c: C| of(c) / self.solution.found.values[(axle, c)];
                let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
                return (share(C::MfD) * value).hypot(finite(share(C::PeakSlip)) * slope * slip);
            }
            PARAMETERS.into_iter().zip(&gradient).map(|(c, g)| of(c) * g).sum()
        };
        Some(self.band(value, &own, change, (axle, C::MfD).into()))
    }

    /// Slip angle of steady corners at a camber, rad.
    pub(crate) fn slip_angle(&self, k: usize, camber: f64) -> Option<Band> {
        let fit = self.solution.fits.lateral[k].slip.as_ref()?;
        let contrast = [camber, camber.powi(3)];
        let value = fit.theta[C1] * contrast[0] + fit.theta[C3] * contrast[1];
        let axle = Axle::BOTH[k];
        let change = |u: &Upstream| {
            let of = |c: C| u.change.values[(axle, c)];
            of(C::SlipCamberC1) * contrast[0] + of(C::SlipCamberC3) * contrast[1]
        };
        let own = own(fit, &contrast);
        Some(self.band(value, &own, change, (axle, C::SlipCamberC1).into()))
    }

    /// Lateral friction of steady corners at a camber.
    pub(crate) fn lateral_friction(&self, k: usize, camber: f64) -> Option<Band> {
        let fit = self.solution.fits.lateral[k].friction.as_ref()?;
        let id = (Axle::BOTH[k], C::LateralFrictionCt).into();
        Some(self.multiple(fit, CT, id, 1.0)?.times(camber.tan()))
    }

    /// Cornering stiffness per load at a camber, or that of camber, 1/rad; without an interval where the table calls
    /// the coefficient not determined.
    ///
    /// METHOD: their ratio is assumed. Over 100 machines the bands of what was not determined held 81 to 91 % of the curves.
    pub(crate) fn stiffness(&self, k: usize, of_camber: bool, camber: f64) -> Option<Band> {
        let (solution, axle) = (self.solution, Axle::BOTH[k]);
        let formulation = solution.inputs.formulation;
        let ratio = solution.inputs.bike.wheel(axle).side_force_ratio;
        let k_alpha = solution.fits.lateral[k].k_alpha(camber, ratio, formulation)?;
        let value = if of_camber { ratio * k_alpha } else { k_alpha };
        let fit = solution.fits.lateral[k].stiffness_fit(formulation)?;
        let own = own(fit, &[1.0, camber * camber]);
        let sd = own.variance.sqrt();
        let of = |upstream: &[&Upstream], dof: f64| -> Estimate {
            let bike = &solution.inputs.bike;
            quotient(solution, upstream, bike, (axle, of_camber), camber, (sd, dof))
        };
        let all = of(&self.upstream, own.dof);
        let ends = |estimate: Estimate| estimate.interval.ends().map(|(low, high)| [low, high]);
        let coefficient = if of_camber { C::CamberStiffness0 } else { C::CorneringStiffness0 };
        if !self.is_determined((axle, coefficient).into()) {
            return Some(Band { value, interval: None, scatter: None });
        }
        // of a stiffness from changes of lean the ride's own noise comes as upstream changes
        let noise: Vec<&Upstream> =
            self.upstream.iter().copied().filter(|u| u.source.name.starts_with(NOISE)).collect();
        let scatter = ends(of(&noise, all.dof));
        Some(Band { value, interval: ends(all), scatter })
    }

    /// Force that slows the coasting motorcycle, N, at the square of its speed and its weight.
    pub(crate) fn resistance(&self, square: f64, weight: f64) -> Option<Band> {
        let fit = self.solution.fits.coasting.resistance.as_ref()?;
        let mut contrast = vec![0.0; fit.theta.len()];
        (contrast[DRAG], contrast[ROLLING]) = (square, weight);
        let value = fit.theta[DRAG] * square + fit.theta[ROLLING] * weight;
        let change = |u: &Upstream| {
            let of = |c: C| u.change.values[(Part::Vehicle, c)];
            let [drag, rolling] = [of(C::Drag) * square, of(C::RollingResistance) * weight];
            match (drag.is_finite(), rolling.is_finite()) {
                (true, true) => drag + rolling,
                (true, false) => drag,
                _ => rolling,
            }
        };
        Some(self.band(value, &own(fit, &contrast), change, (Part::Vehicle, C::Drag).into()))
    }

    /// Overturning moment of the vehicle over lever: the fitted [`K_X`], m, known as the vehicle's coefficient is.
    pub(crate) fn overturning(&self) -> Option<Band> {
        let fit = self.solution.fits.overturning.as_ref()?;
        let inputs = &self.solution.inputs;
        let part = Part::Vehicle;
        let share = super::cornering::overturning_share(&inputs.bike, inputs.formulation, part);
        self.multiple(fit, K_X, (part, C::OverturningStiffness).into(), share)
    }

    fn is_determined(&self, id: Id) -> bool {
        let own = |r: &&Coefficient| Id::from_names(&r.tyre, &r.coefficient) == Some(id);
        self.rows.iter().find(own).is_some_and(|row| row.status == Status::Ok)
    }

    /// One fitted number `share` of which is a coefficient: its interval.
    fn multiple(&self, fit: &Fitted, place: usize, id: Id, share: f64) -> Option<Band> {
        let value = *fit.theta.get(place)?;
        let own = fit.uncertainty(place, 1.0);
        Some(self.band(value, &own, |u| u.change.values[id] / share, id))
    }

    /// The band of a value with its own uncertainty and what upstream quantities change it by; what the table adds to the
    /// coefficient `anchor` after the fit is added to it as well.
    fn band(
        &self,
        value: f64,
        own: &Uncertainty,
        change: impl Fn(&Upstream) -> f64,
        anchor: Id,
    ) -> Band {
        let changes = self.upstream.iter().map(|u| change(u)).filter(|d| d.is_finite());
        let outside: f64 = changes.map(|d| d * d).sum();
        let added = self.added(anchor) * value;
        let (std_error, dof) = together(own, outside + added * added);
        let ends = |std_error: f64| {
            let bounded = std_error > 0.0;
            let ends = bounded.then(|| delta(value, std_error, dof).ends()).flatten();
            ends.map(|(low, high)| [low, high])
        };
        Band { value, interval: ends(std_error), scatter: ends(own.variance.sqrt()) }
    }

    /// Relative standard error that a row has beyond that of its fit; none where the row is of another fit.
    fn added(&self, id: Id) -> f64 {
        let name = id.coefficient.name();
        let is_own = |r: &&Coefficient| r.tyre == id.part.name() && r.coefficient == name;
        let Some(row) = self.rows.iter().find(is_own) else { return 0.0 };
        let (Some(value), Some(std_error)) = (row.value, row.std_error) else { return 0.0 };
        let found = self.solution.found.values[id];
        if (found - value).abs() > 1e-9 * value.abs() || value == 0.0 {
            return 0.0;
        }
        let own = self.solution.uncertainty(id);
        let bike = &self.solution.inputs.bike;
        let of_fit = estimate(self.solution, &self.upstream, bike, id, &own).std_error;
        let more = (std_error * std_error - of_fit * of_fit).max(0.0).sqrt() / value.abs();
        // rounding is no widening
        if more.is_finite() && more > 1e-6 { more } else { 0.0 }
    }
}

/// How well a linear fit knows a combination of its coefficients.
fn own(fit: &Fitted, contrast: &[f64]) -> Uncertainty {
    let (se, dof) = fit.covariance.as_ref().map_or((f64::NAN, 0.0), |c| c.contrast(contrast));
    Uncertainty { variance: se * se, dof, dispersion: None, quality: fit.quality.clone() }
}
