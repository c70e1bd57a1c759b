//! Change of the rolling resistance coefficient per speed.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "rolling_speed",
    sentence: "rolling resistance rises with speed",
    unit: "s/m",
    alike: &["drag"],
    separate_by: "coasting over a wide range of speed",
    parameter: Parameter {
        name: "rolling_speed",
        scale: 0.0005,
        prior: 3.0,
        get: |w| w.rolling_per_speed,
        set: |w, value| w.rolling_per_speed = value,
    },
};
