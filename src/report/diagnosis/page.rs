//! What the page of a diagnosed session says: the rows of `causes` and `discrepancies` in words, in
//! the order of the questions they answer.

use serde::Serialize;

use crate::contract::verdict::Verdict;
use crate::report::diagnosis::bars::{self, Axis, Levels};
use crate::report::diagnosis::labels::{self, sentence};
use crate::report::diagnosis::overlays::Reproduced;
use crate::report::number_format::{self, fixed, typeset};
use crate::report::session::page::when;
use crate::report::{kinds, words};
use crate::tables::rows::{CauseRow, DiscrepancyRow, Ident};

/// Candidates that are shown before the reader asks for the rest.
const SHOWN: usize = 8;

/// What a ride says, in the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The cause is known.
    Named,
    /// It is one of several.
    Ambiguous,
    /// Nothing is wrong that the ride could show.
    Null,
    /// Something is wrong and nothing explains it.
    Unexplained,
    /// The ride can show none of the candidates.
    Blind,
    /// The table `causes` does not know the ride.
    Unjudged,
}

/// One diagnosed session's page, as its template reads it.
#[derive(Debug, Serialize)]
pub struct Page {
    /// The session.
    pub session_id: String,
    /// The bike.
    pub bike_id: String,
    /// Start of the session.
    pub start: String,
    /// What the ride says.
    pub outcome: Outcome,
    /// Yes or no.
    pub answer: &'static str,
    /// The verdict.
    pub verdict: String,
    /// Further sentences.
    pub remarks: Vec<String>,
    /// What was named, the first first.
    pub findings: Vec<Finding>,
    /// Misfits that are structured, the worst first.
    pub misfits: Vec<Misfit>,
    /// The others.
    pub others: Vec<Misfit>,
    /// Ticks of the misfits' axis.
    pub ticks: String,
    /// Whether any misfit has an extended value.
    pub extended: bool,
    /// Candidates, the best first.
    pub candidates: Vec<Candidate>,
    /// The rest of them.
    pub more: Vec<Candidate>,
    /// Classes that the ride cannot tell apart.
    pub rivals: Vec<Rivals>,
    /// What the named causes gain.
    pub gain: Option<Gain>,
    /// Each channel before and after.
    pub channels: Vec<Change>,
    /// What the ride cannot show, by the riding that would.
    pub unseen: Vec<(String, Vec<(String, String)>)>,
}

/// Something that was named.
#[derive(Debug, Clone, Serialize)]
pub struct Finding {
    /// Name in the table.
    pub name: String,
    /// What happens.
    pub sentence: String,
    /// Its size with unit.
    pub size: String,
    /// 95 % interval.
    pub interval: String,
    /// What it could be instead.
    pub or: Vec<String>,
    /// Where it was found, if not in this ride alone.
    pub level: String,
}

/// One channel while one kind of manoeuvre.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub struct Misfit {
    pub channel: String,
    pub name: String,
    pub kind: String,
    pub unit: String,
    pub base: String,
    pub extended: String,
    pub floor: String,
    pub bar: String,
    pub with: String,
    pub blocks: i64,
}

/// One candidate.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub struct Candidate {
    pub name: String,
    pub sentence: String,
    pub verdict: String,
    pub class: &'static str,
    pub score: String,
    pub bar: String,
    pub size: String,
    pub interval: String,
    pub alarms: String,
    pub level: String,
    pub reason: String,
}

/// Candidates that the ride cannot tell apart.
#[derive(Debug, Serialize)]
pub struct Rivals {
    /// What each says happens, and its name.
    pub members: Vec<(String, String)>,
    /// What would tell them apart.
    pub separate_by: String,
}

/// The gain on manoeuvres left out of the fit.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // the sentence in the template
pub struct Gain {
    pub heldout: String,
    pub heldout_bar: String,
    pub bound: String,
    pub bound_bar: String,
    pub share: String,
}

/// A channel before and after.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub struct Change {
    pub channel: String,
    pub name: String,
    pub unit: String,
    pub base: String,
    pub extended: String,
    pub change: String,
    pub base_bar: String,
    pub extended_bar: String,
}

