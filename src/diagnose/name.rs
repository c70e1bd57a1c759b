//! From scores to names (`diagnosis.md`, section 2.5).
//!
//! An alarm is a score beyond what nulls show. Of the candidates that share in it and have a size that
//! can be, the one whose joint refit with the base gains most is named; those that gain nearly as
//! much are its equivalents: the ride cannot tell them apart. The named one joins the base, and what
//! is left is looked at again.

use rayon::prelude::*;

use super::base::{Base, LARGE, Start};
use super::generic::{self, Term};
use super::null_calibration::{Calibrated, Calibration};
use super::null_simulation::Rides;
use super::parameters::{BASE, Parameters};
use super::problem::Linear;
use super::samples::Samples;
use super::scan::{Score, scan};
use crate::contract::verdict::Verdict;
use crate::effects::Effect;
use crate::statistics::order::{SD_PER_MAD, median_or_zero};

/// Share of the largest score that a candidate must have itself.
const SHARE: f64 = 0.3;
/// Score from which there is an alarm, and that who is named must have itself.
pub const ALARM: f64 = 1.25;
/// The same for who may be it as well.
const RIVAL: f64 = 0.8;
/// Least gain of a refit, in twice the loss.
const GAIN: f64 = 12.0;
/// Score that makes up for half of it.
const CLEAR: f64 = 1.5;
/// The same for every further cause: what is not in any model, as a multibody ride's tyres, may gain more
/// than the first needs.
const FURTHER: f64 = 20.0;
/// Score that makes up for half of that.
const SURE: f64 = 1.8;
/// Candidates that are refitted.
const REFITTED: usize = 6;
/// Share of the best gain to first order below which a candidate is not.
const FAR: f64 = 0.2;
/// Share of the best gain from which a candidate is an equivalent.
const EQUIVALENT: f64 = 0.8;
/// Structure, in thresholds of rides on the extended model, that contradicts what was named.
const CONTRADICTS: f64 = 1.4;
/// Share of what an effect shows that is in the structure's channel when it is contradicted by it.
const TOUCHES: f64 = 0.1;
/// Score from which a cause is believed beside structure that is elsewhere, and beside such as
/// contradicts a weaker one where it shows itself.
const STRONG: f64 = 3.0;
/// Structure that contradicts even those.
const OVERRULES: f64 = 2.0;
/// Most causes of one ride.
const MOST: usize = 4;
/// What the model itself is uncertain by, as a share of an estimate.
const MODEL: f64 = 0.03;
/// Share of a channel's noise below which it is learnt anew.
const QUIETER: f64 = 0.9;
/// Score by the stage before from which candidates are held against rides on the model itself.
const LOOK: f64 = 0.7;
/// Most nulls that are ridden on a model with causes, and those of a first look at sizes.
const AGAIN: usize = 16;
const FIRST: usize = 6;
/// How far, as a share, a size may be from what was ridden.
const AWAY: f64 = 0.1;
/// How far from one the share of a size that a fit shows is believed to be.
const SHOWN: f64 = 0.3;

/// Why a candidate that would have been named is not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objection {
    /// It leaves more structure in the channels where it shows itself than a cause may.
    Contradicted,
    /// Null simulations on the model with it do not give its size back, or only one out of bounds.
    NotReproduced,
}

