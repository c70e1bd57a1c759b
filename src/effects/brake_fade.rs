//! Brakes that lose gain within a stop.

use super::Effect;
use super::Level;
use super::model_error::HEAT;
use super::remove::scale;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "brake_fade",
    sentence: "the brakes fade as they warm up within a stop",
    unit: "1",
    typical: 0.06,
    bounds: [-0.3, 0.5],
    source: "organic pads lose 5 to 20 % in one hard stop",
    enters: "brake gain over the heat of the stop",
    channels: &[Channel::BrakePressureFront, Channel::BrakePressureRear],
    kinds: &[
        ManoeuvreKind::FrontBraking,
        ManoeuvreKind::RearBraking,
        ManoeuvreKind::CombinedBraking,
    ],
    alike: &[],
    separate_by: "hard stops from different speeds",
    level: Level::Bike,
    get: |d| d.fade,
    set: |d, value| d.fade = value,
    undo: Some(|session, bike, value| {
        let mass = bike.mass;
        for channel in [Channel::BrakePressureFront, Channel::BrakePressureRear] {
            scale(session, channel, |ride, i| 1.0 - value * mass * ride.brakes[i].stop / HEAT);
        }
    }),
};
