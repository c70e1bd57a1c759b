//! Spin inertia of the wheels.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "wheel_inertia",
    sentence: "the wheels are harder to spin up than the bike file says",
    unit: "1",
    typical: 0.3,
    bounds: [-0.7, 2.0],
    source: "a wheel's inertia is a guess until it is swung",
    enters: "torque that spins the wheels, and their gyroscopic moment",
    channels: &[Channel::WheelSpeedFront, Channel::WheelSpeedRear, Channel::BrakePressureFront],
    kinds: &[
        ManoeuvreKind::FrontBraking,
        ManoeuvreKind::RearBraking,
        ManoeuvreKind::CombinedBraking,
        ManoeuvreKind::Coasting,
    ],
    alike: &[],
    separate_by: "short hard stops and long gentle ones on the same wheel",
    level: Level::Bike,
    get: |d| d.inertia,
    set: |d, value| d.inertia = value,
    undo: Some(|_, bike, value| {
        for wheel in [&mut bike.front, &mut bike.rear] {
            wheel.wheel_inertia = wheel.wheel_inertia.map(|i| i * (1.0 + value));
        }
    }),
};
