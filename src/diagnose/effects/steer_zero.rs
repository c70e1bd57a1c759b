//! Steering angle that is missing in the reading.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "steer_zero",
    sentence: "the steering sensor does not read zero straight on",
    unit: "rad",
    alike: &["front_compliance"],
    separate_by: "straight running",
    parameter: Parameter {
        name: "steer_zero",
        scale: 0.005,
        prior: 3.0,
        get: |w| w.steer_zero,
        set: |w, value| w.steer_zero = value,
    },
};
