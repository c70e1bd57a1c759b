//! Rows of `changes` in words that every reader of them uses.

use std::collections::BTreeSet;

use super::rows::ChangeRow;

/// How many rides of a motorcycle are as before; `None` where none can be compared.
pub(crate) fn head(rows: &[ChangeRow]) -> Option<String> {
    let of = |is: &dyn Fn(&ChangeRow) -> bool| {
        let rides = rows.iter().filter(|r| r.rides == "ride" && is(r));
        rides.map(|r| &r.ident.session_id).collect::<BTreeSet<_>>().len()
    };
    let all = of(&|r| r.verdict != "too_few");
    let (same, since) = (of(&|r| r.verdict == "as_before"), of(&|r| r.verdict == "as_since"));
    let (shared, unclear) = (of(&|r| r.verdict == "as_others"), of(&|r| r.verdict == "unclear"));
    let more = |n: usize, what: &str| if n > 0 { format!(", {n} {what}") } else { String::new() };
    (all > 0).then(|| {
        format!(
            "{same} of {all} rides as before{}{}{}",
            more(since, "as since a change"),
            more(shared, "share a change"),
            more(unclear, "unclear")
        )
    })
}

/// Whether a row says that something changed.
pub(crate) fn is_change(row: &ChangeRow) -> bool {
    matches!(row.verdict.as_str(), "named" | "ambiguous" | "changed")
}

/// Which rides: the session and its date, `since` before it where all later ones are meant; what the rides have in common
/// and how many they are.
pub(crate) fn place(row: &ChangeRow) -> String {
    let session = &row.ident.session_id;
    let date = row.ident.start_time.as_deref().and_then(|t| t.get(..10));
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
