//! Height of the drag above the mass centre.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "drag_height",
    sentence: "the air pushes higher than the mass centre",
    unit: "m",
    alike: &["lift"],
    separate_by: "coasting and braking above 30 m/s",
    parameter: Parameter {
        name: "drag_height",
        scale: 0.3,
        prior: 3.0,
        get: |w| w.drag_height,
        set: |w, value| w.drag_height = value,
    },
};
