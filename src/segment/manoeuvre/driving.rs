//! Under engine power, straight: what is neither corner nor brake nor coasting.

use crate::contract::reason::{Reason, ReasonCode};
use serde::{Deserialize, Serialize};

use super::declaration::{Course, Declaration, Peak, Terrain};
use super::detector::{Claim, Detector, Verdict};
use super::features::Features;

pub(super) static DRIVING: Declaration = Declaration {
    name: "driving",
    words: "driving",
    description: "Under engine power, straight.",
    letter: "D",
    letter_by_side: None,
    colour: "#2e8b57",
    colour_dark: "#5fb98a",
    terrain: Terrain::Both,
    course: Course::Straight,
    brakes: [false, false],
    peak: Peak::Acceleration,
    force_row: Some(6),
};

/// Pieces shorter than this go to their neighbour, s.
const SHORTEST: f64 = 0.3;

/// Thresholds of driving.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Shortest that is used, s.
    pub shortest_used: f64,
    /// Acceleration beyond coasting that must be reached for it to be used, m/s².
    pub least_peak: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config { shortest_used: 0.8, least_peak: 0.8 }
    }
}

impl Detector for Config {
    /// All of the ride: the other detectors come first.
    fn find(&self, f: &Features) -> Vec<Claim> {
        vec![Claim::new(0..f.len(), &DRIVING)]
    }

    fn shortest(&self) -> f64 {
        SHORTEST
    }

    fn judge(&self, f: &Features, claim: &Claim, _: &[bool]) -> Verdict {
        let at = &claim.at;
        let seconds = at.len() as f64 / f.rate;
        let peak = at.clone().map(|i| f.surplus[i]).fold(f64::NEG_INFINITY, f64::max);
        let mean = at.clone().map(|i| f.push[i]).sum::<f64>() / at.len() as f64;
        let reason = if seconds < self.shortest_used {
            Some(Reason::new(
                ReasonCode::Short,
                format!("lasts {seconds:.1} s, shorter than {:.1} s", self.shortest_used),
            ))
        } else if peak == f64::NEG_INFINITY {
            Some(Reason::new(
                ReasonCode::MissingSamples,
                "too near gaps in the velocity to know its acceleration",
            ))
        } else if peak >= self.least_peak {
            None
        } else if mean < -0.3 {
            Some(Reason::new(ReasonCode::EngineBraking, "slows on a closed throttle"))
        } else {
            Some(Reason::new(ReasonCode::Weak, "the speed is held: too little slip to learn from"))
        };
        Verdict { quality: (peak / 3.0).clamp(0.0, 1.0), reason }
    }
}
