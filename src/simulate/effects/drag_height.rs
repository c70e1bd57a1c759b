//! Height of the drag.

use super::physics::Physics;
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct DragHeight;

impl Physics for DragHeight {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the air pushes higher than the centre of mass",
        opposite: "the air pushes lower than the centre of mass",
        unit: "m",
        typical: 0.3,
        bounds: [-0.6, 1.0],
        source: "the centre of pressure is 0 to 0.3 m above the centre of mass",
        enters: "load transfer over speed",
        channels: &[Channel::WheelSpeedFront, Channel::WheelSpeedRear, Channel::VelocityX],
        kinds: &[ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking, ManoeuvreKind::Driving],
        confounded_with: &[],
        separate_by: "coasting and braking above 30 m/s",
        level: Level::Bike,
        faint: true,
    };

    fn pitch_moment(size: f64, moment: f64, drag: f64) -> f64 {
        moment + size * drag
    }
}
