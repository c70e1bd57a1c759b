//! Slippery end of the strip.

use super::physics::{Physics, Reach};
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct LowFrictionPatch;

impl Physics for LowFrictionPatch {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the far end of the strip is slippery",
        opposite: "the far end of the strip grips better than the rest",
        unit: "1",
        typical: 0.06,
        bounds: [-0.3, 0.3],
        source: "dust, paint and damp cost 5 to 30 % of friction",
        enters: "friction of what is ridden along the first straight's heading",
        channels: &[Channel::Yaw, Channel::BrakePressureFront],
        kinds: &[ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking],
        confounded_with: &[],
        separate_by: "braking to the limit in both directions",
        level: Level::Site,
        faint: false,
    };
    const REACH: Reach = Reach::SLIPS;
    const NEEDS_HEADING: bool = true;

    fn grip(size: f64, grip: f64, _time: f64, along: f64) -> f64 {
        let there = if along > 0.5 { size } else { 0.0 };
        grip * (1.0 - there)
    }
}
