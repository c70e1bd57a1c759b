//! Relative error of both wheels' spin inertia.

use super::Effect;
use crate::diagnose::world::Parameter;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "wheel_inertia",
    sentence: "the wheels are heavier to spin up than the bike file says",
    unit: "1",
    alike: &[],
    separate_by: "hard braking and coasting in one ride",
    parameter: Parameter {
        name: "wheel_inertia",
        scale: 0.3,
        prior: 3.0,
        get: |w| w.inertia_error,
        set: |w, value| w.inertia_error = value,
    },
};
