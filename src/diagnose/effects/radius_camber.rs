//! Crown radius whose versine leaves the rolling radius.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "radius_camber",
    sentence: "the rolling radius falls with camber",
    unit: "m",
    alike: &[],
    separate_by: "bends with the front wheel rolling freely",
    parameter: Parameter {
        name: "radius_camber",
        scale: 0.02,
        prior: 3.0,
        get: |w| w.radius_crown,
        set: |w, value| w.radius_crown = value,
    },
};
