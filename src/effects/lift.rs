//! Aerodynamic lift.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "lift",
    sentence: "the air lifts the bike",
    unit: "kg/m",
    typical: 0.05,
    bounds: [-0.3, 0.5],
    source: "lift areas of 0.05 to 0.15 m2, Cossalter 2006, section 3.2",
    enters: "wheel loads over speed",
    channels: &[Channel::WheelSpeedFront, Channel::WheelSpeedRear, Channel::VelocityX],
    kinds: &[ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking, ManoeuvreKind::Cornering],
    alike: &["drag_height", "friction_load"],
    separate_by: "bends above 30 m/s",
    level: Level::Bike,
    get: |d| d.lift,
    set: |d, value| d.lift = value,
    undo: None,
};
