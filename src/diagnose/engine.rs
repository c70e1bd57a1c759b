//! The diagnosis engine: what road and off-road implement, and the naming of causes that both share
//! (`book/src/diagnosis.md`, section 2.5).
//!
//! An alarm is a score beyond what fault-free simulations show. Of the candidates that share in it and whose
//! size is within its bounds the one whose joint fit with the model gains most is named; those that gain
//! nearly as much are its equivalents. The named one joins the model, and every other candidate is judged
//! anew on that.

use std::collections::BTreeMap;

use super::calibration::{Calibration, Cell, Rms};
use super::cause::{Cause, Estimate, Judged, Naming, Refusal, Refusals, Structure};
use crate::contract::verdict::Verdict;
use crate::store::tables::rows::DiscrepancyRow;

/// What decides whether a candidate is named, where the kinds of riding differ. Scores are in units of
/// what 19 of 20 fault-free simulations stay below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NamingRules {
    /// Score from which there is an alarm, and that a named candidate and its equivalents must have.
    pub alarm: f64,
    /// Share of the best gain from which a candidate is an equivalent.
    pub equivalent: f64,
    /// Share of its gain that a rival keeps beside the named one if it is a cause of its own; `None` leaves
    /// every rival an equivalent.
    pub independent: Option<f64>,
}

/// A candidate in a joint fit with the model.
#[derive(Debug, Clone)]
pub(crate) struct Refit<M> {
    /// As it was judged before.
    pub judged: Judged,
    /// Its size in the joint fit.
    pub estimate: Option<Estimate>,
    /// Fall of twice the loss.
    pub gain: f64,
    /// The joint fit.
    pub model: M,
}

/// What joint fits make of the candidates that share in an alarm.
#[derive(Debug, Clone)]
pub(crate) struct Joint<M> {
    /// Those that may be causes, the largest gain first.
    pub refits: Vec<Refit<M>>,
    /// Those that are refused by their fits, or were not fitted.
    pub refused: Refusals,
}

/// What is left of the named causes once each was put to the test, and all other candidates.
#[derive(Debug, Clone)]
pub(crate) struct Confirmed<M> {
    /// In the order of their naming, with their final sizes.
    pub named: Vec<Cause>,
    /// Those with an objection.
    pub rejected: Vec<Cause>,
    /// All others, in any order.
    pub rest: Vec<Cause>,
    /// The model with what is named.
    pub extended: M,
    /// The largest residual structure, where it is looked for.
    pub structure: Option<Structure>,
    /// Whether something is wrong that no candidate explains.
    pub unexplained: bool,
}

/// The row of `causes` of what no candidate explains.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unexplained {
    /// How many times what null simulations show.
    pub score: f64,
    /// What the score is of.
    pub parameter: &'static str,
    /// Why it is said.
    pub reason: String,
    /// Whether the row stands before those of the named causes.
    pub first: bool,
}

/// Block residuals of one channel in one kind of manoeuvre: block and residual, in time order.
pub(crate) type CellResiduals = BTreeMap<Cell, Vec<(usize, f64)>>;

/// Residuals put into their cells, in the order in which they come.
pub(crate) fn in_cells(residuals: impl Iterator<Item = (Cell, usize, f64)>) -> CellResiduals {
    let mut out = CellResiduals::new();
    for (cell, block, r) in residuals {
        out.entry(cell).or_default().push((block, r));
    }
    out
}

/// A kind of riding that can be diagnosed, for one ride: its residuals, its candidates, its null
/// simulations and what is particular about judging them.
pub(crate) trait Engine {
    /// A fitted model, the base or one with causes.
    type Model;
    /// A model with what every open candidate shows on it.
    type Stage;
    /// What scores are measured by.
    type Scale;

    /// What decides whether a candidate is named.
    fn rules(&self) -> NamingRules;

    /// The base model and what candidates show on it.
    fn first(&self) -> Self::Stage;

    /// Every open candidate at a stage.
    fn judge(&self, stage: &Self::Stage) -> Vec<Judged>;

    /// Joint fits with the candidates that alarm: those that have a size within their bounds, and what refuses the
    /// others. `named` are in the stage's model.
    fn refits(&self, stage: &Self::Stage, judged: &[Judged], named: &[Cause])
    -> Joint<Self::Model>;

    /// Why a refitted candidate is not named: too little gain, or what else is asked of a cause; `None` of one that may be.
    fn refuses(
        &self,
        stage: &Self::Stage,
        refit: &Refit<Self::Model>,
        named: &[Cause],
    ) -> Option<Refusal>;