/// One candidate, judged.
#[derive(Debug, Clone)]
pub struct Cause {
    /// Which.
    pub effect: Effect,
    /// What is said of it.
    pub verdict: Verdict,
    /// Why it is not needed though it alarmed and gained enough.
    pub objection: Option<Objection>,
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

impl Cause {
    fn rejected(self, objection: Objection) -> Self {
        Cause { verdict: Verdict::NotNeeded, objection: Some(objection), ..self }
    }
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

/// A model, and what candidates and structure show on rides on it.
struct Stage<'a> {
    model: Base,
    /// With the noise that it leaves.
    rides: Rides<'a>,
    /// What was ridden: the model, with sizes as they must be for fits to show the model's.
    ridden: Parameters,
    /// Candidates that are not in it.
    open: Vec<Effect>,
    /// To first order, by `open`.
    scores: Vec<Score>,
    /// Rides on it, by `open`.
    nulls: Calibration,
}

/// A candidate at a stage.
struct Candidate {
    effect: Effect,
    seen: Calibrated,
    /// In the effect's unit.
    bias: f64,
    /// To first order, or that of the base's fit with it.
    gain: f64,
    /// Whether a base that was dragged astray is right with it.
    explains: bool,
}

impl<'a> Stage<'a> {
    /// The next: a model that fits better leaves less noise.
    ///
    /// Rides on it tell what sizes its causes have. Candidates are held against them only where those
    /// of the stage before have it that one may be a cause as well: they cost the most.
    fn new(
        samples: &Samples,
        model: &Base,
        open: Vec<Effect>,
        before: &Stage<'a>,
        named: &[(Cause, f64)],
    ) -> Self {
        let count = before.nulls.nulls.min(AGAIN);
        let sigma = model.sigma;
        let model = model.settled(samples);
        let quieter = sigma.iter().zip(model.sigma).map(|(before, now)| now / before);
        let quieter = quieter.fold(1.0, f64::min);
        let rides = match quieter < QUIETER {
            true => before.rides.learnt(&model),
            false => before.rides.on(&model.world),
        };
        let fit = |number| rides.fit(number, &model, &model.parameters, &[]).1.base.world;
        let fits: Vec<Parameters> = (0..count.min(FIRST)).into_par_iter().map(fit).collect();
        // a fit that shows half of a size leaves the other half for somebody else to take up
        let settled = settled(&model, &model.world, &fits, named);
        let off = |((c, _), (value, _)): (&(Cause, f64), &(f64, f64))| {
            (value - size(&c.effect, &model)).abs() > AWAY * value.abs()
        };
        let mut ridden = model.world.clone();
        if named.iter().zip(&settled).any(off) {
            for ((cause, _), (value, _)) in named.iter().zip(&settled) {
                let p = cause.effect.parameter();
                let [low, high] = cause.effect.bounds;
                p.set(&mut ridden, p.get(&model.start) + value.clamp(low, high));
            }
        }
        let rides = rides.on(&ridden);
        // candidates as those before would judge them; what is quieter now they judge too low
        let place = |e: &Effect| before.open.iter().position(|b| b.name == e.name);
        let places: Vec<usize> = open.iter().filter_map(place).collect();
        let (nulls, scores) = (before.nulls.only(&places), scan(samples, &model, &open));
        let mut stage = Stage { model, rides, ridden, open, scores, nulls };
        let alarming = largest(stage.candidates(&[]).iter()) > LOOK * quieter;
        let candidates = if alarming { stage.open.as_slice() } else { &[] };
        let nulls = Calibration::new(&stage.rides, &stage.model, candidates, count);
        stage.nulls = if alarming { nulls } else { nulls.judging_as(&stage.nulls) };
        stage
    }

    /// What every open candidate shows.
    fn candidates(&self, gains: &[f64]) -> Vec<Candidate> {
        let judge = |(k, (effect, score)): (usize, (&Effect, &Score))| {
            let strained = gains.get(k).copied().unwrap_or(0.0);
            Candidate {
                effect: *effect,
                seen: self.nulls.judge(k, score),
                bias: self.nulls.bias[k] * effect.typical.abs(),
                gain: score.gain.max(strained),
                explains: strained > LARGE,
            }
        };
        self.open.iter().zip(&self.scores).enumerate().map(judge).collect()
    }

    /// The cause that the model gains most by, and the model with it.
    fn best(
        &self,
        samples: &Samples,
        candidates: &[Candidate],
        sees: &dyn Fn(&Effect) -> bool,
    ) -> Option<(Cause, f64, Base)> {
        // what could not be that large says nothing of how much the others share in
        let possible = |c: &&Candidate| c.effect.in_bounds(c.seen.delta * c.effect.typical.abs());
        let believed = largest(candidates.iter().filter(possible));
        let scored = |c: &Candidate, least: f64| c.seen.score > least.max(SHARE * believed);
        let mut gated: Vec<&Candidate> = candidates
            .iter()
            .filter(|c| scored(c, RIVAL) || sees(&c.effect) && c.explains)
            .collect();
        // those that can be named first
        let alarms = |c: &Candidate| scored(c, ALARM) || c.explains;
        gated.sort_by(|a, b| alarms(b).cmp(&alarms(a)).then(b.gain.total_cmp(&a.gain)));
        gated.truncate(REFITTED);
        let least = FAR * gated.first().map_or(0.0, |c| c.gain);
        gated.retain(|c| c.gain > least);
        let mut refits: Vec<(&Candidate, f64, Base)> = gated
            .into_par_iter()
            .map(|c| {
                let refit = self.model.extended(samples, &[c.effect.parameter()], 8);
                (c, 2.0 * (self.model.loss - refit.loss), refit)
            })
            .filter(|(c, _, refit)| c.effect.in_bounds(size(&c.effect, refit)))
            .collect();
        refits.sort_by(|a, b| b.1.total_cmp(&a.1));
        let further = self.model.parameters.len() > BASE.len();
        let (best, gain, refit) = refits.iter().find(|(c, gain, _)| {
            let least = match c.seen.score {
                _ if !scored(c, ALARM) => LARGE,
                score if further && score > SURE => 0.5 * FURTHER,
                _ if further => FURTHER,
                score if score > CLEAR => 0.5 * GAIN,
                _ => GAIN,
            };
            *gain > least && alarms(c)
        })?;
        let equivalent: Vec<&'static str> = refits
            .iter()
            .filter(|(c, g, _)| *g > EQUIVALENT * gain && c.effect.name != best.effect.name)
            .map(|(c, _, _)| c.effect.name)
            .collect();
        let cause = Cause {
            verdict: if equivalent.is_empty() { Verdict::Named } else { Verdict::Ambiguous },
            value: size(&best.effect, refit) - best.bias,
            gain: *gain,
            equivalent,
            ..best.cause(Verdict::Named)
        };
        Some((cause, best.bias, refit.clone()))
    }

