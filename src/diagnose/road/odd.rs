//! A manoeuvre against the ride's others: what happened once - a slippery place under one stop, a gust, a bump.
//!
//! ```text
//! mean residual of a manoeuvre and of the others, under the model fitted without it
//! t = its difference from the others of its family, over their scatter
//! ```
//!
//! One stop of three drags a fit along, and the other two seem odd as well: so the fit is made without it. The comparison is that of rides
//! ([`difference`](crate::diagnose::reference::difference)), the chance is that of any manoeuvre and channel of the ride
//! (Bonferroni).

use rayon::prelude::*;

use super::base::Base;
use super::problem::Problem;
use super::residuals::{CHANNELS, UNITS};
use super::samples::{BLOCK, Samples};
use crate::diagnose::reference::difference::{Difference, difference};
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::statistics::number_format::{decimals, fixed};
use crate::statistics::order::median_of_finite;
use crate::store::tables::rows::{Ident, OddManoeuvre};

/// Chance that any manoeuvre of a ride in which nothing happens is said to be odd.
const FALSE_ALARMS: f64 = 0.01;
/// Fewest blocks of a manoeuvre that have a mean: a second.
const FEWEST: f64 = 4.0;
/// Believed scatter between manoeuvres over the error of a mean from independent blocks: they are not independent, and what
/// the nominal model lacks differs between manoeuvres.
const SCATTER: f64 = 2.5;
/// Difference over its error from which the model is fitted without a manoeuvre.
const SUSPECT: f64 = 1.2;

/// The rows of `odd_manoeuvres` of a ride, in order of time.
pub(crate) fn odd_manoeuvres(samples: &Samples, base: &Base, ident: &Ident) -> Vec<OddManoeuvre> {
    let problem = base.problem(samples);
    let linear = problem.linear(&base.values);
    // the fits without a manoeuvre share them
    problem.accumulate(&linear);
    let numbers = 0..samples.manoeuvres.len();
    let all = || (0..CHANNELS.len()).flat_map(|c| numbers.clone().map(move |n| (n, c)));
    let first: Vec<(usize, Difference)> = all()
        .filter_map(|(n, c)| Some((n, against_others(samples, &linear.residuals[c], n)?)))
        .collect();
    let tests = first.len() as f64;
    let is_suspect = |n: usize| first.iter().any(|(own, by)| *own == n && by.t().abs() > SUSPECT);
    let odd = |n: usize| -> Vec<OddManoeuvre> {
        let kept: Vec<bool> = numbers.clone().map(|k| k != n).collect();
        let without = Problem { only: Some(&kept), ..base.problem(samples) };
        let (mut values, mut linear) = (base.values.clone(), linear.clone());
        for _ in 0..2 {
            let Some((moved, _)) = without.descend(&mut linear, &values) else { break };
            values = moved;
        }
        let by = |c: usize| Some((c, against_others(samples, &linear.residuals[c], n)?));
        (0..CHANNELS.len())
            .filter_map(by)
            .filter(|(_, by)| by.chance() * tests <= FALSE_ALARMS)
            .map(|(c, by)| row(samples, ident, n, c, by, tests))
            .collect()
    };
    let suspects: Vec<usize> = numbers.clone().filter(|n| is_suspect(*n)).collect();
    suspects.into_par_iter().flat_map_iter(odd).collect()
}

