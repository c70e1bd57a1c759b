//! Where a motorcycle changes its lean: slaloms, lane changes, and corners with their roll-in and roll-out.

use std::ops::Range;

use super::columns::{MARGIN, NEEDED, acceleration};
use super::config::Config;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::estimate::zeros::Zeros;

/// Lean from which a stretch is in a corner, rad.
const LEANING: f64 = 0.1;
/// Time before and after a change of lean that belongs to it, s.
const AROUND: f64 = 1.5;
/// Time before and after braking, driving or crawling that is left out, s.
const APART: f64 = 0.6;
/// Shortest stretch, s.
const SHORTEST: f64 = 3.0;
/// Least range of lean within a stretch, rad.
const LEAST_RANGE: f64 = 0.08;
/// Over what the roll rate is averaged, s.
const SMOOTH: f64 = 0.3;
/// Over what the forward acceleration is averaged, s.
const SLOW: f64 = 1.0;
/// Line pressure of a brake that is on, Pa.
const PRESSED: f64 = 5e4;

/// Samples of each stretch; `None` where a channel is missing that the fit cannot do without.
pub(crate) fn find(session: &Session, zeros: &Zeros, config: &Config) -> Option<Vec<Range<usize>>> {
    let needed: Vec<&[f64]> = NEEDED.iter().map(|c| session.get(*c)).collect::<Option<_>>()?;
    let lateral = [Channel::AccelerationY, Channel::VelocityY].map(|c| session.get(c));
    if lateral.iter().all(Option::is_none) {
        return None;
    }
    let optional = [Channel::Pitch, Channel::PitchRate].map(|c| session.get(c));
    let whole: Vec<&[f64]> =
        needed.into_iter().chain(lateral.into_iter().chain(optional).flatten()).collect();
    let (rate, n) = (session.rate, session.len);
    let finite: Vec<bool> = (0..n).map(|i| whole.iter().all(|x| x[i].is_finite())).collect();
    let samples = |seconds: f64| ((seconds * rate).round() as usize).max(1);

    let roll = session.get(Channel::Roll)?;
    let speed = session.get(Channel::VelocityX)?;
    let rolling = mean(session.get(Channel::RollRate)?, samples(SMOOTH));
    let driven = mean(&acceleration(session, zeros)?, samples(SLOW));
    let pressures =
        [Channel::BrakePressureFront, Channel::BrakePressureRear].map(|c| session.get(c));
    let is_pressed = |i: usize| pressures.iter().flatten().any(|p| p[i] > PRESSED);
    let lean = |i: usize| (roll[i] - zeros.roll).abs();
    let unfit: Vec<bool> = (0..n)
        .map(|i| {
            let steady = driven[i].abs() <= config.max_acceleration;
            !(steady && speed[i] >= config.min_speed && lean(i) <= config.max_lean) || is_pressed(i)
        })
        .collect();
    let changing: Vec<bool> = (0..n)
        .map(|i| !unfit[i] && (rolling[i].abs() > config.roll_rate || lean(i) > LEANING))
        .collect();
    let near = within(&changing, samples(AROUND));
    let apart = within(&unfit, samples(APART));
    let usable: Vec<bool> = (0..n).map(|i| finite[i] && near[i] && !apart[i]).collect();

    let margin = (MARGIN * rate).ceil() as usize;
    let mut out = Vec::new();
    for run in runs(&finite) {
        if run.len() <= 2 * margin {
            continue;
        }
        // the kernel reaches beyond a stretch, but not beyond the run
        let inner = run.start + margin..run.end - margin;
        for part in runs(&usable[inner.clone()]) {
            let part = inner.start + part.start..inner.start + part.end;
            let (low, high) = part.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), i| {
                (l.min(roll[i]), h.max(roll[i]))
            });
            if part.len() < samples(SHORTEST) || high - low < LEAST_RANGE {
                continue;
            }
            let pieces = part.len().div_ceil(samples(config.longest));
            let cut = |k: usize| part.start + k * part.len() / pieces;
            out.extend((0..pieces).map(|k| cut(k)..cut(k + 1)));
        }
    }
    Some(out)
}

/// Most stretches of a fit: more tell little more and take their time.
const MOST: usize = 40;

/// At most [`MOST`] of them, evenly.
pub(crate) fn thinned(all: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let n = all.len();
    let is_kept = |k: usize| n <= MOST || k * MOST / n != (k + 1) * MOST / n;
    all.into_iter().enumerate().filter(|(k, _)| is_kept(*k)).map(|(_, stretch)| stretch).collect()
}

/// Whether any sample within `reach` is set.
fn within(set: &[bool], reach: usize) -> Vec<bool> {
    let mut out = vec![false; set.len()];
    let mut last: Option<usize> = None;
    for i in 0..set.len() {
        last = if set[i] { Some(i) } else { last };
        out[i] = last.is_some_and(|k| i - k <= reach);
    }
    let mut next: Option<usize> = None;
    for i in (0..set.len()).rev() {
        next = if set[i] { Some(i) } else { next };
        out[i] = out[i] || next.is_some_and(|k| k - i <= reach);
    }
    out
}

/// Runs of set samples.
fn runs(set: &[bool]) -> Vec<Range<usize>> {
    let mut out = Vec::new();
    let mut start = None;
    for (i, is_set) in set.iter().chain([&false]).enumerate() {
        match (start, is_set) {
            (None, true) => start = Some(i),
            (Some(from), false) => {
                out.push(from..i);
                start = None;
            }
            _ => {}
        }
    }
    out
}

/// Centred mean over so many samples; NaN near missing ones and at the ends.
fn mean(x: &[f64], width: usize) -> Vec<f64> {
    let half = width / 2;
    let mut sums = Vec::with_capacity(x.len() + 1);
    let mut missing = Vec::with_capacity(x.len() + 1);
    sums.push(0.0);
    missing.push(0_usize);
    for (i, value) in x.iter().enumerate() {
        let is_missing = !value.is_finite();
        sums.push(sums[i] + if is_missing { 0.0 } else { *value });
        missing.push(missing[i] + usize::from(is_missing));
    }
    (0..x.len())
        .map(|i| {
            let (a, b) = (i.saturating_sub(half), (i + half + 1).min(x.len()));
            if missing[b] > missing[a] { f64::NAN } else { (sums[b] - sums[a]) / (b - a) as f64 }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_runs_and_neighbours() {
        assert_eq!(mean(&[1.0, 2.0, 3.0, f64::NAN], 3)[1], 2.0);
        assert!(mean(&[1.0, 2.0, 3.0, f64::NAN], 3)[2].is_nan());
        assert_eq!(runs(&[false, true, true, false, true]), vec![1..3, 4..5]);
        let near = within(&[false, false, true, false, false, false], 1);
        assert_eq!(near, [false, true, true, true, false, false]);
    }
}
