//! Side-force ratio of the front tyre.

use super::physics::{Physics, Reach, Remove};
use super::spec::{EffectSpec, Level};
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct SideForceRatioFront;

impl Physics for SideForceRatioFront {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the front side-force ratio is not the assumed one",
        opposite: "the front side-force ratio is not the assumed one",
        unit: "1",
        typical: 0.03,
        bounds: [-0.15, 0.15],
        source: "0.05 to 0.12 in published motorcycle tyres",
        enters: "camber's share of the front side force",
        channels: &[
            Channel::SteerAngle,
            Channel::VelocityY,
            Channel::YawRate,
            Channel::Roll,
            Channel::AccelerationY,
        ],
        kinds: &[ManoeuvreKind::Cornering],
        confounded_with: &[
            "cornering_stiffness_front",
            "twisting_stiffness",
            "front_compliance",
            "pneumatic_trail",
        ],
        separate_by: "corners hung off and corners leaning out, in rides of their own",
        level: Level::Bike,
        faint: false,
    };
    const TYRES: &[Axle] = &[Axle::Front];
    const IN_PER_CENT: bool = false;
    const REACH: Reach = Reach::LATERAL;
    const REMOVE: Option<Remove> = Some(|_, bike, size| bike.front.side_force_ratio += size);

    fn side_force_ratio(size: f64, ratio: f64, axle: Axle) -> f64 {
        if axle == Axle::Front { ratio + size } else { ratio }
    }
}
