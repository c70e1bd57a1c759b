//! Corners: from where the braking begins over the slowest point to where the drive ends.

use std::ops::Range;

use super::cornering::CORNERING;
use super::detector::Claim;
use super::means::{Means, smooth};
use super::offroad::Config;

/// The slowest point has a rise to both sides within this time, s.
const SIGHT: f64 = 6.0;
/// It is the slowest of its surroundings of this half width, s.
const SLOWEST_HALF_WIDTH_S: f64 = 1.5;

/// Corners. Whoops have slowest points of their own.
pub(super) fn corners(m: &Means, config: &Config) -> Vec<Claim> {
    let even = smooth(&m.speed, m.count(0.4));
    let (sight, near) = (m.count(SIGHT), m.count(SLOWEST_HALF_WIDTH_S));
    let highest = |x: &[f64]| x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = |x: &[f64]| x.iter().copied().fold(f64::INFINITY, f64::min);
    let mut out: Vec<Range<usize>> = Vec::new();
    for i in 1..even.len().saturating_sub(1) {
        if m.waves[i] || !(even[i] <= even[i - 1] && even[i] < even[i + 1]) {
            continue;
        }
        let (first, end) = (i.saturating_sub(sight), (i + sight).min(even.len()));
        let around = &even[i.saturating_sub(near)..(i + near).min(even.len())];
        if highest(&even[first..i]) - even[i] < config.corner_speed
            || highest(&even[i + 1..end]) - even[i] < config.corner_speed
            || even[i] > lowest(around)
        {
            continue;
        }
        let start = (first..i)
            .rev()
            .find(|&j| m.acceleration[j] > -0.25 * config.braking && i - j > near / 3)
            .unwrap_or(first);
        let end = (i..end)
            .find(|&j| m.acceleration[j] < 0.5 * config.driving && j - i > near / 3)
            .unwrap_or(end);
        match out.last_mut() {
            Some(last) if last.end > start => last.end = last.end.max(end),
            _ => out.push(start..end),
        }
    }
    out.into_iter().map(|at| Claim::new(at, &CORNERING)).collect()
}
