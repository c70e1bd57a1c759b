//! Rolling radii, drag and rolling resistance from coasting runs.
//!
//! ```text
//!      v_x = R_rol omega                                                  both wheels
//! (23) (m + sum(I/R^2)) a_x = -c_drag v_x^2 - c_rol m g [- m g grade direction]
//! ```
//!
//! The radius is that of a freely rolling wheel under the load at rest. A coasting wheel differs a little: rolling
//! resistance puts load on the front, and the inertia of the wheels makes them slip ([`free_speed`]).
//!
//! A ride without enough coasting still determines the front radius: the undriven wheel rolls
//! freely under gentle engine power too ([`free_rolling`]).
//!
//! The printed form has neither the wheels' inertia nor the slope of the test strip. Altitude or climb show
//! it sample by sample ([`crate::estimate::grade`]); both directions of travel separate its remainder from rolling resistance.

use std::collections::BTreeSet;

use crate::GRAVITY;
use crate::contract::coefficient::{Coefficient, Id};
use crate::estimate::samples::Samples;
use crate::estimate::signals::Inputs;
use crate::motorcycle::balance::USUAL_SLIP_STIFFNESS;
use crate::statistics::clustered_fit::{self, Fitted, Uncertainty};
use crate::tyre::formulation::Formulation;

/// Differences of speed that are never outliers, m/s.
const SPEED_FLOOR: f64 = 0.005;
/// Differences of resistance over weight that are never outliers.
const RESISTANCE_FLOOR: f64 = 5e-4;

/// Under engine power the front wheel rolls freely, but for its inertia; below this acceleration
/// that is a slip of less than 0.04 %, m/s².
pub(crate) const GENTLE: f64 = 1.5;
/// Coasting runs that do without the help of driving.
const ENOUGH: usize = 3;

/// Coefficient of the radius fit: the rolling radius, m.
pub(crate) const RADIUS: usize = 0;
/// Coefficient of the resistance fit: aerodynamic drag, kg/m.
pub(crate) const DRAG: usize = 0;
/// Coefficient of the resistance fit: rolling resistance over weight.
pub(crate) const ROLLING: usize = 1;
/// Coefficient of the resistance fit where both directions were ridden: the outbound grade.
pub(crate) const GRADE: usize = 2;

/// The samples that determine the front wheel's radius: coasting, and gentle driving beside it where
/// there are fewer than three coasting runs.
pub(crate) fn free_rolling(coast: &Samples, driving: &Samples) -> Samples {
    let mut out = coast.clone();
    if clustered_fit::count(&coast.segment) < ENOUGH {
        let gentle: Vec<usize> =
            (0..driving.len()).filter(|&i| driving.velocity_x_rate[i].abs() < GENTLE).collect();
        out.append(driving.select(&gentle));
    }
    out
}

/// The fits to coasting runs.
#[derive(Debug, Clone, Default)]
pub struct Coasting {
    /// Of each wheel, see [`RADIUS`].
    pub radius: [Option<Fitted>; 2],
    /// See [`DRAG`], [`ROLLING`] and [`GRADE`].
    pub resistance: Option<Fitted>,
}

/// Drag (kg/m) and rolling resistance coefficient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resistance {
    /// Drag, kg/m.
    pub drag: f64,
    /// Rolling resistance over weight.
    pub rolling: f64,
}

impl Resistance {
    fn of(theta: &[f64]) -> Self {
        Resistance { drag: theta[DRAG], rolling: theta[ROLLING] }
    }
}

impl Coasting {
    /// Rolling radius of each wheel, m.
    pub fn radii(&self) -> [Option<f64>; 2] {
        [0, 1].map(|k| self.radius[k].as_ref().map(|f| f.theta[RADIUS]))
    }

    /// Resistances of the coasting motorcycle.
    pub fn resistances(&self) -> Option<Resistance> {
        self.resistance.as_ref().map(|f| Resistance::of(&f.theta))
    }

