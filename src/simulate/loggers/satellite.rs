//! A satellite logger with a line to the engine: a `.vbo` text as such loggers write it, latitude and longitude in
//! minutes (west is positive), time of day as hhmmss, and a lean that is calculated from course and speed.

use super::board::{Board, Column, Foreign};
use crate::GRAVITY;

/// Of the rows, Hz.
const RATE: f64 = 10.0;
/// How late engine signals are after the receiver's own, s.
const BUS_LATE: f64 = 0.08;

pub(super) fn write(mut board: Board<'_>) -> Foreign {
    let gps = board.satellite([0.2, 0.0, 0.95], 0.03, 1.0);
    let rate = board.rate();
    // what the logger can do: the change of course over half a second
    let span = (0.25 * rate) as usize;
    let n = gps.course.len();
    let lean: Vec<f64> = (0..n)
        .map(|i| {
            let (a, b) = (i.saturating_sub(span), (i + span).min(n - 1));
            let turn = (gps.course[b] - gps.course[a]).to_radians() * rate / (b - a) as f64;
            (gps.speed[i] * turn / GRAVITY).atan().to_degrees()
        })
        .collect();
    let minutes = |x: &[f64], sign: f64| x.iter().map(|x| sign * 60.0 * x).collect::<Vec<f64>>();
    let columns = [
        Column::new("lat", minutes(&gps.latitude, 1.0)).step(1e-6, 6),
        Column::new("long", minutes(&gps.longitude, -1.0)).step(1e-6, 6),
        Column::new("velocity", gps.speed.iter().map(|v| 3.6 * v).collect())
            .noisy(0.08)
            .step(0.001, 3),
        Column::new("heading", gps.course).noisy(0.1).step(0.01, 2).on_circle(360.0),
        Column::new("height", gps.altitude).step(0.01, 2),
        Column::new("rpm", board.revolutions()).noisy(8.0).step(10.0, 0).late(BUS_LATE),
        Column::new("throttle", board.column(|s| 100.0 * s.controls.throttle))
            .step(0.4, 1)
            .late(BUS_LATE),
        Column::new("lean_calc", lean).step(0.1, 1),
    ];
    let mut text = String::from(
        "File created on 01/07/2026 at 09:00:00\n\n[header]\nsatellites\ntime\nlatitude\nlongitude\n\
         velocity kmh\nheading\nheight\nengine speed rpm\nthrottle position %\nlean angle (calculated) deg\n\n\
         [column names]\nsats time",
    );
    for c in &columns {
        text.push(' ');
        text.push_str(c.name);
    }
    text.push_str("\n\n[data]\n");
    text.push_str(&board.rows(&columns, RATE, " ", |t| {
        let (hour, minute) = (9 + (t / 3600.0) as usize, (t / 60.0) as usize % 60);
        format!("011 {hour:02}{minute:02}{:05.2}", t % 60.0)
    }));
    let truth = board.truth(&columns, "");
    Foreign { file: "satellite.vbo".into(), text, truth }
}
