//! A box with an inertial unit and a satellite receiver, strapped on any way round: columns like RaceBox's CSV,
//! ISO dates, accelerations in g with gravity in them, rates in degrees a second. Written from memory of its exports.

use nalgebra::{Rotation3, Vector3};

use super::board::{Board, Column, Foreign};
use crate::GRAVITY;

/// Of the rows, Hz.
const RATE: f64 = 25.0;
/// How late the receiver is after the inertial unit, s.
const LATE: f64 = 0.1;
/// Where the box sits from the rear contact, frame axes, m.
const PLACE: [f64; 3] = [0.55, 0.05, 1.0];

pub(super) fn write(mut board: Board<'_>) -> Foreign {
    let gps = board.satellite(PLACE, 0.04, 1.0);
    let centre = board.ridden.entry.model.motorcycle.centre();
    let arm = Vector3::from(PLACE) - centre;
    let mut draw = |limit: f64| board.random.between(-limit, limit);
    let mounting = [draw(0.5), draw(0.5), draw(std::f64::consts::PI)];
    let mut bias = |sd: f64| Vector3::new(draw(sd), draw(sd), draw(sd));
    let (off_force, off_rate) = (bias(0.03), bias(0.5));
    // the box's axes in the frame
    let turned = Rotation3::from_euler_angles(mounting[0], mounting[1], mounting[2]);
    let mut force = [0; 3].map(|_| Vec::with_capacity(board.samples().len()));
    let mut rate = force.clone();
    for s in board.samples() {
        let m = &s.motion;
        let felt = m.rotation.transpose() * (m.acceleration - m.gravity)
            + m.spin_rate.cross(&arm)
            + m.spin.cross(&m.spin.cross(&arm));
        let f = turned.inverse() * felt / GRAVITY + off_force;
        let w = turned.inverse() * m.spin * 1_f64.to_degrees() + off_rate;
        for k in 0..3 {
            force[k].push(f[k]);
            rate[k].push(w[k]);
        }
    }
    let [fx, fy, fz] = force;
    let [wx, wy, wz] = rate;
    let ridden = board.ridden;
    let length = ridden.entry.circuit.length;
    let lap = ridden.hands.iter().map(|h| (h.along / length).max(0.0).floor() + 1.0).collect();
    let speed = gps.speed.iter().map(|v| 3.6 * v).collect();
    let columns = [
        Column::new("Latitude", gps.latitude).step(1e-7, 7).late(LATE),
        Column::new("Longitude", gps.longitude).step(1e-7, 7).late(LATE),
        Column::new("Altitude", gps.altitude).step(0.1, 1).late(LATE),
        Column::new("Speed", speed).noisy(0.1).step(0.01, 2).late(LATE),
        Column::new("GForceX", fx).noisy(0.02).step(0.001, 3),
        Column::new("GForceY", fy).noisy(0.02).step(0.001, 3),
        Column::new("GForceZ", fz).noisy(0.02).step(0.001, 3),
        Column::new("Lap", lap).digits(0).held(),
        Column::new("GyroX", wx).noisy(0.3).step(0.01, 2),
        Column::new("GyroY", wy).noisy(0.3).step(0.01, 2),
        Column::new("GyroZ", wz).noisy(0.3).step(0.01, 2),
    ];
    let mut text = String::from("Record,Time");
    for c in &columns {
        text.push(',');
        text.push_str(c.name);
    }
    text.push('\n');
    let start = ridden.ride.session.meta.start_time.clone().unwrap_or_default();
    let hour = start.get(..13).unwrap_or("2026-07-01T09").to_owned();
    text.push_str(&board.rows(&columns, RATE, ",", |t| {
        let minute = (t / 60.0) as usize;
        format!("{:.0},{hour}:{minute:02}:{:06.3}Z", t * RATE + 1.0, t - 60.0 * minute as f64)
    }));
    let [roll, pitch, yaw] = mounting;
    let more = format!(
        "mounting = [{roll:.5}, {pitch:.5}, {yaw:.5}] # rad, box to frame, Rz Ry Rx\nplace = {PLACE:?} # m\n"
    );
    let truth = board.truth(&columns, &more);
    Foreign { file: "phone.csv".into(), text, truth }
}
