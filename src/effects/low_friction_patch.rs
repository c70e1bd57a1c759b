//! Slippery end of the strip.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "low_friction_patch",
    sentence: "the far end of the strip is slippery",
    unit: "1",
    typical: 0.06,
    bounds: [-0.3, 0.3],
    source: "dust, paint and damp cost 5 to 30 % of friction",
    enters: "friction of what is ridden along the first straight's heading",
    channels: &[Channel::Yaw, Channel::BrakePressureFront],
    kinds: &[ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking],
    alike: &[],
    separate_by: "braking to the limit in both directions",
    level: Level::Site,
    get: |d| d.patch,
    set: |d, value| d.patch = value,
    undo: None,
};
