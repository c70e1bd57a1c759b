//! Off-road manoeuvres: flights, whoops, corners, brakings, drives.
//!
//! ```text
//! whoops  >  flight  >  corner (braking, slowest point, exit)  >  braking  >  driving  >  other
//! ```
//! Works on 50 Hz means of what the off-road estimate gave: the flights of the wheels and the
//! braking forces are known by then.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::Segment;
use super::mask::{close_holes, drop_short, hysteresis, runs};
use crate::contract::manoeuvre::{Direction, ManoeuvreKind};
use crate::filter::remove_slow;

/// Settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Shortest flight of both wheels, s.
    pub shortest_flight: f64,
    /// Pitch beyond its mean over a second that makes a wave, rad.
    pub whoops_pitch: f64,
    /// Fewest waves of whoops.
    pub whoops_count: usize,
    /// Speed lost before and won after the slowest point of a corner, m/s.
    pub corner_speed: f64,
    /// Deceleration of a braking, m/s².
    pub braking: f64,
    /// Acceleration of a drive, m/s².
    pub driving: f64,
    /// Shortest braking and drive, s.
    pub shortest: f64,
    /// Share of missing samples beyond which a segment is not used.
    pub missing: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            shortest_flight: 0.15,
            whoops_pitch: 0.06,
            whoops_count: 3,
            corner_speed: 2.0,
            braking: 1.2,
            driving: 0.8,
            shortest: 0.3,
            missing: 0.1,
        }
    }
}

/// What the manoeuvres are found in, sample by sample; NaN where unknown.
#[derive(Debug, Clone, Copy)]
pub struct Ride<'a> {
    /// Hz.
    pub rate: f64,
    /// Forward speed, m/s.
    pub speed: &'a [f64],
    /// Forward acceleration, m/s².
    pub acceleration: &'a [f64],
    /// Nose up, rad.
    pub pitch: &'a [f64],
    /// Both wheels off.
    pub airborne: &'a [bool],
    /// Braking forces, N.
    pub braking: [&'a [f64]; 2],
    /// A force that is missing where the estimate is.
    pub load: &'a [f64],
    /// Yaw rate, where logged, rad/s.
    pub yaw_rate: Option<&'a [f64]>,
}

/// Rate of the means, Hz.
const COARSE: f64 = 50.0;

/// Cuts a ride into segments, in time order, none overlapping, all of it covered.
pub fn run(ride: &Ride<'_>, config: &Config) -> Vec<Segment> {
    let n = ride.load.len();
    let step = (ride.rate / COARSE).round().max(1.0) as usize;
    let rate = ride.rate / step as f64;
    let coarse = |x: &[f64]| -> Vec<f64> {
        x.chunks(step)
            .map(|c| {
                let known = c.iter().filter(|v| v.is_finite());
                known.clone().sum::<f64>() / known.count() as f64
            })
            .collect()
    };
    let speed = coarse(ride.speed);
    let acceleration = smooth(&coarse(ride.acceleration), (0.3 * rate) as usize);
    let mut kinds = vec![ManoeuvreKind::Other; speed.len()];

    let mut driving =
        hysteresis(acceleration.iter().copied(), config.driving, 0.5 * config.driving);
    let mut braking =
        hysteresis(acceleration.iter().map(|a| -a), config.braking, 0.5 * config.braking);
    for mask in [&mut driving, &mut braking] {
        close_holes(mask, (0.1 * rate) as usize);
        drop_short(mask, (config.shortest * rate) as usize);
    }
    paint(&mut kinds, &driving, |_| ManoeuvreKind::Driving);
    let [front, rear] = ride.braking.map(&coarse);
    let sum =
        |x: &[f64], at: &Range<usize>| x[at.clone()].iter().filter(|v| v.is_finite()).sum::<f64>();
    paint(&mut kinds, &braking, |at| {
        let (f, r) = (sum(&front, at), sum(&rear, at));
        match f / (f + r) {
            share if share > 0.85 => ManoeuvreKind::FrontBraking,
            share if share < 0.15 => ManoeuvreKind::RearBraking,
            _ => ManoeuvreKind::CombinedBraking,
        }
    });
    let waves = waves(&coarse(ride.pitch), rate, config);
    for corner in corners(&speed, &acceleration, &waves, rate, config) {
        kinds[corner].fill(ManoeuvreKind::Cornering);
    }
    // a flight is exact to the sample: found on the fine clock, painted last
    for at in runs(&waves) {
        kinds[at].fill(ManoeuvreKind::Whoops);
    }
    let mut fine: Vec<ManoeuvreKind> = (0..n).map(|i| kinds[i / step]).collect();
    for at in runs(ride.airborne) {
        if at.len() as f64 >= config.shortest_flight * ride.rate && !waves[at.start / step] {
            fine[at].fill(ManoeuvreKind::Airborne);
        }
    }
    pieces(&fine, (0.06 * ride.rate) as usize)
        .into_iter()
        .map(|at| segment(ride, at.clone(), fine[at.start], config))
        .collect()
}

