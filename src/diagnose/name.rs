//! From scores to names (`diagnosis.md`, section 2.5).
//!
//! An alarm is a score beyond what nulls show. Of the candidates that share in it and have a size that
//! can be, the one whose joint refit with the base gains most is named; those that gain nearly as
//! much are its equivalents: the ride cannot tell them apart. The named one joins the base, and what
//! is left is looked at again.

use super::base::Base;
use super::effects::Effect;
use super::generic::{self, Term};
use super::null::Calibration;
use super::samples::Samples;
use super::scan::scan;

/// Share of the largest score that a candidate must have itself.
const SHARE: f64 = 0.3;
/// Least score that a candidate must have itself.
const LEAST: f64 = 1.0;
/// Score of any candidate from which there is an alarm.
const ALARM: f64 = 1.1;
/// Least gain of a refit, in twice the loss.
const GAIN: f64 = 12.0;
/// The same for every further name, and its share of the first one's gain.
const FURTHER: (f64, f64) = (50.0, 0.05);
/// Candidates that are refitted.
const REFITTED: usize = 6;
/// Share of the best gain from which a candidate is an equivalent.
const EQUIVALENT: f64 = 0.8;
/// Structure, in thresholds, that contradicts what was named.
const CONTRADICTS: f64 = 2.0;
/// Most causes of one ride.
const MOST: usize = 4;
/// What the model itself is uncertain by, as a share of an estimate.
const MODEL: f64 = 0.03;

/// What is said of a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It is the cause.
    Named,
    /// It is one of a class that the ride cannot tell apart.
    Ambiguous,
    /// Nothing speaks for it.
    NotNeeded,
    /// The ride says nothing about it.
    NotIdentifiable,
}

impl Verdict {
    /// As in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Named => "named",
            Verdict::Ambiguous => "ambiguous",
            Verdict::NotNeeded => "not_needed",
            Verdict::NotIdentifiable => "not_identifiable",
        }
    }
}

/// One candidate, judged.
#[derive(Debug, Clone)]
pub struct Cause {
    /// Which.
    pub effect: Effect,
    /// What is said of it.
    pub verdict: Verdict,
    /// Its size, in the effect's unit.
    pub value: f64,
    /// Standard deviation of it.
    pub std_error: f64,
    /// Over one is beyond what nulls show.
    pub score: f64,
    /// Fall of twice the loss when it joined the base; zero where it was not refitted.
    pub gain: f64,
    /// Others that the ride cannot tell from it.
    pub equivalent: Vec<&'static str>,
}

/// What a ride says of its causes.
#[derive(Debug, Clone)]
pub struct Naming {
    /// Every candidate, the best first.
    pub causes: Vec<Cause>,
    /// The base with what was named.
    pub extended: Base,
    /// Largest score of all before anything was named.
    pub alarm: f64,
    /// What is left over which variable, and how many times what nulls show at most.
    pub left: Option<(Term, f64)>,
    /// Whether structure is left that no candidate explains.
    pub unexplained: bool,
}

/// Names the causes.
pub fn name(
    samples: &Samples,
    base: &Base,
    effects: &[Effect],
    calibration: &Calibration,
) -> Naming {
    let mut current = base.clone();
    let mut open: Vec<usize> = (0..effects.len()).collect();
    let mut named: Vec<Cause> = Vec::new();
    let mut first_alarm = 0.0;
    let mut rest: Vec<Cause> = Vec::new();
    for round in 0..=MOST {
        let candidates: Vec<Effect> = open.iter().map(|&j| effects[j]).collect();
        let scores = scan(samples, &current, &candidates);
        let judged: Vec<_> =
            open.iter().zip(&scores).map(|(&j, s)| (j, calibration.judge(j, s), *s)).collect();
        let alarm = judged.iter().map(|(_, c, _)| c.score).fold(0.0, f64::max);
        if round == 0 {
            first_alarm = alarm;
        }
        rest = judged
            .iter()
            .map(|(j, c, _)| Cause {
                effect: effects[*j],
                verdict: if !calibration.sees(*j) {
                    Verdict::NotIdentifiable
                } else {
                    Verdict::NotNeeded
                },
                value: c.delta * effects[*j].typical.abs(),
                std_error: c.std_error * effects[*j].typical.abs(),
                score: c.score,
                gain: 0.0,
                equivalent: Vec::new(),
            })
            .collect();
        if alarm <= ALARM || round == MOST {
            break;
        }
        let mut gated: Vec<_> =
            judged.iter().filter(|(_, c, _)| c.score > LEAST.max(SHARE * alarm)).collect();
        gated.sort_by(|a, b| b.2.gain.total_cmp(&a.2.gain));
        gated.truncate(REFITTED);
        let mut refits: Vec<(usize, f64, Base)> = gated
            .iter()
            .map(|(j, _, _)| {
                let refit = current.extended(samples, &[effects[*j].parameter()], 4);
                (*j, 2.0 * (current.loss - refit.loss), refit)
            })
            .filter(|(j, gain, refit)| {
                let p = effects[*j].parameter();
                let size = p.get(&refit.world) - p.get(&base.start);
                let least = match named.first() {
                    None => GAIN,
                    Some(first) => FURTHER.0.max(FURTHER.1 * first.gain),
                };
                *gain > least && effects[*j].possible(size)
            })
            .collect();
        refits.sort_by(|a, b| b.1.total_cmp(&a.1));
        let Some((best, gain, refit)) = refits.first().cloned() else {
            break;
        };
        let equivalent: Vec<&'static str> = refits[1..]
            .iter()
            .filter(|(_, g, _)| *g > EQUIVALENT * gain)
            .map(|(j, _, _)| effects[*j].name)
            .collect();
        let effect = effects[best];
        let p = effect.parameter();
        let Some((_, seen, _)) = judged.iter().find(|(j, _, _)| *j == best) else { break };
        let value = p.get(&refit.world) - p.get(&base.start) - calibration.bias[best] * p.scale;
        let std_error = (seen.std_error * p.scale).hypot(MODEL * value);
        let verdict = if equivalent.is_empty() { Verdict::Named } else { Verdict::Ambiguous };
        named.push(Cause {
            effect,
            verdict,
            value,
            std_error,
            score: seen.score,
            gain,
            equivalent,
        });
        current = refit;
        open.retain(|j| *j != best);
    }
    // what is left, over which variable
    let problem = current.problem(samples);
    let terms = generic::terms(samples, &problem, &problem.linear(&current.world));
    let (most, times) = calibration.largest(&terms);
    let left = most.map(|_| times / calibration.structure).and_then(|times| {
        // the most unusual term tells that there is something, the largest what it goes with
        let beyond = |t: &&Term| t.gain > 0.0;
        let term = terms.iter().filter(beyond).max_by(|a, b| a.gain.total_cmp(&b.gain))?;
        Some((*term, times))
    });
    let bar = if named.is_empty() { 1.0 } else { CONTRADICTS };
    let unexplained = left.is_some_and(|(_, times)| times > bar);
    rest.retain(|c| named.iter().all(|n| n.effect.name != c.effect.name));
    rest.sort_by(|a, b| b.score.total_cmp(&a.score));
    named.extend(rest);
    Naming { causes: named, extended: current, alarm: first_alarm, left, unexplained }
}
