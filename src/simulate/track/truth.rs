//! What is true of a session on the track beside tyres and forces: what was done when, and the machine's numbers.

use serde::Serialize;

use super::drivetrain::Drivetrain;
use super::ridden::{CORNER, TrackRide};

/// Something the rider did for a while.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Doing {
    /// drive, engine_braking, front_braking, combined_braking, rear_braking, trail_braking, corner_closed,
    /// corner_drive or gear_change.
    pub what: &'static str,
    /// From the log's start, s.
    pub start: f64,
    /// End, s.
    pub end: f64,
    /// Counted from 1.
    pub lap: usize,
}

/// Manoeuvres in time, without gaps.
pub fn doings(ridden: &TrackRide) -> Vec<Doing> {
    let (rate, length) = (ridden.ride.session.rate, ridden.entry.circuit.length);
    let mut out: Vec<Doing> = Vec::new();
    for (i, (hands, sample)) in ridden.hands.iter().zip(&ridden.ride.samples).enumerate() {
        let leaning = sample.wheels[1].camber.abs() > CORNER;
        let pressed = hands.pressure.map(|p| p > 5e4);
        let open = hands.throttle > 0.02;
        let what = match (leaning, pressed) {
            _ if hands.shifting => "gear_change",
            (true, [true, _]) => "trail_braking",
            (true, _) if open => "corner_drive",
            (true, _) => "corner_closed",
            (false, [true, true]) => "combined_braking",
            (false, [true, false]) => "front_braking",
            (false, [false, true]) => "rear_braking",
            (false, _) if open => "drive",
            (false, _) => "engine_braking",
        };
        let (time, lap) = (i as f64 / rate, (hands.along / length).max(0.0) as usize + 1);
        match out.last_mut() {
            Some(last) if last.what == what && last.lap == lap => last.end = time + 1.0 / rate,
            _ => out.push(Doing { what, start: time, end: time + 1.0 / rate, lap }),
        }
    }
    out
}

#[derive(Debug, Serialize)]
struct Notes<'a> {
    session_id: &'a str,
    mass: f64,
    wheelbase: f64,
    cg_to_front: f64,
    cg_height: f64,
    /// Peak friction of the tyres' own road by which the road's multiplies.
    road_friction: f64,
    /// Brake gain, N m/Pa.
    brake_gain: [f64; 2],
    /// Drag, kg/m.
    drag: f64,
    wheel_inertia: [f64; 2],
    crown_radius: [f64; 2],
    /// d force / d slip ratio over load, upright at the static load.
    slip_stiffness: [f64; 2],
    /// m/s, in road axes.
    wind: [f64; 2],
    steepest_grade: f64,
    lap_length: f64,
    /// Crossings, s.
    crossings: &'a [f64],
    attempts_that_fell: &'a [String],
    drivetrain: Drivetrain,
    doing: Vec<Doing>,
}

/// The machine's numbers, crossings of the start line and what was done when, as TOML.
pub fn notes(ridden: &TrackRide) -> String {
    let m = &ridden.entry.model.motorcycle;
    let (centre, loads) = (m.centre(), m.static_loads());
    let friction = ridden.entry.model.road.friction;
    let slip_stiffness = [0, 1].map(|k| {
        let pull = |slip_ratio: f64| {
            let load = loads[k];
            let input = crate::tyre::paper::Input {
                slip_ratio,
                slip_angle: 0.0,
                camber: 0.0,
                load,
                friction,
            };
            m.tyres.as_ref().map_or(f64::NAN, |t| t[k].forces(&input).force_x / load)
        };
        (pull(1e-4) - pull(-1e-4)) / 2e-4
    });
    let crown = [0, 1].map(|k| m.tyres.as_ref().map_or(f64::NAN, |t| t[k].carcass().crown));
    let notes = Notes {
        session_id: &ridden.ride.session.meta.session_id,
        mass: m.mass(),
        wheelbase: m.wheelbase(),
        cg_to_front: m.centres[0].x - centre.x,
        cg_height: centre.z,
        road_friction: friction,
        brake_gain: m.brake_gain,
        drag: 0.5 * m.air_density * m.aerodynamics[0],
        wheel_inertia: [0, 1].map(|k| m.wheels[k].about_origin[(1, 1)]),
        crown_radius: crown,
        slip_stiffness,
        wind: ridden.entry.wind,
        steepest_grade: ridden.entry.grade,
        lap_length: ridden.entry.circuit.length,
        crossings: &ridden.crossings,
        attempts_that_fell: &ridden.failed,
        drivetrain: ridden.entry.drivetrain,
        doing: doings(ridden),
    };
    toml::to_string(&notes).unwrap_or_else(|e| format!("# cannot be written: {e}\n"))
}
