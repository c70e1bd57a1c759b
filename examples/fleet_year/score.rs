//! Events that the search reports, compared with those that were planted.

use std::collections::BTreeMap;

use roadbench::internals::contract::fleet_event::EventKind;
use roadbench::internals::fleet::BikeAnalysis;
use roadbench::internals::fleet::events::Event;
use roadbench::internals::fleet::scan::Shape;

use super::planted::{Kind, Planted};
use super::year::BEGIN;

/// An event is the planted one where its day is at most so many days off.
const NEAR: f64 = 14.0;
/// What wear changes.
const WORN: [&str; 5] = [
    "effective_rolling_radius",
    "mf_d",
    "cornering_stiffness_0",
    "camber_stiffness_0",
    "overturning_stiffness",
];

/// Kind of a reported event.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// A planted one, by its number; how many days its date is off; whether its kind is right.
    Of(usize, f64, bool),
    /// Wear, reported as steps.
    Worn,
    /// Nothing that was planted.
    False,
}

/// Days at which an event begins and ends: of the first session of it, and of the first after it.
fn ends(bike: &BikeAnalysis, event: &Event) -> [Option<f64>; 2] {
    let day = |i: usize| bike.history.days.get(i).copied().flatten().map(|d| d - BEGIN);
    match event.shape {
        Shape::Stretch(a, b) => [day(a).filter(|_| a > 0), day(b)],
        Shape::Line => [None; 2],
    }
}

/// What each event of a motorcycle is.
pub fn verdict(bike: &BikeAnalysis, number: usize, event: &Event, planted: &[Planted]) -> Verdict {
    let of_bike = || planted.iter().enumerate().filter(|(_, p)| p.bike == number);
    let wears = of_bike().find(|(_, p)| p.kind == Kind::Wear);
    if let (Some((i, _)), EventKind::Drift) = (wears, event.kind) {
        return Verdict::Of(i, 0.0, true);
    }
    let there = ends(bike, event);
    let near = of_bike()
        .filter(|(_, p)| p.kind != Kind::Wear)
        .flat_map(|(i, p)| [p.from, p.to].map(|day| (i, p, day)))
        .filter(|(_, _, day)| *day < 365.0)
        .flat_map(|(i, p, day)| there.map(|end| (i, p, (end.unwrap_or(f64::INFINITY) - day).abs())))
        .filter(|(_, _, off)| *off <= NEAR)
        .min_by(|a, b| a.2.total_cmp(&b.2));
    // one session near a change is not the change
    if let (Some((i, p, off)), true) = (near, event.sessions().len() > 2) {
        let right = match p.kind {
            Kind::Swap(_) => event.kind == EventKind::TyreSwap,
            Kind::File => event.kind == EventKind::BikeFile,
            Kind::Sensors => matches!(event.kind, EventKind::BikeFile | EventKind::Change),
            Kind::Wear => false,
        };
        return Verdict::Of(i, off, right);
    }
    let worn =
        event.moved.iter().all(|m| WORN.contains(&bike.history.keys[m.coefficient].1.as_str()));
    if wears.is_some() && worn && event.sessions().len() > 2 {
        return Verdict::Worn;
    }
    Verdict::False
}

/// Counts of a kind.
#[derive(Default)]
struct Row {
    planted: usize,
    found: usize,
    right: usize,
    off: Vec<f64>,
    parts: usize,
}

/// Prints what of the planted was found among events with a rate of false ones up to `rate`.
pub fn print(bikes: &[BikeAnalysis], planted: &[Planted], rate: f64) {
    let mut rows: BTreeMap<&str, Row> = BTreeMap::new();
    let mut found: BTreeMap<usize, (f64, bool)> = BTreeMap::new();
    let (mut told, mut wrong, mut worn) = (0, 0, 0);
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for (number, bike) in bikes.iter().enumerate() {
        for event in bike.events.iter().filter(|e| e.discovery <= rate) {
            told += 1;
            match verdict(bike, number, event, planted) {
                Verdict::Of(i, off, right) => {
                    let best = found.entry(i).or_insert((off, right));
                    best.0 = best.0.min(off);
                    best.1 |= right;
                    rows.entry(planted[i].kind.name()).or_default().parts += 1;
                }
                Verdict::Worn => worn += 1,
                Verdict::False => {
                    wrong += 1;
                    *kinds.entry(event.kind.name()).or_default() += 1;
                }
            }
        }
    }
    for (i, p) in planted.iter().enumerate() {
        let row = rows.entry(p.kind.name()).or_default();
        row.planted += 1;
        if let Some((off, right)) = found.get(&i) {
            row.found += 1;
            row.right += usize::from(*right);
            row.off.push(*off);
        }
    }
    println!(
        "\nq <= {rate}: {told} events told, {wrong} of nothing planted ({:.1} %), {worn} of wear as steps; false: {kinds:?}\n",
        100.0 * wrong as f64 / told.max(1) as f64
    );
    println!(
        "| planted | number | found | missed | named right | date off, median days | events told of it |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for (name, mut row) in rows {
        row.off.sort_by(f64::total_cmp);
        let off = row.off.get(row.off.len() / 2).copied().unwrap_or(f64::NAN);
        println!(
            "| {name} | {} | {} | {} | {} | {off:.1} | {} |",
            row.planted,
            row.found,
            row.planted - row.found,
            row.right,
            row.parts
        );
    }
}

/// A line per event that is nothing planted, or is called what it is not.
pub fn print_false(bikes: &[BikeAnalysis], planted: &[Planted]) {
    for (number, bike) in bikes.iter().enumerate() {
        for event in &bike.events {
            let what = match verdict(bike, number, event, planted) {
                Verdict::False => "nothing",
                Verdict::Of(i, _, false) => planted[i].kind.name(),
                _ => continue,
            };
            {
                let day = bike.history.days[event.sessions().start].unwrap_or(f64::NAN) - BEGIN;
                eprintln!(
                    "{what}: bike {number} day {day:.0}, {} sessions, q {:.1e}: {} {}",
                    event.sessions().len(),
                    event.discovery,
                    event.kind.name(),
                    event.reason
                );
            }
        }
    }
}

/// Prints how long after it happened each kind is reported; `told` by number of the planted one, days.
pub fn print_late(planted: &[Planted], told: &BTreeMap<usize, f64>) {
    println!("\n| planted | number | told | days late, median | most |");
    println!("|---|---:|---:|---:|---:|");
    let mut rows: BTreeMap<&str, (usize, Vec<f64>)> = BTreeMap::new();
    for (i, p) in planted.iter().enumerate() {
        let row = rows.entry(p.kind.name()).or_default();
        row.0 += 1;
        row.1.extend(told.get(&i).map(|day| day - p.from));
    }
    for (name, (number, mut late)) in rows {
        late.sort_by(f64::total_cmp);
        let at = |i: usize| late.get(i).copied().unwrap_or(f64::NAN);
        let (middle, most) = (at(late.len() / 2), at(late.len().saturating_sub(1)));
        println!("| {name} | {number} | {} | {middle:.0} | {most:.0} |", late.len());
    }
}
