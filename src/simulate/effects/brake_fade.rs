//! Brakes that lose gain within a stop.

use super::physics::{Physics, Remove};
use super::ride::{BrakeHistory, HEAT, scale_pressures};
use super::spec::{BRAKING, EffectSpec, Level};
use crate::contract::channel::Channel;

pub(super) struct BrakeFade;

impl Physics for BrakeFade {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the brakes fade as they warm up within a stop",
        opposite: "the brakes bite better as they warm up within a stop",
        unit: "1",
        typical: 0.06,
        bounds: [-0.3, 0.5],
        source: "organic pads lose 5 to 20 % in one hard stop",
        enters: "brake gain over the heat of the stop",
        channels: &[Channel::BrakePressureFront, Channel::BrakePressureRear],
        kinds: BRAKING,
        confounded_with: &[],
        separate_by: "hard stops from different speeds",
        level: Level::Bike,
        faint: false,
    };
    const REMOVE: Option<Remove> = Some(|session, bike, size| {
        scale_pressures(session, |brakes| Self::brake_gain(size, 1.0, bike.mass, brakes));
    });

    fn brake_gain(size: f64, ratio: f64, mass: f64, brakes: BrakeHistory) -> f64 {
        ratio - size * mass * brakes.stop / HEAT
    }
}
