//! What several rides' diagnoses say together, for the terminal: shared causes first, then those of single rides.

use std::collections::{BTreeMap, BTreeSet};

use crate::report::diagnosis::cause_labels;
use crate::report::diagnosis::outcome::{Outcome, is_found, outcome};
use crate::report::readable::sized;
use crate::report::terminal::sentences;
use crate::statistics::number_format;
use crate::store::tables::rows::CauseRow;

/// Causes of single rides that have a line.
const MAX_LINES: usize = 4;
/// Sessions that a line lists.
const LISTED: usize = 5;

/// Lines of at most `width` characters: `sessions` are the rows of each ride, `pooled` those that several share.
pub(crate) fn of_sessions(sessions: &[Vec<CauseRow>], pooled: &[CauseRow], width: usize) -> String {
    let mut out = String::new();
    sentences(&mut out, &said(sessions, pooled), width);
    out
}

/// The same in sentences, names of effects between backticks.
pub(super) fn said(sessions: &[Vec<CauseRow>], pooled: &[CauseRow]) -> Vec<String> {
    // a run that only finished what an earlier one computed has none of its own
    let mut all: Vec<String> =
        (!sessions.is_empty()).then(|| counts(sessions)).into_iter().collect();
    // the table has causes that were pooled and not identified, too
    let identified: Vec<CauseRow> = pooled.iter().filter(|c| is_found(c)).cloned().collect();
    all.extend(identified.iter().filter_map(shared));
    all.extend(single(sessions, &identified));
    all
}

/// Findings in one ride, a clause each with its size and interval.
pub(super) fn of_session(causes: &[CauseRow]) -> Vec<String> {
    let clause = |row: &CauseRow| {
        let what = cause_labels::effect(&row.effect, row.value);
        match sized(row) {
            Some((value, interval)) => format!("{what}: {value} ({interval})"),
            None => what,
        }
    };
    causes.iter().filter(|c| is_found(c)).map(clause).collect()
}

/// Findings in one ride, a sentence for each cause, or why there is none.
pub(crate) fn of_ride(causes: &[CauseRow]) -> Vec<String> {
    let none = match outcome(causes) {
        Outcome::Named | Outcome::Ambiguous => return causes_of_ride(causes),
        Outcome::Unexplained => "A misfit that no candidate explains.",
        Outcome::Blind => "The ride can show no cause.",
        Outcome::Null => "No cause that this ride could show.",
        Outcome::Refused => "A candidate, which is not confirmed.",
        Outcome::Unjudged => "The tables have no verdict.",
    };
    vec![none.to_owned()]
}

/// The causes of one ride, a sentence each; empty where there is none.
pub(crate) fn causes_of_ride(causes: &[CauseRow]) -> Vec<String> {
    let is_sure = outcome(causes) == Outcome::Named;
    let head = if is_sure { "Cause" } else { "One of several causes" };
    of_session(causes).iter().map(|clause| format!("{head}: {clause}.")).collect()
}

/// Numbers of rides by their result.
fn counts(sessions: &[Vec<CauseRow>]) -> String {
    let mut by: BTreeMap<&str, usize> = BTreeMap::new();
    for causes in sessions {
        let words = match outcome(causes) {
            Outcome::Named => "with a cause",
            Outcome::Ambiguous => "with one of several causes",
            Outcome::Unexplained => "with a misfit that no candidate explains",
            Outcome::Blind => "that can show nothing",
            Outcome::Null => "without a cause",
            Outcome::Refused => "with a candidate that is not confirmed",
            Outcome::Unjudged => "without a verdict",
        };
        *by.entry(words).or_default() += 1;
    }
    let parts: Vec<String> = by.into_iter().map(|(words, n)| format!("{n} {words}")).collect();
    format!("{}: {}.", number_format::count(sessions.len(), "ride"), parts.join(", "))
}

/// A cause that several rides share; `None` of one without a size.
fn shared(row: &CauseRow) -> Option<String> {
    let (value, interval) = sized(row)?;
    let over = row.pooled_over.as_deref().unwrap_or("");
    let of = match row.level.as_str() {
        "bike" => format!("All rides of {over}"),
        "site" => format!("All rides at {over}"),
        "night" => format!("All rides of {over}"),
        _ => "All rides".to_owned(),
    };
    let what = cause_labels::effect(&row.effect, row.value);
    Some(format!("{of}: {what}: {value} ({interval}); `{}`.", row.effect))
}

