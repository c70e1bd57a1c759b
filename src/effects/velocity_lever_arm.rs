//! Place of the velocity sensor.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "velocity_lever_arm",
    sentence: "the velocity is not that of the place the bike file says",
    unit: "m",
    typical: 0.15,
    bounds: [-1.2, 1.2],
    source: "an antenna on the tail is half a metre off",
    enters: "lateral velocity over yaw rate",
    channels: &[Channel::VelocityY, Channel::YawRate],
    kinds: &[ManoeuvreKind::Cornering],
    alike: &[],
    separate_by: "tight bends",
    level: Level::Bike,
    get: |d| d.lever_arm,
    set: |d, value| d.lever_arm = value,
    undo: Some(|session, _, value| {
        let rate = session.get(Channel::YawRate).map(<[f64]>::to_vec);
        if let (Some(rate), Some(x)) = (rate, session.get_mut(Channel::VelocityY)) {
            x.iter_mut().zip(rate).for_each(|(x, r)| *x -= value * r);
        }
    }),
};
