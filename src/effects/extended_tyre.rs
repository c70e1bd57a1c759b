//! The paper's tyre with what it leaves out: a tyre of the simulator that departs from it.

use super::model_error::ModelError;
use crate::model::custom::Custom;
use crate::model::tyre::{Input, Output};
use crate::model::tyre_model::{Carcass, Reference, Relaxation, TyreModel};

/// A tyre whose stiffness, friction, trail and rolling resistance are not the paper's.
///
/// Of the departure only what belongs to a tyre and is no number of the paper's own tyre counts:
/// `stiffness_per_load`, `friction_per_load`, `trail`, `rolling_per_speed`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtendedTyre {
    /// The paper's.
    pub custom: Custom,
    /// Load to which changes are relative, N.
    pub load: f64,
    /// How it departs.
    pub departure: ModelError,
}

impl ExtendedTyre {
    /// On the heap; the plain tyre where nothing departs.
    pub fn boxed(custom: Custom, load: f64, departure: &ModelError) -> Box<dyn TyreModel> {
        let d = departure;
        let plain = [d.stiffness_per_load, d.friction_per_load, d.trail, d.rolling_per_speed];
        if plain == [0.0; 4] {
            return Box::new(custom);
        }
        Box::new(ExtendedTyre { custom, load, departure: *d })
    }
}

impl TyreModel for ExtendedTyre {
    fn forces(&self, input: &Input) -> Output {
        let out = self.custom.forces(input);
        let d = &self.departure;
        let more = input.load / self.load - 1.0;
        let mut changed = Output {
            force_x: out.force_x * (1.0 - d.friction_per_load * more),
            force_y: out.force_y * (1.0 + d.stiffness_per_load * more),
            ..out
        };
        if d.trail != 0.0 {
            let tyre = &self.custom.tyre;
            let k_alpha = tyre.stiffness.k_alpha(input.camber, tyre.side_force_ratio);
            let by_slip = -k_alpha * input.slip_angle * input.load.max(0.0);
            let shrinks = (1.0 - k_alpha / 3.0 * input.slip_angle.tan().abs()).max(0.0);
            changed.moment_z -= d.trail * tyre.trail_0(self.load) * shrinks * by_slip;
        }
        changed
    }

    fn relaxation(&self, load: f64, speed: f64) -> Relaxation {
        self.custom.relaxation(load, speed)
    }

    fn rolling_resistance(&self, input: &Input, speed: f64) -> f64 {
        let coefficient = self.departure.rolling_per_speed * speed.abs();
        self.custom.rolling_resistance(input, speed)
            + coefficient * input.load.max(0.0) * self.custom.tyre.rolling_radius
    }

    fn carcass(&self) -> Carcass {
        self.custom.carcass()
    }

    fn reference(&self) -> Reference {
        self.custom.reference()
    }

    fn boxed_clone(&self) -> Box<dyn TyreModel> {
        Box::new(*self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::scenario::Scenario;

    /// At the load to which changes are relative nothing changes but what is absolute.
    #[test]
    fn it_departs_by_load_and_by_as_much_as_is_said() {
        let plant = Scenario::builtin("perfect").expect("scenario").nominal_plant();
        let custom = Custom::new(plant.tyres[0], 1250.0);
        let departure = ModelError {
            stiffness_per_load: -0.3,
            friction_per_load: 0.1,
            ..ModelError::default()
        };
        let tyre = ExtendedTyre::boxed(custom, 1250.0, &departure);
        let input =
            |load| Input { slip_ratio: -0.02, slip_angle: 0.01, camber: -0.3, load, friction: 1.0 };
        assert_eq!(tyre.forces(&input(1250.0)), custom.forces(&input(1250.0)));
        let (own, plain) = (tyre.forces(&input(2500.0)), custom.forces(&input(2500.0)));
        assert!((own.force_y / plain.force_y - 0.7).abs() < 1e-12);
        assert!((own.force_x / plain.force_x - 0.9).abs() < 1e-12);
        assert_eq!(tyre.forces(&input(0.0)), Output::default());
    }
}
