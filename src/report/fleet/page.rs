//! What the fleet's page says: what happened to the bikes, how their tyres compare, how each
//! coefficient went over time.

use std::collections::{BTreeMap, BTreeSet};

use jiff::Timestamp;
use serde::Serialize;

use crate::report::charts::chart::{Chart, Cloud, Label, Line, Span};
use crate::report::charts::resolution;
use crate::report::fleet::ratios;
use crate::report::fleet::tables::{Histories, SessionEstimate};
use crate::report::number_format::{self, fixed, round, typeset};
use crate::report::run::page::count;
use crate::report::session::page::when;
use crate::report::{inline_svg, words};
use crate::tables::rows::{EventRow, FleetRow, SessionRow};

/// File name of the page.
pub const PAGE: &str = "fleet.html";
/// Largest number of charts over time.
const CHARTS: usize = 40;
/// Bikes up to which every comparison is unfolded.
const UNFOLDED: usize = 12;
/// Coefficients drawn over time also where nothing happened.
const MAIN: [(&str, &str); 4] = [
    ("front", "mf_d"),
    ("front", "cornering_stiffness_0"),
    ("rear", "mf_d"),
    ("rear", "cornering_stiffness_0"),
];

/// The fleet's page, as its template reads it.
#[derive(Debug, Serialize)]
pub struct Page {
    /// Bikes.
    pub bikes: usize,
    /// The line that sums it up.
    pub verdict: String,
    /// The second line.
    pub sub: String,
    /// What happened, the surest first.
    pub events: Vec<Event>,
    /// Comparisons by tyre.
    pub tyres: Vec<(String, Vec<Compared>)>,
    /// Charts over time that were left out.
    pub more: usize,
    /// Side force ratios, and on what has none.
    pub ratios: Option<(Vec<ratios::Ratio>, String)>,
}

/// A link to a session's page.
#[derive(Debug, Serialize)]
pub struct Link {
    /// Its page; empty where it has none.
    pub href: String,
    /// Its name.
    pub name: String,
}

/// One event.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub struct Event {
    pub bike: String,
    pub kind: String,
    pub words: String,
    pub tyre: String,
    pub coefficients: String,
    pub first: Link,
    pub last: Link,
    pub when: String,
    pub sessions: i64,
    pub size: String,
    pub evidence: String,
    pub reason: String,
}

/// One coefficient over the bikes.
#[derive(Debug, Serialize)]
pub struct Compared {
    /// In words.
    pub words: String,
    /// Name in the tables.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Ends of the common axis.
    pub axis: (String, String),
    /// Whether it is unfolded.
    pub open: bool,
    /// A line per bike and tyre model.
    pub rows: Vec<Row>,
}

/// One bike, or one of its tyre models.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub struct Row {
    pub bike: String,
    pub model: String,
    pub sessions: usize,
    pub median: String,
    pub spread: String,
    pub drawing: String,
    pub between: String,
    pub drift: String,
    pub drifts: bool,
    pub shrinkage: String,
    pub flags: i64,
}

/// Puts the fleet's tables in words and charts. `pages` are the sessions' files.
pub fn build(
    sessions: &[SessionRow],
    pages: &[String],
    rows: &[FleetRow],
    events: &[EventRow],
    histories: &Histories,
) -> (Page, Vec<Chart>) {
    let fleet = Fleet { sessions, pages, rows, events, histories };
    let bikes: BTreeSet<&str> = rows.iter().map(|r| r.bike_id.as_str()).collect();
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for event in events {
        *kinds.entry(kind(&event.kind)).or_default() += 1;
    }
    let happened: Vec<String> = kinds.iter().map(|(what, n)| count(*n, what)).collect();
    let verdict = match happened.is_empty() {
        true => "Nothing but scatter: no bike changed from one session to the next.".to_owned(),
        false => format!("{}.", happened.join(", ")),
    };
    let alarm = events.first().map(|e| e.false_alarm_rate).filter(|a| *a > 0.0);
    let sub = match alarm {
        Some(rate) => format!(
            "Of bikes to which nothing happened {} % get an event all the same.",
            fixed(100.0 * rate, number_format::decimals_of(100.0 * rate, None).min(1))
        ),
        None => String::new(),
    };
    let (charts, more) = fleet.charts();
    let page = Page {
        bikes: bikes.len(),
        verdict,
        sub,
        events: events.iter().map(|e| fleet.event(e)).collect(),
        tyres: fleet.compared(bikes.len() <= UNFOLDED),
        more,
        ratios: None,
    };
    (page, charts)
}

