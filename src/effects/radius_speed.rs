//! Growth of the tyres with speed.

use super::Effect;
use super::Level;
use super::remove::scale;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "radius_speed",
    sentence: "the tyres grow with speed",
    unit: "1",
    typical: 0.003,
    bounds: [-0.004, 0.03],
    source: "a few per mille at 20 m/s for cross-ply carcasses, less for radial ones",
    enters: "rolling radius of both wheels",
    channels: &[Channel::WheelSpeedFront, Channel::WheelSpeedRear, Channel::VelocityX],
    kinds: &[ManoeuvreKind::Coasting, ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking],
    alike: &[],
    separate_by: "rolling freely over a wide range of speed",
    level: Level::Bike,
    get: |d| d.radius_per_speed,
    set: |d, value| d.radius_per_speed = value,
    undo: Some(|session, _, value| {
        for channel in [Channel::WheelSpeedFront, Channel::WheelSpeedRear] {
            scale(session, channel, |ride, i| 1.0 + value * (ride.v[i] / 20.0).powi(2));
        }
    }),
};
