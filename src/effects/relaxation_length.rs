//! Relaxation length of the tyres.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "relaxation_length",
    sentence: "the tyres answer later than assumed",
    unit: "m",
    typical: 0.15,
    bounds: [-0.3, 0.8],
    source: "0.1 to 0.4 m, growing with speed, de Vries and Pacejka 1998",
    enters: "lag of the slip angles",
    channels: &[Channel::SteerAngle, Channel::VelocityY, Channel::YawRate],
    kinds: &[ManoeuvreKind::Cornering],
    alike: &[],
    separate_by: "quick changes of lean",
    level: Level::Bike,
    get: |d| d.relaxation,
    set: |d, value| d.relaxation = value,
    undo: Some(|_, bike, value| {
        for wheel in [&mut bike.front, &mut bike.rear] {
            let usual = wheel.relaxation_length.unwrap_or(wheel.radius);
            wheel.relaxation_length = Some((usual + value).max(0.02));
        }
    }),
};
