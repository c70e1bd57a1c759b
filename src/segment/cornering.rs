//! Leaning steadily in a bend, and the rolling in and out of it.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::features::Features;
use super::mask::{drop_short, hysteresis, runs};
use super::{Evidence, Verdict};

/// Settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// A lean beyond this is a bend, rad.
    pub lean: f64,
    /// The bend ends below this, rad: what riders wobble on a straight.
    pub lean_end: f64,
    /// Shortest, s.
    pub shortest: f64,
    /// Rolling faster than this next to a bend is rolling in or out, rad/s.
    pub roll_rate: f64,
    /// Steady is a roll rate below this, rad/s: the slip angles lag it by less than a degree.
    pub steady_roll_rate: f64,
    /// Uncombined is an acceleration below this, m/s²: a slip of about 1 %.
    pub uncombined_acceleration: f64,
    /// Share of a bend that must be steady and uncombined for it to be used.
    pub least_share: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            lean: 0.10,
            lean_end: 0.07,
            shortest: 0.8,
            roll_rate: 0.01,
            steady_roll_rate: 0.25,
            uncombined_acceleration: 1.5,
            least_share: 0.4,
        }
    }
}

/// Where the bike is in a bend.
pub fn detect(f: &Features, config: &Config) -> Vec<bool> {
    // left and right apart: a chicane is two bends
    let mut left = hysteresis(f.lean.iter().map(|l| -l), config.lean, config.lean_end);
    let mut right = hysteresis(f.lean.iter().copied(), config.lean, config.lean_end);
    let least = f.blocks(config.shortest);
    drop_short(&mut left, least);
    drop_short(&mut right, least);
    left.iter().zip(&right).map(|(l, r)| *l || *r).collect()
}

/// Where it rolls into or out of a bend without being in it yet.
pub fn transitions(f: &Features, corners: &[bool], config: &Config) -> Vec<bool> {
    let mut out = vec![false; f.len()];
    let reach = f.blocks(1.5);
    for Range { start, end } in runs(corners) {
        let side = f.lean[(start + end) / 2].signum();
        for i in (start.saturating_sub(reach)..start).rev() {
            let rolls_in = side * f.lean_rate[i] > config.roll_rate;
            if !rolls_in || corners[i] {
                break;
            }
            out[i] = true;
        }
        for i in end..(end + reach).min(f.len()) {
            let rolls_out = side * f.lean_rate[i] < -config.roll_rate;
            if !rolls_out || corners[i] {
                break;
            }
            out[i] = true;
        }
    }
    out
}

/// Whether a bend can be used.
pub fn judge(f: &Features, at: &Range<usize>, evidence: &Evidence, config: &Config) -> Verdict {
    let all = at.len() as f64;
    let count = |test: &dyn Fn(usize) -> bool| at.clone().filter(|&i| test(i)).count() as f64 / all;
    let steady = count(&|i| f.lean_rate[i].abs() < config.steady_roll_rate);
    let uncombined = count(&|i| {
        f.acceleration[i].abs() < config.uncombined_acceleration && !evidence.braking[i]
    });
    let both = count(&|i| {
        f.lean_rate[i].abs() < config.steady_roll_rate
            && f.acceleration[i].abs() < config.uncombined_acceleration
            && !evidence.braking[i]
    });
    let reason = if both >= config.least_share {
        None
    } else if uncombined < steady {
        Some(format!(
            "braking or accelerating while leaning for {:.0} % of it",
            100.0 * (1.0 - uncombined)
        ))
    } else {
        Some(format!("rolling for {:.0} % of it: no steady lean", 100.0 * (1.0 - steady)))
    };
    Verdict { quality: both * (all / f.rate / 3.0).min(1.0), reason }
}
