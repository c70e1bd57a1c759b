//! The page over all sessions: what happened to the bikes, how their tyres compare, how each
//! coefficient went over time.

use std::collections::{BTreeMap, BTreeSet};

use crate::report::charts::chart::Chart;
use crate::report::fleet::comparison::{self, Compared};
use crate::report::fleet::tables::FleetTables;
use crate::report::fleet::{event_kind, history, ratios};
use crate::statistics::number_format::{self, fixed, typeset};
use crate::store::tables::rows::EventRow;

/// File name of the page.
pub(crate) const PAGE: &str = "fleet.html";

#[derive(Debug)]
pub(crate) struct Page {
    pub bikes: usize,
    /// The line that sums it up.
    pub verdict: String,
    pub sub: String,
    /// Events, the surest first.
    pub events: Vec<Event>,
    /// Comparisons by tyre.
    pub tyres: Vec<(String, Vec<Compared>)>,
    /// Charts over time that were left out.
    pub more: usize,
    /// Side force ratios, and on what has none.
    pub ratios: Option<(Vec<ratios::Ratio>, String)>,
}

/// One line of the summary's list of events.
#[derive(Debug)]
#[allow(missing_docs)] // headings of the table
pub(crate) struct Event {
    pub bike: String,
    pub label: String,
    pub tyre: String,
    pub first: String,
    pub sessions: i64,
    pub size: String,
    pub reason: String,
}

/// The page but for the side force ratios, and its charts over time.
pub(crate) fn build(fleet: &FleetTables<'_>) -> (Page, Vec<Chart>) {
    let FleetTables { rows, events, .. } = fleet;
    let bikes: BTreeSet<&str> = rows.iter().map(|r| r.bike_id.as_str()).collect();
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for event in *events {
        *kinds.entry(event_kind::label(&event.kind)).or_default() += 1;
    }
    let happened: Vec<String> =
        kinds.iter().map(|(what, n)| number_format::count(*n, what)).collect();
    let verdict = match happened.is_empty() {
        true => "No bike changed by more than the scatter between sessions.".to_owned(),
        false => format!("{}.", happened.join(", ")),
    };
    let alarm = events.first().map(|e| e.false_alarm_rate).filter(|a| *a > 0.0);
    let sub = match alarm {
        Some(rate) => format!(
            "False alarms: {} % of bikes without a change get an event.",
            fixed(100.0 * rate, number_format::decimals_of(100.0 * rate, None).min(1))
        ),
        None => String::new(),
    };
    let (charts, more) = history::charts(fleet);
    let page = Page {
        bikes: bikes.len(),
        verdict,
        sub,
        events: events.iter().map(event).collect(),
        tyres: comparison::by_tyre(fleet, bikes.len() <= comparison::ALL),
        more,
        ratios: None,
    };
    (page, charts)
}

fn event(e: &EventRow) -> Event {
    Event {
        bike: e.bike_id.clone(),
        label: event_kind::label(&e.kind).to_owned(),
        tyre: e.tyre.clone(),
        first: e.first_session.clone(),
        sessions: e.n_sessions,
        size: e
            .size
            .map(|s| format!("{}{} %", if s > 0.0 { "+" } else { "" }, fixed(100.0 * s, 1)))
            .map(|s| typeset(&s))
            .unwrap_or_default(),
        reason: e.reason.clone(),
    }
}
