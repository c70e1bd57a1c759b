//! What is new since the last diagnosis of an output: the changes that were not reported then, those that are no longer, and
//! how many stand.
//!
//! A change is the same if rides of the same kind differ for the same cause, in the same direction. The start of a step may be a
//! ride or two off, as more rides place it better. Each earlier change is the same as one current change at most. So a step is
//! new once, whichever night shows it first; so are its cause once it is found, and a step back.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::search::NEAR;
use crate::statistics::number_format::count;
use crate::store::tables::changes::{is_change, place, shared_words};
use crate::store::tables::rows::ChangeRow;

/// Most new changes that have a line each, and most that are no longer reported.
const LISTED: [usize; 2] = [40, 6];

/// The changes of an output, compared with those that it had.
#[derive(Debug)]
pub(crate) struct News<'a> {
    /// All current rows, each with whether it was not there at the last diagnosis.
    pub rows: Vec<(&'a ChangeRow, bool)>,
    /// Changes that were reported before and are no longer, nor any other of the same rides.
    pub gone: Vec<&'a ChangeRow>,
}

impl<'a> News<'a> {
    /// Of the current rows and the earlier ones, each in order of motorcycle and time.
    pub(crate) fn new(now: &'a [ChangeRow], before: &'a [ChangeRow]) -> Self {
        let starts = Starts::of(now);
        let [own_now, own_before] = [now, before].map(by_bike);
        let of = |rows: &BTreeMap<&str, Vec<&'a ChangeRow>>, row: &ChangeRow| {
            rows.get(row.ident.bike_id.as_str()).cloned().unwrap_or_default()
        };
        let mut rows = Vec::with_capacity(now.len());
        for own in now.chunk_by(|a, b| a.ident.bike_id == b.ident.bike_id) {
            let known = starts.known(own, &of(&own_before, &own[0]));
            rows.extend(own.iter().zip(known).map(|(row, is_known)| (row, !is_known)));
        }
        // the last day's step is a day's once there are later rides
        let is_again = |row: &ChangeRow, b: &ChangeRow| {
            starts.is_of_same_rides(row, b)
                || row.ident.key() == b.ident.key() && row.cause == b.cause
        };
        let is_gone = |b: &&ChangeRow| {
            let own = || of(&own_now, b).into_iter();
            is_change(b) && !own().any(|row| is_change(row) && is_again(row, b))
        };
        News { rows, gone: before.iter().filter(is_gone).collect() }
    }

    /// The new changes.
    pub(crate) fn new_changes(&self) -> Vec<&'a ChangeRow> {
        self.rows.iter().filter(|(row, is_new)| *is_new && is_change(row)).map(|r| r.0).collect()
    }

    /// The changes that were reported before and stand.
    pub(crate) fn standing(&self) -> Vec<&'a ChangeRow> {
        self.rows.iter().filter(|(row, is_new)| !is_new && is_change(row)).map(|r| r.0).collect()
    }

    /// Lines for a terminal: how the rides that were diagnosed now compare, what is new, and how much stands, with what lists
    /// it. Empty where no ride can be compared yet.
    pub(crate) fn text(&self, diagnosed: &BTreeSet<(&str, &str)>, list: &str) -> String {
        if self.gone.is_empty() && self.rows.iter().all(|(row, _)| row.verdict == "too_few") {
            return String::new();
        }
        let mut text = self.head(diagnosed);
        let new = self.new_changes();
        text += match new.is_empty() {
            true => "No new change since the last diagnosis.\n",
            false => "New since the last diagnosis:\n",
        };
        let mut last = String::new();
        for row in new.iter().take(LISTED[0]) {
            let rides = format!("{}, {}", row.ident.bike_id, place(row));
            // writing to a String cannot fail
            let _ = match rides == last {
                true => writeln!(text, "    also: {}", row.sentence),
                false => writeln!(text, "  {rides}: {}", row.sentence),
            };
            last = rides;
        }
        if new.len() > LISTED[0] {
            let _ = writeln!(text, "  and {} more", new.len() - LISTED[0]);
        }
        if !self.gone.is_empty() {
            let what = |row: &&ChangeRow| {
                format!("{}, {}: {}", row.ident.bike_id, place(row), subject(&row.sentence))
            };
            let mut lines: Vec<String> = self.gone.iter().take(LISTED[1]).map(what).collect();
            if self.gone.len() > LISTED[1] {
                lines.push(format!("and {} more", self.gone.len() - LISTED[1]));
            }
            let _ = writeln!(text, "No longer reported: {}", lines.join("; "));
        }
        let standing = self.standing();
        if !standing.is_empty() {
            let bikes: BTreeSet<&str> =
                standing.iter().map(|row| row.ident.bike_id.as_str()).collect();
            let [stand, lists] =
                if standing.len() == 1 { ["stands", "it"] } else { ["stand", "them"] };
            let _ = writeln!(
                text,
                "{} of {} still {stand}; {list} lists {lists}.",
                count(standing.len(), "earlier change"),
                count(bikes.len(), "motorcycle")
            );
        }
        text
    }

    /// How the rides that were diagnosed now compare with the others of their motorcycles; empty without any.
    fn head(&self, diagnosed: &BTreeSet<(&str, &str)>) -> String {
        if diagnosed.is_empty() {
            return String::new();
        }
        let of = |is: &dyn Fn(&ChangeRow) -> bool| {
            let own = self.rows.iter().map(|r| r.0).filter(|row| row.rides == "ride" && is(row));
            let keys: BTreeSet<(&str, &str)> = own.map(|row| row.ident.key()).collect();
            keys.intersection(diagnosed).count()
        };
        let drifts = self.rows.iter().map(|r| r.0).filter(|row| row.rides == "drift");
        let drifting: BTreeSet<&str> = drifts.map(|row| row.ident.bike_id.as_str()).collect();
        let has_drift = |row: &ChangeRow| drifting.contains(row.ident.bike_id.as_str());
        let is_shared = |row: &ChangeRow| row.verdict == "as_others";
        let verdict = |name: &'static str| move |row: &ChangeRow| row.verdict == name;
        let parts = [
            (of(&verdict("as_before")), "as the motorcycle's other rides"),
            (of(&verdict("as_since")), "after a change that lasts"),
            (of(&|row| is_shared(row) && !has_drift(row)), shared_words(false)),
            (of(&|row| is_shared(row) && has_drift(row)), shared_words(true)),
            (of(&is_change), "unlike the motorcycle's other rides"),
            (of(&verdict("unclear")), "not clear"),
            (of(&verdict("too_few")), "of motorcycles with fewer than four rides"),
        ];
        let parts: Vec<String> =
            parts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
        let all = count(diagnosed.len(), "ride");
        if parts.is_empty() {
            format!("{all} diagnosed\n")
        } else {
            format!("{all} diagnosed: {}\n", parts.join(", "))
        }
    }
}

