//! Lean of the rider's body.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "rider_lean",
    sentence: "the rider leans his body with the bike",
    unit: "m/rad",
    typical: 0.06,
    bounds: [-0.3, 0.3],
    source: "a hanging rider moves the mass centre by 3 to 8 cm",
    enters: "mass centre across the bike over roll",
    channels: &[Channel::Roll, Channel::AccelerationY],
    kinds: &[ManoeuvreKind::Cornering],
    alike: &["overturning_stiffness", "roll_zero", "gyroscopic"],
    separate_by: "no ride; a camera",
    level: Level::Night,
    get: |d| d.rider_lean,
    set: |d, value| d.rider_lean = value,
    undo: None,
};
