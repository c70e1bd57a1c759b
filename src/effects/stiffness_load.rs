//! Load sensitivity of the cornering stiffness.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "stiffness_load",
    sentence: "cornering stiffness per load falls with load",
    unit: "1",
    typical: -0.2,
    bounds: [-0.9, 0.5],
    source: "motorcycle tyres lose 10 to 40 % per doubled load, Pacejka 2012, section 11.6",
    enters: "cornering stiffness per load of both tyres",
    channels: &[
        Channel::SteerAngle,
        Channel::VelocityY,
        Channel::YawRate,
        Channel::AccelerationY,
        Channel::BrakePressureFront,
    ],
    kinds: &[ManoeuvreKind::Cornering],
    alike: &["drag_height"],
    separate_by: "bends with the brake on",
    level: Level::Bike,
    get: |d| d.stiffness_per_load,
    set: |d, value| d.stiffness_per_load = value,
    undo: None,
};
