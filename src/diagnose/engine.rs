//! The diagnosis engine: the trait that road and off-road implement, and the identification of causes that both share
//! (`book/src/diagnosis.md`, section 2.5).
//!
//! An alarm is a score beyond those of fault-free simulations. The candidates that alarm are fitted jointly with the
//! model. Of those with a size within bounds the one that gains most is identified as the cause; those that gain nearly
//! as much are its equivalents. The cause joins the model, and every other candidate is scored again on that model.

use std::collections::BTreeMap;

use super::calibration::{Calibration, Cell, Rms};
use super::cause::{Cause, Estimate, Identification, Judged, Refusal, Refusals, Structure};
use crate::contract::verdict::Verdict;
use crate::store::tables::rows::DiscrepancyRow;

/// Thresholds of identification that differ between road and off-road. Scores are in units of the value that 19 of 20
/// fault-free simulations stay below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct IdentificationRules {
    /// Smallest score of an alarm, and of a cause and its equivalents.
    pub alarm: f64,
    /// Share of the best gain from which a candidate is an equivalent.
    pub equivalent: f64,
    /// Share of its gain that a rival keeps beside the identified cause if it is a cause of its own; `None` leaves every
    /// rival an equivalent.
    pub independent: Option<f64>,
}

/// A candidate in a joint fit with the model.
#[derive(Debug, Clone)]
pub(crate) struct Refit<M> {
    /// Its score and gain before the joint fit.
    pub judged: Judged,
    /// Its size in the joint fit.
    pub estimate: Option<Estimate>,
    /// Fall of twice the loss.
    pub gain: f64,
    pub model: M,
}

/// Results of the joint fits with the candidates that alarm.
#[derive(Debug, Clone)]
pub(crate) struct JointFits<M> {
    /// Candidates that may be causes, the largest gain first.
    pub refits: Vec<Refit<M>>,
    /// Candidates that their fits refuse, or that were not fitted, with the reason.
    pub refused: Refusals,
}

/// Causes after the tests that each must survive, and all other candidates.
#[derive(Debug, Clone)]
pub(crate) struct Confirmed<M> {
    /// Causes in the order of their identification, with their final sizes.
    pub named: Vec<Cause>,
    /// Causes that a test withdrew, with the objection.
    pub rejected: Vec<Cause>,
    /// All other candidates, in any order.
    pub rest: Vec<Cause>,
    /// The model with the causes.
    pub extended: M,
    /// The largest residual structure; `None` off the road, where none is sought.
    pub structure: Option<Structure>,
    /// Whether the ride has a misfit that no candidate explains.
    pub unexplained: bool,
}

/// The row of `causes` for a misfit that no candidate explains.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unexplained {
    /// Size of the misfit over that of fault-free simulations.
    pub score: f64,
    /// Residual or signal with the misfit.
    pub parameter: &'static str,
    /// Reason, a sentence for the table and the page.
    pub reason: String,
    /// Whether the row comes before those of the causes.
    pub first: bool,
}

/// Block residuals of one channel in one kind of manoeuvre: block and residual, in time order.
pub(crate) type CellResiduals = BTreeMap<Cell, Vec<(usize, f64)>>;

/// Residuals grouped by cell, each in the order given.
pub(crate) fn in_cells(residuals: impl Iterator<Item = (Cell, usize, f64)>) -> CellResiduals {
    let mut out = CellResiduals::new();
    for (cell, block, r) in residuals {
        out.entry(cell).or_default().push((block, r));
    }
    out
}

/// One ride of one kind of riding: its residuals, candidates and fault-free simulations, and the rules that only this
/// kind has.
pub(crate) trait Engine {
    /// A fitted model: the nominal one, or one with causes.
    type Model;
    /// A model with the score of every open candidate on it.
    type Stage;
    /// Spread and threshold by which sizes become scores.
    type Scale;