fn paint(
    kinds: &mut [ManoeuvreKind],
    mask: &[bool],
    kind: impl Fn(&Range<usize>) -> ManoeuvreKind,
) {
    for at in runs(mask) {
        let kind = kind(&at);
        kinds[at].fill(kind);
    }
}

/// Runs of one kind; a scrap goes to the run before it, unless that is a flight.
fn pieces(kinds: &[ManoeuvreKind], shortest: usize) -> Vec<Range<usize>> {
    let mut out: Vec<Range<usize>> = Vec::new();
    let mut start = 0;
    while start < kinds.len() {
        let end = kinds[start..]
            .iter()
            .position(|k| *k != kinds[start])
            .map_or(kinds.len(), |d| start + d);
        let scrap = end - start < shortest && kinds[start] != ManoeuvreKind::Airborne;
        match out.last_mut() {
            Some(last)
                if kinds[last.start] == kinds[start]
                    || (scrap && kinds[last.start] != ManoeuvreKind::Airborne) =>
            {
                last.end = end;
            }
            _ => out.push(start..end),
        }
        start = end;
    }
    out
}

fn segment(ride: &Ride<'_>, at: Range<usize>, kind: ManoeuvreKind, config: &Config) -> Segment {
    let missing = ride.load[at.clone()].iter().filter(|v| !v.is_finite()).count();
    let missing = missing as f64 / at.len() as f64;
    let reason = if missing > config.missing {
        Some(format!("{:.0} % of its samples have no estimate", 100.0 * missing))
    } else if kind == ManoeuvreKind::Other {
        Some("neither flight, whoops, corner, braking nor drive".to_owned())
    } else {
        None
    };
    let direction = match (kind, ride.yaw_rate) {
        (ManoeuvreKind::Cornering, Some(yaw)) => {
            let turn: f64 = yaw[at.clone()].iter().filter(|v| v.is_finite()).sum();
            (turn != 0.0).then_some(if turn > 0.0 { Direction::Left } else { Direction::Right })
        }
        _ => None,
    };
    Segment {
        kind,
        start: at.start,
        end: at.end,
        direction,
        quality: 1.0 - missing,
        used: reason.is_none(),
        reason,
    }
}

/// Centred mean over `2 half + 1` known values.
fn smooth(x: &[f64], half: usize) -> Vec<f64> {
    (0..x.len())
        .map(|i| {
            let near = &x[i.saturating_sub(half)..(i + half + 1).min(x.len())];
            let known = near.iter().filter(|v| v.is_finite());
            known.clone().sum::<f64>() / known.count() as f64
        })
        .collect()
}

/// Where the pitch swings to and fro: runs of half waves, each high and short enough.
fn waves(pitch: &[f64], rate: f64, config: &Config) -> Vec<bool> {
    let mut swing: Vec<f64> = pitch.iter().map(|v| if v.is_finite() { *v } else { 0.0 }).collect();
    remove_slow(&mut swing, rate, 0.7);
    let mut mask = vec![false; swing.len()];
    // half waves between changes of sign: start, end, height
    let mut halves: Vec<(usize, usize, f64)> = Vec::new();
    let mut start = 0;
    for i in 1..=swing.len() {
        if i == swing.len() || (swing[i] > 0.0) != (swing[start] > 0.0) {
            let height = swing[start..i].iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            halves.push((start, i, height));
            start = i;
        }
    }
    let wave = |h: &(usize, usize, f64)| {
        let length = (h.1 - h.0) as f64 / rate;
        h.2 >= config.whoops_pitch && (0.06..0.5).contains(&length)
    };
    let good: Vec<bool> = halves.iter().map(wave).collect();
    for run in runs(&good) {
        if run.len() >= 2 * config.whoops_count {
            mask[halves[run.start].0..halves[run.end - 1].1].fill(true);
        }
    }
    mask
}