/// The rows of each motorcycle.
fn by_bike(rows: &[ChangeRow]) -> BTreeMap<&str, Vec<&ChangeRow>> {
    let mut bikes: BTreeMap<&str, Vec<&ChangeRow>> = BTreeMap::new();
    for row in rows {
        bikes.entry(row.ident.bike_id.as_str()).or_default().push(row);
    }
    bikes
}

/// What a sentence says that differs.
fn subject(sentence: &str) -> &str {
    let ends = [" differs", " drifts"].iter().filter_map(|verb| sentence.find(verb));
    &sentence[..ends.min().unwrap_or(sentence.len())]
}

/// The order of the rides of each motorcycle.
struct Starts<'a> {
    order: BTreeMap<(&'a str, &'a str), usize>,
}

impl<'a> Starts<'a> {
    fn of(rows: &'a [ChangeRow]) -> Self {
        let mut order = BTreeMap::new();
        for row in rows {
            let next = order.len();
            order.entry(row.ident.key()).or_insert(next);
        }
        Starts { order }
    }

    /// Whether each of a motorcycle's rows was there before. The nearest starts are paired first, and each earlier row is in
    /// one pair.
    fn known(&self, now: &[ChangeRow], before: &[&ChangeRow]) -> Vec<bool> {
        let mut pairs = Vec::new();
        for (i, row) in now.iter().enumerate() {
            let same = before.iter().enumerate().filter(|(_, b)| self.is_same(row, b));
            pairs.extend(same.map(|(j, b)| (self.apart(row, b).unwrap_or_default(), i, j)));
        }
        pairs.sort_unstable();
        let (mut known, mut is_taken) = (vec![false; now.len()], vec![false; before.len()]);
        for (_, i, j) in pairs {
            if !known[i] && !is_taken[j] {
                (known[i], is_taken[j]) = (true, true);
            }
        }
        known
    }