    /// How well a coefficient of these fits is known; `None` of any other, and where there is no fit.
    pub fn uncertainty(&self, id: Id) -> Option<Uncertainty> {
        match (id.coefficient, id.part.axle()) {
            (Coefficient::EffectiveRollingRadius, Some(axle)) => {
                Some(self.radius[axle as usize].as_ref()?.uncertainty(RADIUS, 1.0))
            }
            (Coefficient::Drag, _) => Some(self.resistance.as_ref()?.uncertainty(DRAG, 1.0)),
            (Coefficient::RollingResistance, _) => {
                Some(self.resistance.as_ref()?.uncertainty(ROLLING, 1.0))
            }
            _ => None,
        }
    }
}

/// Speed `R omega` (m/s) of a wheel without brake and engine, had it the load at rest and no slip of its inertia; `v` is
/// that of the motorcycle. Under engine power (`driven`) the loads follow the acceleration, else rolling resistance.
///
/// Together 0.02 to 0.03 % of a coasting front wheel's radius, nearly what its interval is.
fn free_speed(x: &Samples, i: usize, inputs: &Inputs, wheel: usize, v: f64, driven: bool) -> f64 {
    let rate = x.velocity_x_rate[i];
    if inputs.formulation != Formulation::Corrected || !rate.is_finite() {
        return v;
    }
    let rotating = inputs.rotating_mass();
    let mass = inputs.bike.mass;
    let spin_rate: f64 = (0..2).map(|k| rotating[k] * inputs.radius[k] * rate).sum();
    let total = if driven {
        mass * rate + inputs.drag * v * v
    } else {
        -inputs.rolling * mass * GRAVITY - (rotating[0] + rotating[1]) * rate
    };
    let load = inputs.loads(total, spin_rate, 1.0, 0.0, 0.0)[wheel];
    let slip = -rotating[wheel] * rate / (USUAL_SLIP_STIFFNESS * load);
    let sunk = inputs.radius[wheel] - inputs.loaded_radius(wheel, load);
    v * (1.0 + slip) + x.omega[wheel][i] * sunk
}

/// Rows of one wheel's radius fit: `(omega, R omega, cluster)`; samples of other segments than `coasting` are driven.
fn radius_rows(
    x: &Samples,
    coasting: &Samples,
    inputs: &Inputs,
    wheel: usize,
) -> (Vec<f64>, Vec<f64>, Vec<usize>) {
    let coasts: BTreeSet<usize> = coasting.segment.iter().copied().collect();
    let mut rows = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..x.len() {
        let omega = x.omega[wheel][i];
        let v = x.velocity_x[i] + inputs.zeros.latency * x.velocity_x_rate[i];
        if omega.is_finite() && v.is_finite() && omega > 1.0 {
            let driven = !coasts.contains(&x.segment[i]);
            rows.0.push(omega);
            rows.1.push(free_speed(x, i, inputs, wheel, v, driven));
            rows.2.push(x.segment[i]);
        }
    }
    rows
}

/// Rows of the resistance fit, in units of the weight.
struct ResistanceRows {
    columns: Vec<Vec<f64>>,
    y: Vec<f64>,
    clusters: Vec<usize>,
}

