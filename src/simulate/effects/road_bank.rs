//! Cross fall of the road.

use super::physics::{Physics, Reach};
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct RoadBank;

impl Physics for RoadBank {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the road is banked",
        opposite: "the road is banked",
        unit: "rad",
        typical: 0.006,
        bounds: [-0.06, 0.06],
        source: "cross falls of 1 to 3 % drain a road",
        enters: "camber against the road, and weight across it",
        channels: &[Channel::AccelerationY, Channel::Roll],
        kinds: &[ManoeuvreKind::Cornering],
        confounded_with: &["roll_zero"],
        separate_by: "corners to both sides",
        level: Level::Site,
        faint: false,
    };
    const REACH: Reach = Reach::ATTITUDE;

    fn camber(size: f64, camber: f64) -> f64 {
        camber - size
    }

    fn weight_across(size: f64, share: f64) -> f64 {
        share - size
    }
}
