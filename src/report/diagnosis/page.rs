//! The content of a diagnosed session's page: the rows of `causes` and `discrepancies`, in the order
//! of the questions that they answer.

use serde::Serialize;

use crate::contract::verdict::Verdict;
use crate::report::diagnosis::bars::{self, Axis, Levels};
use crate::report::diagnosis::cause_labels::{self, sentence};
use crate::report::diagnosis::misfits::{Change, Misfit, change, levels, misfit, worst_first};
use crate::report::diagnosis::outcome::{
    Finding, Outcome, equivalents, findings, is_candidate, is_found, outcome, remarks, verdict,
};
use crate::report::diagnosis::overlays::pooled;
use crate::report::diagnosis::simulation::{Simulation, simulation};
use crate::statistics::number_format::{self, fixed, typeset};
use crate::store::tables::rows::{CauseRow, DiscrepancyRow, Ident, SimulationError};

/// Candidates that are shown before the reader asks for the rest.
const SHOWN: usize = 8;

/// One diagnosed session's page, as its template reads it.
#[derive(Debug, Serialize)]
pub struct Page {
    /// Id of the session, as in the tables.
    pub session_id: String,
    /// Id of the bike, as in the tables.
    pub bike_id: String,
    /// Start of the session.
    pub start: String,
    /// Result of the ride.
    pub outcome: Outcome,
    /// Whether the model reproduces the ride, in one sentence.
    pub answer: &'static str,
    /// Identified and possible causes.
    pub verdict: String,
    /// Further sentences.
    pub remarks: Vec<String>,
    /// Identified causes in the order of their identification.
    pub findings: Vec<Finding>,
    /// Misfits that are structured, the worst first.
    pub misfits: Vec<Misfit>,
    /// Misfits within what fault-free simulations show.
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
    /// Gain of the identified causes in simulation.
    pub gain: Option<Gain>,
    /// The simulation before and after, on manoeuvres left out of the fit.
    pub simulation: Simulation,
    /// Residuals over the whole ride before and after, where nothing was simulated.
    pub channels: Vec<Change>,
    /// Effects that the ride cannot show, by the riding that would.
    pub unseen: Vec<(String, Vec<(String, String)>)>,
}

/// One line of the list of candidates.
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
    /// Sentence of each, and its name.
    pub members: Vec<(String, String)>,
    /// Riding or channel that would separate them.
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

/// The content of one page.
pub fn build(
    ident: &Ident,
    causes: &[CauseRow],
    discrepancies: &[DiscrepancyRow],
    errors: &[SimulationError],
) -> Page {
    let outcome = outcome(causes);
    let findings = findings(causes);
    let (answer, verdict) = verdict(outcome, &findings, causes);
    let sorted = worst_first(discrepancies);
    let levels: Vec<Levels> = sorted.iter().filter_map(|r| levels(r)).collect();
    let axis = Axis::of(&levels);
    let (misfits, others) = sorted.iter().partition::<Vec<&DiscrepancyRow>, _>(|r| r.structured);
    let lines = |rows: Vec<&DiscrepancyRow>| rows.into_iter().map(|r| misfit(r, axis)).collect();
    let mut candidates: Vec<Candidate> = causes
        .iter()
        .filter(|c| is_candidate(c) && c.verdict != Verdict::NotIdentifiable.name())
        .map(candidate)
        .collect();
    // every candidate over the threshold is shown, however many they are
    let over = candidates.iter().filter(|c| c.class != "rest").count();
    let more = candidates.split_off(SHOWN.max(over).min(candidates.len()));
    Page {
        session_id: ident.session_id.clone(),
        bike_id: ident.bike_id.clone(),
        start: ident.start_time.as_deref().map(number_format::timestamp).unwrap_or_default(),
        outcome,
        answer,
        verdict,
        remarks: remarks(outcome, causes, errors),
        findings,
        misfits: lines(misfits),
        others: lines(others),
        ticks: axis.ticks(),
        extended: discrepancies.iter().any(|r| r.rmse_extended.is_some()),
        candidates,
        more,
        rivals: rivals(causes),
        gain: gain(causes),
        simulation: simulation(errors),
        channels: match errors {
            [] => pooled(discrepancies).iter().map(change).collect(),
            _ => Vec::new(),
        },
        unseen: unseen(causes),
    }
}

fn candidate(row: &CauseRow) -> Candidate {
    let (size, interval) = cause_labels::size(row);
    // the sign of a size within its noise says nothing
    let is_open = row.verdict == Verdict::Alternative.name();
    let told = row.value.filter(|_| is_found(row) || is_open || row.score > 1.0);
    Candidate {
        name: row.effect.clone(),
        sentence: cause_labels::effect(&row.effect, told),
        verdict: cause_labels::verdict(&row.verdict),
        class: match Verdict::from_name(&row.verdict) {
            Some(Verdict::Named) => "named",
            Some(Verdict::Ambiguous | Verdict::Alternative) => "ambiguous",
            _ if row.score > 1.0 => "beyond",
            _ => "rest",
        },
        score: fixed(row.score, if row.score.abs() < 10.0 { 1 } else { 0 }),
        bar: bars::score(row.score),
        size,
        interval,
        alarms: percent(row.false_alarm_rate),
        level: cause_labels::level(&row.level),
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
                members: names
                    .map(|n| (sentence(&cause_labels::effect_in(causes, n)), n.to_owned()))
                    .collect(),
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

fn unseen(causes: &[CauseRow]) -> Vec<(String, Vec<(String, String)>)> {
    let mut out: Vec<(String, Vec<(String, String)>)> = Vec::new();
    for c in causes.iter().filter(|c| c.verdict == Verdict::NotIdentifiable.name()) {
        let ride =
            c.separate_by.clone().filter(|s| !s.is_empty()).unwrap_or_else(|| c.reason.clone());
        let item = (cause_labels::effect(&c.effect, None), c.effect.clone());
        match out.iter_mut().find(|(r, _)| *r == ride) {
            Some((_, items)) => items.push(item),
            None => out.push((ride, vec![item])),
        }
    }
    out
}
