//! The tables over all sessions, read back: `fleet`, `fleet_events`, `fleet_ratios`,
//! `fleet_pooled`.

use std::collections::BTreeMap;
use std::path::Path;

use crate::report::tables::{Columns, collect, for_each_batch};
use crate::report::{Error, words};
use crate::tables::rows::{EventRow, FleetRow, RatioRow};

/// Every `fleet` row, by bike, then in the contract's order.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn fleet(out: &Path) -> Result<Vec<FleetRow>, Error> {
    let mut rows = collect(out, "fleet", |c, i| FleetRow {
        bike_id: c.text("bike_id", i),
        tyre: c.text("tyre", i),
        coefficient: c.text("coefficient", i),
        unit: c.text("unit", i),
        n_sessions: c.integer("n_sessions", i),
        median: c.maybe("median", i),
        robust_sd: c.maybe("robust_sd", i),
        quartile_1: c.maybe("quartile_1", i),
        quartile_3: c.maybe("quartile_3", i),
        within_sd: c.maybe("within_sd", i),
        between_sd: c.maybe("between_sd", i),
        drift_per_day: c.maybe("drift_per_day", i),
        n_flagged: c.integer("n_flagged", i),
        flagged_sessions: c.maybe_text("flagged_sessions", i),
        between_sd_settled: c.maybe("between_sd_settled", i),
        between_ci95_low: c.maybe("between_ci95_low", i),
        between_ci95_high: c.maybe("between_ci95_high", i),
        between_sd_fleet: c.maybe("between_sd_fleet", i),
        drift_settled_per_day: c.maybe("drift_settled_per_day", i),
        drift_ci95_low: c.maybe("drift_ci95_low", i),
        drift_ci95_high: c.maybe("drift_ci95_high", i),
        n_events: c.integer("n_events", i),
    })?;
    rows.sort_by(|a, b| {
        (&a.bike_id, words::order(&a.tyre, &a.coefficient))
            .cmp(&(&b.bike_id, words::order(&b.tyre, &b.coefficient)))
    });
    Ok(rows)
}

/// Every `fleet_events` row, the surest first.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn events(out: &Path) -> Result<Vec<EventRow>, Error> {
    let mut rows = collect(out, "fleet_events", |c, i| EventRow {
        bike_id: c.text("bike_id", i),
        kind: c.text("kind", i),
        tyre: c.text("tyre", i),
        coefficients: c.text("coefficients", i),
        first_session: c.text("first_session", i),
        last_session: c.text("last_session", i),
        first_time: c.maybe_text("first_time", i),
        n_sessions: c.integer("n_sessions", i),
        size: c.maybe("size", i),
        evidence: c.number("evidence", i),
        false_alarm_rate: c.number("false_alarm_rate", i),
        reason: c.text("reason", i),
    })?;
    rows.sort_by(|a, b| {
        b.evidence.abs().total_cmp(&a.evidence.abs()).then_with(|| a.bike_id.cmp(&b.bike_id))
    });
    Ok(rows)
}

/// Every `fleet_ratios` row, by bike, the front first.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn ratios(out: &Path) -> Result<Vec<RatioRow>, Error> {
    let mut rows = collect(out, "fleet_ratios", |c, i| RatioRow {
        bike_id: c.text("bike_id", i),
        tyre: c.text("tyre", i),
        first_session: c.text("first_session", i),
        last_session: c.text("last_session", i),
        n_sessions: c.integer("n_sessions", i),
        side_force_ratio: c.maybe("side_force_ratio", i),
        ci95_low: c.maybe("ci95_low", i),
        ci95_high: c.maybe("ci95_high", i),
        cornering_stiffness_0: c.maybe("cornering_stiffness_0", i),
        scatter: c.maybe("scatter", i),
        variety: c.number("variety", i),
        noise: c.number("noise", i),
        status: c.text("status", i),
        reason: c.maybe_text("reason", i),
    })?;
    // a stable sort: tyres that followed one another on an axle stay in their order
    rows.sort_by(|a, b| (&a.bike_id, &a.tyre).cmp(&(&b.bike_id, &b.tyre)));
    Ok(rows)
}

/// One session's value of a coefficient, its own and with its siblings' help. Small: a fleet has
/// hundreds of thousands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Place of the session.
    pub session: u32,
    /// Whether its status is `ok`.
    pub sure: bool,
    /// Its own estimate.
    pub value: f32,
    /// Its standard error.
    pub error: f32,
    /// The pooled estimate.
    pub pooled: f32,
    /// Lower end of its 95 % interval.
    pub low: f32,
    /// Upper end.
    pub high: f32,
    /// Weight of the siblings.
    pub shrinkage: f32,
}

/// Values by bike, tyre and coefficient.
pub type Histories = BTreeMap<(String, String, String), Vec<Seen>>;

/// The table `fleet_pooled`, compact; `places` are the sessions by (bike, session). Rows of
/// sessions that are not there are left out.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn histories(out: &Path, places: &BTreeMap<(&str, &str), usize>) -> Result<Histories, Error> {
    let mut found = Histories::new();
    for_each_batch(out, "fleet_pooled", |c: &Columns, n| {
        for i in 0..n {
            let bike = c.str("bike_id", i);
            let Some(place) = places.get(&(bike, c.str("session_id", i))) else { continue };
            let key = (bike.to_owned(), c.text("tyre", i), c.text("coefficient", i));
            let number = |name| c.number(name, i) as f32;
            found.entry(key).or_default().push(Seen {
                session: *place as u32,
                sure: c.str("status", i) == "ok",
                value: number("value"),
                error: number("std_error"),
                pooled: number("pooled"),
                low: number("pooled_ci95_low"),
                high: number("pooled_ci95_high"),
                shrinkage: number("shrinkage"),
            });
        }
    })?;
    Ok(found)
}
