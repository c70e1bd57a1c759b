//! Relative loss of rolling radius per kN.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "radius_load",
    sentence: "the rolling radius falls under load",
    unit: "1/kN",
    alike: &["friction_load"],
    separate_by: "braking of the other wheel",
    parameter: Parameter {
        name: "radius_load",
        scale: 0.005,
        prior: 3.0,
        get: |w| w.radius_per_load,
        set: |w, value| w.radius_per_load = value,
    },
};
