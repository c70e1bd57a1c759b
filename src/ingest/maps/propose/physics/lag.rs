//! The delay of one speed after another, apart from slip.
//!
//! A driven or braked wheel runs ahead of the speed over ground by a slip that goes with the acceleration: beside
//! `L a` of a delay `L` there is `c v a` of slip, and a correlation of their changes would take the one for the other.
//! Both are fitted, with the wheel's smaller radius on the tyre's side and the antenna's shorter way in corners:
//!
//! ```text
//! v(t + L) = k w + c w min(a, 0) + d w max(a, 0) + e w (1 - cos(p)) + h tan(p) sin(p) / w       tan(p) = lateral / g
//! ```
//!
//! `d` only for a wheel that is driven. Hard braking, where slip is not proportional any more, is left out.

use nalgebra::{DMatrix, DVector};

use super::delay::{Delay, halves_error};
use super::signal::{self, RATE};
use crate::GRAVITY;
use crate::statistics::order;

/// Longest delay that is looked for, s.
const LONGEST: f64 = 1.0;
/// Accelerations in which slip is proportional, m/s²: of a free wheel also those of hard drive.
const FREE: std::ops::Range<f64> = -3.0..8.0;
const DRIVEN: std::ops::Range<f64> = -3.0..3.0;
/// Standard error of a delay after a wheel, s: what slip leaves on simulated rides of known delay.
const ERROR: f64 = 0.03;
/// The same of a wheel that is driven, s.
const ERROR_DRIVEN: f64 = 0.04;
/// The same where nothing tells corners from straights, s: a wheel runs ahead in them by up to 5 %, as a delay would have it.
const ERROR_BLIND: f64 = 0.12;
/// Fewest points of a fit: 10 s.
const LEAST: usize = 200;
/// Steps of lags on either side of the best that are fitted robustly.
const FINE: i64 = 4;
/// Beyond so many standard deviations a point counts less.
const HUBER: f64 = 2.0;

/// A wheel's speed and what its slip goes with, all on the same clock.
pub(super) struct Wheel<'a> {
    /// Speed by the wheel's spin, m/s.
    pub speed: &'a [f64],
    /// Forward acceleration, m/s².
    pub acceleration: &'a [f64],
    /// Lateral acceleration, m/s²; zeros where it is not known.
    pub lateral: &'a [f64],
    /// Whether the engine drives it.
    pub driven: bool,
}

/// The delay of a speed over ground (m/s) after a wheel's; `None` where they do not go together.
///
/// Its error covers what the halves of the log say by themselves.
pub(super) fn lag(wheel: &Wheel<'_>, speed: &[f64]) -> Option<Delay> {
    let range = if wheel.driven { DRIVEN } else { FREE };
    let keep = |i: usize| wheel.speed[i] > 5.0 && range.contains(&wheel.acceleration[i]);
    let terms = terms(wheel);
    let (value, r) = lowest(&terms, speed, keep)?;
    let middle = speed.len() / 2;
    let halves =
        [true, false].map(|first| lowest(&terms, speed, |i| keep(i) && (i < middle) == first));
    let least = match (wheel.driven, wheel.lateral.iter().any(|a| *a != 0.0)) {
        (_, false) => ERROR_BLIND,
        (true, _) => ERROR_DRIVEN,
        _ => ERROR,
    };
    Some(Delay { value, error: halves_error(halves.map(|h| h.map(|h| h.0)), least), r })
}

fn terms(wheel: &Wheel<'_>) -> Vec<Vec<f64>> {
    let of = |f: &dyn Fn(usize) -> f64| (0..wheel.speed.len()).map(f).collect::<Vec<f64>>();
    let (w, a) = (wheel.speed, wheel.acceleration);
    let lean = of(&|i| {
        let f = wheel.lateral[i] / GRAVITY;
        if f.is_finite() { f.atan() } else { 0.0 }
    });
    let mut all = vec![w.to_vec(), of(&|i| w[i] * a[i].min(0.0))];
    if wheel.driven {
        all.push(of(&|i| w[i] * a[i].max(0.0)));
    }
    if lean.iter().any(|p| *p != 0.0) {
        all.push(of(&|i| w[i] * (1.0 - lean[i].cos())));
        all.push(of(&|i| lean[i].tan() * lean[i].sin() / w[i].max(3.0)));
    }
    all
}

