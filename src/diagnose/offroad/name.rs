//! From gains to names, as on the road (`diagnosis.md`, section 2.5).
//!
//! An alarm is a score beyond what nulls show. Of the candidates that share in it and have a size
//! that can be, the one that gains most is named, together with those that gain nearly as much. It
//! joins the model, everything that is named is fitted again, and what is left is looked at again.

use super::effects::{ALL, Curve};
use super::fit::{Fit, Problem, Value};
use super::null::Calibration;

pub use crate::contract::verdict::Verdict;

/// Least gain of a name, in twice the loss; of every further one, and its share of the first one's: what
/// the first is not exact by must not pass for another cause.
const GAIN: f64 = 30.0;
const FURTHER: (f64, f64) = (50.0, 0.05);
/// Folds of held-out jumps, whoops and corners, and the share of its gain that a name must keep there.
pub const FOLDS: usize = 5;
const HELD: f64 = 0.5;
/// Share of the best gain from which a candidate is an equivalent.
const EQUIVALENT: f64 = 0.8;
/// Share of its gain that a rival keeps beside the named one if it is a cause of its own.
const BESIDE: f64 = 0.3;
/// Standard deviation of a frequency's logarithm from which it is not known.
const VAGUE: f64 = 0.5;
/// Share of a usual size below which a force of the suspension is not worth a name.
const SMALL: f64 = 0.15;

/// One candidate, judged.
#[derive(Debug, Clone)]
pub struct Cause {
    /// Index into [`ALL`].
    pub effect: usize,
    /// What is said of it.
    pub verdict: Verdict,
    /// Its number; absent at the base.
    pub value: Value,
    /// 95 % interval of the number.
    pub interval: Option<[f64; 2]>,
    /// Over one is beyond what nulls show.
    pub score: f64,
    /// Fall of twice the loss when it joined.
    pub gain: f64,
    /// Others that the ride cannot tell from it.
    pub equivalent: Vec<&'static str>,
}

/// What a ride says of its causes.
#[derive(Debug, Clone)]
pub struct Naming {
    /// Every candidate: the named in the order of their naming, then the others by their score.
    pub causes: Vec<Cause>,
    /// The model with what is named.
    pub extended: Fit,
    /// Indices of the named.
    pub named: Vec<usize>,
    /// Largest score before anything was named.
    pub alarm: f64,
    /// Whether there was an alarm that no candidate explains.
    pub unexplained: bool,
}

