//! Rows of laps, their corners and their points.

use serde::{Deserialize, Serialize};

use super::corners::{corners, sections};
use super::find::{DetectedLaps, Kind, Lap};
use super::grip::{Grip, RideEstimates};
use super::ground::{Ground, MOVING};
use super::trace::{Stations, Trace};
use crate::contract::session::Session;
use crate::statistics::order::quantile;
use crate::store::tables::rows::{
    Ident, LapCoefficientRow, LapCornerRow, LapPointRow, LapRow, LapTrendRow,
};

/// The rows of a track session's laps.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Laps {
    /// Of the table `laps`.
    pub laps: Vec<LapRow>,
    /// Of the table `lap_trends`: what the tyres did over the laps; from the fit of the ride.
    pub trends: Vec<LapTrendRow>,
    /// Of the table `lap_coefficients`.
    #[serde(skip)]
    pub coefficients: Vec<LapCoefficientRow>,
    /// Of the table `lap_corners`.
    pub corners: Vec<LapCornerRow>,
    /// Of the table `lap_points`; not handed on by workers.
    #[serde(skip)]
    pub points: Vec<LapPointRow>,
}

/// Forward acceleration below which it is braking, m/s².
const BRAKING: f64 = -1.5;

/// Finite largest value.
fn most(x: impl Iterator<Item = f64>) -> Option<f64> {
    x.filter(|v| v.is_finite()).max_by(f64::total_cmp)
}

fn finite(x: f64) -> Option<f64> {
    Some(x).filter(|v| v.is_finite())
}

pub(super) fn rows(
    session: &Session,
    ground: &Ground,
    found: &DetectedLaps,
    known: &RideEstimates<'_>,
    ident: &Ident,
) -> Laps {
    let grip = Grip::new(session, ground, known);
    let laps: Vec<LapRow> =
        (0..found.laps.len()).map(|k| lap(k, ground, found, &grip, ident)).collect();
    let best = &found.laps[found.best];
    let Some(stations) = Stations::new(ground, best) else {
        return Laps { laps, ..Laps::default() };
    };
    let traces = stations.traces(ground, found);
    let Some(fastest) = traces.iter().find(|t| t.lap == found.best) else {
        return Laps { laps, ..Laps::default() };
    };
    let signals = |trace: &Trace| Along::new(trace, &found.laps[trace.lap], ground, &grip);
    let of_best = signals(fastest);
    let corners = corners(&of_best.across, &of_best.speed, stations.step);
    let parts = sections(&corners, stations.at.len());
    let mut out = Laps { laps, ..Laps::default() };
    for trace in &traces {
        let along = signals(trace);
        let number = trace.lap as i64;
        for (k, corner) in corners.iter().enumerate() {
            let (from, to) = (parts[k], parts[k + 1]);
            let time = trace.time[to] - trace.time[from];
            let within = corner.start..=corner.end;
            // what is braked before the turn is of the turn, the drive on the straight is not
            let slower = |i: &usize| *i > from && along.along[*i - 1] < BRAKING;
            let braked = (from..=corner.start).rev().take_while(slower).last();
            let braked = braked.map_or(corner.start, |i| i - 1);
            out.corners.push(LapCornerRow {
                ident: ident.clone(),
                lap: number,
                corner: k as i64 + 1,
                direction: if corner.left { "left" } else { "right" }.to_owned(),
                station_start: corner.start as f64 * stations.step,
                station_apex: corner.apex as f64 * stations.step,
                station_end: corner.end as f64 * stations.step,
                time,
                time_difference: time - (fastest.time[to] - fastest.time[from]),
                speed_min: most(along.speed[within.clone()].iter().map(|v| -v)).map(|v| -v),
                roll_peak: along
                    .roll
                    .as_ref()
                    .and_then(|roll| most(roll[within.clone()].iter().map(|r| r.abs()))),
                friction_used_max: most(along.used[braked..=corner.end].iter().copied()),
            });
        }
        for (k, at) in stations.at.iter().enumerate() {
            out.points.push(LapPointRow {
                ident: ident.clone(),
                lap: number,
                station: k as f64 * stations.step,
                latitude: ground.place(*at)[0],
                longitude: ground.place(*at)[1],
                x: at[0],
                y: at[1],
                time: trace.time[k],
                time_difference: trace.time[k] - fastest.time[k],
                speed: finite(along.speed[k]),
                roll: along.roll.as_ref().and_then(|r| finite(r[k])),
                acceleration_x: finite(along.along[k]),
                acceleration_y: finite(along.across[k]),
                friction_used: finite(along.used[k]),
            });
        }
    }
    out
}

/// A lap's signals by station.
struct Along {
    speed: Vec<f64>,
    roll: Option<Vec<f64>>,
    along: Vec<f64>,
    across: Vec<f64>,
    used: Vec<f64>,
}

impl Along {
    fn new(trace: &Trace, lap: &Lap, ground: &Ground, grip: &Grip) -> Self {
        let of = |x: &[f64]| trace.of(x, lap, ground.rate);
        Along {
            speed: of(&ground.speed),
            roll: grip.roll.as_deref().map(of),
            along: of(&grip.along),
            across: of(&grip.across),
            used: of(&grip.used),
        }
    }
}

fn lap(number: usize, ground: &Ground, found: &DetectedLaps, grip: &Grip, ident: &Ident) -> LapRow {
    let lap = &found.laps[number];
    let timed = lap.kind == Kind::Timed;
    let last = ground.samples();
    let from = ((lap.start * ground.rate).ceil() as usize).min(last);
    let to = ((lap.end * ground.rate) as usize + 1).clamp(from, last);
    let moving = |x: &[f64]| -> Vec<f64> {
        (from..to)
            .filter(|&i| ground.speed[i] > MOVING)
            .map(|i| x[i])
            .filter(|v| v.is_finite())
            .collect()
    };
    let roll = grip.roll.as_deref().map(moving).unwrap_or_default();
    let lean = |sign: f64| most(roll.iter().map(|r| sign * r)).map(|r| r.max(0.0));
    let along = moving(&grip.along);
    let mut used = moving(&grip.used);
    LapRow {
        ident: ident.clone(),
        lap: number as i64,
        kind: lap.kind.name().to_owned(),
        line: found.line.source.name().to_owned(),
        line_latitude: finite(ground.place(found.line.middle)[0]),
        line_longitude: finite(ground.place(found.line.middle)[1]),
        timed_by: if found.by_markers { "markers" } else { "position" }.to_owned(),
        position_difference: lap.position_difference,
        best: number == found.best,
        start: lap.start,
        duration: lap.duration(),
        duration_std_error: timed.then_some(lap.error),
        distance: lap.distance,
        speed_max: most(ground.speed[from..to].iter().copied()),
        speed_min: most(ground.speed[from..to].iter().map(|v| -v)).map(|v| -v),
        roll_left: lean(-1.0),
        roll_right: lean(1.0),
        acceleration_x_min: most(along.iter().map(|a| -a)).map(|a| 0.0 - a.max(0.0)),
        acceleration_x_max: most(along.iter().copied()).map(|a| a.max(0.0)),
        friction_used_max: most(used.iter().copied()),
        friction_used_95: quantile(&mut used, 0.95),
        friction_available: grip.available.map(|a| a.friction),
        friction_basis: grip.available.map(|a| a.basis.name().to_owned()),
    }
}