    /// What is left over which variable, and how many times what nulls show at most.
    fn left(&self, samples: &Samples) -> (Option<(Term, f64)>, Linear) {
        let problem = self.model.problem(samples);
        let linear = problem.linear(&self.model.world);
        let terms = generic::terms(samples, &problem, &linear);
        let (most, times) = self.nulls.largest(&terms);
        // the most unusual term tells that there is something, the one that gains most beyond its
        // usual what it goes with
        let beyond = terms.iter().zip(&self.nulls.usual).map(|(t, usual)| (t, t.gain - usual));
        let term = beyond.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|_| most.is_some());
        (term.map(|(t, _)| (*t, times / self.nulls.structure)), linear)
    }
}

impl Candidate {
    fn cause(&self, verdict: Verdict) -> Cause {
        let unit = self.effect.typical.abs();
        Cause {
            effect: self.effect,
            verdict,
            objection: None,
            value: self.seen.delta * unit,
            std_error: self.seen.std_error * unit,
            score: self.seen.score,
            gain: 0.0,
            equivalent: Vec::new(),
        }
    }
}

fn largest<'a>(candidates: impl Iterator<Item = &'a Candidate>) -> f64 {
    candidates.map(|c| c.seen.score).fold(0.0, f64::max)
}

/// Sizes and their errors from rides on the model itself: what a fit makes of a size that is known
/// there is what it makes of the unknown one here.
///
/// A fit shows a share of a true size beside a bias that is there without it, given in the effect's
/// unit: noise in a regressor holds it back. The rides tell both.
fn settled(
    model: &Base,
    ridden: &Parameters,
    fits: &[Parameters],
    named: &[(Cause, f64)],
) -> Vec<(f64, f64)> {
    let (start, count) = (&model.start, fits.len() as f64);
    let settle = |(cause, bias): &(Cause, f64)| {
        let p = cause.effect.parameter();
        let shown = size(&cause.effect, model);
        let truth = p.get(ridden) - p.get(start);
        let own: Vec<f64> = fits.iter().map(|fit| p.get(fit) - p.get(start)).collect();
        let centre = median_or_zero(&own);
        let off: Vec<f64> = own.iter().map(|x| (x - centre).abs()).collect();
        let spread = SD_PER_MAD * median_or_zero(&off);
        let mean = own.iter().sum::<f64>() / count;
        let square = own.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
        let sd = 0.5 * ((square / (count - 1.0).max(1.0)).sqrt() + spread);
        // the share, and how well so few rides tell it; a size within its noise tells nothing of it
        let precision = (truth / (1.25 * sd)).powi(2) * count;
        let believed = SHOWN.powi(-2);
        let seen = precision * (centre - bias) / truth;
        let share = ((seen + believed) / (precision + believed)).clamp(0.3, 2.0);
        let value = truth + (shown - centre) / share;
        let scatter = cause.std_error.max(sd) / share;
        let of_share = (value - truth) / share / (precision + believed).sqrt();
        match value.is_finite() {
            true => (value, scatter.hypot(of_share).hypot(MODEL * value)),
            // the model cannot even be ridden: what the fit itself says
            false => (shown - bias, cause.std_error.hypot(MODEL * shown)),
        }
    };
    named.iter().map(settle).collect()
}

/// Size of an effect in a model, beyond what is assumed of it.
fn size(effect: &Effect, model: &Base) -> f64 {
    let p = effect.parameter();
    p.get(&model.world) - p.get(&model.start)
}

