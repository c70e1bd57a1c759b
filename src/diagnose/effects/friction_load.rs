//! Change of peak friction per relative change of load.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "friction_load",
    sentence: "friction falls with load",
    unit: "1",
    alike: &["radius_load"],
    separate_by: "the same slip at different loads",
    parameter: Parameter {
        name: "friction_load",
        scale: 0.15,
        prior: 3.0,
        get: |w| w.friction_per_load,
        set: |w, value| w.friction_per_load = value,
    },
};
