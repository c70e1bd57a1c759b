//! Head wind along the strip.

use super::Effect;
use super::Level;
use super::remove::add;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "wind",
    sentence: "a steady wind blows along the strip",
    unit: "m/s",
    typical: 1.0,
    bounds: [-6.0, 6.0],
    source: "a light breeze, Beaufort 1 to 3",
    enters: "air speed in the drag, with the sign of the heading",
    channels: &[Channel::AccelerationX, Channel::Yaw],
    kinds: &[ManoeuvreKind::Coasting],
    alike: &["road_grade"],
    separate_by: "coasting from more than 20 m/s in both directions, or a still day",
    level: Level::Night,
    get: |d| d.wind,
    set: |d, value| d.wind = value,
    undo: Some(|session, bike, value| {
        let per_mass = bike.drag / bike.mass;
        add(session, Channel::AccelerationX, |ride, i| {
            let air = ride.v[i] + value * ride.along[i];
            per_mass * (air * air.abs() - ride.v[i] * ride.v[i])
        });
    }),
};
