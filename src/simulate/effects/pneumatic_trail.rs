//! Pneumatic trail of the tyres.

use super::physics::{Physics, Reach};
use super::spec::{EffectSpec, Level};
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct PneumaticTrail;

impl Physics for PneumaticTrail {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the pneumatic trail is not the assumed one",
        opposite: "the pneumatic trail is not the assumed one",
        unit: "1",
        typical: 0.4,
        bounds: [-1.0, 3.0],
        source: "(12) takes it from the static deflection",
        enters: "yaw moment over side slip",
        channels: &[Channel::YawRate, Channel::AccelerationY],
        kinds: &[ManoeuvreKind::Cornering],
        confounded_with: &[],
        separate_by: "a tyre bench",
        level: Level::Bike,
        faint: true,
    };
    const TYRES: &[Axle] = &Axle::BOTH;
    const REACH: Reach = Reach::LATERAL;

    fn relative_trail(size: f64, ratio: f64) -> f64 {
        ratio + size
    }
}
