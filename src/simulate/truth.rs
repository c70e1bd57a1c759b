//! What a characterisation of the simulated bike must find.
//!
//! Most coefficients are the plant's own parameters. `c1`, `c3` (eq. 37) and `ct` (eq. 38)
//! describe tyre, bike and course together: they are the same functions fitted by least squares
//! to the true slip angles, cambers and forces of the ride.

use super::Simulated;
use super::motorcycle::Plant;
use crate::GRAVITY;
use crate::bike::Axle;
use crate::model::tyre::trail_0;
use crate::segment::Kind;

/// One true coefficient: tyre, name, value, unit.
pub type True = (&'static str, &'static str, f64, &'static str);

/// One tyre in quasi-static cornering.
#[derive(Debug, Clone, Copy)]
struct Point {
    camber: f64,
    slip_angle: f64,
    friction_y: f64,
}

/// The true states of a tyre in the quasi-static, uncombined samples of a ride's corners.
fn cornering(plant: &Plant, ride: &Simulated, tyre: usize) -> Vec<Point> {
    let rate = ride.session.rate;
    let weight = plant.mass * GRAVITY;
    let mut points = Vec::new();
    for &(kind, start, end, _) in &ride.labels {
        if kind != Kind::Cornering {
            continue;
        }
        for i in (start * rate) as usize..((end * rate) as usize).min(ride.states.len()) {
            let (state, response) = (&ride.states[i], &ride.trace[i]);
            let pull = plant.mass * response.acceleration[0] + plant.drag * state.vx * state.vx;
            if state.roll_rate.abs() < 0.2 && state.roll.abs() > 0.07 && pull.abs() < 0.15 * weight
            {
                points.push(Point {
                    camber: response.camber[tyre],
                    slip_angle: state.alpha[tyre],
                    friction_y: response.tyre[tyre].force_y / response.load[tyre],
                });
            }
        }
    }
    points
}

/// `(c1, c3)` of eq. 37 by least squares.
fn slip_camber(points: &[Point]) -> (f64, f64) {
    let sum = |f: &dyn Fn(&Point) -> f64| points.iter().map(f).sum::<f64>();
    let g = |p: &Point, n: i32| p.camber.powi(n);
    let (a, b, d) = (sum(&|p| g(p, 2)), sum(&|p| g(p, 4)), sum(&|p| g(p, 6)));
    let (x, y) = (sum(&|p| p.slip_angle * g(p, 1)), sum(&|p| p.slip_angle * g(p, 3)));
    let det = a * d - b * b;
    ((x * d - y * b) / det, (a * y - b * x) / det)
}

/// `ct` of eq. 38 by least squares.
fn lateral_friction(points: &[Point]) -> f64 {
    let sum = |f: &dyn Fn(&Point) -> f64| points.iter().map(f).sum::<f64>();
    sum(&|p| p.friction_y * p.camber.tan()) / sum(&|p| p.camber.tan().powi(2))
}

/// Every coefficient of the contract.
pub fn coefficients(plant: &Plant, ride: &Simulated) -> Vec<True> {
    let mut rows = Vec::new();
    let (lf, l) = (plant.cg_to_front, plant.wheelbase);
    let share = [(l - lf) / l, lf / l];
    for (i, axle) in Axle::BOTH.into_iter().enumerate() {
        let tyre = &plant.tyres[i];
        let name = axle.name();
        let points = cornering(plant, ride, i);
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
