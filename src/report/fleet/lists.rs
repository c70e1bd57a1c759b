//! The long tables of the page over all sessions: what changed, and side force ratios.

use crate::report::fleet::ratios::Ratio;
use crate::report::fleet::what_changed::entries::{Line, Shown};
use crate::report::fleet::what_changed::motorcycle::Motorcycle;
use crate::report::list::{self, Cell, List, Part, column, number};
use crate::statistics::number_format::fixed;

/// Changes on every motorcycle, the surest first.
pub(crate) fn changes(motorcycles: &[Motorcycle]) -> List {
    let mut rows: Vec<(f64, Vec<Cell>)> = Vec::new();
    for motorcycle in motorcycles {
        for (entry, strength) in motorcycle.entries.iter().zip(&motorcycle.strengths) {
            rows.push((*strength, change(motorcycle, entry, *strength)));
        }
    }
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    List {
        label: "What changed",
        words: "bike, session, what",
        class: "events",
        table: "fleet_events",
        page: list::OTHERS,
        columns: vec![
            column("Bike", ""),
            column("Rides", ""),
            column("What changed", "why"),
            number("Size over its standard error", "size over its standard error"),
        ],
        rows: rows.into_iter().map(|(_, cells)| cells).collect(),
    }
}

fn change(of: &Motorcycle, entry: &Shown, strength: f64) -> Vec<Cell> {
    let place = Part { class: "", text: entry.place.clone(), href: entry.page.clone() };
    let line = |l: &Line| {
        ("way", vec![Part::new("", format!("{}.", l.sentence)), Part::new("seen", l.way)])
    };
    let strength = fixed(strength, 1);
    vec![
        Cell::page(&of.bike_id, &of.page, true),
        Cell::Lines { lines: vec![("", vec![place])] },
        Cell::Lines { lines: entry.lines.iter().map(line).collect() },
        Cell::Text(strength),
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