/// One line of the run's page.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub struct Entry {
    pub href: String,
    pub session_id: String,
    pub bike_id: String,
    pub start: String,
    pub outcome: Outcome,
    pub verdict: &'static str,
    pub findings: Vec<Finding>,
    pub reason: String,
    pub structured: usize,
}

/// What the rows of a ride say in the end.
pub fn outcome(causes: &[CauseRow]) -> Outcome {
    let is = |verdict: Verdict| causes.iter().any(|c| c.verdict == verdict.name());
    let blind = |c: &CauseRow| c.verdict == Verdict::NotIdentifiable.name();
    match causes {
        [] => Outcome::Unjudged,
        _ if is(Verdict::Named) => Outcome::Named,
        _ if is(Verdict::Ambiguous) => Outcome::Ambiguous,
        _ if is(Verdict::Unexplained) => Outcome::Unexplained,
        _ if causes.iter().all(blind) => Outcome::Blind,
        _ => Outcome::Null,
    }
}

/// One line of the run's page.
pub fn entry(ident: &Ident, href: &str, causes: &[CauseRow], rows: &[DiscrepancyRow]) -> Entry {
    let outcome = outcome(causes);
    Entry {
        href: href.to_owned(),
        session_id: ident.session_id.clone(),
        bike_id: ident.bike_id.clone(),
        start: ident.start_time.as_deref().map(when).unwrap_or_default(),
        outcome,
        verdict: match outcome {
            Outcome::Named => "named",
            Outcome::Ambiguous => "one of several",
            Outcome::Null => "nothing that this ride could show",
            Outcome::Unexplained => "unexplained",
            Outcome::Blind => "the ride can show nothing",
            Outcome::Unjudged => "no verdict in the tables",
        },
        findings: findings(causes),
        reason: unexplained(causes).map(|c| c.reason.clone()).unwrap_or_default(),
        structured: rows.iter().filter(|r| r.structured).count(),
    }
}

/// Discrepancies, the structured ones first, then by how far they are beyond every null.
pub fn worst_first(rows: &[DiscrepancyRow]) -> Vec<&DiscrepancyRow> {
    let ratio = |r: &DiscrepancyRow| r.rmse_base / r.null_largest.max(f64::MIN_POSITIVE);
    let mut out: Vec<&DiscrepancyRow> = rows.iter().filter(|r| r.rmse_base.is_finite()).collect();
    out.sort_by(|a, b| b.structured.cmp(&a.structured).then(ratio(b).total_cmp(&ratio(a))));
    out
}

/// Puts a diagnosis in words. `reproduced` are the channels before and after.
pub fn build(
    ident: &Ident,
    causes: &[CauseRow],
    discrepancies: &[DiscrepancyRow],
    reproduced: &[Reproduced],
) -> Page {
    let outcome = outcome(causes);
    let findings = findings(causes);
    let (answer, verdict) = verdict(outcome, &findings, causes);
    let sorted = worst_first(discrepancies);
    let levels: Vec<Levels> = sorted.iter().filter_map(|r| levels(r)).collect();
    let axis = Axis::of(&levels);
    let (misfits, others) = sorted.iter().partition::<Vec<&DiscrepancyRow>, _>(|r| r.structured);
    let tell = |rows: Vec<&DiscrepancyRow>| rows.into_iter().map(|r| misfit(r, axis)).collect();
    let mut candidates: Vec<Candidate> = causes
        .iter()
        .filter(|c| is_candidate(c) && c.verdict != Verdict::NotIdentifiable.name())
        .map(candidate)
        .collect();
    // whoever is over the threshold is shown, however many
    let over = candidates.iter().filter(|c| c.class != "rest").count();
    let more = candidates.split_off(SHOWN.max(over).min(candidates.len()));
    Page {
        session_id: ident.session_id.clone(),
        bike_id: ident.bike_id.clone(),
        start: ident.start_time.as_deref().map(when).unwrap_or_default(),
        outcome,
        answer,
        verdict,
        remarks: remarks(outcome, causes),
        findings,
        misfits: tell(misfits),
        others: tell(others),
        ticks: axis.ticks(),
        extended: discrepancies.iter().any(|r| r.rmse_extended.is_some()),
        candidates,
        more,
        rivals: rivals(causes),
        gain: gain(causes),
        channels: reproduced.iter().map(change).collect(),
        unseen: unseen(causes),
    }
}

