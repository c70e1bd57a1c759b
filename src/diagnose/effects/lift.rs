//! Lift over speed squared, shared by both wheels.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "lift",
    sentence: "the air lifts the bike",
    unit: "kg/m",
    alike: &["drag_height"],
    separate_by: "bends above 30 m/s",
    parameter: Parameter {
        name: "lift",
        scale: 0.05,
        prior: 3.0,
        get: |w| w.lift,
        set: |w, value| w.lift = value,
    },
};