    /// Thresholds of identification.
    fn rules(&self) -> IdentificationRules;

    /// The nominal model with the scores on it.
    fn nominal_stage(&self) -> Self::Stage;

    /// Size, score and gain of every open candidate at a stage.
    fn judge(&self, stage: &Self::Stage) -> Vec<Judged>;

    /// Joint fits with the candidates that alarm: those that have a size within their bounds, and what refuses the
    /// others. `named` are in the stage's model.
    fn refits(
        &self,
        stage: &Self::Stage,
        judged: &[Judged],
        named: &[Cause],
    ) -> JointFits<Self::Model>;

    /// Reason why a refitted candidate is not a cause, such as too little gain; `None` if it may be one.
    fn refuses(
        &self,
        stage: &Self::Stage,
        refit: &Refit<Self::Model>,
        named: &[Cause],
    ) -> Option<Refusal>;

    /// The next stage, whose model includes the last of `named`.
    fn add_cause(
        &self,
        stage: Self::Stage,
        refit: Refit<Self::Model>,
        named: &[Cause],
    ) -> Self::Stage;

    /// Tests the causes once more (steps 7 to 9 of section 2.5). `judged` are the open candidates of the last stage.
    fn confirm(
        &self,
        stage: Self::Stage,
        judged: Vec<Judged>,
        named: Vec<Cause>,
    ) -> Confirmed<Self::Model>;

    /// Name and unit of every channel of residuals.
    fn channels(&self) -> Vec<(&'static str, &'static str)>;

    /// Residuals of the nominal model.
    fn base_residuals(&self) -> CellResiduals;

    /// Residuals of the extended model.
    fn extended_residuals(&self, identification: &Identification<Self::Model>) -> CellResiduals;

    /// Noise of each channel over the largest of its fault-free simulations: the median over the kinds of manoeuvre, at
    /// least 1. A channel that is noisier everywhere is noisy, not wrong.
    fn noise_factors(&self, before: &Rms) -> Vec<f64>;

    /// Fewest blocks of a channel and kind of manoeuvre in which structure is sought.
    fn fewest_blocks(&self) -> usize;

