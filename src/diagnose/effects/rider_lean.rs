//! Sideways shift of the mass centre per roll.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "rider_lean",
    sentence: "the rider leans his body with the bike",
    unit: "m/rad",
    alike: &["overturning_stiffness"],
    separate_by: "no ride; a camera",
    parameter: Parameter {
        name: "rider_lean",
        scale: 0.06,
        prior: 3.0,
        get: |w| w.rider_lean,
        set: |w, value| w.rider_lean = value,
    },
};
