//! What a diagnosis concludes of one ride, as an answer to the question whether the model reproduces it.

use serde::Serialize;

use crate::contract::verdict::{ALARM_OFFROAD, ALARM_ROAD, Verdict};
use crate::report::diagnosis::{cause_labels, simulation};
use crate::report::kinds;
use crate::report::readable::sized;
use crate::simulate::effects::Effect;
use crate::statistics::number_format::{self, fixed, typeset_sentence};
use crate::store::tables::rows::{CauseRow, DiscrepancyRow, Ident, SimulationError};

/// Most signals that are listed as left.
const LEFT: usize = 3;

/// Result of the diagnosis of a ride.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The cause is known.
    Named,
    /// It is one of several.
    Ambiguous,
    /// Nothing is wrong that the ride could show.
    Null,
    /// A candidate scores as a cause does, and a rule refused it.
    Refused,
    /// Something is wrong and nothing explains it.
    Unexplained,
    /// The ride can show none of the candidates.
    Blind,
    /// The table `causes` does not know the ride.
    Unjudged,
}

#[derive(Debug, Clone, Serialize)]
pub struct Finding {
    /// Name in the table.
    pub name: String,
    /// Sentence of the effect, as a clause.
    pub sentence: String,
    /// Its size with unit.
    pub size: String,
    /// 95 % interval.
    pub interval: String,
    /// Other causes that it could be.
    pub or: Vec<String>,
    /// Where it was found, if not in this ride alone.
    pub level: String,
}

/// One line of the run's page.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub(crate) struct Entry {
    pub href: String,
    pub session_id: String,
    pub bike_id: String,
    pub start: String,
    pub outcome: Outcome,
    pub verdict: &'static str,
    pub findings: Vec<Finding>,
    pub reason: String,
    /// Largest gain of the simulation by the identified causes, or that it gains nothing, and what gets worse; of an
    /// unexplained ride where it is wrong.
    pub gain: String,
    pub structured: usize,
}

/// Result of the rows of a ride.
pub fn outcome(causes: &[CauseRow]) -> Outcome {
    let is = |verdict: Verdict| causes.iter().any(|c| c.verdict == verdict.name());
    let blind = |c: &CauseRow| c.verdict == Verdict::NotIdentifiable.name();
    match causes {
        [] => Outcome::Unjudged,
        _ if is(Verdict::Named) => Outcome::Named,
        _ if is(Verdict::Ambiguous) => Outcome::Ambiguous,
        _ if is(Verdict::Unexplained) => Outcome::Unexplained,
        _ if causes.iter().all(blind) => Outcome::Blind,
        _ if causes.iter().any(is_refused) => Outcome::Refused,
        _ => Outcome::Null,
    }
}

/// Whether a candidate has the score of a cause and is none.
fn is_refused(row: &CauseRow) -> bool {
    let needed = if Effect::named(&row.effect).is_ok() { ALARM_ROAD } else { ALARM_OFFROAD };
    row.verdict == Verdict::NotNeeded.name() && row.score > needed
}

/// Candidates with the score of a cause that were refused, each with the rule that refused it: for pages and the terminal.
pub(crate) fn refused(causes: &[CauseRow]) -> impl Iterator<Item = String> {
    causes.iter().filter(|c| is_refused(c)).map(|c| {
        let size = sized(c).map_or(String::new(), |(size, _)| format!(", {size}"));
        let (what, score) = (cause_labels::effect(&c.effect, c.value), fixed(c.score, 1));
        format!("{}: {what}{size}, score {score}; {}", c.effect, c.reason.trim_end_matches('.'))
    })
}

/// One line of the run's page.
pub(crate) fn entry(
    ident: &Ident,
    href: &str,
    causes: &[CauseRow],
    rows: &[DiscrepancyRow],
    errors: &[SimulationError],
) -> Entry {
    let outcome = outcome(causes);
    Entry {
        href: href.to_owned(),
        session_id: ident.session_id.clone(),
        bike_id: ident.bike_id.clone(),
        start: ident.start_time.as_deref().map(number_format::timestamp).unwrap_or_default(),
        outcome,
        verdict: match outcome {
            Outcome::Named => "cause identified",
            Outcome::Ambiguous => "one of several",
            Outcome::Null => "no cause that this ride could show",
            Outcome::Refused => "not confirmed",
            Outcome::Unexplained => "unexplained",
            Outcome::Blind => "the ride can show nothing",
            Outcome::Unjudged => "no verdict in the tables",
        },
        findings: findings(causes),
        reason: match outcome {
            Outcome::Refused => refused(causes).next().unwrap_or_default(),
            _ => unexplained(causes).map(|c| c.reason.clone()).unwrap_or_default(),
        },
        gain: match outcome {
            Outcome::Unexplained => simulation::wrong_in_short(errors),
            _ => simulation::in_short(errors),
        },
        structured: rows.iter().filter(|r| r.structured).count(),
    }
}

pub(super) fn is_found(row: &CauseRow) -> bool {
    Verdict::from_name(&row.verdict).is_some_and(Verdict::is_cause)
}

