//! What one way says of a change. Events of coefficients become rows as those of the comparison of rides, with the sentence of
//! the same pattern.

use crate::contract::fleet_event::{Affected, EventKind};
use crate::report::change_sentence::{self, Parts};
use crate::report::fleet::what_changed::rides::{Ride, Rides};
use crate::report::{labels, parameter_words};
use crate::simulate::effects::Effect;
use crate::statistics::number_format::typeset_sentence;
use crate::store::tables::changes::has_in_common;
use crate::store::tables::rows::{ChangeRow, EventRow, Ident};

/// Label of a change whose cause is not known.
pub(crate) const UNKNOWN: &str = "cause unknown";
/// Standard deviations of a 95 % interval.
const WIDE: f64 = 1.96;

/// Which way shows a change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Way {
    /// `diagnose` holds each ride's numbers against those of the other rides.
    Rides,
    /// `run` searches the coefficients of all sessions.
    Coefficients,
}

impl Way {
    pub(crate) fn words(self) -> &'static str {
        match self {
            Way::Rides => "comparison of rides",
            Way::Coefficients => "coefficients",
        }
    }
}

/// A number that each ride has.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)] // columns of the tables
pub(crate) enum Quantity {
    /// Of the table `coefficients`.
    Coefficient { tyre: String, name: String },
    /// Of the table `estimates`: a parameter of the nominal model, or the size of an effect.
    Number(String),
}

/// Evidence of one method.
#[derive(Debug, Clone)]
pub(crate) struct Evidence {
    pub way: Way,
    /// The change. An event's `rides` is also `stretch`: rides up to one that is not the last.
    pub row: ChangeRow,
    /// The rides that differ, by their place in the motorcycle's rides.
    pub members: Vec<bool>,
    /// The numbers that moved, the surest first; of the comparison of rides the cause first.
    pub quantities: Vec<Quantity>,
    /// The cause in one or two words, for a chart.
    pub label: String,
    /// Evidence, as a line below the sentence.
    pub detail: String,
}

impl Evidence {
    /// Of a row of `changes`.
    pub(crate) fn of_change(row: &ChangeRow, rides: &Rides) -> Self {
        let moved = row.moved.as_deref().unwrap_or_default();
        let moved_names = moved.split(", ").filter_map(|m| m.split(' ').next());
        let mut quantities: Vec<Quantity> = Vec::new();
        let swap = row.cause.as_deref().and_then(Affected::of_swap_key);
        // a changed tyre is no number of its own
        let cause = row.cause.as_deref().filter(|_| swap.is_none());
        for name in cause.into_iter().chain(moved_names) {
            let quantity = Quantity::Number(name.to_owned());
            if !name.is_empty() && !quantities.contains(&quantity) {
                quantities.push(quantity);
            }
        }
        let first = rides.place(&row.ident.session_id).unwrap_or(0);
        let is_member = |(i, ride): (usize, &Ride)| match row.rides.as_str() {
            "drift" => true,
            "since" => i >= first,
            "ride" => i == first,
            _ => i == first || has_in_common(row, &ride.ident, &ride.circumstances),
        };
        let effect = row.cause.as_deref().filter(|name| Effect::named(name).is_ok());
        let detail = match moved.is_empty() {
            true => String::new(),
            false => typeset_sentence(&format!("Moved: {moved}.")),
        };
        Evidence {
            way: Way::Rides,
            members: rides.rides.iter().enumerate().map(is_member).collect(),
            quantities,
            label: match (swap, effect) {
                (Some(swap), _) => swap.swap_label().to_owned(),
                (None, Some(effect)) => labels::spaced(effect),
                (None, None) => UNKNOWN.to_owned(),
            },
            detail,
            row: row.clone(),
        }
    }

