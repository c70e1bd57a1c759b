//! Side-force ratio of the rear tyre.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "side_force_ratio_rear",
    sentence: "the rear side-force ratio is not the assumed one",
    unit: "1",
    typical: 0.03,
    bounds: [-0.15, 0.15],
    source: "0.05 to 0.12 in published motorcycle tyres",
    enters: "camber's share of the rear side force",
    channels: &[Channel::VelocityY, Channel::YawRate, Channel::Roll, Channel::AccelerationY],
    kinds: &[ManoeuvreKind::Cornering],
    alike: &["cornering_stiffness_rear", "twisting_stiffness", "pneumatic_trail"],
    separate_by: "bends with the brake or the throttle on",
    level: Level::Bike,
    get: |d| d.side_force_ratio[1],
    set: |d, value| d.side_force_ratio[1] = value,
    undo: Some(|_, bike, value| bike.rear.side_force_ratio += value),
};
