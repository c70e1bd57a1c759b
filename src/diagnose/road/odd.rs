//! A manoeuvre against the ride's others: what happened once - a slippery place under one stop, a gust, a bump.
//!
//! ```text
//! mean residual of each manoeuvre and channel, under the nominal model     error sigma / sqrt(blocks)
//! t = its difference from the other manoeuvres of its family, over their scatter
//! ```
//!
//! A robust fit gives such a manoeuvre little weight; here it is a result. The comparison is that of rides
//! ([`difference`](crate::diagnose::reference::difference)), the chance is that of any manoeuvre and channel of the ride
//! (Bonferroni).

use super::base::Base;
use super::residuals::{CHANNELS, UNITS};
use super::samples::{BLOCK, Samples};
use crate::diagnose::reference::difference::{Difference, difference};
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::statistics::number_format::{decimals, fixed};
use crate::store::tables::rows::{Ident, OddManoeuvre};

/// Chance that any manoeuvre of a ride in which nothing happens is said to be odd.
const FALSE_ALARMS: f64 = 0.01;
/// Fewest blocks of a manoeuvre that have a mean: a second.
const FEWEST: usize = 4;
/// Believed scatter between manoeuvres over the error from noise: what the nominal model lacks differs between them.
const SCATTER: f64 = 2.0;

/// The rows of `odd_manoeuvres` of a ride, in order of time.
pub(crate) fn odd_manoeuvres(samples: &Samples, base: &Base, ident: &Ident) -> Vec<OddManoeuvre> {
    let residuals = base.problem(samples).residuals(&base.values);
    let mut tried = Vec::new();
    for (channel, column) in residuals.iter().enumerate() {
        let means: Vec<(f64, f64)> = samples
            .manoeuvres
            .iter()
            .map(|(_, range)| mean(&column[range.start / BLOCK..range.end / BLOCK]))
            .collect();
        for (number, (kind, _)) in samples.manoeuvres.iter().enumerate() {
            let sigma = base.sigma[channel];
            let others = |i: usize| is_alike(samples.manoeuvres[i].0, *kind);
            let value = |i: usize| if others(i) { means[i].0 } else { f64::NAN };
            let values: Vec<f64> = (0..means.len()).map(value).collect();
            let errors: Vec<f64> = means.iter().map(|m| sigma * m.1).collect();
            let known = errors.iter().zip(&values).filter(|(_, v)| v.is_finite());
            let usual: Vec<f64> = known.map(|(e, _)| *e).collect();
            let usual = crate::statistics::order::median_of_finite(&usual).unwrap_or(f64::NAN);
            let by = difference(&values, &errors, |i| i == number, SCATTER * usual);
            tried.extend(by.map(|by| (number, channel, by)));
        }
    }
    let tests = tried.len() as f64;
    let mut rows: Vec<(usize, usize, Difference)> =
        tried.into_iter().filter(|(_, _, by)| by.chance() * tests <= FALSE_ALARMS).collect();
    rows.sort_by_key(|(number, channel, _)| (*number, *channel));
    rows.into_iter()
        .map(|(number, channel, by)| row(samples, ident, number, channel, by, tests))
        .collect()
}

/// Mean of a manoeuvre's blocks, and its error in those of a block.
fn mean(blocks: &[f64]) -> (f64, f64) {
    let known = blocks.iter().filter(|r| r.is_finite());
    let n = known.clone().count();
    match n >= FEWEST {
        true => (known.sum::<f64>() / n as f64, (n as f64).sqrt().recip()),
        false => (f64::NAN, f64::NAN),
    }
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
