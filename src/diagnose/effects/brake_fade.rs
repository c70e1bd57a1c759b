//! Relative loss of brake gain per 50 kJ of a stop.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "brake_fade",
    sentence: "the brakes fade as they warm up within a stop",
    unit: "1",
    alike: &[],
    separate_by: "hard stops from different speeds",
    parameter: Parameter {
        name: "brake_fade",
        scale: 0.06,
        prior: 3.0,
        get: |w| w.fade,
        set: |w, value| w.fade = value,
    },
};
