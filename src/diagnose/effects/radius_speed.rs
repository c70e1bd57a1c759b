//! Relative growth of the rolling radii at 20 m/s, quadratic.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "radius_speed",
    sentence: "the tyres grow with speed",
    unit: "1",
    alike: &[],
    separate_by: "rolling freely over a wide range of speed",
    parameter: Parameter {
        name: "radius_speed",
        scale: 0.003,
        prior: 3.0,
        get: |w| w.radius_per_speed,
        set: |w, value| w.radius_per_speed = value,
    },
};
