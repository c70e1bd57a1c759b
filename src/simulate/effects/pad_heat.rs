//! Pads whose friction changes with all the heat they have taken.

use super::physics::{Physics, Remove};
use super::ride::{BrakeHistory, HEAT, scale_pressures};
use super::spec::{BRAKING, EffectSpec, Level};
use crate::contract::channel::Channel;

/// Least friction that is left of the pads', as a share.
const LEAST: f64 = 0.3;

pub(super) struct PadHeat;

impl Physics for PadHeat {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the pads lose friction with all the heat they have taken since the start",
        opposite: "the pads gain friction with all the heat they have taken since the start",
        unit: "1",
        typical: 0.01,
        bounds: [-0.05, 0.1],
        source: "assumed: a tenth of the friction over twenty stops from 50 km/h; not measured",
        enters: "brake gain over the heat of all stops so far, without cooling",
        channels: &[Channel::BrakePressureFront, Channel::BrakePressureRear],
        kinds: BRAKING,
        confounded_with: &[],
        separate_by: "the same stop at the start and at the end of a ride with many",
        level: Level::Bike,
        faint: false,
    };
    const REMOVE: Option<Remove> = Some(|session, bike, size| {
        scale_pressures(session, |brakes| Self::brake_gain(size, 1.0, bike.mass, brakes));
    });

    fn brake_gain(size: f64, ratio: f64, mass: f64, brakes: BrakeHistory) -> f64 {
        ratio * (1.0 - size * mass * brakes.total / HEAT).max(LEAST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gain_falls_from_stop_to_stop_and_not_below_the_least() {
        let gain_after = |stops: usize| {
            let mut brakes = BrakeHistory::default();
            for _ in 0..stops {
                // 250 kg with 200 J/kg are one unit of heat
                brakes.update(20.0, true, 0.01);
                brakes.update(0.0, true, 0.01);
                brakes.update(0.0, false, 60.0);
            }
            PadHeat::brake_gain(0.04, 1.0, 250.0, brakes)
        };
        assert_eq!(gain_after(0), 1.0);
        assert!((gain_after(1) - 0.96).abs() < 1e-12);
        assert!((gain_after(5) - 0.8).abs() < 1e-12);
        assert_eq!(gain_after(50), LEAST);
    }
}
