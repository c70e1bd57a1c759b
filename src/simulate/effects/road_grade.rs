//! Slope of the strip.

use super::physics::{Physics, Remove};
use super::ride::add_with;
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct RoadGrade;

impl Physics for RoadGrade {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the road climbs along the strip",
        opposite: "the road falls along the strip",
        unit: "1",
        typical: 0.003,
        bounds: [-0.15, 0.15],
        source: "roads that pass for level fall by a few per mille for drainage",
        enters: "gravity along the road, with the sign of the heading",
        channels: &[Channel::AccelerationX, Channel::Yaw],
        kinds: &[ManoeuvreKind::Coasting, ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking],
        confounded_with: &["wind"],
        separate_by: "coasting from more than 20 m/s in both directions, or the altitude",
        level: Level::Site,
        faint: false,
    };
    const NEEDS_HEADING: bool = true;
    const REMOVE: Option<Remove> = Some(|session, _, size| {
        let pull = crate::GRAVITY * size;
        add_with(session, Channel::AccelerationX, |ride, i| pull * ride.along[i]);
    });

    fn uphill(size: f64, force: f64, weight: f64, along: f64) -> f64 {
        force + weight * size * along
    }
}
