//! Twisting stiffness of the tyres.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "twisting_stiffness",
    sentence: "the twisting stiffness is not the assumed one",
    unit: "m/rad",
    typical: 0.02,
    bounds: [-0.08, 0.08],
    source: "0.02 to 0.06 m/rad in published tyres, seldom measured",
    enters: "yaw moment over camber",
    channels: &[Channel::YawRate, Channel::AccelerationY, Channel::Roll],
    kinds: &[ManoeuvreKind::Cornering],
    alike: &[
        "cornering_stiffness_front",
        "cornering_stiffness_rear",
        "side_force_ratio_front",
        "side_force_ratio_rear",
        "front_compliance",
        "pneumatic_trail",
    ],
    separate_by: "a tyre bench",
    level: Level::Bike,
    get: |d| d.twisting,
    set: |d, value| d.twisting = value,
    undo: Some(|_, bike, value| {
        bike.front.twisting_stiffness += value;
        bike.rear.twisting_stiffness += value;
    }),
};
