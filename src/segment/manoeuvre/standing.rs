//! Where nothing is ridden: no velocity recorded, or too slow for anything to begin.

use super::declaration::{Course, Declaration, Peak, Terrain};
use super::detector::{Claim, Detector, Verdict};
use super::features::Features;
use super::mask::{hysteresis, runs};
use crate::contract::reason::ReasonCode;

pub(super) static OTHER: Declaration = Declaration {
    name: "other",
    words: "other",
    description: "Anything else, standing included.",
    letter: "",
    letter_by_side: None,
    colour: "#b4bac1",
    colour_dark: "#5b6470",
    terrain: Terrain::Both,
    course: Course::Any,
    brakes: [false, false],
    peak: Peak::Acceleration,
    force_row: None,
};

/// Blocks without forward velocity.
#[derive(Debug)]
pub(crate) struct NoVelocity;

impl Detector for NoVelocity {
    fn find(&self, f: &Features) -> Vec<Claim> {
        let missing: Vec<bool> = f.speed.iter().map(|v| !v.is_finite()).collect();
        others(&missing)
    }

    fn judge(&self, _: &Features, _: &Claim, _: &[bool]) -> Verdict {
        Verdict::unusable(ReasonCode::NoVelocity, "no forward velocity recorded")
    }
}

/// Blocks at rest or at walking pace.
#[derive(Debug)]
pub(crate) struct Standing {
    /// Below this speed nothing begins, m/s.
    pub min_speed: f64,
    /// Below this speed everything ends, m/s.
    pub end_speed: f64,
}

impl Detector for Standing {
    fn find(&self, f: &Features) -> Vec<Claim> {
        let moving = hysteresis(f.speed.iter().copied(), self.min_speed, self.end_speed);
        let slow: Vec<bool> = moving.iter().map(|m| !m).collect();
        others(&slow)
    }

    fn judge(&self, _: &Features, _: &Claim, _: &[bool]) -> Verdict {
        Verdict::unusable(
            ReasonCode::Slow,
            format!("standing or slower than {:.1} m/s", self.min_speed),
        )
    }
}

fn others(mask: &[bool]) -> Vec<Claim> {
    runs(mask).into_iter().map(|at| Claim::new(at, &OTHER)).collect()
}