    /// Of a row of `fleet_events`.
    pub(crate) fn of_event(event: &EventRow, rides: &Rides) -> Self {
        let is_of_run = |(_, ride): &(usize, &Ride)| ride.is_of_run;
        let known: Vec<usize> =
            rides.rides.iter().enumerate().filter(is_of_run).map(|(i, _)| i).collect();
        let first = rides.place(&event.first_session).unwrap_or(0);
        let last = rides.place(&event.last_session).unwrap_or(first);
        let kind = EventKind::from_name(&event.kind);
        let which = match kind {
            Some(EventKind::Drift) => "drift",
            _ if event.n_sessions <= 1 => "ride",
            _ if known.last() == Some(&last) => "since",
            _ => "stretch",
        };
        let inside = usize::try_from(event.n_sessions).unwrap_or(0);
        let others = match which {
            "drift" => 0,
            "since" => known.iter().filter(|i| **i < first).count(),
            _ => known.len().saturating_sub(inside),
        };
        let quantities: Vec<Quantity> =
            event.coefficients.split(", ").filter_map(quantity).collect();
        let what = quantities.first().map_or_else(|| "it".to_owned(), words);
        // the size is that of the surest coefficient, the evidence its contrast over its standard deviation
        let half = |size: f64| WIDE * (size / event.evidence).abs();
        let size = event.size.map(|s| change_sentence::size(s, half(s), (" %", 100.0)));
        let sentence = change_sentence::sentence(&Parts {
            what: &what,
            size: size.as_deref().unwrap_or_default(),
            rides: which,
            counts: [inside, others],
            cause: kind.and_then(|kind| cause(kind, &event.tyre)),
            rivals: &[],
        });
        let more: Vec<String> = quantities.iter().skip(1).map(words).collect();
        let also = match more.is_empty() {
            true => String::new(),
            false => format!("Also moved: {}. ", more.join(", ")),
        };
        let detail = format!("{also}{}", as_sentence(&typeset_sentence(&event.reason)));
        let ident = Ident {
            bike_id: event.bike_id.clone(),
            session_id: event.first_session.clone(),
            start_time: event.first_time.clone(),
        };
        Evidence {
            way: Way::Coefficients,
            members: (0..rides.rides.len())
                .map(|i| which == "drift" || (first..=last).contains(&i))
                .collect(),
            quantities,
            label: match kind {
                Some(EventKind::TyreSwap) => affected(&event.tyre).swap_label().to_owned(),
                Some(EventKind::BikeFile) => labels::spaced(&event.kind),
                _ => UNKNOWN.to_owned(),
            },
            detail,
            row: ChangeRow {
                ident,
                rides: which.to_owned(),
                in_common: match which {
                    "stretch" => Some(format!("{} to {}", event.first_session, event.last_session)),
                    "since" if kind == Some(EventKind::TyreSwap) => {
                        tyres(rides, first, &event.tyre)
                    }
                    _ => None,
                },
                n_rides: event.n_sessions,
                n_others: others as i64,
                verdict: "changed".to_owned(),
                value: event.size,
                unit: Some("1".to_owned()),
                t: Some(event.evidence),
                false_discovery_rate: event.false_discovery_rate,
                sentence,
                ..ChangeRow::default()
            },
        }
    }

    /// Over its standard error.
    pub(crate) fn strength(&self) -> f64 {
        self.row.t.map_or(0.0, f64::abs)
    }
}

/// A coefficient as the table of events has it: `rear mf_d`.
fn quantity(text: &str) -> Option<Quantity> {
    let (tyre, name) = text.split_once(' ')?;
    Some(Quantity::Coefficient { tyre: tyre.to_owned(), name: name.to_owned() })
}

/// A quantity in words, with its article.
pub(crate) fn words(quantity: &Quantity) -> String {
    match quantity {
        Quantity::Coefficient { tyre, name } => parameter_words::of_coefficient(tyre, name),
        Quantity::Number(name) => match Effect::named(name) {
            Ok(_) => labels::spaced(name),
            Err(_) => parameter_words::parameter(name).to_owned(),
        },
    }
}

/// A clause with a capital letter and a full stop; nothing of an empty one.
pub(super) fn as_sentence(clause: &str) -> String {
    let mut letters = clause.chars();
    match letters.next() {
        Some(first) => format!("{}{}.", first.to_uppercase(), letters.as_str()),
        None => String::new(),
    }
}

/// Cause of an event, as a main clause; `None` where coefficients do not show it.
fn cause(kind: EventKind, tyre: &str) -> Option<&'static str> {
    match kind {
        EventKind::TyreSwap => Some(affected(tyre).swap_sentence()),
        EventKind::BikeFile => Some("the bike file had a wrong mass, wheelbase or centre of mass"),
        EventKind::Drift | EventKind::Outlier | EventKind::Change => None,
    }
}

/// The part of an event; both tyres where the name is not known.
fn affected(tyre: &str) -> Affected {
    Affected::from_name(tyre).unwrap_or(Affected::Both)
}

/// The tyres that the logs say were new with a ride: `rear tyre soft`.
fn tyres(rides: &Rides, first: usize, tyre: &str) -> Option<String> {
    let [before, now] =
        [first.checked_sub(1)?, first].map(|i| rides.rides.get(i).map(|r| &r.circumstances));
    let (before, now) = (before?, now?);
    let pairs = [
        ("front", &before.tyre_front, &now.tyre_front),
        ("rear", &before.tyre_rear, &now.tyre_rear),
    ];
    let new = pairs
        .iter()
        .filter(|(part, before, now)| (tyre == *part || tyre == "both") && before != now);
    let new: Vec<String> = new
        .filter_map(|(part, _, now)| now.as_ref().map(|name| format!("{part} tyre {name}")))
        .collect();
    (!new.is_empty()).then(|| new.join(", "))
}
