//! Crown of the tyres.

use super::Effect;
use super::Level;
use super::remove::scale;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "radius_camber",
    sentence: "the rolling radius falls with camber",
    unit: "m",
    typical: 0.02,
    bounds: [-0.01, 0.12],
    source: "tyres are toroids of 50 to 95 mm; how much of the versine the rolling radius loses is the tyre's",
    enters: "rolling radius of both wheels",
    channels: &[Channel::WheelSpeedFront, Channel::VelocityX, Channel::Roll],
    kinds: &[ManoeuvreKind::Cornering],
    alike: &[],
    separate_by: "bends with the front wheel rolling freely",
    level: Level::Bike,
    get: |d| d.radius_crown,
    set: |d, value| d.radius_crown = value,
    undo: Some(|session, bike, value| {
        for (channel, radius) in [
            (Channel::WheelSpeedFront, bike.front.radius),
            (Channel::WheelSpeedRear, bike.rear.radius),
        ] {
            scale(session, channel, |ride, i| 1.0 - value / radius * (1.0 - ride.roll[i].cos()));
        }
    }),
};