/// The lag of least squares of `y(t + lag)` on the terms, s, and how much they explain, as a correlation.
///
/// `keep` says which points of the terms count.
pub(super) fn lowest(
    terms: &[Vec<f64>],
    y: &[f64],
    keep: impl Fn(usize) -> bool,
) -> Option<(f64, f64)> {
    let rows: Vec<usize> =
        (0..y.len()).filter(|&i| keep(i) && terms.iter().all(|t| t[i].is_finite())).collect();
    let most = (LONGEST * RATE) as i64;
    let cost = |lag: i64, limit: f64| Fit::of(terms, y, &rows, lag)?.cost(terms, y, limit);
    let coarse = (-most..=most).step_by(2).filter_map(|lag| Some((lag, cost(lag, f64::INFINITY)?)));
    let (around, _) = coarse.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let middle = Fit::of(terms, y, &rows, around)?;
    let limit = HUBER * middle.spread.max(1e-9);
    let fine: Vec<(i64, f64)> =
        (around - FINE..=around + FINE).filter_map(|lag| Some((lag, cost(lag, limit)?))).collect();
    let best = (0..fine.len()).min_by(|i, j| fine[*i].1.total_cmp(&fine[*j].1))?;
    let (before, after) = (fine.get(best.checked_sub(1)?)?, fine.get(best + 1)?);
    let (y0, y1, y2) = (before.1, fine[best].1, after.1);
    let bend = y0 - 2.0 * y1 + y2;
    if bend <= 0.0 {
        return None;
    }
    let place = fine[best].0 as f64 + 0.5 * (y0 - y2) / bend;
    Some((place / RATE, middle.r))
}

/// A robust fit at one lag.
struct Fit {
    rows: Vec<(usize, usize)>,
    found: DVector<f64>,
    /// Robust standard deviation of the residuals.
    spread: f64,
    r: f64,
}

impl Fit {
    fn of(terms: &[Vec<f64>], y: &[f64], rows: &[usize], lag: i64) -> Option<Fit> {
        let shifted = |i: usize| usize::try_from(i as i64 + lag).ok().filter(|j| *j < y.len());
        let rows: Vec<(usize, usize)> = rows
            .iter()
            .filter_map(|&i| Some((i, shifted(i)?)))
            .filter(|(_, j)| y[*j].is_finite())
            .collect();
        if rows.len() < LEAST {
            return None;
        }
        let mut fit =
            Fit { found: DVector::zeros(terms.len()), spread: f64::INFINITY, r: 0.0, rows };
        for _ in 0..3 {
            fit.found = fit.solved(terms, y)?;
            let off: Vec<f64> = fit.left(terms, y).collect();
            fit.spread = order::spread_about(&off, 0.0);
        }
        let mean = fit.rows.iter().map(|r| y[r.1]).sum::<f64>() / fit.rows.len() as f64;
        let whole: f64 = fit.rows.iter().map(|r| (y[r.1] - mean).powi(2)).sum();
        let left: f64 = fit.left(terms, y).map(|x| x * x).sum();
        fit.r = (1.0 - left / whole).max(0.0).sqrt();
        Some(fit)
    }

    fn left<'a>(&'a self, terms: &'a [Vec<f64>], y: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let of = |i: usize| terms.iter().zip(self.found.iter()).map(|(t, f)| t[i] * f).sum::<f64>();
        self.rows.iter().map(move |(i, j)| y[*j] - of(*i))
    }

    /// Least squares, points that were far off weighing less.
    fn solved(&self, terms: &[Vec<f64>], y: &[f64]) -> Option<DVector<f64>> {
        let k = terms.len();
        let limit = HUBER * self.spread;
        let off: Vec<f64> = self.left(terms, y).collect();
        let (mut normal, mut right) = (DMatrix::<f64>::zeros(k, k), DVector::<f64>::zeros(k));
        for ((i, j), off) in self.rows.iter().zip(off) {
            let weight = if off.abs() > limit { limit / off.abs() } else { 1.0 };
            for a in 0..k {
                let x = weight * terms[a][*i];
                right[a] += x * y[*j];
                for b in 0..=a {
                    normal[(a, b)] += x * terms[b][*i];
                }
            }
        }
        normal.fill_upper_triangle_with_lower_triangle();
        (0..k).for_each(|a| normal[(a, a)] *= 1.0 + 1e-12);
        Some(normal.cholesky()?.solve(&right))
    }

    /// Mean loss of Huber.
    fn cost(&self, terms: &[Vec<f64>], y: &[f64], limit: f64) -> Option<f64> {
        let loss =
            |x: f64| if x.abs() < limit { 0.5 * x * x } else { limit * (x.abs() - 0.5 * limit) };
        let sum: f64 = self.left(terms, y).map(loss).sum();
        Some(sum / self.rows.len() as f64)
    }
}

/// An engine's speed as that of the rear wheel: divided by the ratios that it keeps to the speed.
#[derive(Debug)]
pub(super) struct Gearing {
    /// Engine speed (the log's unit) per m/s, the shortest gear first.
    pub ratios: Vec<f64>,
    /// Share of the time in which one of them holds.
    pub share: f64,
    /// The speed that follows, m/s; NaN between gears.
    pub speed: Vec<f64>,
}

