//! Side-force ratio of the rear tyre.

use super::physics::{Physics, Reach, Remove};
use super::spec::{EffectSpec, Level};
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct SideForceRatioRear;

impl Physics for SideForceRatioRear {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the rear side-force ratio is not the assumed one",
        opposite: "the rear side-force ratio is not the assumed one",
        unit: "1",
        typical: 0.03,
        bounds: [-0.15, 0.15],
        source: "0.05 to 0.12 in published motorcycle tyres",
        enters: "camber's share of the rear side force",
        channels: &[Channel::VelocityY, Channel::YawRate, Channel::Roll, Channel::AccelerationY],
        kinds: &[ManoeuvreKind::Cornering],
        confounded_with: &["cornering_stiffness_rear", "twisting_stiffness", "pneumatic_trail"],
        separate_by: "corners hung off and corners leaning out, in rides of their own",
        level: Level::Bike,
        faint: false,
    };
    const TYRES: &[Axle] = &[Axle::Rear];
    const IN_PER_CENT: bool = false;
    const REACH: Reach = Reach::LATERAL;
    const REMOVE: Option<Remove> = Some(|_, bike, size| bike.rear.side_force_ratio += size);

    fn side_force_ratio(size: f64, ratio: f64, axle: Axle) -> f64 {
        if axle == Axle::Rear { ratio + size } else { ratio }
    }
}
