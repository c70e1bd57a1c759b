//! Twisting stiffness of the front tyre.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "twisting_stiffness",
    sentence: "the front twisting stiffness is not the assumed one",
    unit: "m/rad",
    alike: &["side_force_ratio_front", "side_force_ratio_rear", "stiffness_load"],
    separate_by: "a tyre bench",
    parameter: Parameter {
        name: "twisting_stiffness",
        scale: 0.02,
        prior: 3.0,
        get: |w| w.twisting_stiffness[0],
        set: |w, value| w.twisting_stiffness[0] = value,
    },
};
