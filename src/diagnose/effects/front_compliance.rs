//! Steering angle that is lost per side force.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "front_compliance",
    sentence: "the front frame gives way under side force",
    unit: "rad/N",
    alike: &["side_force_ratio_front", "steer_zero"],
    separate_by: "bends with the brake on",
    parameter: Parameter {
        name: "front_compliance",
        scale: 5e-06,
        prior: 3.0,
        get: |w| w.compliance,
        set: |w, value| w.compliance = value,
    },
};
