//! What a characterisation of the simulated bike must find.
//!
//! Most coefficients are the plant's own parameters. `c1`, `c3` (eq. 37) and `ct` (eq. 38)
//! belong to tyre and bike together: they come from steady turns of the undisturbed plant.

use super::motorcycle::{Action, Plant, State};
use super::plan::Phase;
use super::random::Random;
use super::rider::{Disturbance, Rider};
use crate::GRAVITY;
use crate::bike::Axle;
use crate::model::tyre::trail_0;
use crate::segment::Direction;

/// One true coefficient: tyre, name, value, unit.
pub type True = (&'static str, &'static str, f64, &'static str);

/// What one steady turn shows of a tyre.
#[derive(Debug, Clone, Copy)]
pub struct SteadyPoint {
    /// Camber, rad.
    pub camber: f64,
    /// Slip angle, rad.
    pub slip_angle: f64,
    /// Lateral friction `Fy/Fz`.
    pub friction_y: f64,
}

/// Steady left turns of the given leans (rad, positive) and radius (m): front and rear tyre.
pub fn steady_turns(plant: &Plant, leans: &[f64], radius: f64) -> Vec<[SteadyPoint; 2]> {
    leans
        .iter()
        .map(|&lean| {
            let speed = (GRAVITY * lean.tan() * 0.88 * radius).sqrt().max(5.0);
            let phases = [
                Phase::Cruise { speed, duration: 1.0 },
                Phase::Corner {
                    direction: Direction::Left,
                    lean,
                    ramp: 2.0,
                    turn: f64::INFINITY,
                    speed: Some(speed),
                },
            ];
            let dt = 0.01;
            let calm = Disturbance::default();
            let mut rider = Rider::new(plant, &phases, calm, Random::new(0, "steady"), dt);
            let mut state = State { vx: speed, ..State::default() };
            state.omega = [0, 1].map(|i| speed / plant.tyres[i].rolling_radius);
            let mut action = Action::default();
            for _ in 0..1200 {
                let response = plant.response(&state, &action);
                action = rider.act(&state, &response).0;
                plant.advance(&mut state, &action, dt);
            }
            let response = plant.response(&state, &action);
            [0, 1].map(|i| SteadyPoint {
                camber: response.camber[i],
                slip_angle: state.alpha[i],
                friction_y: response.tyre[i].force_y / response.load[i],
            })
        })
        .collect()
}

/// `(c1, c3)` of eq. 37 by least squares.
fn slip_camber(points: &[SteadyPoint]) -> (f64, f64) {
    let sum = |f: &dyn Fn(&SteadyPoint) -> f64| points.iter().map(f).sum::<f64>();
    let g = |p: &SteadyPoint, n: i32| p.camber.powi(n);
    let (a, b, d) = (sum(&|p| g(p, 2)), sum(&|p| g(p, 4)), sum(&|p| g(p, 6)));
    let (x, y) = (sum(&|p| p.slip_angle * g(p, 1)), sum(&|p| p.slip_angle * g(p, 3)));
    let det = a * d - b * b;
    ((x * d - y * b) / det, (a * y - b * x) / det)
}

/// `ct`: the limit of `mu_y / tan(gamma)` upright, from a parabola in `gamma^2`.
fn lateral_friction(points: &[SteadyPoint]) -> f64 {
    let n = points.len() as f64;
    let x = |p: &SteadyPoint| p.camber * p.camber;
    let y = |p: &SteadyPoint| p.friction_y / p.camber.tan();
    let mean = |f: &dyn Fn(&SteadyPoint) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (mx, my) = (mean(&x), mean(&y));
    let slope = mean(&|p| (x(p) - mx) * (y(p) - my)) / mean(&|p| (x(p) - mx).powi(2));
    my - slope * mx
}

/// Every coefficient of the contract.
pub fn coefficients(plant: &Plant) -> Vec<True> {
    let mut rows = Vec::new();
    let leans: Vec<f64> = (2..=12).map(|i| 0.05 * f64::from(i)).collect();
    let turns = steady_turns(plant, &leans, 14.0);
    let (lf, l) = (plant.cg_to_front, plant.wheelbase);
    let share = [(l - lf) / l, lf / l];
    for (i, axle) in Axle::BOTH.into_iter().enumerate() {
        let tyre = &plant.tyres[i];
        let name = axle.name();
        let points: Vec<SteadyPoint> = turns.iter().map(|t| t[i]).collect();
        let (c1, c3) = slip_camber(&points);
        let k0 = tyre.stiffness.k_alpha(0.0, tyre.side_force_ratio);
        let mf = tyre.friction;
        let load = plant.mass * GRAVITY * share[i];
        rows.extend([
            (name, "effective_rolling_radius", tyre.rolling_radius, "m"),
            (name, "peak_slip", tyre.peak_slip, "1"),
            (name, "mf_b", mf.b, "1"),
            (name, "mf_c", mf.c, "1"),
            (name, "mf_d", mf.d, "1"),
            (name, "mf_e1", mf.e1, "1"),
            (name, "mf_e2", mf.e2, "1"),
            (name, "slip_camber_c1", c1, "1"),
            (name, "slip_camber_c3", c3, "1/rad2"),
            (name, "lateral_friction_ct", lateral_friction(&points), "1"),
            (name, "cornering_stiffness_0", k0, "1/rad"),
            (name, "camber_stiffness_0", k0 * tyre.side_force_ratio, "1/rad"),
            (name, "side_force_ratio", tyre.side_force_ratio, "1"),
            (name, "twisting_stiffness", tyre.twisting_stiffness, "m/rad"),
            (name, "overturning_stiffness", tyre.overturning_stiffness, "m"),
            (name, "relaxation_length", tyre.relaxation_length, "m"),
            (
                name,
                "pneumatic_trail_0",
                trail_0(tyre.rolling_radius, tyre.vertical_stiffness, load),
                "m",
            ),
        ]);
    }
    let crown: f64 = (0..2).map(|i| share[i] * plant.tyres[i].overturning_stiffness).sum();
    rows.extend([
        ("vehicle", "drag", plant.drag, "kg/m"),
        ("vehicle", "rolling_resistance", plant.tyres[0].rolling_resistance, "1"),
        ("vehicle", "overturning_stiffness", crown, "m"),
    ]);
    rows
}
