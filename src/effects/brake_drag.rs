//! Brakes that drag while warm.

use super::Effect;
use super::Level;
use super::model_error::HEAT;
use super::remove::add;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "brake_drag",
    sentence: "the brakes drag while they are warm",
    unit: "N m",
    typical: 2.0,
    // it cannot push
    bounds: [0.0, 20.0],
    source: "pads that do not come free; a drag that never changes is rolling resistance",
    enters: "torque on both wheels over the heat of past stops",
    channels: &[
        Channel::WheelSpeedFront,
        Channel::WheelSpeedRear,
        Channel::BrakePressureFront,
        Channel::AccelerationX,
    ],
    kinds: &[ManoeuvreKind::Coasting],
    alike: &["rolling_resistance"],
    separate_by: "coasting before and straight after hot stops",
    level: Level::Bike,
    get: |d| d.brake_drag,
    set: |d, value| d.brake_drag = value,
    undo: Some(|session, bike, value| {
        let turned = 1.0 / bike.front.radius + 1.0 / bike.rear.radius;
        add(session, Channel::AccelerationX, |ride, i| value * ride.brakes[i].warm / HEAT * turned);
    }),
};
