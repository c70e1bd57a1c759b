//! Zero of the roll reading.

use super::Effect;
use super::Level;
use super::remove::add;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "roll_zero",
    sentence: "the roll sensor does not read zero upright",
    unit: "rad",
    typical: 0.006,
    bounds: [-0.06, 0.06],
    source: "mounting angles and attitude filters are off by half a degree",
    enters: "roll",
    channels: &[Channel::Roll, Channel::AccelerationY],
    kinds: &[ManoeuvreKind::Cornering],
    alike: &["road_bank", "rider_lean"],
    separate_by: "bends to both sides",
    level: Level::Bike,
    get: |d| d.roll_zero,
    set: |d, value| d.roll_zero = value,
    undo: Some(|session, _, value| add(session, Channel::Roll, |_, _| value)),
};
