//! Spin that is not the wheels'.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "gyroscopic",
    sentence: "more spins than the wheels: the engine, or less",
    unit: "1",
    typical: 0.25,
    bounds: [-1.0, 1.5],
    source: "a crankshaft adds 10 to 40 % of the wheels' gyroscopic moment",
    enters: "gyroscopic moments in roll and yaw",
    channels: &[Channel::Roll, Channel::AccelerationY, Channel::YawRate],
    kinds: &[ManoeuvreKind::Cornering],
    alike: &["overturning_stiffness", "rider_lean"],
    separate_by: "bends of the same lean at different speeds",
    level: Level::Bike,
    get: |d| d.gyroscopic,
    set: |d, value| d.gyroscopic = value,
    undo: None,
};