/// Names the causes of residuals under the base.
pub fn name(problem: &Problem, bare: &[f64], calibration: &Calibration) -> Naming {
    let mut current = problem.fit(bare, &[], None);
    let mut named: Vec<usize> = Vec::new();
    let mut causes: Vec<Cause> = Vec::new();
    let (mut alarm, mut unexplained) = (0.0, false);
    let mut rest: Vec<Cause>;
    let mut rivals: Option<Vec<(&'static str, f64)>> = None;
    loop {
        let mut tried: Vec<(usize, f64, f64, Fit)> = Vec::new();
        for j in (0..ALL.len()).filter(|j| !named.contains(j)) {
            let fit = problem.fit(bare, &with(&named, j), Some(&current));
            let gain = 2.0 * (current.loss - fit.loss);
            tried.push((j, gain, calibration.score(j, gain), fit));
        }
        // a rival that still gains much beside the named one is none
        if let (Some(last), Some(before)) = (causes.last_mut(), &rivals) {
            let still = |name: &str| {
                let old = before.iter().find(|r| r.0 == name).map_or(0.0, |r| r.1);
                let new = tried.iter().find(|t| ALL[t.0].name == name).map_or(0.0, |t| t.1);
                new > BESIDE * old
            };
            last.equivalent.retain(|name| !still(name));
            if last.equivalent.is_empty() {
                last.verdict = Verdict::Named;
            }
        }
        // of one family one alone is named: together they would only share out what is seen
        let related = |j: usize| {
            named.iter().any(|&k| ALL[k].family.is_some() && ALL[k].family == ALL[j].family)
        };
        let top = tried.iter().map(|t| t.2).fold(0.0, f64::max);
        if named.is_empty() {
            alarm = top;
        }
        rest = tried
            .iter()
            .map(|(j, gain, score, fit)| Cause {
                effect: *j,
                verdict: match visible(problem, calibration, &current, *j) {
                    true => Verdict::NotNeeded,
                    false => Verdict::NotIdentifiable,
                },
                value: fit.values[*j].map(|v| v - calibration.bias[*j]),
                interval: interval(problem, fit, &with(&named, *j), *j, calibration),
                score: *score,
                gain: *gain,
                equivalent: Vec::new(),
            })
            .collect();
        if top <= 1.0 {
            break;
        }
        let least = causes.first().map_or(GAIN, |c: &Cause| FURTHER.0.max(FURTHER.1 * c.gain));
        let relevant = |t: &(usize, f64, f64, Fit)| {
            let (j, gain, score, fit) = t;
            let big = fit.values[*j].is_some_and(|v| match problem.curves[*j] {
                // less than the file is usually known to
                Curve::Line(_) => v.abs() > SMALL * ALL[*j].usual,
                // at an end of the frequencies there is only noise to smooth
                Curve::Nodes { .. } => inside(*j, v),
            });
            *score > 1.0 && *gain > least && big && !related(*j)
        };
        let too_much = tried.iter().any(relevant);
        let mut gated: Vec<_> = tried
            .into_iter()
            .filter(|t| relevant(t) && t.3.values[t.0].is_some_and(|v| inside(t.0, v)))
            .collect();
        gated.sort_by(|a, b| b.1.total_cmp(&a.1));
        let sizes: Vec<(usize, f64)> = gated.iter().map(|g| (g.0, g.1)).collect();
        // a cause is one on jumps and whoops that it was not fitted to as well
        let before = problem.held_out(bare, &named, &current, FOLDS);
        let holds = |t: &(usize, f64, f64, Fit)| {
            let joined = with(&named, t.0);
            let sigma = problem.std_errors(&t.3, &joined)[named.len()];
            let known = match problem.curves[t.0] {
                Curve::Line(_) => t.3.values[t.0].is_some_and(|v| v.abs() > 1.96 * sigma),
                Curve::Nodes { .. } => sigma < VAGUE,
            };
            known && before - problem.held_out(bare, &joined, &t.3, FOLDS) > HELD * t.1
        };
        let Some((j, gain, score, fit)) = gated.into_iter().find(holds) else {
            unexplained = named.is_empty() && too_much;
            break;
        };
        let near: Vec<(&'static str, f64)> = sizes
            .into_iter()
            .filter(|g| g.0 != j && g.1 > EQUIVALENT * gain)
            .map(|g| (ALL[g.0].name, g.1))
            .collect();
        causes.push(Cause {
            effect: j,
            verdict: if near.is_empty() { Verdict::Named } else { Verdict::Ambiguous },
            value: None,
            interval: None,
            score,
            gain,
            equivalent: near.iter().map(|n| n.0).collect(),
        });
        rivals = Some(near);
        named.push(j);
        current = fit;
    }
    for cause in &mut causes {
        let j = cause.effect;
        // nor is one that was named itself
        cause.equivalent.retain(|rival| !named.iter().any(|&k| ALL[k].name == *rival));
        if cause.equivalent.is_empty() {
            cause.verdict = Verdict::Named;
        }
        cause.interval = interval(problem, &current, &named, j, calibration);
        cause.value = current.values[j].map(|v| v - calibration.bias[j]);
    }
    rest.sort_by(|a, b| b.score.total_cmp(&a.score));
    causes.extend(rest);
    Naming { causes, extended: current, named, alarm, unexplained }
}

/// Whether a number can be.
fn inside(j: usize, value: f64) -> bool {
    let [low, high] = ALL[j].possible;
    // 2 % inside a range of frequencies, from which a search may stop short
    value > low * if low > 0.0 { 1.02 } else { 1.0 } && value < 0.98 * high
}

fn with(named: &[usize], j: usize) -> Vec<usize> {
    let mut out = named.to_vec();
    out.push(j);
    out
}

/// Whether one of usual size would be beyond the nulls, and its number known to half of itself.
fn visible(problem: &Problem, calibration: &Calibration, current: &Fit, j: usize) -> bool {
    let usual = ALL[j].usual;
    let mut r = vec![0.0; problem.weight.len()];
    problem.curves[j].add(usual, &mut r);
    // what a bike off its file would not explain of it
    let without = problem.fit(&r, &[], None);
    let mut there = current.clone();
    there.values[j] = Some(usual);
    let sigma = problem.std_errors(&there, &[j])[0];
    let most = match problem.curves[j] {
        Curve::Line(_) => 0.5 * usual,
        Curve::Nodes { .. } => VAGUE,
    };
    let gain = 2.0 * without.loss;
    calibration.score(j, gain) > 1.0 && gain > GAIN && sigma < most
}

fn interval(
    problem: &Problem,
    fit: &Fit,
    included: &[usize],
    j: usize,
    calibration: &Calibration,
) -> Option<[f64; 2]> {
    let value = fit.values[j]?;
    let place = included.iter().position(|k| *k == j)?;
    let sigma = problem.std_errors(fit, included)[place];
    if !sigma.is_finite() {
        return None;
    }
    Some(match &problem.curves[j] {
        Curve::Nodes { .. } => [value * (-1.96 * sigma).exp(), value * (1.96 * sigma).exp()],
        Curve::Line(_) => {
            let middle = value - calibration.bias[j];
            [middle - 1.96 * sigma, middle + 1.96 * sigma]
        }
    })
}
