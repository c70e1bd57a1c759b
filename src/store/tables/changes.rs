//! Rows of `changes` in words that every reader of them uses.

use std::collections::BTreeSet;

use super::rows::{ChangeRow, Circumstances, Ident};

/// Rides by which a set can be made, as the column `rides` has them, and in words.
const COMMON: [(&str, &str); 5] = [
    ("tyre_front", "front tyre"),
    ("tyre_rear", "rear tyre"),
    ("rider", "rider"),
    ("site", "site"),
    ("day", "day"),
];
/// Text before the words where the rides are the rest.
pub(crate) const REST: &str = "all but ";

/// Common property of rides, by the name that the column `rides` has, in words with its value: `rider anna`.
pub(crate) fn common_words(rides: &str, value: &str) -> String {
    let known = COMMON.iter().find(|(name, _)| *name == rides);
    format!("{} {value}", known.map_or(rides, |(_, words)| *words))
}

/// Property that a ride has in common with others, by the name that the column `rides` has, in words: `rider anna`. `None` where its
/// log does not say.
pub(crate) fn common(rides: &str, ident: &Ident, around: &Circumstances) -> Option<String> {
    let value = match rides {
        "tyre_front" => around.tyre_front.as_deref(),
        "tyre_rear" => around.tyre_rear.as_deref(),
        "rider" => around.rider_id.as_deref(),
        "site" => around.site.as_deref(),
        "day" => date(ident),
        _ => None,
    };
    value.filter(|value| !value.is_empty()).map(|value| common_words(rides, value))
}

/// Whether a ride is one of those that have a row's change in common.
pub(crate) fn has_in_common(row: &ChangeRow, ident: &Ident, around: &Circumstances) -> bool {
    let (Some(all), Some(own)) = (&row.in_common, common(&row.rides, ident, around)) else {
        return false;
    };
    // what the rides are a set by stands first; further words are of the same rides
    let is = |words: &str| {
        words.strip_prefix(&own).is_some_and(|rest| rest.is_empty() || rest.starts_with(", "))
    };
    match all.strip_prefix(REST) {
        Some(rest) => !is(rest),
        None => is(all),
    }
}

/// The date of a ride.
fn date(ident: &Ident) -> Option<&str> {
    ident.start_time.as_deref().and_then(|t| t.get(..10))
}

/// Number of rides of a motorcycle that are as before; `None` where none can be compared.
pub(crate) fn head(rows: &[ChangeRow]) -> Option<String> {
    let of = |is: &dyn Fn(&ChangeRow) -> bool| {
        let rides = rows.iter().filter(|r| r.rides == "ride" && is(r));
        rides.map(|r| &r.ident.session_id).collect::<BTreeSet<_>>().len()
    };
    let all = of(&|r| r.verdict != "too_few");
    let (same, since) = (of(&|r| r.verdict == "as_before"), of(&|r| r.verdict == "as_since"));
    let (shared, unclear) = (of(&|r| r.verdict == "as_others"), of(&|r| r.verdict == "unclear"));
    let is_drift = rows.iter().any(|r| r.rides == "drift");
    let more = |n: usize, what: &str| if n > 0 { format!(", {n} {what}") } else { String::new() };
    (all > 0).then(|| {
        format!(
            "{same} of {all} rides as before{}{}{}",
            more(since, "after a change that lasts"),
            more(shared, shared_words(is_drift)),
            more(unclear, "unclear")
        )
    })
}

/// Words for rides that differ as other rides do, whose motorcycle has a drift or none.
pub(crate) fn shared_words(is_drift: bool) -> &'static str {
    if is_drift { "follow a drift" } else { "share a change" }
}

/// Whether a row says that something changed.
pub(crate) fn is_change(row: &ChangeRow) -> bool {
    matches!(row.verdict.as_str(), "named" | "ambiguous" | "changed")
}

/// Which rides: the session and its date, `since` before it where all later ones are meant; what the rides have in common
/// and how many they are.
pub(crate) fn place(row: &ChangeRow) -> String {
    let session = &row.ident.session_id;
    let date = date(&row.ident);
    let all = row.in_common.as_deref();
    match (row.rides.as_str(), all) {
        ("drift", _) => format!("over {} rides", row.n_rides),
        ("since", _) => {
            let details: Vec<&str> = date.into_iter().chain(all).collect();
            match details.is_empty() {
                true => format!("since {session}"),
                false => format!("since {session} ({})", details.join(", ")),
            }
        }
        ("ride" | "against", _) | (_, None) => {
            date.map_or(session.clone(), |date| format!("{session} ({date})"))
        }
        (_, Some(all)) => format!("{all} ({} rides)", row.n_rides),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rides_are_known_by_what_they_have_in_common() {
        let of = |rider: &str| Circumstances {
            rider_id: Some(rider.to_owned()),
            ..Circumstances::default()
        };
        let ident = Ident { start_time: Some("2026-05-03T10:00:00Z".into()), ..Ident::default() };
        let row = |rides: &str, all: &str| ChangeRow {
            rides: rides.to_owned(),
            in_common: Some(all.to_owned()),
            ..ChangeRow::default()
        };
        let anna = row("rider", "rider anna, site north");
        assert!(has_in_common(&anna, &ident, &of("anna")));
        // a name that begins like another is another
        assert!(!has_in_common(&row("rider", "rider annabel"), &ident, &of("anna")));
        assert!(!has_in_common(&anna, &ident, &of("ben")));
        let rest = row("rider", "all but rider anna");
        assert!(!has_in_common(&rest, &ident, &of("anna")));
        assert!(has_in_common(&rest, &ident, &of("ben")));
        assert!(has_in_common(&row("day", "day 2026-05-03"), &ident, &of("ben")));
        assert!(!has_in_common(&row("since", "front tyre new"), &ident, &of("ben")));
    }
}
