//! What [`crate::fleet`] found, as rows of the fleet's tables.

use std::collections::BTreeMap;

use jiff::Timestamp;

use crate::fleet::BikeAnalysis;
use crate::fleet::events::{Event, Moved};
use crate::fleet::ratio::Ratio;
use crate::fleet::threshold::FALSE_ALARMS;
use crate::store::tables::rows::{EventRow, FleetRow, PooledRow, RatioRow, Status};

/// Unit by tyre and coefficient.
pub(crate) type Units = BTreeMap<(String, String), String>;

/// Value and interval of a session's own row of `coefficients`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Own {
    pub value: f64,
    pub std_error: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
}

/// Rows by bike, session, tyre and coefficient.
pub(crate) type Owns = BTreeMap<[String; 4], Own>;

/// Adds the results of the analysis to each row of `fleet`.
pub(crate) fn complete(rows: &mut [FleetRow], bikes: &[BikeAnalysis]) {
    let by_id: BTreeMap<&str, &BikeAnalysis> =
        bikes.iter().map(|bike| (bike.bike.as_str(), bike)).collect();
    for row in rows {
        let Some(bike) = by_id.get(row.bike_id.as_str()) else { continue };
        let key = |k: &(String, String)| k.0 == row.tyre && k.1 == row.coefficient;
        let Some(c) = bike.history.keys.iter().position(key) else { continue };
        let series = &bike.series[c];
        let parts = series.components.as_ref();
        // without start times the slope is per session, which the table has no column for
        let drift = series.drift.as_ref().filter(|_| bike.history.is_dated());
        row.between_sd_settled = parts.map(|p| p.sd);
        row.between_ci95_low = parts.map(|p| p.low);
        row.between_ci95_high = parts.map(|p| p.high);
        row.between_sd_fleet = series.fleet_sd;
        row.drift_settled_per_day = drift.map(|d| d.slope);
        row.drift_ci95_low = drift.map(|d| d.low);
        row.drift_ci95_high = drift.map(|d| d.high);
        row.n_events = bike.events.iter().filter(|e| e.affects(c)).count() as i64;
    }
}

/// The rows of `fleet_pooled`.
///
/// Rows of pooled values. A value without a share of other sessions keeps the interval of its own row, which for few
/// manoeuvres is wider than 1.96 standard errors.
pub(crate) fn pooled_rows(bike: &BikeAnalysis, units: &Units, owns: &Owns) -> Vec<PooledRow> {
    let history = &bike.history;
    let mut rows = Vec::new();
    for (c, key) in history.keys.iter().enumerate() {
        for (i, pooled) in bike.pooled[c].iter().enumerate() {
            let Some(pooled) = pooled else { continue };
            let determined = history.values[c][i].is_finite();
            let (value, error, status) = match determined {
                true => (history.values[c][i], history.errors[c][i], Status::Ok),
                false => (history.poor[c][i], history.poor_errors[c][i], Status::PoorlyDetermined),
            };
            let session = [&bike.bike, &history.sessions[i], &key.0, &key.1].map(String::clone);
            let own = owns.get(&session).map(|own| own.interval);
            let half = 1.96 * pooled.error;
            let usual = [pooled.value - half, pooled.value + half];
            let interval = own.filter(|_| pooled.shrinkage == 0.0).unwrap_or(usual);
            rows.push(PooledRow {
                bike_id: bike.bike.clone(),
                session_id: history.sessions[i].clone(),
                tyre: key.0.clone(),
                coefficient: key.1.clone(),
                unit: units.get(key).cloned().unwrap_or_default(),
                status,
                value,
                std_error: error,
                ci95_low: own.map(|ends| ends[0]),
                ci95_high: own.map(|ends| ends[1]),
                pooled: pooled.value,
                pooled_std_error: pooled.error,
                pooled_ci95_low: interval[0],
                pooled_ci95_high: interval[1],
                shrinkage: pooled.shrinkage,
            });
        }
    }
    rows
}

