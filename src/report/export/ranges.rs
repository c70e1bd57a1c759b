//! What a session rode of a tyre: where its coefficients hold.
//!
//! Read from the tables: slips and cambers from the samples that the fits used (those with at
//! least half of the full weight), accelerations from the manoeuvres. Loads follow from the
//! accelerations and the bike file.

use serde::Serialize;

use crate::GRAVITY;
use crate::contract::bike::{Axle, Bike};
use crate::motorcycle::balance::{Lengths, front_load_line, pitching};
use crate::report::plots::fits::{FRICTION_X, FRICTION_Y, K_ALPHA, SLIP_ANGLE, STIFFNESS};
use crate::report::plots::plot::{DATA, Plot};
use crate::store::tables::rows::{Manoeuvre, PlotPoint};

/// Least robust weight of a sample that counts as ridden.
const COUNTS: f64 = 0.5;

/// Least and largest of what was ridden; none where the ride has no such samples.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Ranges {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slip_ratio: Option<[f64; 2]>,
    /// Slip angle, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slip_angle: Option<[f64; 2]>,
    /// Camber, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camber: Option<[f64; 2]>,
    /// Lateral over vertical force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral_friction: Option<[f64; 2]>,
    /// Forward acceleration of the manoeuvres that were used, m/s².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration_x: Option<[f64; 2]>,
    /// Forward speed of the manoeuvres that were used, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed: Option<[f64; 2]>,
    /// Camber, rad, and fitted cornering stiffness per load there, 1/rad, over the ridden camber.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stiffness_over_camber: Vec<[f64; 2]>,
    /// Longitudinal over vertical force of the samples that the friction was fitted to.
    #[serde(skip)]
    pub longitudinal_friction: Vec<f64>,
}

/// Every so-many-th point of the stiffness curve is kept.
const STEP: usize = 10;

impl Ranges {
    /// Of both tyres of a session.
    pub(crate) fn of(manoeuvres: &[Manoeuvre], points: &[PlotPoint]) -> [Self; 2] {
        let (mut acceleration, mut speed) = (None, None);
        for m in manoeuvres.iter().filter(|m| m.used) {
            acceleration = widened(acceleration, m.acceleration_x_peak);
            speed = widened(widened(speed, m.speed_start), m.speed_end);
        }
        [0, 1].map(|k| {
            let over = |plots: &[Plot; 2], pick: fn(&PlotPoint) -> Option<f64>| {
                points
                    .iter()
                    .filter(|p| p.plot == plots[k].name && p.series == DATA)
                    .filter(|p| p.weight.is_none_or(|w| w >= COUNTS))
                    .fold(None, |range, p| widened(range, pick(p)))
            };
            let stiffness: Vec<[f64; 2]> = points
                .iter()
                .filter(|p| p.plot == STIFFNESS[k].name && p.series == K_ALPHA.name)
                .filter_map(|p| Some([p.x, p.y?]))
                .collect();
            let stiffness_over_camber = stiffness.into_iter().step_by(STEP).collect();
            Ranges {
                slip_ratio: over(&FRICTION_X, |p| Some(p.x)),
                slip_angle: over(&SLIP_ANGLE, |p| p.y),
                camber: over(&SLIP_ANGLE, |p| Some(p.x)),
                lateral_friction: over(&FRICTION_Y, |p| p.y),
                acceleration_x: acceleration,
                speed,
                stiffness_over_camber,
                longitudinal_friction: points
                    .iter()
                    .filter(|p| p.plot == FRICTION_X[k].name && p.series == DATA)
                    .filter(|p| p.weight.is_none_or(|w| w >= COUNTS))
                    .filter_map(|p| p.y)
                    .collect(),
            }
        })
    }

    /// Loads of the ridden accelerations, N: the static one where nothing is known.
    pub fn load(&self, bike: &Bike, axle: Axle) -> [f64; 2] {
        let at = |acceleration: f64| {
            let pitching = pitching(bike.mass * acceleration, bike.cg_height, 0.0, 1.0);
            let loads = Lengths::of(bike).loads(bike.mass * GRAVITY, 0.0, pitching);
            loads[axle as usize].max(0.0)
        };
        let [low, high] = self.acceleration_x.unwrap_or([0.0, 0.0]);
        let (a, b) = (at(low.min(0.0)), at(high.max(0.0)));
        [a.min(b), a.max(b)]
    }

    /// Load beyond that at rest over it of a wheel that brakes or drives alone at a longitudinal friction.
    pub fn braked_extra_load(bike: &Bike, axle: Axle, friction: f64) -> f64 {
        // m a = friction Fz, and Fz = Fz0 -+ m a h/l
        let transfer = friction * front_load_line(bike).1;
        let share = match axle {
            Axle::Front => 1.0 + transfer,
            Axle::Rear => 1.0 - transfer,
        };
        1.0 / share.max(0.1) - 1.0
    }

    /// Loads, N, from that at rest to those of the wheel that brakes or drives alone, at the frictions that were fitted.
    pub fn braked_loads(&self, bike: &Bike, axle: Axle) -> [f64; 2] {
        let rest = bike.static_load(axle);
        let at = |y: &f64| rest * (1.0 + Self::braked_extra_load(bike, axle, *y));
        let all = self.longitudinal_friction.iter().map(at);
        all.fold([rest, rest], |[low, high], load| [low.min(load), high.max(load)])
    }

    /// Mean of a function of the longitudinal friction over the samples that it was fitted to, by the square of the
    /// friction: so much does each say of its peak. 1 where there are none.
    pub fn mean_by_square(&self, of: impl Fn(f64) -> f64) -> f64 {
        let sum = |f: &dyn Fn(f64) -> f64| -> f64 {
            self.longitudinal_friction.iter().map(|y| y * y * f(*y)).sum()
        };
        let weight = sum(&|_| 1.0);
        if weight > 0.0 { sum(&of) / weight } else { 1.0 }
    }

    /// The largest size of a range, which the model takes both ways.
    pub fn both_ways(range: Option<[f64; 2]>) -> Option<f64> {
        range.map(|[low, high]| low.abs().max(high.abs()))
    }
}

fn widened(range: Option<[f64; 2]>, x: Option<f64>) -> Option<[f64; 2]> {
    match (range, x.filter(|x| x.is_finite())) {
        (Some([low, high]), Some(x)) => Some([low.min(x), high.max(x)]),
        (None, Some(x)) => Some([x, x]),
        (range, None) => range,
    }
}