fn resistance_rows(x: &Samples, inputs: &Inputs, radius: [f64; 2]) -> ResistanceRows {
    let bike = &inputs.bike;
    let weight = bike.mass * GRAVITY;
    let corrected = inputs.formulation == Formulation::Corrected;
    let at = Inputs { radius, ..inputs.clone() };
    let inertia: f64 = at.rotating_mass().iter().sum::<f64>() + bike.mass;
    let mut runs = [Vec::new(), Vec::new()];
    for i in 0..x.len() {
        if x.direction[i] != 0.0 {
            let side = usize::from(x.direction[i] < 0.0);
            if runs[side].last() != Some(&x.segment[i]) {
                runs[side].push(x.segment[i]);
            }
        }
    }
    let both = corrected && runs.iter().all(|r| r.len() >= 2);
    let mut rows = ResistanceRows {
        columns: vec![Vec::new(); if both { GRADE + 1 } else { ROLLING + 1 }],
        y: Vec::new(),
        clusters: Vec::new(),
    };
    for i in 0..x.len() {
        let v = x.velocity_x[i] + inputs.zeros.latency * x.velocity_x_rate[i];
        let a = x.acceleration_x[i] - inputs.zeros.acceleration_x;
        if !(v.is_finite() && a.is_finite()) {
            continue;
        }
        rows.columns[DRAG].push(v * v / weight);
        rows.columns[ROLLING].push(1.0);
        if both {
            rows.columns[GRADE].push(x.direction[i]);
        }
        let uphill = if corrected { x.grade[i] } else { 0.0 };
        rows.y.push(-inertia * a / weight - uphill);
        rows.clusters.push(x.segment[i]);
    }
    rows
}

/// A coasting run as a whole.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Run {
    /// Index of the segment.
    pub segment: usize,
    /// Means of what the resistance is fitted to.
    pub columns: Vec<f64>,
    /// Mean resistance over weight.
    pub resistance: f64,
    pub samples: usize,
}

/// The means of each coasting run.
pub(crate) fn runs(x: &Samples, inputs: &Inputs) -> Vec<Run> {
    let rows = resistance_rows(x, inputs, inputs.radius);
    let mut out: Vec<Run> = Vec::new();
    for (i, &segment) in rows.clusters.iter().enumerate() {
        if out.last().is_none_or(|run| run.segment != segment) {
            let columns = vec![0.0; rows.columns.len()];
            out.push(Run { segment, columns, resistance: 0.0, samples: 0 });
        }
        if let Some(run) = out.last_mut() {
            run.samples += 1;
            let n = run.samples as f64;
            for (mean, column) in run.columns.iter_mut().zip(&rows.columns) {
                *mean += (column[i] - *mean) / n;
            }
            run.resistance += (rows.y[i] - run.resistance) / n;
        }
    }
    out
}

/// Fits everything that coasting gives; `front` are the samples for the front radius, `known` says whether the log tells
/// coasting from drive: else there is no resistance.
pub fn fit(x: &Samples, front: &Samples, known: bool, inputs: &Inputs) -> Coasting {
    let mut out = Coasting::default();
    for (wheel, rolling) in [front, x].into_iter().enumerate() {
        let (omega, v, clusters) = radius_rows(rolling, x, inputs, wheel);
        if clustered_fit::count(&clusters) >= 2 {
            out.radius[wheel] = clustered_fit::fit(&[&omega], &v, &clusters, SPEED_FLOOR);
        }
    }
    let fitted = out.radii();
    let radius = [0, 1].map(|k| fitted[k].unwrap_or(inputs.radius[k]));
    let rows = resistance_rows(x, inputs, radius);
    if known && clustered_fit::count(&rows.clusters) >= 3 {
        let columns: Vec<&[f64]> = rows.columns.iter().map(Vec::as_slice).collect();
        out.resistance = clustered_fit::fit(&columns, &rows.y, &rows.clusters, RESISTANCE_FLOOR);
    }
    out
}

