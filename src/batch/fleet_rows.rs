//! What [`crate::fleet`] found, as rows of the fleet's tables.

use std::collections::BTreeMap;

use jiff::Timestamp;

use crate::fleet::BikeAnalysis;
use crate::fleet::events::{Event, Moved};
use crate::fleet::threshold::FALSE_ALARMS;
use crate::rows::{EventRow, FleetRow, PooledRow};

/// Unit by tyre and coefficient.
pub type Units = BTreeMap<(String, String), String>;

/// What the analysis adds to each row of `fleet`.
pub fn complete(rows: &mut [FleetRow], bikes: &[BikeAnalysis]) {
    for row in rows {
        let Some(bike) = bikes.iter().find(|b| b.bike == row.bike_id) else { continue };
        let key = |k: &(String, String)| k.0 == row.tyre && k.1 == row.coefficient;
        let Some(c) = bike.history.keys.iter().position(key) else { continue };
        let series = &bike.series[c];
        let parts = series.components.as_ref();
        // without start times the slope is per session, which the table has no column for
        let timed = bike.history.days.iter().all(Option::is_some);
        let drift = series.drift.as_ref().filter(|_| timed);
        row.between_sd_settled = parts.map(|p| p.sd);
        row.between_ci95_low = parts.map(|p| p.low);
        row.between_ci95_high = parts.map(|p| p.high);
        row.between_sd_fleet = series.fleet_sd;
        row.drift_settled_per_day = drift.map(|d| d.slope);
        row.drift_ci95_low = drift.map(|d| d.low);
        row.drift_ci95_high = drift.map(|d| d.high);
        row.n_events = bike.events.iter().filter(|e| e.moves(c)).count() as i64;
    }
}

/// The rows of `fleet_pooled`.
pub fn pooled_rows(bike: &BikeAnalysis, units: &Units) -> Vec<PooledRow> {
    let history = &bike.history;
    let mut rows = Vec::new();
    for (c, key) in history.keys.iter().enumerate() {
        for (i, pooled) in bike.pooled[c].iter().enumerate() {
            let Some(pooled) = pooled else { continue };
            let sure = history.values[c][i].is_finite();
            let (value, error, status) = match sure {
                true => (history.values[c][i], history.errors[c][i], "ok"),
                false => (history.unsure[c][i], history.unsure_errors[c][i], "poorly_determined"),
            };
            rows.push(PooledRow {
                bike_id: bike.bike.clone(),
                session_id: history.sessions[i].clone(),
                tyre: key.0.clone(),
                coefficient: key.1.clone(),
                unit: units.get(key).cloned().unwrap_or_default(),
                status: status.to_owned(),
                value,
                std_error: error,
                pooled: pooled.value,
                pooled_std_error: pooled.error,
                pooled_ci95_low: pooled.value - 1.96 * pooled.error,
                pooled_ci95_high: pooled.value + 1.96 * pooled.error,
                shrinkage: pooled.shrinkage,
            });
        }
    }
    rows
}

/// The rows of `fleet_events`.
pub fn event_rows(bike: &BikeAnalysis) -> Vec<EventRow> {
    let history = &bike.history;
    let row = |event: &Event| {
        let sessions = event.sessions();
        let mut moved: Vec<&Moved> = event.moved.iter().collect();
        moved.sort_by(|a, b| b.score.abs().total_cmp(&a.score.abs()));
        let named = |m: &&Moved| {
            let (tyre, coefficient) = &history.keys[m.coefficient];
            format!("{tyre} {coefficient}")
        };
        let time = |day: f64| Timestamp::from_millisecond((day * 86_400_000.0).round() as i64).ok();
        EventRow {
            bike_id: bike.bike.clone(),
            kind: event.kind.name().to_owned(),
            tyre: event.tyre.to_owned(),
            coefficients: moved.iter().map(named).collect::<Vec<_>>().join(", "),
            first_session: history.sessions[sessions.start].clone(),
            last_session: history.sessions[sessions.end - 1].clone(),
            first_time: history.days[sessions.start].and_then(time).map(|t| t.to_string()),
            n_sessions: sessions.len() as i64,
            size: moved.first().map(|m| m.size).filter(|s| s.is_finite()),
            evidence: event.score,
            false_alarm_rate: FALSE_ALARMS,
            reason: event.reason.clone(),
        }
    };
    bike.events.iter().map(row).collect()
}