/// One coefficient's values by bike, for a figure of its own.
#[derive(Debug)]
pub struct Boxes {
    /// Tyre and coefficient, as in the tables.
    pub name: String,
    /// Heading.
    pub title: String,
    /// Unit.
    pub unit: String,
    /// Bikes with their values.
    pub groups: Vec<(String, Vec<f64>)>,
}

/// Every coefficient of every tyre with the bikes' values.
pub fn compared(sessions: &[SessionRow], rows: &[FleetRow], histories: &Histories) -> Vec<Boxes> {
    let fleet = Fleet { sessions, pages: &[], rows, events: &[], histories };
    fleet
        .coefficients()
        .into_iter()
        .map(|rows| Boxes {
            name: format!("{}_{}", rows[0].tyre, rows[0].coefficient),
            title: format!(
                "{} · {}",
                words::tyre(&rows[0].tyre),
                words::coefficient(&rows[0].coefficient)
            ),
            unit: words::unit(&rows[0].unit),
            groups: rows
                .iter()
                .flat_map(|row| {
                    let named = |model: String| match model.is_empty() {
                        true => row.bike_id.clone(),
                        false => format!("{} {model}", row.bike_id),
                    };
                    let by = fleet.by_model(row);
                    let several = by.len() > 1;
                    by.into_iter()
                        .map(move |(m, v)| (named(if several { m } else { String::new() }), v))
                })
                .collect(),
        })
        .collect()
}

/// A kind of event in words, for counting.
fn kind(name: &str) -> &str {
    match name {
        "tyre_swap" => "tyre swap",
        "bike_file" => "wrong bike file",
        "outlier" => "outlying session",
        other => other,
    }
}

/// Values by tyre model.
type ByModel = Vec<(String, Vec<f64>)>;

struct Fleet<'a> {
    sessions: &'a [SessionRow],
    pages: &'a [String],
    rows: &'a [FleetRow],
    events: &'a [EventRow],
    histories: &'a Histories,
}