/// Half width of a ratio's peak, relative.
const PEAK_HALF_WIDTH: f64 = 0.035;
/// Width of a bin of the logarithm of ratios.
const BIN: f64 = 0.01;

/// The few ratios that a channel keeps to the speed, if it does.
pub(super) fn gearing(engine: &[f64], v: &[f64]) -> Option<Gearing> {
    let log: Vec<f64> = engine
        .iter()
        .zip(v)
        .map(|(n, v)| if *v > 6.0 && *n > 0.0 { (n / v).ln() } else { f64::NAN })
        .collect();
    let pace = signal::change(&log, 4);
    let steady: Vec<f64> =
        log.iter().zip(&pace).filter(|(_, p)| p.abs() < 0.08).map(|(l, _)| *l).collect();
    if steady.len() < 400 {
        return None;
    }
    let low = steady.iter().copied().fold(f64::INFINITY, f64::min);
    let high = steady.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let bins = ((high - low) / BIN).ceil() as usize + 1;
    if bins > 2000 {
        return None;
    }
    let mut count = vec![0_usize; bins];
    steady.iter().for_each(|l| count[((l - low) / BIN) as usize] += 1);
    let reach = (PEAK_HALF_WIDTH / BIN).round() as usize;
    let mass = |i: usize| -> usize {
        count[i.saturating_sub(reach)..(i + reach + 1).min(bins)].iter().sum()
    };
    let mut order: Vec<usize> = (0..bins).collect();
    order.sort_by_key(|i| std::cmp::Reverse(mass(*i)));
    let mut peaks: Vec<usize> = Vec::new();
    for i in order {
        let apart = peaks.iter().all(|p| p.abs_diff(i) > 2 * reach);
        if apart && mass(i) * 40 > steady.len() && peaks.len() < 7 {
            peaks.push(i);
        }
    }
    let mut centres: Vec<f64> = peaks
        .iter()
        .filter_map(|p| {
            let middle = low + (*p as f64 + 0.5) * BIN;
            let near =
                steady.iter().copied().filter(|l| (l - middle).abs() < 2.0 * PEAK_HALF_WIDTH);
            order::median(&mut near.collect::<Vec<f64>>())
        })
        .collect();
    centres.sort_by(|a, b| b.total_cmp(a));
    let of = |l: f64| centres.iter().find(|c| (l - **c).abs() < PEAK_HALF_WIDTH);
    let share = steady.iter().filter(|l| of(**l).is_some()).count() as f64 / steady.len() as f64;
    let speed = engine
        .iter()
        .zip(log.iter().zip(&pace))
        .map(|(n, (l, p))| match of(*l) {
            Some(c) if p.abs() < 0.3 => n / c.exp(),
            _ => f64::NAN,
        })
        .collect();
    Some(Gearing { ratios: centres.iter().map(|c| c.exp()).collect(), share, speed })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ingest::maps::propose::physics::signal::change;

    fn at(shift: f64) -> Vec<f64> {
        let of = |t: f64| {
            30.0 + 14.0 * (0.25 * t).sin() + 5.0 * (0.8 * t).sin() + 2.0 * (1.7 * t + 1.0).cos()
        };
        (0..6000).map(|i| of(f64::from(i) / RATE - shift)).collect()
    }

    #[test]
    fn slip_is_not_taken_for_a_delay() {
        let v = at(0.0);
        let a = change(&v, 1);
        for (late, slip) in [(0.2, 0.0), (0.2, 0.004), (0.0, 0.004), (-0.1, 0.002)] {
            let speed: Vec<f64> =
                v.iter().zip(&a).map(|(v, a)| v * (1.0 + slip * a.min(0.0))).collect();
            let acceleration = change(&speed, 5);
            let lateral = vec![0.0; v.len()];
            let wheel = Wheel {
                speed: &speed,
                acceleration: &acceleration,
                lateral: &lateral,
                driven: false,
            };
            let found = lag(&wheel, &at(late)).expect("found");
            assert!((found.value - late).abs() < 0.015, "{late} {slip}: {found:?}");
        }
    }

    #[test]
    fn gears_are_told_from_the_ratios_that_an_engine_keeps() {
        let v = at(0.0);
        let gear = |v: f64| if v < 25.0 { 250.0 } else { 180.0 };
        let engine: Vec<f64> = v.iter().map(|v| gear(*v) * v).collect();
        let found = gearing(&engine, &v).expect("found");
        assert_eq!(found.ratios.iter().map(|r| r.round()).collect::<Vec<f64>>(), [250.0, 180.0]);
        assert!(found.share > 0.95, "{}", found.share);
        let other: Vec<f64> =
            (0..6000).map(|i| 5000.0 + 3000.0 * (f64::from(i) * 0.011).sin()).collect();
        assert!(gearing(&other, &v).is_none_or(|g| g.share < GEARED_AT_LEAST));
    }

    const GEARED_AT_LEAST: f64 = 0.7;
}