    /// Rides between the starts of two rows; `None` where one is of no current ride.
    fn apart(&self, a: &ChangeRow, b: &ChangeRow) -> Option<usize> {
        let at = |row: &ChangeRow| self.order.get(&row.ident.key()).copied();
        at(a).zip(at(b)).map(|(a, b)| a.abs_diff(b))
    }

    /// Whether two rows say the same.
    fn is_same(&self, a: &ChangeRow, b: &ChangeRow) -> bool {
        if !self.is_of_same_rides(a, b) {
            return false;
        }
        match is_change(a) || is_change(b) {
            true => {
                let is_opposite = a.value.zip(b.value).is_some_and(|(a, b)| a * b < 0.0);
                is_change(a) && is_change(b) && a.cause == b.cause && !is_opposite
            }
            false => a.verdict == b.verdict,
        }
    }

    /// Whether two rows are of the same rides, but for those that came since.
    fn is_of_same_rides(&self, a: &ChangeRow, b: &ChangeRow) -> bool {
        if a.ident.bike_id != b.ident.bike_id || a.rides != b.rides {
            return false;
        }
        let first = |text: &Option<String>| {
            text.as_deref().and_then(|t| t.split(", ").next()).map(str::to_owned)
        };
        match a.rides.as_str() {
            "drift" => true,
            "ride" => a.ident.session_id == b.ident.session_id,
            "since" => self.apart(a, b).is_some_and(|apart| apart <= NEAR),
            _ => first(&a.in_common) == first(&b.in_common),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tables::rows::Ident;

    fn row(bike: &str, k: usize, rides: &str, verdict: &str, cause: &str) -> ChangeRow {
        ChangeRow {
            ident: Ident {
                bike_id: bike.into(),
                session_id: format!("{bike}{k:02}"),
                start_time: Some(format!("2026-05-{:02}T10:00:00Z", k + 1)),
            },
            rides: rides.into(),
            verdict: verdict.into(),
            cause: (!cause.is_empty()).then(|| cause.to_owned()),
            sentence: format!("{cause} differs by 2"),
            ..ChangeRow::default()
        }
    }

    /// Rides of a motorcycle as before, with changes at places of them.
    fn rows(bike: &str, n: usize, changes: &[(usize, &str, &str)]) -> Vec<ChangeRow> {
        let mut all = Vec::new();
        for k in 0..n {
            let own = || changes.iter().filter(move |c| c.0 == k);
            if !own().any(|c| c.1 == "ride") {
                all.push(row(bike, k, "ride", "as_before", ""));
            }
            all.extend(own().map(|(k, rides, cause)| row(bike, *k, rides, "named", cause)));
        }
        all
    }

    fn text(now: &[ChangeRow], before: &[ChangeRow], diagnosed: &[(&str, &str)]) -> String {
        News::new(now, before).text(&diagnosed.iter().copied().collect(), "`roadbench show out`")
    }

    #[test]
    fn a_night_without_a_change_has_one_line_and_what_stands() {
        let before = rows("a", 6, &[(2, "ride", "wind"), (4, "since", "latency")]);
        let now = rows("a", 8, &[(2, "ride", "wind"), (4, "since", "latency")]);
        let said = text(&now, &before, &[("a", "a06"), ("a", "a07")]);
        assert_eq!(
            said,
            "2 rides diagnosed: 2 as the motorcycle's other rides\nNo new change since the last diagnosis.\n\
             2 earlier changes of 1 motorcycle still stand; `roadbench show out` lists them.\n"
        );
    }

    #[test]
    fn what_is_new_comes_first_and_once() {
        let before = rows("a", 8, &[(4, "since", "latency"), (6, "ride", "wind")]);
        let mut now = rows("a", 10, &[(5, "since", "latency"), (9, "ride", "roll_zero")]);
        now.extend(rows("b", 4, &[]));
        let said = text(&now, &before, &[("a", "a08"), ("a", "a09")]);
        // the step is a ride later than before: it is the same one
        assert_eq!(
            said,
            "2 rides diagnosed: 1 as the motorcycle's other rides, 1 unlike the motorcycle's other rides\n\
             New since the last diagnosis:\n  a, a09 (2026-05-10): roll_zero differs by 2\n\
             No longer reported: a, a06 (2026-05-07): wind\n\
             1 earlier change of 1 motorcycle still stands; `roadbench show out` lists it.\n"
        );
        let news = News::new(&now, &now);
        assert!(news.new_changes().is_empty() && news.gone.is_empty());
        assert!(news.rows.iter().all(|(_, is_new)| !is_new));
        // of the same rides the place stands once
        let odd = rows("a", 10, &[(9, "ride", "roll_zero"), (9, "ride", "wind")]);
        let said = text(&odd, &rows("a", 9, &[]), &[("a", "a09")]);
        let lines = "  a, a09 (2026-05-10): roll_zero differs by 2\n    also: wind differs by 2\n";
        assert!(said.ends_with(lines), "{said}");
    }

    #[test]
    fn rides_that_cannot_be_compared_have_no_news() {
        let few: Vec<ChangeRow> = (0..2).map(|k| row("a", k, "ride", "too_few", "")).collect();
        assert_eq!(text(&few, &few[..1], &[("a", "a01")]), "");
    }

    /// A wind of the last day was since that day; the next night says that it was the day's.
    #[test]
    fn what_did_not_last_is_not_called_gone_beside_what_it_was() {
        let before = rows("a", 8, &[(6, "since", "wind")]);
        let now = rows("a", 10, &[(6, "day", "wind")]);
        let news = News::new(&now, &before);
        assert_eq!(news.new_changes().len(), 1);
        assert!(news.gone.is_empty());
    }

    /// A zero that shifts and goes back two rides later: the way back is a change of its own.
    #[test]
    fn a_step_back_is_new() {
        let with_values = |changes: &[(usize, f64)]| {
            let steps: Vec<_> = changes.iter().map(|(k, _)| (*k, "since", "roll_zero")).collect();
            let mut all = rows("a", 9, &steps);
            for row in all.iter_mut().filter(|row| row.cause.is_some()) {
                let own = changes.iter().find(|(k, _)| row.ident.session_id == format!("a{k:02}"));
                row.value = own.map(|(_, value)| *value);
            }
            all
        };
        let new = |now: &[(usize, f64)], before: &[(usize, f64)]| {
            let [now, before] = [now, before].map(with_values);
            let news = News::new(&now, &before);
            let starts = news.new_changes().into_iter().map(|row| row.ident.session_id.clone());
            (starts.collect::<Vec<_>>(), news.standing().len(), news.gone.len())
        };
        let before = [(5, 0.01)];
        assert_eq!(new(&[(5, 0.01), (7, -0.01)], &before), (vec!["a07".to_owned()], 1, 0));
        // two in the same direction are two changes; the nearer one is the earlier one
        assert_eq!(new(&[(4, 0.01), (6, 0.02)], &[(6, 0.02)]), (vec!["a04".to_owned()], 1, 0));
        assert_eq!(new(&[(5, -0.01)], &before), (vec!["a05".to_owned()], 0, 0));
        assert_eq!(new(&[(6, 0.012)], &before), (vec![], 1, 0));
    }

    /// A change whose cause was not known is new once it is known, and not called gone.
    #[test]
    fn a_cause_that_is_found_is_new() {
        let before = rows("a", 8, &[(4, "since", "radius_rear")]);
        let now = rows("a", 8, &[(4, "since", "tyre_swap_rear")]);
        let news = News::new(&now, &before);
        assert_eq!(news.new_changes().len(), 1);
        assert!(news.gone.is_empty() && news.standing().is_empty());
        // two motorcycles with rides of the same names
        let other = rows("b", 8, &[(4, "since", "tyre_swap_rear")]);
        assert_eq!(News::new(&other, &now).new_changes().len(), 1);
    }
}
