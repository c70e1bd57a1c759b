//! Slope of the strip.

use super::Effect;
use super::Level;
use super::remove::add;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "road_grade",
    sentence: "the road climbs along the strip",
    unit: "1",
    typical: 0.003,
    bounds: [-0.02, 0.02],
    source: "roads that pass for level fall by a few per mille for drainage",
    enters: "gravity along the road, with the sign of the heading",
    channels: &[Channel::AccelerationX, Channel::Yaw],
    kinds: &[ManoeuvreKind::Coasting, ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking],
    alike: &["wind"],
    separate_by: "coasting from more than 20 m/s in both directions, or the altitude",
    level: Level::Site,
    get: |d| d.grade,
    set: |d, value| d.grade = value,
    undo: Some(|session, _, value| {
        let pull = crate::GRAVITY * value;
        add(session, Channel::AccelerationX, |ride, i| pull * ride.along[i]);
    }),
};
