//! In neutral, no brake, straight.
//!
//! With a gear channel: neutral and no brake. Without: neither drive nor brake to be seen,
//! that is a deceleration as drag and rolling resistance give it and wheels that turn at the
//! ratio of their radii.

use crate::contract::reason::{Reason, ReasonCode};
use serde::{Deserialize, Serialize};

use super::declaration::{Course, Declaration, Peak, Terrain};
use super::detector::{Claim, Detector, Verdict};
use super::features::Features;
use super::mask::{close_holes, drop_short, hysteresis, runs};

pub(super) static COASTING: Declaration = Declaration {
    name: "coasting",
    words: "coasting",
    description: "In neutral, no brake, straight.",
    letter: "C",
    letter_by_side: None,
    colour: "#6b7f93",
    colour_dark: "#8fa3b8",
    terrain: Terrain::Road,
    course: Course::Straight,
    brakes: [false, false],
    peak: Peak::Acceleration,
    force_row: None,
};

/// Thresholds of coasting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Without a gear channel: drive or brake below this is none, m/s².
    pub push: f64,
    /// It has ended above this, m/s².
    pub push_end: f64,
    /// Acceleration beyond coasting that ends it at once, m/s²: slopes stay below.
    pub surplus: f64,
    /// Acceleration beyond coasting may change by this much in 0.6 s, m/s².
    pub change: f64,
    /// Acceleration beyond coasting at which its ends are set, m/s².
    pub edge: f64,
    /// A throttle beyond this drives, 1.
    pub throttle: f64,
    /// Shortest, s.
    pub shortest: f64,
    /// Shortest that is used, s.
    pub shortest_used: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            push: 0.07,
            push_end: 0.10,
            surplus: 0.2,
            throttle: 0.02,
            change: 0.10,
            edge: 0.15,
            shortest: 1.0,
            shortest_used: 1.0,
        }
    }
}

/// Blocks in which nothing drives; [`braking`](super::braking) comes before it.
fn rolls_freely(f: &Features, config: &Config) -> Vec<bool> {
    if let Some(gear) = &f.gear {
        return gear.iter().map(|g| *g < 0.5).collect();
    }
    let open = |i: usize| f.throttle.as_ref().is_some_and(|t| t[i] > config.throttle);
    let closed = |i: usize| !open(i);
    let span = f.blocks(0.3);
    let last = f.len().saturating_sub(1);
    // drive that only passes through zero changes on the way
    let even = |i: usize| {
        let (before, after) = (i.saturating_sub(span), (i + span).min(last));
        (f.surplus[after] - f.surplus[before]).abs() < config.change
    };
    // minus the size: large is free
    let free = (0..f.len()).map(|i| {
        let push = f.push[i].abs();
        let surplus = f.surplus[i].abs();
        // what is missing, beside a gap, is no coasting
        if push.is_nan() || surplus.is_nan() || !closed(i) || surplus >= config.surplus {
            f64::NAN
        } else if even(i) {
            -push
        } else {
            -push.max(1.01 * config.push)
        }
    });
    let mut mask = hysteresis(free, -config.push, -config.push_end);
    // the push is a mean over a second and blurs the ends
    let reach = f.blocks(0.8);
    for run in runs(&mask) {
        let ok = |i: &usize| closed(*i) && f.surplus[*i].abs() < config.edge;
        for i in (run.start.saturating_sub(reach)..run.start).rev().take_while(ok) {
            mask[i] = true;
        }
        for i in (run.end..(run.end + reach).min(f.len())).take_while(ok) {
            mask[i] = true;
        }
    }
    close_holes(&mut mask, f.blocks(0.3));
    drop_short(&mut mask, f.blocks(config.shortest));
    mask
}

impl Detector for Config {
    fn find(&self, f: &Features) -> Vec<Claim> {
        let free = runs(&rolls_freely(f, self));
        free.into_iter().map(|at| Claim::new(at, &COASTING)).collect()
    }

    fn shortest(&self) -> f64 {
        self.shortest
    }

    fn judge(&self, f: &Features, claim: &Claim, _: &[bool]) -> Verdict {
        let seconds = claim.at.len() as f64 / f.rate;
        let reason = (seconds < self.shortest_used).then(|| {
            Reason::new(
                ReasonCode::Short,
                format!("lasts {seconds:.1} s, shorter than {:.1} s", self.shortest_used),
            )
        });
        Verdict { quality: (seconds / 6.0).min(1.0), reason }
    }
}
