//! Lateral fits of one tyre and the overturning moment of both, from steady corners.
//!
//! ```text
//! (37) alpha(gamma) = c1 gamma + c3 gamma^3
//! (38) mu_y(gamma)  = ct tan(gamma)
//! (39) alpha + C gamma = -mu_y / k_alpha(gamma),   1/k_alpha = (t1 + t2 gamma^2) gamma/tan(gamma)
//! (35) Mx_tot = -k_xf (Fz_f tan(gamma_f) + r_r/r_f Fz_r tan(gamma_r))
//! ```
//!
//! Printed (39) is the quotient of the fitted (37) and (38), `k_alpha0 = -ct / (c1 + C)`. In a
//! tight bend the front wheel leans further than the bike by an angle that depends on the
//! radius, not on the lean, so neither (37) nor (38) passes the origin there and their quotient
//! misses the upright stiffness (by 9 % front in the paper's own course, simulated). The
//! corrected form fits the same family of curves to (39) multiplied through: linear in `t1` and
//! `t2`, no sample is divided by a small angle, and slip angle, the noisy side, stays the
//! response. Without noise and in wide bends the two agree.
//! Printed (35), (36): `Mx_tot = k_x m g tan(phi)`, split by the tyre widths.

use crate::contract::bike::Bike;
use crate::estimate::signals::Signals;
use crate::model::formulation::Formulation;
use crate::statistics::clustered_fit::{self, Fitted};

/// Differences of slip angle that are never outliers, rad.
const ANGLE_FLOOR: f64 = 2e-3;
/// Differences of lateral friction that are never outliers.
const FRICTION_FLOOR: f64 = 0.015;
/// Differences of overturning moment over weight that are never outliers, m.
pub const MOMENT_FLOOR: f64 = 5e-4;

/// Rows of one tyre's lateral fits.
#[derive(Debug, Clone, Default)]
pub struct Rows {
    /// Camber, rad.
    pub camber: Vec<f64>,
    /// Its cube.
    pub cube: Vec<f64>,
    /// Slip angle, rad.
    pub slip_angle: Vec<f64>,
    /// `tan(gamma)`.
    pub tangent: Vec<f64>,
    /// `Fy / Fz`.
    pub friction: Vec<f64>,
    /// `alpha + C gamma`.
    pub side: Vec<f64>,
    /// `-mu_y gamma / tan(gamma)` and that times `gamma^2`.
    pub compliance: [Vec<f64>; 2],
    /// Manoeuvre.
    pub clusters: Vec<usize>,
}

/// The lateral fits of one tyre.
#[derive(Debug, Clone, Default)]
pub struct Lateral {
    /// `c1, c3`.
    pub slip: Option<Fitted>,
    /// `ct`.
    pub friction: Option<Fitted>,
    /// `t1, t2` of (39) multiplied through.
    pub compliance: Option<Fitted>,
    /// Largest camber ridden, rad (99 %).
    pub ridden: f64,
}

impl Lateral {
    /// `k_alpha(gamma)`, 1/rad: of (39) multiplied through, or as printed. `None` where there is
    /// no fit or the curve has left the ridden range and turned over.
    pub fn k_alpha(&self, gamma: f64, ratio: f64, formulation: Formulation) -> Option<f64> {
        let tangent = if gamma.abs() < 1e-6 { 1.0 } else { gamma.tan() / gamma };
        let (top, bottom) = match formulation {
            Formulation::Corrected => {
                let t = &self.compliance.as_ref()?.theta;
                (1.0, t[0] + t[1] * gamma * gamma)
            }
            Formulation::Paper => {
                let c = &self.slip.as_ref()?.theta;
                let ct = self.friction.as_ref()?.theta[0];
                (-ct, c[0] + ratio + c[1] * gamma * gamma)
            }
        };
        Some(tangent * top / bottom).filter(|k| k.is_finite() && *k > 0.0)
    }
}

