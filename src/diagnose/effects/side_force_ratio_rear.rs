//! Side-force ratio of the rear tyre.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "side_force_ratio_rear",
    sentence: "the rear side-force ratio is not the assumed one",
    unit: "1",
    alike: &["side_force_ratio_front", "stiffness_load", "twisting_stiffness"],
    separate_by: "bends with the brake or the throttle on",
    parameter: Parameter {
        name: "side_force_ratio_rear",
        scale: 0.03,
        prior: 3.0,
        get: |w| w.side_force_ratio[1],
        set: |w, value| w.side_force_ratio[1] = value,
    },
};
