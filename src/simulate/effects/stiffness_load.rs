//! Load sensitivity of the cornering stiffness.

use super::physics::{Physics, Reach};
use super::spec::{EffectSpec, Level};
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct StiffnessLoad;

impl Physics for StiffnessLoad {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "cornering stiffness per load falls with load",
        opposite: "cornering stiffness per load rises with load",
        unit: "1",
        typical: -0.2,
        bounds: [-0.9, 0.5],
        source: "motorcycle tyres lose 10 to 40 % per doubled load, Pacejka 2012, section 11.6",
        enters: "cornering stiffness per load of both tyres",
        channels: &[
            Channel::SteerAngle,
            Channel::VelocityY,
            Channel::YawRate,
            Channel::AccelerationY,
            Channel::BrakePressureFront,
        ],
        kinds: &[ManoeuvreKind::Cornering],
        confounded_with: &["drag_height"],
        separate_by: "corners with the brake on",
        level: Level::Bike,
        faint: false,
    };
    const TYRES: &[Axle] = &Axle::BOTH;
    const REACH: Reach = Reach::LATERAL;

    fn relative_stiffness(size: f64, ratio: f64, extra_load: f64) -> f64 {
        ratio + size * extra_load
    }
}
