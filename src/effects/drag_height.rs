//! Height of the drag.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "drag_height",
    sentence: "the air pushes higher than the mass centre",
    unit: "m",
    typical: 0.3,
    bounds: [-0.6, 1.0],
    source: "the centre of pressure is 0 to 0.3 m above the mass centre",
    enters: "load transfer over speed",
    channels: &[Channel::WheelSpeedFront, Channel::WheelSpeedRear, Channel::VelocityX],
    kinds: &[ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking, ManoeuvreKind::Driving],
    alike: &["lift", "stiffness_load"],
    separate_by: "coasting and braking above 30 m/s",
    level: Level::Bike,
    get: |d| d.drag_height,
    set: |d, value| d.drag_height = value,
    undo: None,
};
