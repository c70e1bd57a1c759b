//! The long tables of the run's page: sessions, diagnoses, rejected inputs.

use crate::report::diagnosis::outcome;
use crate::report::list::{self, Cell, List, Part, column, number};
use crate::report::run::page::Entry;
use crate::store::tables::rows::Rejected;

pub(crate) fn sessions(entries: &[Entry]) -> List {
    List {
        label: "Sessions",
        words: "session, bike, date",
        class: "sessions",
        table: "sessions",
        page: list::SESSIONS,
        columns: vec![
            column("Session", ""),
            column("Bike", ""),
            column("Start", "nowrap"),
            number("Duration", ""),
            number("km", ""),
            number("Determined", ""),
            number("Manoeuvres used", ""),
            number("Warnings", ""),
        ],
        rows: entries
            .iter()
            .map(|s| {
                vec![
                    Cell::page(&s.session_id, &s.page, s.there),
                    Cell::Text(s.bike_id.clone()),
                    Cell::Text(s.start.clone()),
                    Cell::Keyed {
                        text: s.duration.clone(),
                        key: if s.seconds.is_finite() { s.seconds } else { -1.0 },
                    },
                    Cell::Text(s.distance.clone()),
                    Cell::Text(format!("{} of {}", s.determined, s.of)),
                    Cell::Text(format!("{} of {}", s.used, s.manoeuvres)),
                    Cell::of(s.warnings),
                ]
            })
            .collect(),
    }
}

pub(crate) fn diagnoses(entries: &[outcome::Entry]) -> List {
    List {
        label: "Diagnoses",
        words: "session, bike, cause",
        class: "diagnoses",
        table: "causes",
        page: list::OTHERS,
        columns: vec![
            column("Session", ""),
            column("Bike", ""),
            column("Start", "nowrap"),
            column("Verdict", "judged"),
            column("Cause", "why"),
            number("Structured misfits", "structured misfits"),
        ],
        rows: entries
            .iter()
            .map(|d| {
                vec![
                    Cell::page(&d.session_id, &d.href, true),
                    Cell::Text(d.bike_id.clone()),
                    Cell::Text(d.start.clone()),
                    Cell::of(d.verdict),
                    cause(d),
                    Cell::of(d.structured),
                ]
            })
            .collect(),
    }
}

/// Identified causes, each with its size and alternatives; the reason; the gain.
fn cause(d: &outcome::Entry) -> Cell {
    let mut lines: Vec<(&'static str, Vec<Part>)> = Vec::new();
    for finding in &d.findings {
        let mut parts = vec![Part::new("", &finding.sentence)];
        if !finding.size.is_empty() {
            parts.push(Part::new("size", &finding.size));
        }
        parts.extend(finding.or.iter().map(|other| Part::new("or", format!("or {other}"))));
        lines.push(("cause", parts));
    }
    if !d.reason.is_empty() {
        lines.push(("", vec![Part::new("", &d.reason)]));
    }
    if !d.gain.is_empty() {
        lines.push(("gain", vec![Part::new("", format!("simulated: {}", d.gain))]));
    }
    Cell::Lines { lines }
}

pub(crate) fn rejected(rows: &[Rejected]) -> List {
    let why = |r: &Rejected| vec![Part::new("", &r.message), Part::new("code", &r.code)];
    List {
        label: "Rejected inputs",
        words: "file, reason",
        class: "rejected",
        table: "rejected",
        page: list::OTHERS,
        columns: vec![column("Input", "path"), column("Stage", ""), column("Why", "why")],
        rows: rows
            .iter()
            .map(|r| {
                vec![
                    Cell::Text(r.path.clone()),
                    Cell::Text(r.stage.clone()),
                    Cell::Lines { lines: vec![("", why(r))] },
                ]
            })
            .collect(),
    }
}
