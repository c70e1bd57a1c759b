//! Distance ahead of the stated place.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "velocity_lever_arm",
    sentence: "the velocity sensor is not where the bike file says",
    unit: "m",
    alike: &[],
    separate_by: "tight bends",
    parameter: Parameter {
        name: "velocity_lever_arm",
        scale: 0.15,
        prior: 3.0,
        get: |w| w.lever_arm,
        set: |w, value| w.lever_arm = value,
    },
};
