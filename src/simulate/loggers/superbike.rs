//! A production superbike's bus log: CSV at 10 Hz with units in brackets, the lean of the maker's own inertial
//! unit, wheel speeds by nominal circumferences, a satellite receiver that is late; no yaw rate.

use super::board::{Board, Column, Foreign};

/// Of the rows, Hz.
const RATE: f64 = 10.0;
/// How late the receiver's speed, course and place are, s.
const LATE: f64 = 0.2;
/// How late the lean is: the unit's filter, s.
const LEAN_LATE: f64 = 0.04;
const KMH: f64 = 3.6;

pub(super) fn write(mut board: Board<'_>) -> Foreign {
    let gps = board.satellite([0.2, 0.0, 0.95], 0.04, 1.2);
    let zero = 0.6 * board.random.normal();
    let slow = board.wander(0.7, 15.0);
    let kmh = |v: Vec<f64>| v.into_iter().map(|v| v * KMH).collect::<Vec<f64>>();
    let lean = board.samples().iter().zip(&slow);
    // right is positive, as in ISO 8855
    let lean = lean.map(|(s, slow)| s.wheels[1].camber.to_degrees() + zero + slow).collect();
    let ridden = board.ridden;
    let length = ridden.entry.circuit.length;
    let lap = ridden.hands.iter().map(|h| (h.along / length).max(0.0).floor() + 1.0).collect();
    let bar = |k: usize| board.column(|s| s.controls.pressure[k] / 1e5);
    let front = kmh(board.wheel_speed(0));
    let columns = [
        Column::new("Lap", lap).digits(0).held(),
        // the clock on the dashboard: the front wheel, whole numbers
        Column::new("Speed (km/h)", front.clone()).step(1.0, 0),
        Column::new("Wheel Speed F (km/h)", front).noisy(0.08).step(0.1, 1),
        Column::new("Wheel Speed R (km/h)", kmh(board.wheel_speed(1))).noisy(0.08).step(0.1, 1),
        Column::new("RPM", board.revolutions()).noisy(8.0).step(10.0, 0),
        Column::new("Gear", board.column(|s| s.controls.gear)).digits(0).held(),
        Column::new("TPS (%)", board.column(|s| 100.0 * s.controls.throttle)).step(0.4, 1),
        Column::new("Brake F (bar)", bar(0)).step(0.1, 1),
        Column::new("Brake R (bar)", bar(1)).step(0.1, 1),
        Column::new("Lean (deg)", lean).noisy(0.15).step(0.1, 1).late(LEAN_LATE),
        Column::new("GPS Speed (km/h)", kmh(gps.speed)).noisy(0.1).step(0.01, 2).late(LATE),
        Column::new("Latitude (deg)", gps.latitude).step(1e-7, 7).late(LATE),
        Column::new("Longitude (deg)", gps.longitude).step(1e-7, 7).late(LATE),
        Column::new("Course (deg)", gps.course)
            .noisy(0.1)
            .step(0.01, 2)
            .late(LATE)
            .on_circle(360.0),
        Column::new("Altitude (m)", gps.altitude).step(0.1, 1).late(LATE),
        Column::new("Water Temp (C)", board.column(|_| 84.0)).digits(0),
        Column::new("Error Flags", board.column(|_| 0.0)).digits(0),
    ];
    let mut text = String::from("Time (ms)");
    for c in &columns {
        text.push(',');
        text.push_str(c.name);
    }
    text.push('\n');
    text.push_str(&board.rows(&columns, RATE, ",", |t| format!("{:.0}", 1000.0 * t)));
    let truth = board.truth(&columns, &format!("lean_zero = {zero:.3} # deg\n"));
    Foreign { file: "superbike.csv".into(), text, truth }
}
