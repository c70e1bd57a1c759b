//! Growth of the tyres with speed.

use super::physics::{Physics, Reach, Remove, Rolling};
use super::ride::scale_with;
use super::spec::{EffectSpec, Level};
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

/// Speed of the stated growth, m/s.
const GROWN_AT: f64 = 20.0;

pub(super) struct RadiusSpeed;

impl Physics for RadiusSpeed {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the tyres grow with speed",
        opposite: "the tyres shrink with speed",
        unit: "1",
        typical: 0.003,
        bounds: [-0.004, 0.03],
        source: "a few per mille at 20 m/s for cross-ply carcasses, less for radial ones",
        enters: "rolling radius of both wheels",
        channels: &[Channel::WheelSpeedFront, Channel::WheelSpeedRear, Channel::VelocityX],
        kinds: &[ManoeuvreKind::Coasting, ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking],
        confounded_with: &[],
        separate_by: "rolling freely over a wide range of speed",
        level: Level::Bike,
        faint: false,
    };
    const TYRES: &[Axle] = &Axle::BOTH;
    const REACH: Reach = Reach::SLIPS;
    const REMOVE: Option<Remove> = Some(|session, _, size| {
        for channel in [Channel::WheelSpeedFront, Channel::WheelSpeedRear] {
            scale_with(session, channel, |ride, i| 1.0 + size * (ride.v[i] / GROWN_AT).powi(2));
        }
    });

    fn relative_radius(size: f64, ratio: f64, rolling: Rolling) -> f64 {
        let grown = rolling.speed / GROWN_AT;
        ratio + size * grown * grown
    }
}