impl Fleet<'_> {
    fn place(&self, bike: &str, session: &str) -> Option<usize> {
        self.sessions.binary_search_by(|s| s.ident.key().cmp(&(bike, session))).ok()
    }

    fn link(&self, bike: &str, session: &str) -> Link {
        let href = self.place(bike, session).map(|i| self.pages[i].clone()).unwrap_or_default();
        Link { href, name: session.to_owned() }
    }

    fn event(&self, e: &EventRow) -> Event {
        Event {
            bike: e.bike_id.clone(),
            kind: e.kind.clone(),
            words: kind(&e.kind).to_owned(),
            tyre: e.tyre.clone(),
            coefficients: e
                .coefficients
                .split(", ")
                .map(|c| match c.split_once(' ') {
                    Some((tyre, name)) => format!("{tyre} {}", words::coefficient(name)),
                    None => c.to_owned(),
                })
                .collect::<Vec<_>>()
                .join("; "),
            first: self.link(&e.bike_id, &e.first_session),
            last: self.link(&e.bike_id, &e.last_session),
            when: e.first_time.as_deref().map(when).unwrap_or_default(),
            sessions: e.n_sessions,
            size: e
                .size
                .map(|s| format!("{}{} %", if s > 0.0 { "+" } else { "" }, fixed(100.0 * s, 1)))
                .map(|s| typeset(&s))
                .unwrap_or_default(),
            evidence: fixed(e.evidence.abs(), 1),
            reason: e.reason.clone(),
        }
    }

    /// The rows of each coefficient that some session determined, in the contract's order.
    fn coefficients(&self) -> Vec<Vec<&FleetRow>> {
        let mut names: BTreeMap<_, Vec<&FleetRow>> = BTreeMap::new();
        for row in self.rows.iter().filter(|r| r.n_sessions > 0) {
            names.entry(words::order(&row.tyre, &row.coefficient)).or_default().push(row);
        }
        names.into_values().collect()
    }

    /// A bike's values, sorted, by the tyre model that was on.
    fn by_model(&self, row: &FleetRow) -> ByModel {
        let at = (row.bike_id.clone(), row.tyre.clone(), row.coefficient.clone());
        let mut by: BTreeMap<String, Vec<f64>> = BTreeMap::new();
        for seen in self.histories.get(&at).into_iter().flatten().filter(|s| s.determined) {
            let session = &self.sessions[seen.session as usize];
            let model = match row.tyre.as_str() {
                "front" => session.tyre_front.clone(),
                "rear" => session.tyre_rear.clone(),
                _ => None,
            };
            by.entry(model.unwrap_or_default()).or_default().push(f64::from(seen.value));
        }
        by.values_mut().for_each(|v| v.sort_by(f64::total_cmp));
        by.into_iter().collect()
    }

    fn compared(&self, open: bool) -> Vec<(String, Vec<Compared>)> {
        let mut out: Vec<(String, Vec<Compared>)> = Vec::new();
        for rows in &self.coefficients() {
            let title = words::tyre(&rows[0].tyre);
            if out.last().is_none_or(|(t, _)| t != title) {
                out.push((title.to_owned(), Vec::new()));
            }
            let open = open || rows.iter().any(|r| r.n_events > 0);
            if let Some((_, list)) = out.last_mut() {
                list.push(self.coefficient(rows, open));
            }
        }
        out
    }

    /// One coefficient: the bikes' boxes over a common axis.
    fn coefficient(&self, rows: &[&FleetRow], open: bool) -> Compared {
        let none = Vec::new();
        let parts: Vec<(&FleetRow, ByModel)> =
            rows.iter().map(|row| (*row, self.by_model(row))).collect();
        let (low, high) = inline_svg::common_axis(
            parts.iter().flat_map(|(_, by)| by.iter().map(|(_, values)| values.as_slice())),
        );
        let digits = number_format::decimals_of(high, Some((high - low) / 20.0));
        let row = |r: &FleetRow, i: usize, model: &str, values: &[f64]| {
            let shown = |v: Option<f64>| v.map(|v| typeset(&fixed(v, digits))).unwrap_or_default();
            let seen =
                self.histories.get(&(r.bike_id.clone(), r.tyre.clone(), r.coefficient.clone()));
            let shrinkage: Vec<f64> =
                seen.unwrap_or(&none).iter().map(|s| f64::from(s.shrinkage)).collect();
            let drift = r.drift_settled_per_day.or(r.drift_per_day);
            let ends = r.drift_ci95_low.zip(r.drift_ci95_high);
            let bike_line = i == 0;
            let of_bike = |text: String| if bike_line { text } else { String::new() };
            Row {
                bike: of_bike(r.bike_id.clone()),
                model: model.to_owned(),
                sessions: values.len(),
                median: shown(number_format::median(values)),
                spread: shown(number_format::robust_sd(values)),
                drawing: inline_svg::boxes(values, low, high),
                between: of_bike(shown(r.between_sd_settled.or(r.between_sd))),
                drift: of_bike(drift_words(drift, ends)),
                drifts: bike_line && ends.is_some_and(|(l, h)| l > 0.0 || h < 0.0),
                shrinkage: of_bike(
                    number_format::median(&shrinkage)
                        .map(|s| format!("{} %", fixed(100.0 * s, 0)))
                        .unwrap_or_default(),
                ),
                flags: if bike_line { r.n_events.max(r.n_flagged) } else { 0 },
            }
        };
        Compared {
            words: words::coefficient(&rows[0].coefficient).to_owned(),
            name: rows[0].coefficient.clone(),
            unit: words::unit(&rows[0].unit),
            axis: (typeset(&fixed(low, digits)), typeset(&fixed(high, digits))),
            open,
            rows: parts
                .iter()
                .flat_map(|(r, by)| {
                    by.iter().enumerate().map(move |(i, (model, values))| (*r, i, model, values))
                })
                .map(|(r, i, model, values)| row(r, i, model, values))
                .collect(),
        }
    }

    /// Charts over time: what an event concerns first, then the main coefficients of every bike;
    /// and how many were left out.
    fn charts(&self) -> (Vec<Chart>, usize) {
        let mut wanted: Vec<(&str, String, String)> = Vec::new();
        for e in self.events {
            for (tyre, name) in e.coefficients.split(", ").filter_map(|c| c.split_once(' ')).take(3)
            {
                wanted.push((&e.bike_id, tyre.to_owned(), name.to_owned()));
            }
        }
        let bikes: BTreeSet<&str> = self.rows.iter().map(|r| r.bike_id.as_str()).collect();
        for bike in bikes {
            wanted.extend(MAIN.map(|(tyre, name)| (bike, tyre.to_owned(), name.to_owned())));
        }
        let mut drawn = BTreeSet::new();
        let mut charts = Vec::new();
        let mut more = 0;
        for (bike, tyre, name) in wanted {
            if !drawn.insert((bike, tyre.clone(), name.clone())) {
                continue;
            }
            let Some(seen) = self.histories.get(&(bike.to_owned(), tyre.clone(), name.clone()))
            else {
                continue;
            };
            if seen.len() < 2 {
                continue;
            }
            match charts.len() < CHARTS {
                true => charts.push(self.chart(bike, &tyre, &name, seen)),
                false => more += 1,
            }
        }
        (charts, more)
    }

    fn chart(&self, bike: &str, tyre: &str, name: &str, seen: &[SessionEstimate]) -> Chart {
        let unit = self
            .rows
            .iter()
            .find(|r| r.bike_id == bike && r.tyre == tyre && r.coefficient == name)
            .map(|r| words::unit(&r.unit))
            .unwrap_or_default();
        let stamp = |i: usize| {
            let text = self.sessions[i].ident.start_time.as_deref()?;
            Some(text.parse::<Timestamp>().ok()?.as_second() as f64)
        };
        let timed = seen.iter().all(|s| stamp(s.session as usize).is_some());
        let mut order: Vec<(f64, &SessionEstimate)> = seen
            .iter()
            .enumerate()
            .map(|(i, s)| {
                (stamp(s.session as usize).filter(|_| timed).unwrap_or(i as f64 + 1.0), s)
            })
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.session.cmp(&b.1.session)));
        let values = || order.iter().map(|(_, s)| f64::from(s.value));
        let digits = resolution::digits(values());
        let put = |v: f32| round(f64::from(v), digits);
        let some = |v: f32| Some(put(v)).filter(|v| v.is_finite());
        let mut cloud = Cloud {
            name: "sessions".into(),
            label: "a session alone, 95 % interval".into(),
            r: Some(3.0),
            ..Cloud::default()
        };
        for (x, s) in &order {
            let i = s.session as usize;
            cloud.x.push(*x);
            cloud.y.push(put(s.value));
            cloud.w.push(if s.determined { 1.0 } else { 0.35 });
            cloud.m.push(None);
            cloud.lo.push(some(s.value - 1.96 * s.error));
            cloud.hi.push(some(s.value + 1.96 * s.error));
            let doubt = if s.determined { "" } else { ", poorly determined" };
            cloud.t.push(format!("{}{doubt}", self.sessions[i].ident.session_id));
            cloud.h.push(self.pages[i].clone());
        }
        let line = Line {
            name: "pooled".into(),
            label: "with its siblings' help".into(),
            x: order.iter().map(|(x, _)| *x).collect(),
            y: order.iter().map(|(_, s)| some(s.pooled)).collect(),
            lo: order.iter().map(|(_, s)| some(s.low)).collect(),
            hi: order.iter().map(|(_, s)| some(s.high)).collect(),
            ..Line::default()
        };
        let own = format!("{tyre} {name}");
        let x_of = |session: &str| {
            let place = self.place(bike, session)? as u32;
            order.iter().find(|(_, s)| s.session == place).map(|(x, _)| *x)
        };
        let spans: Vec<Span> = self
            .events
            .iter()
            .filter(|e| e.bike_id == bike && e.coefficients.split(", ").any(|c| c == own))
            .filter_map(|e| {
                let (from, to) = (x_of(&e.first_session)?, x_of(&e.last_session)?);
                Some(Span { from, to, label: kind(&e.kind).to_owned() })
            })
            .collect();
        let happened: Vec<&str> = spans.iter().map(|s| s.label.as_str()).collect();
        Chart {
            name: format!("{bike}_{tyre}_{name}_over_time"),
            title: format!("{bike} · {tyre} · {}", words::coefficient(name)),
            caption: match happened.is_empty() {
                true => String::new(),
                false => format!("Shaded: {}.", happened.join(", ")),
            },
            x: Label {
                label: if timed { "start of the session" } else { "session" }.into(),
                unit: String::new(),
            },
            y: Label { label: "value".into(), unit },
            lines: vec![line],
            points: cloud.x.len(),
            clouds: vec![cloud],
            time: timed,
            spans,
            ..Chart::default()
        }
    }
}

fn drift_words(drift: Option<f64>, ends: Option<(f64, f64)>) -> String {
    let Some(drift) = drift else { return String::new() };
    // per hundred days: per day nobody can read it
    let digits =
        number_format::decimals_of(100.0 * drift, ends.map(|(l, h)| 100.0 * (h - l) / 2.0)).min(8);
    let show = |v: f64| typeset(&fixed(100.0 * v, digits));
    match ends {
        Some((low, high)) => format!("{} ({} to {})", show(drift), show(low), show(high)),
        None => show(drift),
    }
}