/// The kept samples of one tyre as rows; `ratio` is the side force ratio `C`.
pub fn rows(signals: &Signals, segment: &[usize], keep: &[usize], tyre: usize, ratio: f64) -> Rows {
    let mut out = Rows::default();
    for &i in keep {
        let gamma = signals.camber[tyre][i];
        let alpha = signals.slip_angle[tyre][i];
        let mu = signals.force_y[tyre][i] / signals.load[tyre][i];
        let tangent = gamma.tan();
        let compliance = if gamma == 0.0 { -mu } else { -mu * gamma / tangent };
        out.camber.push(gamma);
        out.cube.push(gamma.powi(3));
        out.slip_angle.push(alpha);
        out.tangent.push(tangent);
        out.friction.push(mu);
        out.side.push(alpha + ratio * gamma);
        out.compliance[0].push(compliance);
        out.compliance[1].push(compliance * gamma * gamma);
        out.clusters.push(segment[i]);
    }
    out
}

impl Rows {
    fn slip_columns(&self) -> [&[f64]; 2] {
        [&self.camber, &self.cube]
    }

    fn compliance_columns(&self) -> [&[f64]; 2] {
        [&self.compliance[0], &self.compliance[1]]
    }
}

/// Fits (37), (38) and (39) robustly.
pub fn fit(rows: &Rows) -> Lateral {
    if clustered_fit::count(&rows.clusters) < 2 {
        return Lateral::default();
    }
    let mut camber: Vec<f64> = rows.camber.iter().map(|g| g.abs()).collect();
    camber.sort_by(f64::total_cmp);
    Lateral {
        slip: clustered_fit::fit(
            &rows.slip_columns(),
            &rows.slip_angle,
            &rows.clusters,
            ANGLE_FLOOR,
        ),
        friction: clustered_fit::fit(
            &[&rows.tangent],
            &rows.friction,
            &rows.clusters,
            FRICTION_FLOOR,
        ),
        compliance: clustered_fit::fit(
            &rows.compliance_columns(),
            &rows.side,
            &rows.clusters,
            ANGLE_FLOOR,
        ),
        ridden: camber.get(camber.len() * 99 / 100).copied().unwrap_or(0.0),
    }
}

/// `c1, c3`, then `ct`, then `t1`; `None` where there is no fit.
pub type Values = (Option<[f64; 2]>, Option<f64>, Option<f64>);

impl Lateral {
    /// The coefficients.
    pub fn values(&self) -> Values {
        (
            self.slip.as_ref().map(|f| [f.theta[0], f.theta[1]]),
            self.friction.as_ref().map(|f| f.theta[0]),
            self.compliance.as_ref().map(|f| f.theta[0]),
        )
    }
}

/// The same coefficients when the inputs change a little.
pub fn refit(rows: &Rows, base: &Lateral) -> Values {
    let again = |columns: &[&[f64]], y: &[f64], fitted: &Option<Fitted>| {
        clustered_fit::refit(columns, y, &fitted.as_ref()?.weights)
    };
    (
        again(&rows.slip_columns(), &rows.slip_angle, &base.slip).map(|t| [t[0], t[1]]),
        again(&[&rows.tangent], &rows.friction, &base.friction).map(|t| t[0]),
        again(&rows.compliance_columns(), &rows.side, &base.compliance).map(|t| t[0]),
    )
}

/// Rows of the overturning fit: lever, moment, manoeuvre.
pub fn overturning_rows(
    signals: &Signals,
    segment: &[usize],
    keep: &[usize],
) -> (Vec<f64>, Vec<f64>, Vec<usize>) {
    let lever = keep.iter().map(|&i| signals.overturning_lever[i]).collect();
    let moment = keep.iter().map(|&i| signals.overturning[i]).collect();
    (lever, moment, keep.iter().map(|&i| segment[i]).collect())
}

/// `k_x` of front, rear and vehicle per unit of the fitted coefficient (eq. 36).
pub fn overturning_shares(bike: &Bike, formulation: Formulation) -> [f64; 3] {
    let front_load = bike.cg_to_rear() / bike.wheelbase;
    let rear_load = bike.cg_to_front / bike.wheelbase;
    match formulation {
        // the fit is of the front tyre
        Formulation::Corrected => {
            let ratio = bike.rear.width / bike.front.width;
            [1.0, ratio, front_load + ratio * rear_load]
        }
        // the fit is of the vehicle, split as printed
        Formulation::Paper => {
            let ratio = bike.front.width / bike.rear.width;
            let front = 1.0 / (front_load + rear_load * ratio);
            [front, front * ratio, 1.0]
        }
    }
}
