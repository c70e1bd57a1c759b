//! Leaning steadily in a corner.

use crate::contract::reason::{Reason, ReasonCode};
use serde::{Deserialize, Serialize};

use super::declaration::{Course, Declaration, Direction, Peak, Terrain};
use super::detector::{Claim, Detector, Verdict};
use super::features::Features;
use super::mask::{drop_short, hysteresis, runs};

pub(super) static CORNERING: Declaration = Declaration {
    name: "cornering",
    words: "cornering",
    description: "Leaning steadily in a corner; off-road from the braking manoeuvre before its slowest point to the end of the drive after it.",
    letter: "\u{21b6}\u{21b7}",
    letter_by_side: Some(["\u{21b6}", "\u{21b7}"]),
    colour: "#2472b3",
    colour_dark: "#5aa3de",
    terrain: Terrain::Both,
    course: Course::Bend,
    brakes: [false, false],
    peak: Peak::Roll,
    force_row: Some(2),
};

/// Time about the apex that is enough of a corner which is braked into and driven out of, s: seven samples of the fit.
const APEX: f64 = 0.5;

/// Thresholds of corners.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// A lean beyond this is a corner, rad.
    pub lean: f64,
    /// The corner ends below this, rad: riders lean that far while going straight.
    pub lean_end: f64,
    /// Shortest, s.
    pub shortest: f64,
    /// Rolling faster than this next to a corner is rolling in or out, rad/s.
    pub roll_rate: f64,
    /// Steady is a roll rate below this, rad/s: the slip angles lag it by less than a degree.
    pub steady_roll_rate: f64,
    /// Uncombined is an acceleration below this, m/s²: a slip of about 1 %.
    pub uncombined_acceleration: f64,
    /// Share of a corner that must be steady and uncombined for it to be used; of steady lean alone where both last 0.5 s.
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

/// Blocks in left-hand and in right-hand corners.
fn by_side(f: &Features, config: &Config) -> [Vec<bool>; 2] {
    // each side for itself: a chicane is two corners
    let mut left = hysteresis(f.lean.iter().map(|l| -l), config.lean, config.lean_end);
    let mut right = hysteresis(f.lean.iter().copied(), config.lean, config.lean_end);
    let least = f.blocks(config.shortest);
    drop_short(&mut left, least);
    drop_short(&mut right, least);
    [left, right]
}

/// Blocks in a corner of either side.
pub(crate) fn bends(f: &Features, config: &Config) -> Vec<bool> {
    let [left, right] = by_side(f, config);
    left.iter().zip(&right).map(|(l, r)| *l || *r).collect()
}

impl Detector for Config {
    fn find(&self, f: &Features) -> Vec<Claim> {
        let [left, right] = by_side(f, self);
        let claims = |mask: &[bool], side: Direction| -> Vec<Claim> {
            let claim = |at| Claim { at, kind: &CORNERING, direction: Some(side) };
            runs(mask).into_iter().map(claim).collect()
        };
        [claims(&left, Direction::Left), claims(&right, Direction::Right)].concat()
    }

    fn judge(&self, f: &Features, claim: &Claim, braked: &[bool]) -> Verdict {
        let all = claim.at.len() as f64;
        let count = |test: &dyn Fn(usize) -> bool| {
            claim.at.clone().filter(|&i| test(i)).count() as f64 / all
        };
        let is_steady = |i: usize| f.lean_rate[i].abs() < self.steady_roll_rate;
        let is_uncombined =
            |i: usize| f.acceleration[i].abs() < self.uncombined_acceleration && !braked[i];
        let (steady, uncombined) = (count(&is_steady), count(&is_uncombined));
        let both = count(&|i| is_steady(i) && is_uncombined(i));
        let apex = both * all / f.rate >= APEX && steady >= self.least_share;
        let reason = if both >= self.least_share || apex {
            None
        } else if uncombined < steady {
            Some(Reason::new(
                ReasonCode::Combined,
                format!(
                    "braking or accelerating while leaning for {:.0} % of it",
                    100.0 * (1.0 - uncombined)
                ),
            ))
        } else {
            Some(Reason::new(
                ReasonCode::NotSteady,
                format!("rolling for {:.0} % of it: no steady lean", 100.0 * (1.0 - steady)),
            ))
        };
        Verdict { quality: both * (all / f.rate / 3.0).min(1.0), reason }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks per second.
    const RATE: f64 = 25.0;

    /// Why a corner is refused; of its parts length (s), acceleration (m/s²) and roll rate (rad/s).
    fn refused(parts: &[(f64, f64, f64)]) -> Option<ReasonCode> {
        let mut f = Features { rate: RATE, ..Features::default() };
        for &(seconds, acceleration, roll_rate) in parts {
            let blocks = (seconds * RATE).round() as usize;
            f.acceleration.extend(vec![acceleration; blocks]);
            f.lean_rate.extend(vec![roll_rate; blocks]);
        }
        let n = f.acceleration.len();
        let side = Some(Direction::Left);
        let claim = Claim { at: 0..n, kind: &CORNERING, direction: side };
        Config::default().judge(&f, &claim, &vec![false; n]).reason.map(|reason| reason.code)
    }

    #[test]
    fn a_corner_that_is_braked_into_and_driven_out_of_is_used_about_its_apex() {
        let apex = |seconds| refused(&[(2.0, -4.0, 0.2), (seconds, 0.5, 0.0), (2.4, 3.0, 0.1)]);
        assert_eq!(apex(0.6), None);
        assert_eq!(apex(0.4), Some(ReasonCode::Combined));
        // as long an apex of a motorcycle that sways from side to side is none
        let swaying = [(2.0, 0.0, 0.6), (0.6, 0.0, 0.1), (2.4, 0.0, -0.6)];
        assert_eq!(refused(&swaying), Some(ReasonCode::NotSteady));
    }
}
