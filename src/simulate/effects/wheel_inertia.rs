//! Spin inertia of the wheels.

use super::physics::{Physics, Remove};
use super::spec::{EffectSpec, Level};
use crate::contract::bike::USUAL_WHEEL_INERTIA;
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct WheelInertia;

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
        for (wheel, usual) in [&mut bike.front, &mut bike.rear].into_iter().zip(USUAL_WHEEL_INERTIA)
        {
            let inertia = wheel.wheel_inertia.unwrap_or(usual);
            wheel.wheel_inertia = Some(Self::wheel_inertia(size, inertia));
        }
    });

    fn wheel_inertia(size: f64, inertia: f64) -> f64 {
        inertia * (1.0 + size)
    }
}