fn is_found(row: &CauseRow) -> bool {
    Verdict::from_name(&row.verdict).is_some_and(Verdict::is_cause)
}

/// Whether a row is of a candidate, and not of what none of them explains.
fn is_candidate(row: &CauseRow) -> bool {
    row.verdict != Verdict::Unexplained.name()
}

fn unexplained(causes: &[CauseRow]) -> Option<&CauseRow> {
    causes.iter().find(|c| !is_candidate(c))
}

fn equivalents(row: &CauseRow) -> Vec<&str> {
    let names = row.equivalent_to.as_deref().unwrap_or_default().split(',').map(str::trim);
    names.filter(|n| !n.is_empty()).collect()
}

fn findings(causes: &[CauseRow]) -> Vec<Finding> {
    causes
        .iter()
        .filter(|c| is_found(c))
        .map(|c| {
            let (size, interval) = labels::size(c);
            Finding {
                name: c.effect.clone(),
                sentence: labels::effect(&c.effect),
                size,
                interval,
                or: equivalents(c).into_iter().map(labels::effect).collect(),
                level: labels::level(&c.level),
            }
        })
        .collect()
}

fn verdict(outcome: Outcome, findings: &[Finding], causes: &[CauseRow]) -> (&'static str, String) {
    match outcome {
        Outcome::Named => (
            match unexplained(causes) {
                None => "No, and it is known why.",
                Some(_) => "No, and only part of it is known.",
            },
            match findings.len() {
                1 => "One cause is named:".to_owned(),
                n => format!("{n} causes are named:"),
            },
        ),
        Outcome::Ambiguous => (
            "No, and this ride cannot tell which of several causes it is.",
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
            "Yes, as far as this ride can tell.",
            "Nothing is wrong that this ride could show.".to_owned(),
        ),
        Outcome::Blind => {
            ("That cannot be said.", "This ride can show none of the candidates.".to_owned())
        }
        Outcome::Unjudged => (
            "There is no verdict.",
            "The table causes has no row of this ride; what the model leaves is below.".to_owned(),
        ),
    }
}