/// Causes that no line above has, the most frequent first.
fn single(sessions: &[Vec<CauseRow>], pooled: &[CauseRow]) -> Vec<String> {
    let is_shared =
        |c: &&CauseRow| pooled.iter().any(|p| p.effect == c.effect && sized(p).is_some());
    let mut by: BTreeMap<(&str, bool), Vec<&CauseRow>> = BTreeMap::new();
    for row in sessions.iter().flatten().filter(|c| is_found(c) && !is_shared(c)) {
        // a sign of its own is a sentence of its own
        by.entry((&row.effect, row.value.is_some_and(|v| v < 0.0))).or_default().push(row);
    }
    let mut groups: Vec<Vec<&CauseRow>> = by.into_values().collect();
    groups.sort_by_key(|rows| std::cmp::Reverse(rows.len()));
    let left = groups.len().saturating_sub(MAX_LINES);
    let mut out: Vec<String> = groups.into_iter().take(MAX_LINES).filter_map(group).collect();
    if left > 0 {
        out.push(format!(
            "{} more of single rides: -v or the report.",
            number_format::count(left, "cause")
        ));
    }
    out
}

/// One cause of some rides, with the range of its sizes.
fn group(mut rows: Vec<&CauseRow>) -> Option<String> {
    rows.sort_by(|a, b| a.value.unwrap_or(0.0).total_cmp(&b.value.unwrap_or(0.0)));
    let (first, last) = (*rows.first()?, *rows.last()?);
    let what = cause_labels::effect(&first.effect, first.value);
    let size = match (sized(first), sized(last)) {
        (Some((value, interval)), _) if rows.len() == 1 => format!("{value} ({interval})"),
        (Some((low, _)), Some((high, _))) => format!("{low} to {high}"),
        _ => "size unknown".to_owned(),
    };
    let sessions: BTreeSet<&str> = rows.iter().map(|r| r.ident.session_id.as_str()).collect();
    let listed: Vec<&str> = sessions.iter().take(LISTED).copied().collect();
    let more = if sessions.len() > LISTED { ", ..." } else { "" };
    Some(format!(
        "{}: {what}: {size}; `{}`: {}{more}.",
        number_format::count(sessions.len(), "ride"),
        first.effect,
        listed.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::verdict::Verdict;
    use crate::store::tables::rows::Ident;

    fn cause(session: &str, effect: &str, verdict: Verdict, value: f64) -> CauseRow {
        CauseRow {
            ident: Ident { session_id: session.into(), ..Ident::default() },
            effect: effect.into(),
            verdict: verdict.name().into(),
            level: "session".into(),
            unit: "s".into(),
            value: Some(value),
            ci95_low: Some(value - 0.002),
            ci95_high: Some(value + 0.002),
            ..CauseRow::default()
        }
    }

    #[test]
    fn one_ride_has_a_sentence_for_each_cause() {
        let found = of_ride(&[cause("a", "latency", Verdict::Named, 0.02)]);
        assert_eq!(found.len(), 1);
        assert!(found[0].starts_with("Cause: the velocity comes late: 20"), "{found:?}");
        let none = of_ride(&[cause("a", "latency", Verdict::NotNeeded, 0.02)]);
        assert_eq!(none, ["No cause that this ride could show."]);
    }

    #[test]
    fn shared_causes_come_first_and_are_not_said_twice() {
        let sessions = [
            vec![
                cause("a", "latency", Verdict::Named, 0.02),
                cause("a", "wind", Verdict::Named, 2.0),
            ],
            vec![
                cause("b", "latency", Verdict::Named, 0.021),
                cause("b", "wind", Verdict::Named, 3.0),
            ],
            vec![cause("c", "wind", Verdict::NotNeeded, 0.0)],
        ];
        let pooled =
            CauseRow { level: "fleet".into(), ..cause("", "latency", Verdict::Named, 0.0205) };
        let text = of_sessions(&sessions, &[pooled], 80);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "3 rides: 2 with a cause, 1 without a cause.");
        assert!(lines[1].starts_with("All rides: "), "{text}");
        let on_one_line = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains("2 rides: ") && on_one_line.contains("`wind`: a, b."), "{text}");
        assert_eq!(text.matches("`latency`").count(), 1, "{text}");
        assert!(lines.iter().all(|l| l.chars().count() <= 80), "{text}");
    }

    #[test]
    fn a_pooled_cause_that_is_not_identified_is_no_shared_cause() {
        let sessions = [vec![cause("a", "latency", Verdict::Named, 0.02)]];
        let pooled =
            CauseRow { level: "bike".into(), ..cause("", "latency", Verdict::NotNeeded, 0.0205) };
        let lines = said(&sessions, &[pooled]);
        assert!(lines.iter().all(|l| !l.starts_with("All rides")), "{lines:?}");
        assert!(lines.iter().any(|l| l.contains("`latency`: a.")), "{lines:?}");
    }
}
