//! Roll that is missing in the reading.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "roll_zero",
    sentence: "the roll sensor does not read zero upright",
    unit: "rad",
    alike: &["road_bank"],
    separate_by: "bends to both sides",
    parameter: Parameter {
        name: "roll_zero",
        scale: 0.006,
        prior: 3.0,
        get: |w| w.roll_zero,
        set: |w, value| w.roll_zero = value,
    },
};