/// Names the causes of what a base leaves, looked for from near it ([`Base::believable`]).
///
/// Once a cause is in the model, further candidates and structure are held against rides on the model
/// with it: what a large cause leaves of itself it leaves there too, and is none of another's.
pub fn name<'a>(
    samples: &Samples,
    start: &Start,
    effects: &[Effect],
    calibration: &Calibration,
    rides: &Rides<'a>,
) -> Naming {
    let Start { base, near, gains, .. } = start;
    let sees = |effect: &Effect| {
        effects.iter().position(|e| e.name == effect.name).is_some_and(|j| calibration.sees(j))
    };
    let scores = scan(samples, near, effects);
    let first = || Stage {
        model: near.clone(),
        rides: rides.on(&near.world),
        ridden: near.world.clone(),
        open: effects.to_vec(),
        scores: scores.clone(),
        nulls: calibration.clone(),
    };
    let mut stage = first();
    let mut candidates = stage.candidates(gains);
    let unseen: Vec<Cause> = candidates
        .iter()
        .filter(|c| !sees(&c.effect))
        .map(|c| c.cause(Verdict::NotIdentifiable))
        .collect();
    let alarm = largest(candidates.iter());
    let mut named: Vec<(Cause, f64)> = Vec::new();
    // a base that was dragged astray is an alarm by itself: what is linear may not tell by whom
    while named.len() < MOST
        && (largest(candidates.iter()) > ALARM || candidates.iter().any(|c| c.explains))
    {
        let Some((cause, bias, refit)) = stage.best(samples, &candidates, &sees) else { break };
        let mut open = stage.open.clone();
        open.retain(|e| sees(e) && e.name != cause.effect.name);
        named.push((cause, bias));
        stage = Stage::new(samples, &refit, open, &stage, &named);
        candidates = stage.candidates(&[]);
    }
    if named.is_empty() {
        stage.model = base.clone();
    }
    let (mut left, linear) = stage.left(samples);
    let beyond = |left: Option<(Term, f64)>, named: &[(Cause, f64)]| {
        let bar = if named.is_empty() { 1.0 } else { CONTRADICTS };
        left.is_some_and(|(_, times)| times > bar)
    };
    let mut unexplained = beyond(left, &named);
    let mut out: Vec<Cause> = Vec::new();
    if let Some((term, times)) = left.filter(|_| unexplained) {
        // whoever shows where the structure is takes up part of something else, and so may the weak
        let problem = stage.model.problem(samples);
        let shows = |(cause, _): &mut (Cause, f64)| {
            let place = stage.model.parameters.iter().position(|p| p.name == cause.effect.name);
            let touches = |k: usize| problem.share(&linear.columns[k], term.channel) > TOUCHES;
            cause.score < STRONG || times > OVERRULES && place.is_some_and(touches)
        };
        let contradicted = |(c, _): (Cause, f64)| c.rejected(Objection::Contradicted);
        out.extend(named.extract_if(.., shows).map(contradicted));
    }
    // who is left stays without the others, at the sizes that rides on the model itself give back
    let mut whole = out.is_empty();
    let mut lost: Vec<Cause> = Vec::new();
    while !named.is_empty() {
        if !whole {
            let more: Vec<_> = named.iter().map(|(c, _)| c.effect.parameter()).collect();
            let kept = near.extended(samples, &more, 8);
            stage = Stage::new(samples, &kept, Vec::new(), &first(), &named);
        }
        let settled = settled(&stage.model, &stage.ridden, &stage.nulls.fits, &named);
        let is =
            |c: &Cause, (value, sd): (f64, f64)| value.abs() >= sd && c.effect.in_bounds(value);
        whole = named.iter().zip(&settled).all(|((c, _), found)| is(c, *found));
        let mut found = settled.into_iter();
        let mut kept = Vec::new();
        for (cause, bias) in named {
            let Some((value, std_error)) = found.next() else { break };
            match (whole, is(&cause, (value, std_error))) {
                (true, _) => kept.push((Cause { value, std_error, ..cause }, bias)),
                (false, true) => kept.push((cause, bias)),
                (false, false) => lost.push(cause.rejected(Objection::NotReproduced)),
            }
        }
        named = kept;
        if whole {
            break;
        }
    }
    if named.is_empty() && !(out.is_empty() && lost.is_empty()) {
        stage = first();
        candidates = stage.candidates(gains);
        stage.model = base.clone();
    }
    // what they took up is left now
    if !lost.is_empty() && !unexplained {
        left = stage.left(samples).0;
        unexplained = beyond(left, &named);
    }
    out.extend(lost);
    let mut causes: Vec<Cause> = named.into_iter().map(|(cause, _)| cause).collect();
    let judged = |c: &&Candidate| out.iter().all(|o| o.effect.name != c.effect.name);
    let seen = candidates.iter().filter(judged).filter(|c| sees(&c.effect));
    let mut rest: Vec<Cause> = seen.map(|c| c.cause(Verdict::NotNeeded)).collect();
    rest.sort_by(|a, b| b.score.total_cmp(&a.score));
    causes.extend(out.into_iter().chain(rest).chain(unseen));
    Naming { causes, extended: stage.model, alarm, left, unexplained }
}
