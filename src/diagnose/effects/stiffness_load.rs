//! Change of cornering stiffness per load, per relative change of load.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "stiffness_load",
    sentence: "cornering stiffness per load falls with load",
    unit: "1",
    alike: &["side_force_ratio_front", "side_force_ratio_rear", "twisting_stiffness"],
    separate_by: "bends with the brake on",
    parameter: Parameter {
        name: "stiffness_load",
        scale: 0.2,
        prior: 3.0,
        get: |w| w.stiffness_per_load,
        set: |w, value| w.stiffness_per_load = value,
    },
};