/// Whether a row is of a candidate, and not of what none of them explains.
pub(super) fn is_candidate(row: &CauseRow) -> bool {
    row.verdict != Verdict::Unexplained.name()
}

fn unexplained(causes: &[CauseRow]) -> Option<&CauseRow> {
    causes.iter().find(|c| !is_candidate(c))
}

pub(super) fn equivalents(row: &CauseRow) -> Vec<&str> {
    let names = row.equivalent_to.as_deref().unwrap_or_default().split(',').map(str::trim);
    names.filter(|n| !n.is_empty()).collect()
}

pub(super) fn findings(causes: &[CauseRow]) -> Vec<Finding> {
    causes
        .iter()
        .filter(|c| is_found(c))
        .map(|c| {
            let (size, interval) = cause_labels::size(c);
            Finding {
                name: c.effect.clone(),
                sentence: cause_labels::effect(&c.effect, c.value),
                size,
                interval,
                or: equivalents(c)
                    .into_iter()
                    .map(|name| cause_labels::effect_in(causes, name))
                    .collect(),
                level: cause_labels::level(&c.level),
            }
        })
        .collect()
}

pub(super) fn verdict(
    outcome: Outcome,
    findings: &[Finding],
    causes: &[CauseRow],
) -> (&'static str, String) {
    match outcome {
        Outcome::Named => (
            match unexplained(causes) {
                None => "No, and it is known why.",
                Some(_) => "No, and only part of it is known.",
            },
            match findings.len() {
                1 => "One cause is identified:".to_owned(),
                n => format!("{n} causes are identified:"),
            },
        ),
        Outcome::Ambiguous => (
            "No, and this ride cannot distinguish between several causes.",
            match findings.len() {
                1 => "It is one of these:".to_owned(),
                n => format!("There are {n}, and each is one of these:"),
            },
        ),
        Outcome::Unexplained => (
            "No, and it is not known why.",
            format!(
                "Something is wrong that no candidate explains: {}.",
                unexplained(causes).map_or("", |c| c.reason.trim_end_matches('.'))
            ),
        ),
        Outcome::Null => (
            "Yes, as far as this ride can show.",
            "Nothing is wrong that this ride could show.".to_owned(),
        ),
        Outcome::Refused => (
            "This ride leaves it open.",
            "Something stands out as a cause does, but is not confirmed.".to_owned(),
        ),
        Outcome::Blind => {
            ("This ride cannot show it.", "It would show none of the candidates.".to_owned())
        }
        Outcome::Unjudged => (
            "There is no verdict.",
            "The table causes has no row of this ride; the residuals of the model are below."
                .to_owned(),
        ),
    }
}

/// How much of what is beyond noise the causes explain, and where the simulation stays wrong.
fn explained(errors: &[SimulationError]) -> Option<String> {
    let share = SimulationError::explained(errors)?;
    let left: Vec<String> = SimulationError::stays_wrong(errors)
        .into_iter()
        .take(LEFT)
        .map(|r| {
            let channel = cause_labels::channel(&r.channel, &r.unit);
            let kind = kinds::label(&r.kind);
            format!("{channel} while {kind}, {} times the noise", fixed(r.in_floors(), 1))
        })
        .collect();
    let left = match left.is_empty() {
        true => "nothing beyond twice the noise".to_owned(),
        false => left.join("; "),
    };
    let share = if share > 0.0 {
        format!("explains {} % of", fixed(100.0 * share, 0))
    } else {
        "explains nothing of".to_owned()
    };
    Some(format!(
        "In the simulation of manoeuvres left out it {share} what is beyond noise; left: {left}."
    ))
}

pub(super) fn remarks(
    outcome: Outcome,
    causes: &[CauseRow],
    errors: &[SimulationError],
) -> Vec<String> {
    let mut out = Vec::new();
    if let Outcome::Named | Outcome::Ambiguous = outcome {
        out.extend(explained(errors));
    }
    if let (Outcome::Named | Outcome::Ambiguous, Some(c)) = (outcome, unexplained(causes)) {
        out.push(format!(
            "Something more is wrong that no candidate explains: {}.",
            c.reason.trim_end_matches('.')
        ));
    }
    if let Outcome::Refused | Outcome::Unexplained = outcome {
        let listed = out.len();
        out.extend(refused(causes).map(|text| format!("{}.", typeset_sentence(&text))));
        if out.len() > listed {
            return out;
        }
    }
    let scored = causes.iter().filter(|c| c.score.is_finite() && is_candidate(c));
    let top = scored.max_by(|a, b| a.score.total_cmp(&b.score));
    if let (Outcome::Null | Outcome::Unexplained, Some(top)) = (outcome, top) {
        let score = fixed(top.score, 1);
        out.push(if top.score > 1.0 {
            format!(
                "The largest score is {score}, of “{}”: {}.",
                cause_labels::effect(&top.effect, top.value),
                top.reason.trim_end_matches('.')
            )
        } else {
            format!(
                "The largest score of any candidate is {score}; 19 of 20 simulated rides with nothing \
                 wrong stay below 1."
            )
        });
    }
    out
}
