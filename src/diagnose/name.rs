//! From scores to names (`diagnosis.md`, section 2.5).
//!
//! An alarm is a score beyond what nulls show. Of the candidates that share in it and have a size that
//! can be, the one whose joint refit with the base gains most is named; those that gain nearly as
//! much are its equivalents: the ride cannot tell them apart. The named one joins the base, and what
//! is left is looked at again.

use rayon::prelude::*;

use super::base::{Base, LARGE, Start};
use super::effects::Effect;
use super::generic::{self, Term};
use super::null::{Calibrated, Calibration, median};
use super::rides::Rides;
use super::samples::Samples;
use super::scan::scan;
use super::world::World;

/// Share of the largest score that a candidate must have itself.
const SHARE: f64 = 0.3;
/// Least score that a candidate must have itself.
const LEAST: f64 = 1.0;
/// Score of any candidate from which there is an alarm.
pub const ALARM: f64 = 1.1;
/// Least gain of a refit, in twice the loss.
const GAIN: f64 = 12.0;
/// Score that makes up for half of it.
const CLEAR: f64 = 1.5;
/// The same for every further name, and its share of the first one's gain.
const FURTHER: (f64, f64) = (20.0, 0.03);
/// Candidates that are refitted.
const REFITTED: usize = 6;
/// Share of the best gain from which a candidate is an equivalent.
const EQUIVALENT: f64 = 0.8;
/// Structure, in thresholds, that contradicts what was named: what a cause leaves of itself grows with
/// it, so the bar is this share of its score, within limits.
const CONTRADICTS: f64 = 0.75;
/// See above.
const BARS: [f64; 2] = [1.4, 3.0];
/// Share of what an effect shows that is in the structure's channel when it is contradicted by it.
const TOUCHES: f64 = 0.1;
/// Score from which a cause is believed beside structure that is elsewhere.
const STRONG: f64 = 3.0;
/// Most causes of one ride.
const MOST: usize = 4;
/// Rides on the extended model.
const AGAIN: usize = 16;
/// What the model itself is uncertain by, as a share of an estimate.
const MODEL: f64 = 0.03;
/// How far from one the share of a size that a fit shows is believed to be.
const SHOWN: f64 = 0.3;

/// What is said of a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It is the cause.
    Named,
    /// It is one of a class that the ride cannot tell apart.
    Ambiguous,
    /// It would have been named, but leaves more structure than a cause may.
    Contradicted,
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
            Verdict::Contradicted | Verdict::NotNeeded => "not_needed",
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

impl Naming {
    /// Whether anything was.
    pub fn named(&self) -> bool {
        self.causes.iter().any(|c| matches!(c.verdict, Verdict::Named | Verdict::Ambiguous))
    }
}

