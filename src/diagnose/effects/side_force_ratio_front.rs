//! Side-force ratio of the front tyre.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "side_force_ratio_front",
    sentence: "the front side-force ratio is not the assumed one",
    unit: "1",
    alike: &["side_force_ratio_rear", "stiffness_load", "twisting_stiffness", "front_compliance"],
    separate_by: "bends with the brake or the throttle on",
    parameter: Parameter {
        name: "side_force_ratio_front",
        scale: 0.03,
        prior: 3.0,
        get: |w| w.side_force_ratio[0],
        set: |w, value| w.side_force_ratio[0] = value,
    },
};