/// The same coefficients when the inputs change a little, robust weights held.
pub(crate) fn refit(
    x: &Samples,
    front: &Samples,
    inputs: &Inputs,
    base: &Coasting,
) -> ([Option<f64>; 2], Option<Resistance>) {
    let mut radius = [None; 2];
    for (wheel, slot) in radius.iter_mut().enumerate() {
        if let Some(fitted) = &base.radius[wheel] {
            let rolling = if wheel == 0 { front } else { x };
            let (omega, v, _) = radius_rows(rolling, x, inputs, wheel);
            *slot = clustered_fit::refit(&[&omega], &v, &fitted.weights).map(|t| t[RADIUS]);
        }
    }
    let at = [0, 1].map(|k| radius[k].unwrap_or(inputs.radius[k]));
    let resistance = base.resistance.as_ref().and_then(|fitted| {
        let rows = resistance_rows(x, inputs, at);
        let columns: Vec<&[f64]> = rows.columns.iter().map(Vec::as_slice).collect();
        clustered_fit::refit(&columns, &rows.y, &fitted.weights).map(|t| Resistance::of(&t))
    });
    (radius, resistance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::bike::Bike;
    use crate::estimate::zeros::Zeros;
    use std::path::Path;

    const BIKE: &str = "mass = 250.0\nwheelbase = 1.4\ncg_to_front = 0.7\ncg_height = 0.6\n\
        caster_angle = 0.42\nfront.radius = 0.3\nfront.width = 0.12\nfront.wheel_inertia = 0.45\n\
        front.vertical_stiffness = 130000.0\nfront.deflection_share = 0.333\nrear.radius = 0.3\n\
        rear.width = 0.18\nrear.wheel_inertia = 0.6\nrear.vertical_stiffness = 130000.0\n\
        rear.deflection_share = 0.333\naerodynamics.drag = 0.3\n\
        aerodynamics.rolling_resistance = 0.015\n";

    fn inputs() -> Inputs {
        let bike = Bike::parse(BIKE, "b", Path::new("b.toml")).expect("bike");
        Inputs::nominal(&bike, Formulation::Corrected, Zeros::default())
    }

    /// Three runs that change speed by `rate` (m/s²), of a front wheel of 0.301 m at rest that carries `more` N at a speed
    /// and slips by `slip`.
    fn runs_of(rate: f64, more: impl Fn(f64) -> f64, slip: f64) -> Samples {
        let mut x = Samples::default();
        for segment in 0..3 {
            for i in 0..100 {
                let v = 20.0 + rate * 0.08 * f64::from(i);
                x.segment.push(segment);
                x.velocity_x.push(v);
                x.velocity_x_rate.push(rate);
                x.omega[0].push(v * (1.0 + slip) / (0.301 - 0.333 * more(v) / 130_000.0));
            }
        }
        x
    }

    fn front_radius(x: &Samples, coasting: &Samples) -> f64 {
        let (omega, v, _) = radius_rows(x, coasting, &inputs(), 0);
        v.iter().zip(&omega).map(|(v, omega)| v / omega).sum::<f64>() / v.len() as f64
    }

    #[test]
    fn coasting_shows_the_radius_under_the_load_at_rest_without_slip() {
        // by hand: 5.0 and 6.67 kg of wheels slow down with the motorcycle, each held by its own slip
        let (rate, weight) = (-0.6, 250.0 * GRAVITY);
        let wheels = (0.45 + 0.6) / 0.09;
        let more = (0.015 * weight * 0.6 + wheels * rate * (0.6 - 0.3)) / 1.4;
        let slip = 5.0 * 0.6 / (19.0 * weight / 2.0);
        let x = runs_of(rate, |_| more, slip);
        assert!((x.velocity_x[0] / x.omega[0][0] / 0.301 - 1.0).abs() > 1.5e-4, "a bias to find");
        let found = front_radius(&x, &x);
        assert!((found / 0.301 - 1.0).abs() < 2e-5, "{found}");
    }

    #[test]
    fn drive_takes_load_off_the_front_wheel() {
        // by hand: mass, drag and the wheels' spin pitch the motorcycle up; the front wheel is dragged along
        let (rate, wheels) = (0.8, (0.45 + 0.6) / 0.09);
        let more = |v: f64| -((250.0 * rate + 0.3 * v * v) * 0.6 + wheels * 0.3 * rate) / 1.4;
        let slip = -5.0 * rate / (19.0 * (250.0 * GRAVITY / 2.0 + more(22.0)));
        let x = runs_of(rate, more, slip);
        let [as_coasting, as_driven] =
            [&x, &Samples::default()].map(|coasting| front_radius(&x, coasting) / 0.301 - 1.0);
        assert!(as_coasting > 1e-3 && as_driven.abs() < 3e-5, "{as_coasting} {as_driven}");
    }
}
