//! Cross fall of the road.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "road_bank",
    sentence: "the road is banked",
    unit: "rad",
    typical: 0.006,
    bounds: [-0.06, 0.06],
    source: "cross falls of 1 to 3 % drain a road",
    enters: "camber against the road, and weight across it",
    channels: &[Channel::AccelerationY, Channel::Roll],
    kinds: &[ManoeuvreKind::Cornering],
    alike: &["roll_zero"],
    separate_by: "bends to both sides",
    level: Level::Site,
    get: |d| d.bank,
    set: |d, value| d.bank = value,
    undo: None,
};