/// The rows of `fleet_events`.
pub(crate) fn event_rows(bike: &BikeAnalysis) -> Vec<EventRow> {
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
            tyre: event.affected.name().to_owned(),
            coefficients: moved.iter().map(named).collect::<Vec<_>>().join(", "),
            first_session: history.sessions[sessions.start].clone(),
            last_session: history.sessions[sessions.end - 1].clone(),
            first_time: history.days[sessions.start].and_then(time).map(|t| t.to_string()),
            n_sessions: sessions.len() as i64,
            size: moved.first().map(|m| m.size).filter(|s| s.is_finite()),
            evidence: event.score,
            false_alarm_rate: FALSE_ALARMS,
            false_discovery_rate: Some(event.discovery).filter(|q| q.is_finite()),
            reason: event.reason.clone(),
        }
    };
    bike.events.iter().map(row).collect()
}

/// The rows of `fleet_ratios`.
pub(crate) fn ratio_rows(bike: &BikeAnalysis) -> Vec<RatioRow> {
    let name = |i: Option<&usize>| i.map(|i| bike.history.sessions[*i].clone()).unwrap_or_default();
    let known = |x: f64| x.is_finite().then_some(x);
    let row = |r: &Ratio| {
        let status = r.status();
        let (code, reason) = r.reason().unzip();
        let advice = "riders who lean off differently, or wide and tight corners, would show it";
        RatioRow {
            bike_id: bike.bike.clone(),
            tyre: r.axle.name().to_owned(),
            first_session: name(r.sessions.first()),
            last_session: name(r.sessions.last()),
            n_sessions: r.n as i64,
            side_force_ratio: known(r.value),
            ci95_low: known(r.low),
            ci95_high: known(r.high),
            cornering_stiffness_0: known(r.stiffness),
            scatter: known(r.scatter),
            variety: r.variety,
            noise: r.noise,
            status,
            reason_code: code.map(|code| code.name().to_owned()),
            advice: reason.as_ref().map(|_| advice.to_owned()),
            reason,
        }
    };
    bike.ratios.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::{Observation, analyse};
    use crate::store::tables::file::batch;

    #[test]
    fn the_rows_fit_their_schemas_and_a_lone_wild_session_is_an_event() {
        let row = |i: usize| Observation {
            bike: "b".into(),
            tyre: "front".into(),
            coefficient: "mf_d".into(),
            session: format!("s{i:02}"),
            day: Some(20_000.0 + i as f64),
            value: [1.0, 1.02, 0.99, 1.01, 0.98][i % 5] + if i == 7 { 1.0 } else { 0.0 },
            error: if i == 3 { 0.1 } else { 0.01 },
            determined: i != 9,
            ..Observation::default()
        };
        let bikes = analyse(&(0..20).map(row).collect::<Vec<_>>());
        let mut fleet = vec![FleetRow {
            bike_id: "b".into(),
            tyre: "front".into(),
            coefficient: "mf_d".into(),
            ..FleetRow::default()
        }];
        complete(&mut fleet, &bikes);
        assert_eq!(fleet[0].n_events, 1);
        assert!(fleet[0].between_sd_settled.is_some() && fleet[0].drift_ci95_low.is_some());
        let events: Vec<EventRow> = event_rows(&bikes[0]);
        assert_eq!((events[0].kind.as_str(), events[0].n_sessions), ("outlier", 1));
        assert_eq!(events[0].first_session, "s07");
        assert!(events[0].false_discovery_rate.is_some_and(|q| q < 1e-3), "{events:?}");
        assert_eq!(events[0].first_time.as_deref(), Some("2024-10-11T00:00:00Z"));
        let pooled = pooled_rows(&bikes[0], &Units::new(), &Owns::new());
        assert_eq!(pooled.len(), 20);
        assert!(pooled[3].shrinkage > pooled[2].shrinkage && pooled[7].shrinkage == 0.0);
        assert_eq!(pooled[9].status, Status::PoorlyDetermined);
        batch(&fleet).expect("fleet");
        batch(&events).expect("events");
        batch(&pooled).expect("pooled");
    }
}
