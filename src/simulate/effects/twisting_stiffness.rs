//! Twisting stiffness of the tyres.

use super::physics::{Physics, Reach, Remove};
use super::spec::{EffectSpec, Level};
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct TwistingStiffness;

impl Physics for TwistingStiffness {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the twisting stiffness is not the assumed one",
        opposite: "the twisting stiffness is not the assumed one",
        unit: "m/rad",
        typical: 0.02,
        bounds: [-0.08, 0.08],
        source: "0.02 to 0.06 m/rad in published tyres, seldom measured",
        enters: "yaw moment over camber",
        channels: &[Channel::YawRate, Channel::AccelerationY, Channel::Roll],
        kinds: &[ManoeuvreKind::Cornering],
        confounded_with: &[
            "cornering_stiffness_front",
            "cornering_stiffness_rear",
            "front_compliance",
            "pneumatic_trail",
        ],
        separate_by: "a tyre bench",
        level: Level::Bike,
        faint: true,
    };
    const TYRES: &[Axle] = &Axle::BOTH;
    const REACH: Reach = Reach::LATERAL;
    const REMOVE: Option<Remove> = Some(|_, bike, size| {
        bike.front.twisting_stiffness += size;
        bike.rear.twisting_stiffness += size;
    });

    fn twisting_stiffness(size: f64, stiffness: f64) -> f64 {
        stiffness + size
    }
}
