//! Lean of the rider's body.

use super::physics::{Physics, Reach};
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct RiderLean;

impl Physics for RiderLean {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the rider leans his body with the bike",
        opposite: "the rider leans his body against the bike's lean",
        unit: "m/rad",
        typical: 0.06,
        bounds: [-0.3, 0.3],
        source: "a hanging rider moves the centre of mass by 3 to 8 cm",
        enters: "centre of mass across the bike over roll",
        channels: &[Channel::Roll, Channel::AccelerationY],
        kinds: &[ManoeuvreKind::Cornering],
        confounded_with: &["overturning_stiffness", "gyroscopic"],
        separate_by: "no ride; a camera",
        level: Level::Night,
        faint: false,
    };
    const REACH: Reach = Reach::ROLL;

    fn mass_centre_aside(size: f64, offset: f64, roll: f64) -> f64 {
        offset + size * roll
    }
}
