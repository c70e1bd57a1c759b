//! Aerodynamic lift.

use super::physics::Physics;
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct Lift;

impl Physics for Lift {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the air lifts the bike",
        opposite: "the air presses the bike down",
        unit: "kg/m",
        typical: 0.05,
        bounds: [-0.3, 0.5],
        source: "lift areas of 0.05 to 0.15 m2, Cossalter 2006, section 3.2",
        enters: "wheel loads over speed",
        channels: &[Channel::WheelSpeedFront, Channel::WheelSpeedRear, Channel::VelocityX],
        kinds: &[ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking, ManoeuvreKind::Cornering],
        confounded_with: &[],
        separate_by: "corners above 30 m/s",
        level: Level::Bike,
        faint: true,
    };

    fn lift(size: f64, force: f64, speed: f64) -> f64 {
        force + 0.5 * size * speed * speed
    }
}
