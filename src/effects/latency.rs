//! Delay of the velocities.

use super::Effect;
use super::Level;
use super::model_error::ModelError;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "latency",
    sentence: "the velocity comes late",
    unit: "s",
    typical: 0.015,
    bounds: [-0.1, 0.3],
    source: "satellite receivers are 10 to 100 ms late",
    enters: "velocities over time",
    channels: &[Channel::VelocityX, Channel::AccelerationX],
    kinds: &[
        ManoeuvreKind::FrontBraking,
        ManoeuvreKind::RearBraking,
        ManoeuvreKind::CombinedBraking,
        ManoeuvreKind::Driving,
    ],
    alike: &[],
    separate_by: "hard braking",
    level: Level::Bike,
    get: |d| d.latency,
    set: |d, value| d.latency = value,
    undo: Some(|session, _, value| {
        let early = ModelError { latency: -value, ..ModelError::default() };
        early.measure(session);
    }),
};
