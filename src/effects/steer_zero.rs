//! Zero of the steering sensor.

use super::Effect;
use super::Level;
use super::remove::add;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "steer_zero",
    sentence: "the steering sensor does not read zero straight on",
    unit: "rad",
    typical: 0.005,
    bounds: [-0.05, 0.05],
    source: "potentiometers are set to a degree",
    enters: "handlebar angle",
    channels: &[Channel::SteerAngle, Channel::VelocityY, Channel::YawRate],
    kinds: &[ManoeuvreKind::Cornering, ManoeuvreKind::Coasting],
    alike: &[],
    separate_by: "straight running",
    level: Level::Bike,
    get: |d| d.steer_zero,
    set: |d, value| d.steer_zero = value,
    undo: Some(|session, _, value| add(session, Channel::SteerAngle, |_, _| value)),
};
