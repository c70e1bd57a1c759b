//! Relaxation length of the front tyre.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "relaxation_length",
    sentence: "the front tyre answers later than assumed",
    unit: "m",
    alike: &[],
    separate_by: "quick changes of lean",
    parameter: Parameter {
        name: "relaxation_length",
        scale: 0.15,
        prior: 3.0,
        get: |w| w.relaxation_length[0],
        set: |w, value| w.relaxation_length[0] = value,
    },
};
