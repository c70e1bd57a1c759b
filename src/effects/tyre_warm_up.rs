//! Cold tyres.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "tyre_warm_up",
    sentence: "the tyres grip less while they are cold",
    unit: "1",
    typical: 0.06,
    bounds: [-0.3, 0.5],
    source: "5 to 20 % less for the first minutes",
    enters: "friction over the time of the ride",
    channels: &[Channel::BrakePressureFront, Channel::WheelSpeedFront],
    kinds: &[ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking],
    alike: &[],
    separate_by: "braking to the limit early and late",
    level: Level::Night,
    get: |d| d.cold,
    set: |d, value| d.cold = value,
    undo: None,
};
