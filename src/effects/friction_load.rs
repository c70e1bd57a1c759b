//! Load sensitivity of friction.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "friction_load",
    sentence: "friction falls with load",
    unit: "1",
    typical: 0.15,
    bounds: [-0.3, 0.6],
    source: "0.05 to 0.2 per doubled load, Pacejka 2012, section 4.3",
    enters: "friction curve of both tyres",
    channels: &[
        Channel::BrakePressureFront,
        Channel::BrakePressureRear,
        Channel::WheelSpeedFront,
        Channel::WheelSpeedRear,
    ],
    kinds: &[
        ManoeuvreKind::FrontBraking,
        ManoeuvreKind::RearBraking,
        ManoeuvreKind::CombinedBraking,
    ],
    alike: &["lift"],
    separate_by: "the same slip at different loads",
    level: Level::Bike,
    get: |d| d.friction_per_load,
    set: |d, value| d.friction_per_load = value,
    undo: None,
};
