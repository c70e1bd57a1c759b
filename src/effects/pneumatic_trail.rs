//! Pneumatic trail of the tyres.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "pneumatic_trail",
    sentence: "the pneumatic trail is not the assumed one",
    unit: "1",
    typical: 0.4,
    bounds: [-1.0, 3.0],
    source: "(12) takes it from the static deflection",
    enters: "yaw moment over side slip",
    channels: &[Channel::YawRate, Channel::AccelerationY],
    kinds: &[ManoeuvreKind::Cornering],
    alike: &["side_force_ratio_front", "side_force_ratio_rear", "twisting_stiffness"],
    separate_by: "a tyre bench",
    level: Level::Bike,
    get: |d| d.trail,
    set: |d, value| d.trail = value,
    undo: None,
};
