//! A motorcycle's other rides as the reference: what differs between its rides, and why.
//!
//! ```text
//! numbers      all that each ride says: parameters of the nominal model, sizes of effects, traces
//! belief       how much a number scatters between fault-free rides
//! learnt       the same put right by the other motorcycles
//! difference   one number of some rides against the others
//! sums         all numbers of some rides, and the sums of them that show an effect
//! explain      the cause that explains the differences of all numbers
//! sets         rides that may differ: one, since a date, at a site, with a rider, on a tyre, in a night, a drift
//! search       over the sets
//! tyre_swap    a changed tyre as the cause of what the search finds
//! against      chosen rides as the reference of all others together
//! words        in sentences
//! news         what is new since the last time
//! ```
//!
//! What a method gets wrong of a motorcycle is the same in all its rides, and cancels. So sizes that the single ride cannot
//! tell from its own errors stand out. A fault that all rides share stays unseen here: the single ride's diagnosis looks for it.
//! The method is that of `book/src/diagnosis.md`, its section on other rides.

pub(crate) mod against;
pub(crate) mod belief;
pub(crate) mod difference;
pub(crate) mod explain;
#[cfg(test)]
mod fleet_tests;
pub(crate) mod learnt;
pub(crate) mod news;
pub(crate) mod numbers;
pub(crate) mod search;
pub(crate) mod sets;
pub(crate) mod sums;
#[cfg(test)]
mod tests;
pub(crate) mod tyre_swap;
pub(crate) mod words;

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::contract::fleet_event::Affected;
use crate::statistics::discovery::discovery_rates;
use crate::store::tables::changes::place;
use crate::store::tables::rows::{ChangeRow, Ident};
use numbers::{History, Ride};
use search::{Change, SearchResult, search};
use sets::{Kind, OTHERS, Rides};

/// Share of false ones among the changes that are reported.
pub(crate) const FALSE_DISCOVERIES: f64 = 0.05;

/// The rows of `changes` of an output's rides, in order of motorcycle and time.
pub fn changes(rides: Vec<Ride>) -> Vec<ChangeRow> {
    let mut bikes: BTreeMap<String, Vec<Ride>> = BTreeMap::new();
    for ride in rides {
        bikes.entry(ride.ident.bike_id.clone()).or_default().push(ride);
    }
    let mut histories: Vec<History> = bikes.into_values().map(History::new).collect();
    learnt::learn(&mut histories);
    let compared: Vec<(History, SearchResult)> = histories
        .into_par_iter()
        .map(|history| {
            let mut found = match history.len() > OTHERS {
                true => search(&history),
                false => SearchResult::default(),
            };
            found.changes = tyre_swap::explained(&history, found.changes);
            (history, found)
        })
        .collect();
    let tried = compared.iter().map(|(_, found)| found.tried).sum();
    let all = || compared.iter().flat_map(|(_, found)| &found.changes);
    let rates = discovery_rates(&all().map(|c| c.chance).collect::<Vec<_>>(), tried);
    let mut rate = rates.into_iter();
    let mut rows = Vec::new();
    for (history, found) in &compared {
        let sure: Vec<(&Change, f64)> =
            found.changes.iter().zip(&mut rate).filter(|(_, r)| *r <= FALSE_DISCOVERIES).collect();
        rows.extend(of_motorcycle(history, found, &sure));
    }
    rows
}

/// How clearly a ride of one motorcycle shows each effect: its name, the difference over its error, and what a change needs.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for studies
pub fn clearness(rides: Vec<Ride>, session_id: &str) -> Vec<(String, f64, f64)> {
    let history = History::new(rides);
    let ride = history.rides.iter().position(|r| r.session_id == session_id);
    let Some(ride) = ride.filter(|_| history.len() > OTHERS) else { return Vec::new() };
    let evidence =
        search::Evidence::new(&sums::AllRides::new(&history), &Rides::one(ride, history.len()));
    let count = evidence.sums.len() + evidence.numbers.iter().flatten().count();
    let limit = search::FALSE_ALARMS / (Rides::all(&history).len() * count) as f64;
    let of = |(number, d): (usize, difference::Difference)| {
        (history.numbers[number].name.clone(), d.t(), d.needed(limit))
    };
    evidence.sums.into_iter().map(of).collect()
}

