//! Spin inertia of the wheels.

use super::physics::{Physics, Remove};
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

pub struct WheelInertia;

impl Physics for WheelInertia {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the wheels are harder to spin up than the bike file says",
        opposite: "the wheels are easier to spin up than the bike file says",
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
        confounded_with: &[],
        separate_by: "short hard stops and long gentle ones on the same wheel",
        level: Level::Bike,
        faint: false,
    };
    const REMOVE: Option<Remove> = Some(|_, bike, size| {
        for wheel in [&mut bike.front, &mut bike.rear] {
            wheel.wheel_inertia = wheel.wheel_inertia.map(|i| Self::wheel_inertia(size, i));
        }
    });

    fn wheel_inertia(size: f64, inertia: f64) -> f64 {
        inertia * (1.0 + size)
    }
}