    /// The next stage: the last of `named` is in its model.
    fn join(&self, stage: Self::Stage, refit: Refit<Self::Model>, named: &[Cause]) -> Self::Stage;

    /// Puts the named causes to the test. `judged` are the open candidates of the last stage.
    fn confirm(
        &self,
        stage: Self::Stage,
        judged: Vec<Judged>,
        named: Vec<Cause>,
    ) -> Confirmed<Self::Model>;

    /// Name and unit of every channel of residuals.
    fn channels(&self) -> Vec<(&'static str, &'static str)>;

    /// Residuals under the base model.
    fn base_residuals(&self) -> CellResiduals;

    /// Residuals under the model with what is named.
    fn extended_residuals(&self, naming: &Naming<Self::Model>) -> CellResiduals;

    /// Share of a channel's noise on its null simulations that it shows in every kind of manoeuvre, at
    /// least one: a channel that is noisier than that everywhere is noisy, not wrong.
    fn noisier(&self, before: &Rms) -> Vec<f64>;

    /// Fewest blocks of a channel and kind in which structure is looked for.
    fn fewest_blocks(&self) -> usize;

    /// Variables of the ride that a misfit may follow, block by block; and whether they are held against
    /// what the named causes leave, not against the whole misfit.
    fn covariates(&self) -> (Vec<(&'static str, Vec<f64>)>, bool);

    /// What null simulations show.
    fn calibration(&self) -> &Calibration<Self::Scale>;

    /// Fall of twice the loss on manoeuvres left out: of the named causes, and of every candidate together.
    fn held_out_gains(&self, naming: &Naming<Self::Model>) -> [f64; 2];

    /// What no candidate explains.
    fn unexplained(
        &self,
        naming: &Naming<Self::Model>,
        discrepancies: &[DiscrepancyRow],
    ) -> Option<Unexplained>;

    /// What is added to the sentence of a named cause, or of one that is not identifiable.
    fn remark(&self, cause: &Cause) -> String {
        let _ = cause;
        String::new()
    }
}

/// Names the causes of a ride.
pub(crate) fn name<E: Engine>(engine: &E) -> Naming<E::Model> {
    let rules = engine.rules();
    let mut stage = engine.first();
    let mut judged = engine.judge(&stage);
    let alarm = largest(judged.iter());
    let mut named: Vec<Cause> = Vec::new();
    let mut instead: Vec<Cause> = Vec::new();
    let (mut refused_at_first, mut refused) = (None, Refusals::new());
    while largest(judged.iter()) > rules.alarm || judged.iter().any(|j| j.relieves) {
        let found;
        (found, refused) = best(engine, &stage, &judged, &named);
        refused_at_first.get_or_insert_with(|| refused.clone());
        let Some((cause, rivals, refit)) = found else { break };
        instead.extend(rivals.iter().map(|rival| rival.2.clone()));
        named.push(cause);
        stage = engine.join(stage, refit, &named);
        judged = engine.judge(&stage);
        refused.clear();
        if let (Some(share), Some(last)) = (rules.independent, named.last_mut()) {
            // a rival that still gains much beside the named one is a cause of its own
            let gain_of = |name: &str| judged.iter().find(|j| j.candidate.name == name);
            last.retain_equivalents(|name| {
                let before = rivals.iter().find(|r| r.0 == name).map_or(0.0, |r| r.1);
                gain_of(name).map_or(0.0, |j| j.gain) <= share * before
            });
        }
    }
    let confirmed = engine.confirm(stage, judged, named);
    let Confirmed { mut named, rejected, rest, extended, structure, unexplained } = confirmed;
    let refused_at_first = refused_at_first.unwrap_or_default();
    // where nothing that was named is left, the others are judged on the base again
    let at_stage = match named.is_empty() && !rejected.is_empty() {
        true => &refused_at_first,
        false => &refused,
    };
    let mut rest: Vec<Cause> =
        rest.into_iter().map(|cause| cause.refused(at_stage, rules.alarm)).collect();
    let alternatives = alternatives(&named, &mut rest, instead);
    rest.sort_by(|a, b| b.score.total_cmp(&a.score));
    named.extend(alternatives);
    named.extend(rejected.into_iter().chain(rest));
    Naming { causes: named, extended, alarm, structure, unexplained, refused_at_first }
}

/// The equivalents of what is named, with the size that each would have in its place; they are taken out of `rest`, where
/// they are judged beside it and seem not to be needed.
fn alternatives(named: &[Cause], rest: &mut Vec<Cause>, instead: Vec<Cause>) -> Vec<Cause> {
    let is_open = |cause: &Cause| {
        let name = cause.candidate.name;
        named.iter().any(|c| c.verdict.is_cause() && c.equivalent.contains(&name))
    };
    let open: Vec<Cause> = rest.extract_if(.., |cause| is_open(cause)).collect();
    let of = |cause: Cause| {
        let same = |c: &&Cause| c.candidate.name == cause.candidate.name;
        // the last one: what was named before is in the model with both
        let found = instead.iter().rfind(same).cloned();
        found.unwrap_or(Cause { verdict: Verdict::Alternative, ..cause })
    };
    open.into_iter().map(of).collect()
}

/// Candidates that gain nearly as much as the named one, with their gains, and as what they would be in its place.
type Rivals = Vec<(&'static str, f64, Cause)>;

/// A cause, its rivals and the model with it.
type Found<M> = (Cause, Rivals, Refit<M>);

/// The candidate that the model gains most by, as a cause, and the model with it; and what refuses the others.
fn best<E: Engine>(
    engine: &E,
    stage: &E::Stage,
    judged: &[Judged],
    named: &[Cause],
) -> (Option<Found<E::Model>>, Refusals) {
    let Joint { mut refits, mut refused } = engine.refits(stage, judged, named);
    let at = refits.iter().position(|r| match engine.refuses(stage, r, named) {
        Some(why) => {
            refused.insert(r.judged.candidate.name, why);
            false
        }
        None => true,
    });
    let Some(at) = at else { return (None, refused) };
    let best = refits.remove(at);
    let behind = Refusal::Behind(best.judged.candidate.name);
    refused.extend(refits[at..].iter().map(|r| (r.judged.candidate.name, behind)));
    let least = engine.rules().equivalent * best.gain;
    let near = |r: &&Refit<E::Model>| r.gain > least;
    let instead = |r: &Refit<E::Model>| Cause {
        estimate: r.estimate,
        gain: r.gain,
        ..r.judged.cause(Verdict::Alternative)
    };
    let rivals: Rivals =
        refits.iter().filter(near).map(|r| (r.judged.candidate.name, r.gain, instead(r))).collect();
    let cause = Cause {
        estimate: best.estimate,
        gain: best.gain,
        equivalent: rivals.iter().map(|r| r.0).collect(),
        ..best.judged.cause(if rivals.is_empty() { Verdict::Named } else { Verdict::Ambiguous })
    };
    (Some((cause, rivals, best)), refused)
}

/// The largest score; zero of none.
fn largest<'a>(judged: impl Iterator<Item = &'a Judged>) -> f64 {
    judged.map(|j| j.score).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::cause::Candidate;

    fn cause(
        name: &'static str,
        verdict: Verdict,
        size: f64,
        equivalent: &[&'static str],
    ) -> Cause {
        let candidate = Candidate {
            place: 0,
            name,
            parameter: "size",
            sentence: "it does",
            opposite: "it does not",
            unit: "1",
            separate_by: "riding",
            typical: 1.0,
            bounds: [-9.0, 9.0],
        };
        Cause {
            candidate,
            verdict,
            objection: None,
            refusal: None,
            estimate: Some(Estimate::linear(size, 0.1)),
            bias: 0.0,
            score: size,
            gain: 0.0,
            equivalent: equivalent.to_vec(),
        }
    }

    /// Beside the wind that was named the grade seems not to be needed; it is the other of the two.
    #[test]
    fn an_equivalent_has_the_size_that_it_would_have_alone() {
        let named = [cause("wind", Verdict::Ambiguous, 3.0, &["road_grade"])];
        let mut rest = vec![
            cause("road_grade", Verdict::NotNeeded, 0.3, &[]),
            cause("lift", Verdict::NotNeeded, 0.1, &[]),
        ];
        let alone = vec![cause("road_grade", Verdict::Alternative, 2.5, &[])];
        let open = alternatives(&named, &mut rest, alone);
        assert_eq!((open.len(), rest.len()), (1, 1));
        assert_eq!((open[0].verdict, open[0].value()), (Verdict::Alternative, 2.5));
        assert!(!Verdict::Alternative.is_cause(), "it is not in the model beside the wind");
    }
}