/// The rows of one motorcycle: each ride's changes, or that it is as before; then those that start with it and others
/// share.
fn of_motorcycle(
    history: &History,
    found: &SearchResult,
    sure: &[(&Change, f64)],
) -> Vec<ChangeRow> {
    let mut rows = Vec::new();
    for ride in 0..history.len() {
        let own: Vec<_> = sure.iter().filter(|(c, _)| c.rides.has(ride)).collect();
        let (shared, alone): (Vec<_>, Vec<_>) =
            own.into_iter().partition(|(c, _)| c.rides.is_shared());
        rows.extend(alone.iter().map(|(c, rate)| changed(history, c, *rate)));
        if alone.is_empty() {
            rows.push(match shared.first() {
                Some((change, rate)) => as_others(history, change, *rate, ride),
                None => as_before(history, found, ride),
            });
        }
        let starts = shared.iter().filter(|(c, _)| c.rides.first() == ride);
        rows.extend(starts.map(|(c, rate)| changed(history, c, *rate)));
    }
    rows
}

/// The row of a ride that is as others that share a change.
fn as_others(history: &History, change: &Change, rate: f64, ride: usize) -> ChangeRow {
    let row = changed(history, change, rate);
    let others = match change.rides.kind {
        Kind::Since => format!("the rides {}", place(&row)),
        Kind::Drift => "all rides".to_owned(),
        _ => format!("the other rides of {}", change.rides.common.join(", ")),
    };
    ChangeRow {
        ident: history.rides[ride].clone(),
        rides: "ride".to_owned(),
        n_rides: 1,
        n_others: history.len() as i64 - 1,
        verdict: match change.rides.kind {
            Kind::Since => "as_since",
            _ => "as_others",
        }
        .to_owned(),
        sentence: format!("as {others}: {}", row.sentence),
        ..row
    }
}

/// The row of a change.
fn changed(history: &History, change: &Change, rate: f64) -> ChangeRow {
    let [inside, others] = change.rides.counts();
    let number = &history.numbers[change.cause];
    let is_explained = number.effect.is_some() || change.swap.is_some();
    let verdict = match (is_explained, change.rivals.is_empty()) {
        (false, true) => "changed",
        (true, true) => "named",
        (_, false) => "ambiguous",
    };
    // a changed tyre has no size of its own: what moved has
    let sized = |x: f64| Some(x).filter(|x| change.swap.is_none() && x.is_finite());
    let listed = |names: Vec<String>| (!names.is_empty()).then(|| names.join(", "));
    let rivals = change.rivals.iter().map(|p| history.numbers[*p].name.clone()).collect();
    let moved = |m: &search::Moved| words::moved(&history.numbers[m.number], m.by);
    ChangeRow {
        ident: history.rides[change.rides.first()].clone(),
        rides: change.rides.name().to_owned(),
        in_common: listed(change.rides.common.clone()),
        n_rides: inside as i64,
        n_others: others as i64,
        verdict: verdict.to_owned(),
        cause: Some(change.swap.map_or_else(|| number.name.clone(), Affected::swap_key)),
        value: sized(change.size),
        unit: change.swap.is_none().then(|| number.unit.clone()),
        ci95_low: sized(change.size - change.half_width),
        ci95_high: sized(change.size + change.half_width),
        t: Some(change.t),
        chance: Some(change.chance),
        false_discovery_rate: Some(rate),
        rivals: listed(rivals),
        moved: listed(change.moved.iter().map(moved).collect()),
        sentence: words::sentence(history, change),
    }
}

/// The row of a ride of which no change is reported, or that cannot be compared.
fn as_before(history: &History, found: &SearchResult, ride: usize) -> ChangeRow {
    let ident: Ident = history.rides[ride].clone();
    let n_others = history.len() as i64 - 1;
    let row =
        ChangeRow { ident, rides: "ride".to_owned(), n_rides: 1, n_others, ..ChangeRow::default() };
    let is_clear = |chance: f64| chance * found.tried as f64 <= search::FALSE_ALARMS;
    match found.largest.iter().find(|l| l.ride == ride) {
        Some(largest) => ChangeRow {
            verdict: if is_clear(largest.chance) { "unclear" } else { "as_before" }.to_owned(),
            t: Some(largest.moved.by.t()),
            chance: Some(largest.chance),
            moved: Some(words::moved(&history.numbers[largest.moved.number], largest.moved.by)),
            sentence: match is_clear(largest.chance) {
                true => format!(
                    "differs from the motorcycle's {n_others} other rides beyond chance, but it may be the remainder of a \
                     larger change, or one of many tries"
                ),
                false => format!(
                    "no change beyond what the motorcycle's {n_others} other rides scatter by"
                ),
            },
            ..row
        },
        None => ChangeRow {
            verdict: "too_few".to_owned(),
            sentence: format!(
                "fewer than {OTHERS} other rides of the motorcycle can be compared with it"
            ),
            ..row
        },
    }
}
