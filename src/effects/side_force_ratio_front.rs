//! Side-force ratio of the front tyre.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "side_force_ratio_front",
    sentence: "the front side-force ratio is not the assumed one",
    unit: "1",
    typical: 0.03,
    bounds: [-0.15, 0.15],
    source: "0.05 to 0.12 in published motorcycle tyres",
    enters: "camber's share of the front side force",
    channels: &[
        Channel::SteerAngle,
        Channel::VelocityY,
        Channel::YawRate,
        Channel::Roll,
        Channel::AccelerationY,
    ],
    kinds: &[ManoeuvreKind::Cornering],
    alike: &[
        "cornering_stiffness_front",
        "twisting_stiffness",
        "front_compliance",
        "pneumatic_trail",
    ],
    separate_by: "bends with the brake or the throttle on",
    level: Level::Bike,
    get: |d| d.side_force_ratio[0],
    set: |d, value| d.side_force_ratio[0] = value,
    undo: Some(|_, bike, value| bike.front.side_force_ratio += value),
};
