//! Charts of the coefficients over time: each session's own estimate, the pooled ones as a line.

use std::collections::BTreeSet;

use jiff::Timestamp;

use crate::contract::coefficient::{Coefficient, Part};
use crate::report::charts::chart::{Chart, Cloud, Label, Line, Span};
use crate::report::charts::resolution;
use crate::report::fleet::event_kind;
use crate::report::fleet::tables::{FleetTables, SessionEstimate};
use crate::report::labels;
use crate::statistics::number_format::round;

/// Largest number of charts over time.
const CHARTS: usize = 40;
/// Coefficients drawn over time also where nothing happened.
const MAIN: [(Part, Coefficient); 4] = [
    (Part::Front, Coefficient::MfD),
    (Part::Front, Coefficient::CorneringStiffness0),
    (Part::Rear, Coefficient::MfD),
    (Part::Rear, Coefficient::CorneringStiffness0),
];

/// Charts over time: what an event concerns first, then the main coefficients of every bike; and how
/// many were left out.
pub(crate) fn charts(fleet: &FleetTables<'_>) -> (Vec<Chart>, usize) {
    let mut wanted: Vec<(&str, &str, &str)> = Vec::new();
    for e in fleet.events {
        let named = e.coefficients.split(", ").filter_map(|c| c.split_once(' ')).take(3);
        wanted.extend(named.map(|(tyre, name)| (e.bike_id.as_str(), tyre, name)));
    }
    let bikes: BTreeSet<&str> = fleet.rows.iter().map(|r| r.bike_id.as_str()).collect();
    for bike in bikes {
        wanted.extend(MAIN.map(|(part, c)| (bike, part.name(), c.name())));
    }
    let mut drawn = BTreeSet::new();
    let mut charts = Vec::new();
    let mut more = 0;
    for what in wanted {
        let (bike, tyre, name) = what;
        let estimates = fleet.history(bike, tyre, name);
        if !drawn.insert(what) || estimates.len() < 2 {
            continue;
        }
        match charts.len() < CHARTS {
            true => charts.push(History::new(fleet, estimates).chart(bike, tyre, name)),
            false => more += 1,
        }
    }
    (charts, more)
}

/// One coefficient of one bike over its sessions.
struct History<'a> {
    fleet: &'a FleetTables<'a>,
    /// Whether the abscissa is a time, in seconds since 1970; else it is the number of the session.
    timed: bool,
    /// Abscissa and estimate, in their order.
    points: Vec<(f64, &'a SessionEstimate)>,
}

impl<'a> History<'a> {
    fn new(fleet: &'a FleetTables<'a>, estimates: &'a [SessionEstimate]) -> Self {
        let stamp = |s: &SessionEstimate| {
            let text = fleet.sessions[s.session as usize].ident.start_time.as_deref()?;
            Some(text.parse::<Timestamp>().ok()?.as_second() as f64)
        };
        let timed = estimates.iter().all(|s| stamp(s).is_some());
        let mut points: Vec<(f64, &SessionEstimate)> = estimates
            .iter()
            .enumerate()
            .map(|(i, s)| (stamp(s).filter(|_| timed).unwrap_or(i as f64 + 1.0), s))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.session.cmp(&b.1.session)));
        History { fleet, timed, points }
    }

    fn chart(&self, bike: &str, tyre: &str, name: &str) -> Chart {
        let mut rows = self.fleet.rows.iter();
        let row = rows.find(|r| r.bike_id == bike && r.tyre == tyre && r.coefficient == name);
        let unit = row.map(|r| labels::unit(&r.unit)).unwrap_or_default();
        let spans = self.events(bike, &format!("{tyre} {name}"));
        let happened: Vec<&str> = spans.iter().map(|s| s.label.as_str()).collect();
        let caption = match happened.is_empty() {
            true => String::new(),
            false => format!("Shaded: {}.", happened.join(", ")),
        };
        let across = if self.timed { "start of the session" } else { "session" };
        let (cloud, line) = self.series();
        Chart {
            name: format!("{bike}_{tyre}_{name}_over_time"),
            title: format!("{bike} · {tyre} · {}", labels::coefficient(name)),
            caption,
            x: Label { label: across.to_owned(), unit: String::new() },
            y: Label { label: "value".to_owned(), unit },
            lines: vec![line],
            points: cloud.x.len(),
            clouds: vec![cloud],
            time: self.timed,
            spans,
            ..Chart::default()
        }
    }

    /// Each session's own estimate, and the pooled ones.
    fn series(&self) -> (Cloud, Line) {
        let digits = resolution::digits(self.points.iter().map(|(_, s)| f64::from(s.value)));
        let put = |v: f32| round(f64::from(v), digits);
        let some = |v: f32| Some(put(v)).filter(|v| v.is_finite());
        let mut cloud = Cloud {
            name: "sessions".into(),
            label: "single session, 95 % interval".into(),
            r: Some(3.0),
            ..Cloud::default()
        };
        for (x, s) in &self.points {
            let i = s.session as usize;
            cloud.x.push(*x);
            cloud.y.push(put(s.value));
            cloud.w.push(if s.determined { 1.0 } else { 0.35 });
            cloud.m.push(None);
            // tables of an older version have no ends
            let usual = [s.value - 1.96 * s.error, s.value + 1.96 * s.error];
            let ends = if s.ends[0].is_finite() { s.ends } else { usual };
            cloud.lo.push(some(ends[0]));
            cloud.hi.push(some(ends[1]));
            let doubt = if s.determined { "" } else { ", poorly determined" };
            cloud.t.push(format!("{}{doubt}", self.fleet.sessions[i].ident.session_id));
            cloud.h.push(self.fleet.pages[i].clone());
        }
        let pooled = |value: fn(&SessionEstimate) -> f32| {
            self.points.iter().map(|(_, s)| some(value(s))).collect()
        };
        let line = Line {
            name: "pooled".into(),
            label: "pooled with the other sessions".into(),
            x: self.points.iter().map(|(x, _)| *x).collect(),
            y: pooled(|s| s.pooled),
            lo: pooled(|s| s.low),
            hi: pooled(|s| s.high),
            ..Line::default()
        };
        (cloud, line)
    }

    /// The events that concern a tyre's coefficient, as stretches of the abscissa.
    fn events(&self, bike: &str, coefficient: &str) -> Vec<Span> {
        let x_of = |session: &str| {
            let place = self.fleet.place(bike, session)? as u32;
            self.points.iter().find(|(_, s)| s.session == place).map(|(x, _)| *x)
        };
        self.fleet
            .events
            .iter()
            .filter(|e| e.bike_id == bike && e.coefficients.split(", ").any(|c| c == coefficient))
            .filter_map(|e| {
                let (from, to) = (x_of(&e.first_session)?, x_of(&e.last_session)?);
                Some(Span { from, to, label: event_kind::label(&e.kind).to_owned() })
            })
            .collect()
    }
}
