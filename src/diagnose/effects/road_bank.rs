//! Bank, positive when it falls to the left.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "road_bank",
    sentence: "the road is banked",
    unit: "rad",
    alike: &["roll_zero"],
    separate_by: "bends to both sides",
    parameter: Parameter {
        name: "road_bank",
        scale: 0.006,
        prior: 3.0,
        get: |w| w.bank,
        set: |w, value| w.bank = value,
    },
};
