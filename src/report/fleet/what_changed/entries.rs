//! One list of what changed on a motorcycle, in order of time. An event and a change of the same rides and a related quantity
//! are one entry with both evidences.

use serde::Serialize;

use crate::report::fleet::what_changed::evidence::{Evidence, UNKNOWN, Way, as_sentence};
use crate::report::fleet::what_changed::related::are_related;
use crate::report::fleet::what_changed::rides::Rides;
use crate::statistics::number_format::typeset_sentence;
use crate::store::tables::changes::{is_change, place};
use crate::store::tables::rows::{ChangeRow, EventRow};

/// Rides by which two ways may be apart in where a change begins and ends.
const APART: usize = 1;

#[derive(Debug, Clone)]
pub(crate) struct Entry {
    /// Evidence of each method: the comparison of rides first.
    pub evidence: Vec<Evidence>,
}

impl Entry {
    pub(crate) fn place(&self) -> String {
        self.evidence.first().map(|e| place(&e.row)).unwrap_or_default()
    }

    /// Which rides one way says, where the place of the entry does not say it: `Since s07 (2026-05-08, rear tyre soft). `.
    fn own_place(&self, of: &Evidence) -> String {
        let Some(first) = self.evidence.first() else { return String::new() };
        let is_elsewhere = of.row.ident.session_id != first.row.ident.session_id;
        let is_more = of.row.in_common.is_some() && of.row.in_common != first.row.in_common;
        match is_elsewhere || is_more {
            true => format!("{} ", as_sentence(&place(&of.row))),
            false => String::new(),
        }
    }

    /// The cause of the surest change, or that of the coefficients where the comparison of rides knows none.
    fn cause(&self) -> String {
        let of_way = |way: Way| self.evidence.iter().find(|e| e.way == way).map(|e| &e.label);
        let all = || [Way::Rides, Way::Coefficients].into_iter().filter_map(of_way);
        all().find(|label| *label != UNKNOWN).or(all().next()).cloned().unwrap_or_default()
    }

    /// The largest size over its standard error.
    pub(crate) fn strength(&self) -> f64 {
        self.evidence.iter().map(Evidence::strength).fold(0.0, f64::max)
    }

    /// As a page shows it.
    pub(crate) fn shown(&self, rides: &Rides) -> Shown {
        let first = self.evidence.first().and_then(|e| rides.place(&e.row.ident.session_id));
        let line = |e: &Evidence| Line {
            sentence: typeset_sentence(&e.row.sentence),
            way: e.way.words(),
            detail: format!("{}{}", self.own_place(e), e.detail),
        };
        Shown {
            place: self.place(),
            page: first.map(|i| rides.rides[i].page.clone()).unwrap_or_default(),
            cause: self.cause(),
            lines: self.evidence.iter().map(line).collect(),
        }
    }
}

/// An entry as a page shows it.
#[derive(Debug, Clone, Serialize)]
#[allow(missing_docs)] // parts of the line in the template
pub(crate) struct Shown {
    pub place: String,
    pub page: String,
    /// The cause in one to three words.
    pub cause: String,
    pub lines: Vec<Line>,
}

/// Evidence of one method.
#[derive(Debug, Clone, Serialize)]
#[allow(missing_docs)] // parts of the line in the template
pub(crate) struct Line {
    pub sentence: String,
    pub way: &'static str,
    pub detail: String,
}

/// Changes on one motorcycle, in order of the first ride that differs; of one ride the longest change comes first, then
/// the surest.
pub(crate) fn entries(changes: &[ChangeRow], events: &[EventRow], rides: &Rides) -> Vec<Entry> {
    let mut all: Vec<Entry> =
        events.iter().map(|e| Entry { evidence: vec![Evidence::of_event(e, rides)] }).collect();
    for row in changes.iter().filter(|r| is_change(r)) {
        let change = Evidence::of_change(row, rides);
        let is_same = |entry: &&mut Entry| {
            let event = entry.evidence.iter().find(|e| e.way == Way::Coefficients);
            event.is_some_and(|event| {
                is_same_time(&change, event) && are_related(&change.quantities, &event.quantities)
            })
        };
        match all.iter_mut().find(is_same) {
            Some(entry) => entry.evidence.push(change),
            None => all.push(Entry { evidence: vec![change] }),
        }
    }
    for entry in &mut all {
        entry
            .evidence
            .sort_by(|a, b| a.way.cmp(&b.way).then_with(|| b.strength().total_cmp(&a.strength())));
    }
    let key = |entry: &Entry| {
        let members = entry.evidence.first().map(|e| &e.members[..]).unwrap_or_default();
        let first = members.iter().position(|m| *m).unwrap_or(usize::MAX);
        (first, std::cmp::Reverse(members.iter().filter(|m| **m).count()))
    };
    all.sort_by(|a, b| key(a).cmp(&key(b)).then_with(|| b.strength().total_cmp(&a.strength())));
    all
}

/// Whether two ways say something of the same rides: a drift of both, the same single ride, or rides that begin and end alike.
fn is_same_time(change: &Evidence, event: &Evidence) -> bool {
    let is = |e: &Evidence, kind: &str| e.row.rides == kind;
    for kind in ["drift", "ride"] {
        if is(change, kind) || is(event, kind) {
            return is(change, kind) && is(event, kind) && change.members == event.members;
        }
    }
    let ends = |e: &Evidence| {
        let first = e.members.iter().position(|m| *m);
        first.zip(e.members.iter().rposition(|m| *m))
    };
    let (Some(a), Some(b)) = (ends(change), ends(event)) else { return false };
    // rides of a rider who rides now and then are no stretch
    let differ = change.members.iter().zip(&event.members).filter(|(a, b)| a != b).count();
    a.0.abs_diff(b.0) <= APART && a.1.abs_diff(b.1) <= APART && differ <= 2 * APART
}
