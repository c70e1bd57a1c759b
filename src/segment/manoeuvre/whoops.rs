//! Whoops: waves close together, seen in the pitch.

use super::declaration::{Course, Declaration, Peak, Terrain};
use super::detector::Claim;
use super::mask::runs;
use super::offroad::Config;
use crate::filter::remove_slow;

pub(super) static WHOOPS: Declaration = Declaration {
    name: "whoops",
    words: "whoops",
    description: "Over waves close together.",
    letter: "W",
    letter_by_side: None,
    colour: "#8d6e4b",
    colour_dark: "#b8977a",
    terrain: Terrain::OffRoad,
    course: Course::Any,
    brakes: [false, false],
    peak: Peak::Acceleration,
    force_row: Some(1),
};

/// Where the pitch, rad, at `rate` Hz swings to and fro: runs of half waves, each high and short
/// enough.
pub(super) fn waves(pitch: &[f64], rate: f64, config: &Config) -> Vec<bool> {
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

/// Runs of waves.
pub(super) fn whoops(waves: &[bool]) -> Vec<Claim> {
    runs(waves).into_iter().map(|at| Claim::new(at, &WHOOPS)).collect()
}
