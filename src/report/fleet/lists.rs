//! The long tables of the page over all sessions: what happened, and side force ratios.

use crate::report::fleet::page::{Event, Link};
use crate::report::fleet::ratios::Ratio;
use crate::report::list::{self, Cell, List, Part, column, number};
use crate::statistics::number_format;

/// What happened.
pub(crate) fn events<'a>(events: impl Iterator<Item = &'a Event>) -> List {
    List {
        label: "Events",
        words: "bike, session, what",
        class: "events",
        table: "fleet_events",
        page: list::OTHERS,
        columns: vec![
            column("Bike", ""),
            column("What", "judged"),
            column("Sessions", ""),
            number("Size", "size"),
            number("Evidence", "evidence"),
            column("Coefficients", "why"),
            column("Reason", "why"),
        ],
        rows: events.map(event).collect(),
    }
}

fn event(e: &Event) -> Vec<Cell> {
    let to = |link: &Link| Part { class: "", text: link.name.clone(), href: link.href.clone() };
    let mut sessions = vec![to(&e.first)];
    if e.sessions > 1 {
        sessions.extend([Part::new("", "to"), to(&e.last)]);
    }
    let mut count = number_format::count(usize::try_from(e.sessions).unwrap_or(0), "session");
    if !e.when.is_empty() {
        count = format!("{count}, {}", e.when);
    }
    sessions.push(Part::new("count", count));
    let what = match e.tyre.is_empty() {
        true => e.label.clone(),
        false => format!("{}, {}", e.label, e.tyre),
    };
    vec![
        Cell::Text(e.bike.clone()),
        Cell::Text(what),
        Cell::Lines { lines: vec![("", sessions)] },
        Cell::Text(e.size.clone()),
        Cell::Text(format!("{} σ", e.evidence)),
        Cell::Text(e.coefficients.clone()),
        Cell::Text(e.reason.clone()),
    ]
}

/// Side force ratios.
pub(crate) fn ratios(ratios: &[Ratio]) -> List {
    List {
        label: "Side force ratio",
        words: "bike, tyre, status",
        class: "ratios",
        table: "fleet_ratios",
        page: list::OTHERS,
        columns: vec![
            column("Bike", ""),
            column("Tyre", ""),
            column("Sessions", ""),
            number("Ratio C", "ratio"),
            number("95 % interval", "95 %"),
            number("Cornering stiffness, 1/rad", "cornering stiffness"),
            column("Status", "status why"),
        ],
        rows: ratios.iter().map(ratio).collect(),
    }
}

fn ratio(r: &Ratio) -> Vec<Cell> {
    let stretch = format!("{} to {}", r.first, r.last);
    let on = format!("{} on the line", r.sessions);
    let status = match r.reason.is_empty() {
        true => r.status_label.to_owned(),
        false => format!("{}: {}", r.status_label, r.reason),
    };
    vec![
        Cell::Text(r.bike.clone()),
        Cell::Text(r.tyre.clone()),
        Cell::Lines { lines: vec![("", vec![Part::new("", stretch), Part::new("count", on)])] },
        Cell::Text(r.value.clone()),
        Cell::Text(r.interval.clone()),
        Cell::Text(r.stiffness.clone()),
        Cell::Lines {
            lines: vec![(r.status, vec![Part::new("sign", r.sign), Part::new("", status)])],
        },
    ]
}
