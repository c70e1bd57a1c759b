//! Brakes that drag while warm.

use super::physics::{Physics, Remove};
use super::ride::{BrakeHistory, HEAT, add_with};
use super::spec::{EffectSpec, Level};
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct BrakeDrag;

impl Physics for BrakeDrag {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the brakes drag while they are warm",
        opposite: "the bike slows less while the brakes are warm",
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
        confounded_with: &["rolling_resistance"],
        separate_by: "coasting before and straight after hot stops",
        level: Level::Bike,
        faint: true,
    };
    const REMOVE: Option<Remove> = Some(|session, bike, size| {
        let turned = 1.0 / bike.front.radius + 1.0 / bike.rear.radius;
        add_with(session, Channel::AccelerationX, |ride, i| {
            size * ride.brakes[i].whole.warm / HEAT * turned
        });
    });

    fn brake_drag(size: f64, torque: f64, mass: f64, brakes: BrakeHistory, _axle: Axle) -> f64 {
        torque + size * mass * brakes.warm / HEAT
    }
}
