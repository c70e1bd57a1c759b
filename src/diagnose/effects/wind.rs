//! Head wind along the first straight's heading.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "wind",
    sentence: "a steady wind blows along the strip",
    unit: "m/s",
    alike: &["road_grade"],
    separate_by: "coasting from more than 20 m/s, or a still day",
    parameter: Parameter {
        name: "wind",
        scale: 1.0,
        prior: 3.0,
        get: |w| w.wind,
        set: |w, value| w.wind = value,
    },
};