/// From where the braking begins over the slowest point to where the drive ends.
/// Whoops have slowest points of their own.
fn corners(
    speed: &[f64],
    acceleration: &[f64],
    waves: &[bool],
    rate: f64,
    config: &Config,
) -> Vec<Range<usize>> {
    let even = smooth(speed, (0.4 * rate) as usize);
    let sight = (6.0 * rate) as usize;
    let mut out: Vec<Range<usize>> = Vec::new();
    for i in 1..even.len().saturating_sub(1) {
        if waves[i] || !(even[i] <= even[i - 1] && even[i] < even[i + 1]) {
            continue;
        }
        let before = &even[i.saturating_sub(sight)..i];
        let after = &even[i + 1..(i + sight).min(even.len())];
        let highest = |x: &[f64]| x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let lowest = |x: &[f64]| x.iter().copied().fold(f64::INFINITY, f64::min);
        // the slowest point of its surroundings, with a rise to both sides
        let near = (1.5 * rate) as usize;
        let around = &even[i.saturating_sub(near)..(i + near).min(even.len())];
        if highest(before) - even[i] < config.corner_speed
            || highest(after) - even[i] < config.corner_speed
            || even[i] > lowest(around)
        {
            continue;
        }
        let start = (i.saturating_sub(sight)..i)
            .rev()
            .find(|&j| acceleration[j] > -0.25 * config.braking && i - j > near / 3)
            .unwrap_or(i.saturating_sub(sight));
        let end = (i..(i + sight).min(even.len()))
            .find(|&j| acceleration[j] < 0.5 * config.driving && j - i > near / 3)
            .unwrap_or((i + sight).min(even.len()));
        match out.last_mut() {
            Some(last) if last.end > start => last.end = last.end.max(end),
            _ => out.push(start..end),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lap_is_told_apart() {
        let rate = 400.0;
        let n = 400 * 30;
        let t = |i: usize| i as f64 / rate;
        let speed: Vec<f64> = (0..n)
            .map(|i| match t(i) {
                t if t < 5.0 => 12.0,
                t if t < 7.0 => 12.0 - 3.0 * (t - 5.0),
                t if t < 10.0 => 6.0 + 2.0 * (t - 7.0),
                _ => 12.0,
            })
            .collect();
        let acceleration: Vec<f64> = (0..n)
            .map(|i| match t(i) {
                t if (5.0..7.0).contains(&t) => -3.0,
                t if (7.0..10.0).contains(&t) => 2.0,
                t if (26.0..28.0).contains(&t) => -4.0,
                _ => 0.0,
            })
            .collect();
        let airborne: Vec<bool> = (0..n).map(|i| (12.0..12.8).contains(&t(i))).collect();
        let pitch: Vec<f64> = (0..n)
            .map(|i| match t(i) {
                t if (15.0..19.0).contains(&t) => 0.2 * (std::f64::consts::TAU * 2.0 * t).sin(),
                _ => 0.0,
            })
            .collect();
        let (front, zero) = (vec![400.0; n], vec![0.0; n]);
        let ride = Ride {
            rate,
            speed: &speed,
            acceleration: &acceleration,
            pitch: &pitch,
            airborne: &airborne,
            braking: [&front, &zero],
            load: &front,
            yaw_rate: None,
        };
        let segments = run(&ride, &Config::default());
        assert_eq!(segments.first().map(|s| s.start), Some(0));
        assert_eq!(segments.last().map(|s| s.end), Some(n));
        assert!(segments.windows(2).all(|w| w[0].end == w[1].start));
        let found = |kind: ManoeuvreKind| -> Vec<(f64, f64)> {
            segments.iter().filter(|s| s.kind == kind).map(|s| (t(s.start), t(s.end))).collect()
        };
        assert_eq!(found(ManoeuvreKind::Airborne), [(12.0, 12.8)]);
        let near = |got: &[(f64, f64)], start: f64, end: f64, by: f64| {
            assert_eq!(got.len(), 1, "{got:?}");
            assert!((got[0].0 - start).abs() < by && (got[0].1 - end).abs() < by, "{got:?}");
        };
        near(&found(ManoeuvreKind::Whoops), 15.0, 19.0, 0.3);
        near(&found(ManoeuvreKind::Cornering), 5.0, 10.0, 0.4);
        near(&found(ManoeuvreKind::FrontBraking), 26.0, 28.0, 0.4);
    }
}