/// Names the causes of what a base leaves, looked for from near it ([`Base::believable`]).
pub fn name(
    samples: &Samples,
    start: &Start,
    effects: &[Effect],
    calibration: &Calibration,
    rides: &Rides<'_>,
) -> Naming {
    let Start { base, near, .. } = start;
    let mut current = near.clone();
    let mut open: Vec<usize> = (0..effects.len()).collect();
    let mut named: Vec<Cause> = Vec::new();
    let mut biases = Vec::new();
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
        // a base that was dragged astray is an alarm by itself: what is linear may not tell by whom
        let explains = |j: usize| round == 0 && start.gains.get(j).is_some_and(|g| *g > LARGE);
        if (alarm <= ALARM && !open.iter().any(|&j| explains(j))) || round == MOST {
            break;
        }
        let scored = |c: &Calibrated| c.score > LEAST.max(SHARE * alarm);
        let mut gated: Vec<_> = judged
            .iter()
            .filter(|(j, c, _)| scored(c) || calibration.sees(*j) && explains(*j))
            .map(|(j, c, s)| (*j, *c, start.gains.get(*j).map_or(s.gain, |g| g.max(s.gain))))
            .collect();
        gated.sort_by(|a, b| b.2.total_cmp(&a.2));
        gated.truncate(REFITTED);
        let mut refits: Vec<(usize, f64, Base)> = gated
            .par_iter()
            .map(|(j, c, _)| {
                let refit = current.extended(samples, &[effects[*j].parameter()], 8);
                (*j, *c, 2.0 * (current.loss - refit.loss), refit)
            })
            .filter(|(j, c, gain, refit)| {
                let p = effects[*j].parameter();
                let size = p.get(&refit.world) - p.get(&base.start);
                let least = match named.first() {
                    None if !scored(c) => LARGE,
                    None if c.score > CLEAR => 0.5 * GAIN,
                    None => GAIN,
                    Some(first) => FURTHER.0.max(FURTHER.1 * first.gain),
                };
                *gain > least && effects[*j].possible(size)
            })
            .map(|(j, _, gain, refit)| (j, gain, refit))
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
        let bias = calibration.bias[best] * p.scale;
        let value = p.get(&refit.world) - p.get(&base.start) - bias;
        let std_error = seen.std_error * p.scale;
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
        biases.push(bias);
        current = refit;
        open.retain(|j| *j != best);
    }
    if named.is_empty() {
        current = base.clone();
    }
    // what is left, over which variable
    let problem = current.problem(samples);
    let linear = problem.linear(&current.world);
    let terms = generic::terms(samples, &problem, &linear);
    let (most, times) = calibration.largest(&terms);
    let left = most.map(|_| times / calibration.structure).and_then(|times| {
        // the most unusual term tells that there is something, the one that gains most beyond its
        // usual what it goes with
        let (term, _) = terms
            .iter()
            .zip(&calibration.usual)
            .map(|(t, usual)| (t, t.gain - usual))
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((*term, times))
    });
    let bar = match named.first() {
        None => 1.0,
        Some(first) => (CONTRADICTS * first.score.max(first_alarm)).clamp(BARS[0], BARS[1]),
    };
    let contradicts = left.filter(|(_, times)| *times > bar);
    let mut contradicted = Vec::new();
    if let Some((term, _)) = contradicts.filter(|_| !named.is_empty()) {
        // whoever shows where the structure is takes up part of something else, and so may the weak
        let shows = |cause: &Cause| {
            if cause.score < STRONG {
                return true;
            }
            let place = current.parameters.iter().position(|p| p.name == cause.effect.name);
            place.is_some_and(|k| problem.share(&linear.columns[k], term.channel) > TOUCHES)
        };
        let (out, kept): (Vec<_>, Vec<_>) =
            named.into_iter().zip(biases).partition(|(c, _)| shows(c));
        (named, biases) = kept.into_iter().unzip();
        let withdrawn = |c: Cause| Cause { verdict: Verdict::Contradicted, ..c };
        contradicted.extend(out.into_iter().map(|(c, _)| withdrawn(c)));
        if !named.is_empty() && !contradicted.is_empty() {
            let more: Vec<_> = named.iter().map(|c| c.effect.parameter()).collect();
            current = near.extended(samples, &more, 8);
        }
    }
    settle(&mut named, &biases, &current, &base.start, rides);
    named.extend(contradicted);
    rest.retain(|c| named.iter().all(|n| n.effect.name != c.effect.name));
    rest.sort_by(|a, b| b.score.total_cmp(&a.score));
    named.extend(rest);
    let unexplained = contradicts.is_some();
    Naming { causes: named, extended: current, alarm: first_alarm, left, unexplained }
}

/// Sizes and their errors from rides on the extended model itself: what a fit makes of a size that is
/// known there is what it makes of the unknown one here.
///
/// A fit shows a share of a true size beside a bias that is there without it, `biases` in the effects'
/// units: noise in a regressor holds it back. Rides on the extended model tell the share.
fn settle(named: &mut [Cause], biases: &[f64], extended: &Base, start: &World, rides: &Rides<'_>) {
    if named.is_empty() {
        return;
    }
    let rides = rides.on(&extended.world);
    let sizes: Vec<Vec<f64>> = (0..AGAIN)
        .into_par_iter()
        .map(|number| {
            let (_, quick) = rides.fit(number, extended, &extended.parameters, &[]);
            let size = |c: &Cause| c.effect.parameter().get(&quick.base.world);
            named.iter().map(size).collect()
        })
        .collect();
    for (k, (cause, bias)) in named.iter_mut().zip(biases).enumerate() {
        let p = cause.effect.parameter();
        let truth = p.get(&extended.world) - p.get(start);
        let own: Vec<f64> = sizes.iter().map(|s| s[k] - p.get(start)).collect();
        let centre = median(&own);
        let spread = 1.4826 * median(&own.iter().map(|x| (x - centre).abs()).collect::<Vec<_>>());
        let mean = own.iter().sum::<f64>() / AGAIN as f64;
        let square = own.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
        let sd = 0.5 * ((square / (AGAIN as f64 - 1.0)).sqrt() + spread);
        // the share, and how well so few rides tell it; a size within its noise tells nothing of it
        let precision = (truth / (1.25 * sd)).powi(2) * AGAIN as f64;
        let believed = SHOWN.powi(-2);
        let seen = precision * (centre - bias) / truth;
        let share = ((seen + believed) / (precision + believed)).clamp(0.3, 2.0);
        cause.value = (truth - bias) / share;
        let scatter = cause.std_error.max(sd) / share;
        let of_share = cause.value / share / (precision + believed).sqrt();
        cause.std_error = scatter.hypot(of_share).hypot(MODEL * cause.value);
    }
}