fn remarks(outcome: Outcome, causes: &[CauseRow]) -> Vec<String> {
    let mut out = Vec::new();
    if let (Outcome::Named | Outcome::Ambiguous, Some(c)) = (outcome, unexplained(causes)) {
        out.push(format!(
            "Something more is wrong that no candidate explains: {}.",
            c.reason.trim_end_matches('.')
        ));
    }
    let scored = causes.iter().filter(|c| c.score.is_finite() && is_candidate(c));
    let top = scored.max_by(|a, b| a.score.total_cmp(&b.score));
    if let (Outcome::Null | Outcome::Unexplained, Some(top)) = (outcome, top) {
        let score = fixed(top.score, 1);
        out.push(if top.score > 1.0 {
            format!(
                "The largest score is {score}, of “{}”: beyond 1, but it did not stand up: {}.",
                labels::effect(&top.effect),
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

fn levels(row: &DiscrepancyRow) -> Option<Levels> {
    let floor = row.noise_floor;
    (floor > 0.0).then(|| Levels {
        base: row.rmse_base / floor,
        extended: row.rmse_extended.map(|e| e / floor),
        largest: row.null_largest / floor,
    })
}

fn misfit(row: &DiscrepancyRow, axis: Axis) -> Misfit {
    let (unit, scale) = labels::readable(&row.unit);
    let digits = three(row.noise_floor.min(row.rmse_base) * scale);
    let show = |v: f64| typeset(&fixed(v * scale, digits));
    let with = row.covariate.as_deref().map_or(String::new(), |c| {
        let r = row.correlation.map(|r| format!(" ({})", typeset(&format!("{r:+.2}"))));
        format!("{}{}", words::spaced(c), r.unwrap_or_default())
    });
    Misfit {
        channel: labels::channel(&row.channel, &row.unit),
        name: row.channel.clone(),
        kind: kinds::label(&row.kind),
        unit,
        base: show(row.rmse_base),
        extended: row.rmse_extended.map(show).unwrap_or_default(),
        floor: show(row.noise_floor),
        bar: levels(row).map(|l| axis.draw(l)).unwrap_or_default(),
        with,
        blocks: row.n,
    }
}

/// Decimals that give a misfit at least two digits, three at most.
fn three(value: f64) -> usize {
    number_format::decimals_of(value, None).saturating_sub(1).min(6)
}

fn candidate(row: &CauseRow) -> Candidate {
    let (size, interval) = labels::size(row);
    Candidate {
        name: row.effect.clone(),
        sentence: labels::effect(&row.effect),
        verdict: labels::verdict(&row.verdict),
        class: match Verdict::from_name(&row.verdict) {
            Some(Verdict::Named) => "named",
            Some(Verdict::Ambiguous) => "ambiguous",
            _ if row.score > 1.0 => "beyond",
            _ => "rest",
        },
        score: fixed(row.score, if row.score.abs() < 10.0 { 1 } else { 0 }),
        bar: bars::score(row.score),
        size,
        interval,
        alarms: percent(row.false_alarm_rate),
        level: labels::level(&row.level),
        reason: row.reason.clone(),
    }
}

fn percent(share: f64) -> String {
    if share.is_finite() { format!("{} %", fixed(100.0 * share, 0)) } else { String::new() }
}

fn rivals(causes: &[CauseRow]) -> Vec<Rivals> {
    let found = causes.iter().filter(|c| is_found(c) && !equivalents(c).is_empty());
    found
        .map(|c| {
            let names = std::iter::once(c.effect.as_str()).chain(equivalents(c));
            Rivals {
                members: names.map(|n| (sentence(&labels::effect(n)), n.to_owned())).collect(),
                separate_by: c.separate_by.clone().unwrap_or_default(),
            }
        })
        .collect()
}

fn gain(causes: &[CauseRow]) -> Option<Gain> {
    let row = causes.iter().find(|c| c.gain_heldout.is_some())?;
    let (heldout, bound) = (row.gain_heldout?, row.gain_upper_bound);
    let longest = heldout.max(bound.unwrap_or(0.0));
    let share = bound.filter(|b| *b > 0.0 && heldout > 0.0).map(|b| 100.0 * heldout / b);
    Some(Gain {
        heldout: typeset(&fixed(heldout, 0)),
        heldout_bar: bars::share(heldout, longest, "extended"),
        bound: bound.map(|b| typeset(&fixed(b, 0))).unwrap_or_default(),
        bound_bar: bound.map(|b| bars::share(b, longest, "bound")).unwrap_or_default(),
        share: match share {
            Some(s) if s >= 100.0 => "as much as every candidate together".to_owned(),
            Some(s) => format!("{s:.0} % of that"),
            None => String::new(),
        },
    })
}

fn change(row: &Reproduced) -> Change {
    let (unit, scale) = labels::readable(&row.unit);
    let digits = three(row.extended.map_or(row.base, |e| e.min(row.base)) * scale);
    let show = |v: f64| typeset(&fixed(v * scale, digits));
    let longest = row.extended.map_or(row.base, |e| e.max(row.base));
    let change = row.extended.filter(|_| row.base > 0.0).map(|e| 100.0 * (e / row.base - 1.0));
    Change {
        channel: labels::channel(&row.channel, &row.unit),
        name: row.channel.clone(),
        unit,
        base: show(row.base),
        extended: row.extended.map(show).unwrap_or_default(),
        change: change
            .map(|c| typeset(&format!("{}{} %", if c > 0.5 { "+" } else { "" }, fixed(c, 0))))
            .unwrap_or_default(),
        base_bar: bars::share(row.base, longest, "base"),
        extended_bar: row.extended.map(|e| bars::share(e, longest, "extended")).unwrap_or_default(),
    }
}

fn unseen(causes: &[CauseRow]) -> Vec<(String, Vec<(String, String)>)> {
    let mut out: Vec<(String, Vec<(String, String)>)> = Vec::new();
    for c in causes.iter().filter(|c| c.verdict == Verdict::NotIdentifiable.name()) {
        let ride =
            c.separate_by.clone().filter(|s| !s.is_empty()).unwrap_or_else(|| c.reason.clone());
        let item = (labels::effect(&c.effect), c.effect.clone());
        match out.iter_mut().find(|(r, _)| *r == ride) {
            Some((_, items)) => items.push(item),
            None => out.push((ride, vec![item])),
        }
    }
    out
}
