//! Slope along the first straight's heading, rise over run.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "road_grade",
    sentence: "the road climbs along the strip",
    unit: "1",
    alike: &["wind"],
    separate_by: "coasting from more than 20 m/s, or the altitude",
    parameter: Parameter {
        name: "road_grade",
        scale: 0.003,
        prior: 3.0,
        get: |w| w.grade,
        set: |w, value| w.grade = value,
    },
};
