//! Cold tyres.

use super::physics::{Physics, Reach};
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

/// Time over which tyres warm up, s.
const WARMING: f64 = 150.0;

pub(super) struct TyreWarmUp;

impl Physics for TyreWarmUp {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the tyres grip less while they are cold",
        opposite: "the tyres grip better while they are cold",
        unit: "1",
        typical: 0.06,
        bounds: [-0.3, 0.5],
        source: "5 to 20 % less for the first minutes",
        enters: "friction over the time of the ride",
        channels: &[Channel::BrakePressureFront, Channel::WheelSpeedFront],
        kinds: &[ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking],
        confounded_with: &[],
        separate_by: "braking to the limit early and late",
        level: Level::Night,
        faint: true,
    };
    const REACH: Reach = Reach::SLIPS;

    fn grip(size: f64, grip: f64, time: f64, _along: f64) -> f64 {
        // the exponential is for rides that have it only
        if size == 0.0 { grip } else { grip * (1.0 - size * (-time / WARMING).exp()) }
    }
}
