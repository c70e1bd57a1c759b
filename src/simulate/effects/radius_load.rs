//! Flattening of the tyres.

use super::physics::{Multibody, Physics, Reach, Rolling};
use super::spec::{BRAKING, EffectSpec, Level};
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;

pub(super) struct RadiusLoad;

impl Physics for RadiusLoad {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the rolling radius falls more under load than a third of the deflection",
        opposite: "the rolling radius falls less under load than a third of the deflection",
        unit: "1/kN",
        typical: 0.005,
        bounds: [-0.02, 0.04],
        source: "a third of a deflection of 6 mm per kN on 300 mm",
        enters: "rolling radius of both wheels",
        channels: &[Channel::WheelSpeedFront, Channel::WheelSpeedRear, Channel::BrakePressureFront],
        kinds: BRAKING,
        confounded_with: &[],
        separate_by: "braking of the other wheel",
        level: Level::Bike,
        faint: false,
    };
    const TYRES: &[Axle] = &Axle::BOTH;
    const REACH: Reach = Reach::SLIPS;
    const MULTIBODY: Multibody = Multibody::Inherent(
        "its tyres are springs, by a share of whose deflection they roll shorter",
    );

    fn relative_radius(size: f64, ratio: f64, rolling: Rolling) -> f64 {
        ratio - size * rolling.extra_load / 1000.0
    }
}
