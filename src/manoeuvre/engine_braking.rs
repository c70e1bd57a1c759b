//! Slowed by the engine alone, straight: in gear on a closed throttle, no brake.
//!
//! Only the rear tyre brakes, with the engine's drag. Looked for where a throttle is known, or a gear and both
//! pressures: else it looks like a light braking at the rear.

use serde::{Deserialize, Serialize};

use super::declaration::{Course, Declaration, Peak, Terrain};
use super::detector::{Claim, Detector, Verdict};
use super::features::Features;
use super::mask::{close_holes, drop_short, hysteresis, runs};

pub(super) static ENGINE_BRAKING: Declaration = Declaration {
    name: "engine_braking",
    words: "engine braking",
    description: "In gear on a closed throttle, no brake, straight.",
    letter: "E",
    letter_by_side: None,
    colour: "#a0785a",
    colour_dark: "#c49c7c",
    terrain: Terrain::Road,
    course: Course::Straight,
    brakes: [false, false],
    peak: Peak::Acceleration,
    force_row: None,
};

/// Thresholds of engine braking.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Deceleration beyond coasting, m/s².
    pub deceleration: f64,
    /// It has ended below this, m/s².
    pub deceleration_end: f64,
    /// Shortest, s.
    pub shortest: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config { deceleration: 0.5, deceleration_end: 0.3, shortest: 0.5 }
    }
}

impl Detector for Config {
    fn find(&self, f: &Features) -> Vec<Claim> {
        let pressures = f.pressure.iter().all(Option::is_some);
        if f.throttle.is_none() && !(f.gear.is_some() && pressures) {
            return Vec::new();
        }
        let taken = (0..f.len()).map(|i| if f.engine.may[i] { -f.surplus[i] } else { f64::NAN });
        let mut on = hysteresis(taken, self.deceleration, self.deceleration_end);
        close_holes(&mut on, f.blocks(0.2));
        drop_short(&mut on, f.blocks(self.shortest));
        runs(&on).into_iter().map(|at| Claim::new(at, &ENGINE_BRAKING)).collect()
    }

    fn shortest(&self) -> f64 {
        self.shortest
    }

    fn judge(&self, f: &Features, claim: &Claim, _: &[bool]) -> Verdict {
        let peak = claim.at.clone().map(|i| -f.surplus[i]).fold(0.0, f64::max);
        let reason = "slows on a closed throttle in gear: how much of it is the rear tyre's is told by the whole ride \
                      only";
        Verdict { quality: (peak / 3.0).clamp(0.0, 1.0), reason: Some(reason.to_owned()) }
    }
}
