//! Delay of velocity_x and velocity_y.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "latency",
    sentence: "the velocity comes late",
    unit: "s",
    alike: &[],
    separate_by: "hard braking",
    parameter: Parameter {
        name: "latency",
        scale: 0.015,
        prior: 3.0,
        get: |w| w.latency,
        set: |w, value| w.latency = value,
    },
};