/// A manoeuvre's mean residual in a channel less that of the others of its family; `None` where there are too few.
fn against_others(samples: &Samples, column: &[f64], number: usize) -> Option<Difference> {
    let blocks = |n: usize| {
        let range = &samples.manoeuvres[n].1;
        &column[range.start / BLOCK..range.end / BLOCK]
    };
    let kind = samples.manoeuvres[number].0;
    let family: Vec<usize> = (0..samples.manoeuvres.len())
        .filter(|n| is_alike(samples.manoeuvres[*n].0, kind) && mean(blocks(*n)).is_some())
        .collect();
    // noise within the others: what they differ by is in the scatter of their means
    let within: Vec<f64> =
        family.iter().filter(|n| **n != number).map(|n| spread(blocks(*n))).collect();
    let sigma = median_of_finite(&within)?;
    let known = |n: &usize| mean(blocks(*n)).unwrap_or((f64::NAN, f64::NAN));
    let (values, errors): (Vec<f64>, Vec<f64>) = family.iter().map(known).unzip();
    let errors: Vec<f64> = errors.iter().map(|e| sigma * e).collect();
    let scatter = SCATTER * median_of_finite(&errors)?;
    let place = family.iter().position(|n| *n == number)?;
    difference(&values, &errors, |i| i == place, scatter)
}

/// Root mean square of a manoeuvre's blocks about their mean.
fn spread(blocks: &[f64]) -> f64 {
    let known: Vec<f64> = blocks.iter().copied().filter(|r| r.is_finite()).collect();
    let n = known.len() as f64;
    let mean = known.iter().sum::<f64>() / n;
    (known.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
}

/// Mean of a manoeuvre's blocks, and its error in those of a block.
fn mean(blocks: &[f64]) -> Option<(f64, f64)> {
    let known = blocks.iter().filter(|r| r.is_finite());
    let n = known.clone().count() as f64;
    (n >= FEWEST).then(|| (known.sum::<f64>() / n, n.sqrt().recip()))
}

/// Whether manoeuvres of two kinds are compared: every braking is.
fn is_alike(a: ManoeuvreKind, b: ManoeuvreKind) -> bool {
    a == b || a.is_braking() && b.is_braking()
}

fn row(
    samples: &Samples,
    ident: &Ident,
    number: usize,
    channel: usize,
    by: Difference,
    tests: f64,
) -> OddManoeuvre {
    let (kind, range) = &samples.manoeuvres[number];
    let [start, end] = [range.start, range.end - 1].map(|i| samples.time[i]);
    let digits = decimals(by.error);
    let unit = match UNITS[channel] {
        "1" => " standard deviations".to_owned(),
        unit => format!(" {unit}"),
    };
    OddManoeuvre {
        ident: ident.clone(),
        kind: kind.name().to_owned(),
        start,
        end,
        channel: CHANNELS[channel].to_owned(),
        difference: by.size,
        unit: UNITS[channel].to_owned(),
        std_error: by.error,
        t: by.t(),
        chance: (by.chance() * tests).min(1.0),
        sentence: format!(
            "{} at {start:.1} s to {end:.1} s: {} {}{unit} from the ride's others: {}",
            kind.name().replace('_', " "),
            CHANNELS[channel],
            fixed(by.size, digits),
            likely(CHANNELS[channel], *kind, by.size)
        ),
    }
}

/// What usually makes a manoeuvre differ so.
fn likely(channel: &str, kind: ManoeuvreKind, size: f64) -> &'static str {
    let is_braking = kind.is_braking();
    match channel {
        // braking forces and slips are negative
        "slip_front" | "slip_rear" => match (size > 0.0) == is_braking {
            true => "more slip for its force, as on a slippery place or a cold tyre",
            false => "less slip for its force, as on a place with more grip",
        },
        "force_x" => match (is_braking, size > 0.0) {
            (true, true) => {
                "less deceleration for its pressure, as with cold or wet pads, or downhill"
            }
            (true, false) => "more deceleration for its pressure, as with warm pads, or uphill",
            (false, true) => "less resistance, as with a tail wind or downhill",
            (false, false) => "more resistance, as with a gust, uphill, or a dragging brake",
        },
        "lateral_front" | "lateral_rear" => {
            "another slip angle for its force, as on a banked or slippery place or in a gust"
        }
        "roll" => {
            "another lean for its acceleration, as where the road is banked or the rider hangs off"
        }
        _ => "motions that do not agree, as with a bump or a lost position",
    }
}
