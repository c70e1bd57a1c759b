//! Head wind along the strip.

use super::physics::{Physics, Remove};
use super::ride::add_with;
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct Wind;

impl Physics for Wind {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "a steady wind blows along the strip",
        opposite: "a steady wind blows along the strip",
        unit: "m/s",
        typical: 1.0,
        bounds: [-15.0, 15.0],
        source: "a light breeze, Beaufort 1 to 3",
        enters: "air speed in the drag, with the sign of the heading",
        channels: &[Channel::AccelerationX, Channel::Yaw],
        kinds: &[ManoeuvreKind::Coasting],
        confounded_with: &[],
        separate_by: "coasting from more than 20 m/s in both directions, or a still day",
        level: Level::Night,
        faint: false,
    };
    const NEEDS_HEADING: bool = true;
    const REMOVE: Option<Remove> = Some(|session, bike, size| {
        let per_mass = bike.drag / bike.mass;
        add_with(session, Channel::AccelerationX, |ride, i| {
            let air = Self::air_speed(size, ride.v[i], ride.along[i]);
            per_mass * (air * air.abs() - ride.v[i] * ride.v[i])
        });
    });

    fn air_speed(size: f64, speed: f64, along: f64) -> f64 {
        speed + size * along
    }
}