    /// Variables of the ride that a misfit may follow, block by block; and whether they are correlated with the residuals
    /// of the extended model (`true`) or of the nominal one.
    fn covariates(&self) -> (Vec<(&'static str, Vec<f64>)>, bool);

    /// Calibration by fault-free simulations.
    fn calibration(&self) -> &Calibration<Self::Scale>;

    /// Fall of twice the loss on manoeuvres left out: with the causes, and with every candidate free.
    fn held_out_gains(&self, identification: &Identification<Self::Model>) -> [f64; 2];

    /// The misfit that no candidate explains, if there is one.
    fn unexplained(
        &self,
        identification: &Identification<Self::Model>,
        discrepancies: &[DiscrepancyRow],
    ) -> Option<Unexplained>;

    /// Remark after the sentence of a cause, or of a candidate that is not identifiable; often empty.
    fn remark(&self, cause: &Cause) -> String {
        let _ = cause;
        String::new()
    }
}

/// Identifies the causes of a ride.
pub(crate) fn identify_causes<E: Engine>(engine: &E) -> Identification<E::Model> {
    let rules = engine.rules();
    let mut stage = engine.nominal_stage();
    let mut judged = engine.judge(&stage);
    let alarm = largest(judged.iter());
    let mut named: Vec<Cause> = Vec::new();
    let mut replacements: Vec<Cause> = Vec::new();
    let (mut refused_at_first, mut refused) = (None, Refusals::new());
    while largest(judged.iter()) > rules.alarm || judged.iter().any(|j| j.makes_plausible) {
        let selected;
        (selected, refused) = select(engine, &stage, &judged, &named);
        refused_at_first.get_or_insert_with(|| refused.clone());
        let Some((cause, rivals, refit)) = selected else { break };
        replacements.extend(rivals.iter().map(|rival| rival.2.clone()));
        named.push(cause);
        stage = engine.add_cause(stage, refit, &named);
        judged = engine.judge(&stage);
        refused.clear();
        if let (Some(share), Some(last)) = (rules.independent, named.last_mut()) {
            // a rival that still gains much beside the cause is a cause of its own
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
    // if every cause was withdrawn, the others are judged on the nominal model again
    let at_stage = match named.is_empty() && !rejected.is_empty() {
        true => &refused_at_first,
        false => &refused,
    };
    let mut rest: Vec<Cause> =
        rest.into_iter().map(|cause| cause.refused(at_stage, rules.alarm)).collect();
    let alternatives = alternatives(&named, &mut rest, replacements);
    rest.sort_by(|a, b| b.score.total_cmp(&a.score));
    named.extend(alternatives);
    named.extend(rejected.into_iter().chain(rest));
    Identification { causes: named, extended, alarm, structure, unexplained, refused_at_first }
}

/// The equivalents of the causes, each with the size that it would have in the cause's place. They leave `rest`, where
/// they are judged beside the cause and seem not to be needed.
fn alternatives(named: &[Cause], rest: &mut Vec<Cause>, replacements: Vec<Cause>) -> Vec<Cause> {
    let is_open = |cause: &Cause| {
        let name = cause.candidate.name;
        named.iter().any(|c| c.verdict.is_cause() && c.equivalent.contains(&name))
    };
    let open: Vec<Cause> = rest.extract_if(.., |cause| is_open(cause)).collect();
    let of = |cause: Cause| {
        let same = |c: &&Cause| c.candidate.name == cause.candidate.name;
        // the last one was fitted with all earlier causes in the model
        let replacement = replacements.iter().rfind(same).cloned();
        replacement.unwrap_or(Cause { verdict: Verdict::Alternative, ..cause })
    };
    open.into_iter().map(of).collect()
}

/// Candidates that gain nearly as much as the cause: name, gain, and the cause that each would be instead.
type Rivals = Vec<(&'static str, f64, Cause)>;

/// A cause, its rivals and the joint fit with it.
type Selected<M> = (Cause, Rivals, Refit<M>);

/// The candidate with the largest gain, as a cause, and the reasons that refuse the others.
fn select<E: Engine>(
    engine: &E,
    stage: &E::Stage,
    judged: &[Judged],
    named: &[Cause],
) -> (Option<Selected<E::Model>>, Refusals) {
    let JointFits { mut refits, mut refused } = engine.refits(stage, judged, named);
    let at = refits.iter().position(|r| match engine.refuses(stage, r, named) {
        Some(why) => {
            refused.insert(r.judged.candidate.name, why);
            false
        }
        None => true,
    });
    let Some(at) = at else { return (None, refused) };
    let best = refits.remove(at);
    let outgained = Refusal::Outgained(best.judged.candidate.name);
    refused.extend(refits[at..].iter().map(|r| (r.judged.candidate.name, outgained)));
    let least = engine.rules().equivalent * best.gain;
    let near = |r: &&Refit<E::Model>| r.gain > least;
    let as_cause = |r: &Refit<E::Model>| Cause {
        estimate: r.estimate,
        gain: r.gain,
        ..r.judged.cause(Verdict::Alternative)
    };
    let rivals: Rivals = refits
        .iter()
        .filter(near)
        .map(|r| (r.judged.candidate.name, r.gain, as_cause(r)))
        .collect();
    let cause = Cause {
        estimate: best.estimate,
        gain: best.gain,
        equivalent: rivals.iter().map(|r| r.0).collect(),
        ..best.judged.cause(if rivals.is_empty() { Verdict::Named } else { Verdict::Ambiguous })
    };
    (Some((cause, rivals, best)), refused)
}

/// The largest score; 0 if there is none.
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

    /// Beside an identified wind the grade seems not to be needed, yet it is the alternative.
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
