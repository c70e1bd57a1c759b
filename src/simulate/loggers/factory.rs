//! A factory machine's log: CSV at 100 Hz, short names without units, and among them error flags, targets and raw
//! voltages of the same things.

use super::board::{Board, Column, Foreign};
use crate::GRAVITY;
use crate::simulate::multibody::joint;

/// Of the rows, Hz.
const RATE: f64 = 100.0;
/// How late the receiver is, s.
const LATE: f64 = 0.12;
const KMH: f64 = 3.6;

pub(super) fn write(mut board: Board<'_>) -> Foreign {
    let gps = board.satellite([0.2, 0.0, 0.95], 0.03, 1.0);
    let degrees = |of: fn(&crate::simulate::ride::Sample) -> f64| {
        move |s: &crate::simulate::ride::Sample| of(s).to_degrees()
    };
    let kmh = |v: Vec<f64>| v.into_iter().map(|v| v * KMH).collect::<Vec<f64>>();
    let bar = |k: usize| board.column(|s| s.controls.pressure[k] / 1e5);
    // half a volt at rest, four and a half at 100 bar
    let volt = |k: usize| board.column(|s| 0.5 + 0.04 * s.controls.pressure[k] / 1e5);
    let felt = |axis: usize| {
        board.column(|s| {
            let m = &s.motion;
            (m.rotation.transpose() * (m.acceleration - m.gravity))[axis] / GRAVITY
        })
    };
    let fork = board.column(|s| 1000.0 * s.joints[joint::FORK]);
    let shock = board.column(|s| 300.0 * s.joints[joint::SWING]);
    let target = board.column(|s| 100.0 * (s.controls.throttle * 1.05).min(1.0));
    let columns = [
        Column::new("v_front", kmh(board.wheel_speed(0))).noisy(0.05).step(0.01, 2),
        Column::new("v_rear", kmh(board.wheel_speed(1))).noisy(0.05).step(0.01, 2),
        Column::new("p_brake_fr", bar(0)).noisy(0.03).step(0.01, 2),
        Column::new("p_brake_rr", bar(1)).noisy(0.03).step(0.01, 2),
        Column::new("u_p_brake_fr", volt(0)).noisy(0.002).step(0.001, 3),
        Column::new("u_p_brake_rr", volt(1)).noisy(0.002).step(0.001, 3),
        Column::new("s_susp_fr", fork).noisy(0.1).step(0.01, 2),
        Column::new("s_susp_rr", shock).noisy(0.05).step(0.01, 2),
        Column::new("yawrate_imu", board.column(degrees(|s| s.motion.spin.z)))
            .noisy(0.2)
            .step(0.01, 2),
        Column::new("rollrate_imu", board.column(degrees(|s| s.motion.spin.x)))
            .noisy(0.2)
            .step(0.01, 2),
        Column::new("pitchrate_imu", board.column(degrees(|s| s.motion.spin.y)))
            .noisy(0.2)
            .step(0.01, 2),
        Column::new("acc_x_imu", felt(0)).noisy(0.02).step(0.001, 3),
        Column::new("acc_y_imu", felt(1)).noisy(0.02).step(0.001, 3),
        Column::new("acc_z_imu", felt(2)).noisy(0.02).step(0.001, 3),
        Column::new("lean_imu", board.column(degrees(|s| s.wheels[1].camber)))
            .noisy(0.1)
            .step(0.01, 2)
            .late(0.02),
        Column::new("n_engine", board.revolutions()).noisy(5.0).step(1.0, 0),
        Column::new("n_engine_limit", board.column(|_| 12_500.0)).digits(0),
        Column::new("pos_throttle", board.column(|s| 100.0 * s.controls.throttle)).step(0.1, 1),
        Column::new("pos_throttle_target", target).step(0.1, 1),
        Column::new("gear", board.column(|s| s.controls.gear)).digits(0).held(),
        Column::new("E_grip", board.column(|_| 0.0)).digits(0),
        Column::new("E_imu", board.column(|_| 0.0)).digits(0),
        Column::new("v_target_pit", board.column(|_| 60.0)).digits(0),
        Column::new("v_gps", kmh(gps.speed)).noisy(0.1).step(0.01, 2).late(LATE),
        Column::new("lat_gps", gps.latitude).step(1e-7, 7).late(LATE),
        Column::new("lon_gps", gps.longitude).step(1e-7, 7).late(LATE),
        Column::new("altitude_gps", gps.altitude).step(0.01, 2).late(LATE),
    ];
    let mut text = String::from("t");
    for c in &columns {
        text.push(',');
        text.push_str(c.name);
    }
    text.push('\n');
    text.push_str(&board.rows(&columns, RATE, ",", |t| format!("{t:.3}")));
    let truth = board.truth(&columns, "");
    Foreign { file: "factory.csv".into(), text, truth }
}
