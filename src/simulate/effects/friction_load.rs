//! Load sensitivity of friction.

use super::physics::{Physics, Reach};
use super::spec::{BRAKING, EffectSpec, Level};
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;

pub(super) struct FrictionLoad;

impl Physics for FrictionLoad {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "friction falls with load",
        opposite: "friction rises with load",
        unit: "1",
        typical: 0.15,
        bounds: [-0.3, 0.6],
        source: "0.05 to 0.2 per doubled load, Pacejka 2012, section 4.3",
        enters: "friction curve of both tyres",
        channels: &[
            Channel::BrakePressureFront,
            Channel::BrakePressureRear,
            Channel::WheelSpeedFront,
            Channel::WheelSpeedRear,
        ],
        kinds: BRAKING,
        confounded_with: &[],
        separate_by: "the same slip at different loads",
        level: Level::Bike,
        faint: true,
    };
    const TYRES: &[Axle] = &Axle::BOTH;
    const REACH: Reach = Reach::SLIPS;

    fn relative_friction(size: f64, ratio: f64, extra_load: f64) -> f64 {
        ratio - size * extra_load
    }
}
