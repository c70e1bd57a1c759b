//! Flattening of the tyres.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "radius_load",
    sentence: "the rolling radius falls under load",
    unit: "1/kN",
    typical: 0.005,
    bounds: [-0.004, 0.04],
    source: "a third of a deflection of 6 mm per kN on 300 mm",
    enters: "rolling radius of both wheels",
    channels: &[Channel::WheelSpeedFront, Channel::WheelSpeedRear, Channel::BrakePressureFront],
    kinds: &[
        ManoeuvreKind::FrontBraking,
        ManoeuvreKind::RearBraking,
        ManoeuvreKind::CombinedBraking,
    ],
    alike: &[],
    separate_by: "braking of the other wheel",
    level: Level::Bike,
    get: |d| d.radius_per_load,
    set: |d, value| d.radius_per_load = value,
    undo: None,
};
