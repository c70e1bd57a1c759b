//! The paper's tyre with what it leaves out: a tyre of the simulator that departs from it.

use super::ModelError;
use super::composed::Acting;
use crate::model::custom::Custom;
use crate::model::tyre::{Input, Output};
use crate::model::tyre_model::{Carcass, Reference, Relaxation, TyreModel};

/// A tyre whose stiffness, friction, trail and rolling resistance are not the paper's.
///
/// Errors of the paper's own numbers (side-force ratio, twisting stiffness, relaxation length) are in
/// `custom`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtendedTyre {
    /// The paper's.
    pub custom: Custom,
    /// Load to which changes are relative, N.
    pub load: f64,
    /// How it departs.
    pub error: ModelError,
}

impl ExtendedTyre {
    /// On the heap; the plain tyre where nothing departs.
    pub fn boxed(custom: Custom, load: f64, error: &ModelError) -> Box<dyn TyreModel> {
        if *error == ModelError::default() {
            return Box::new(custom);
        }
        Box::new(ExtendedTyre { custom, load, error: *error })
    }
}

impl TyreModel for ExtendedTyre {
    fn forces(&self, input: &Input) -> Output {
        let acting = Acting {
            tyre: &self.custom.tyre,
            slip_angle: input.slip_angle,
            camber: input.camber,
            load: input.load.max(0.0),
            reference_load: self.load,
            extra_load: input.load / self.load - 1.0,
        };
        self.error.tyre_output(self.custom.forces(input), &acting)
    }

    fn relaxation(&self, load: f64, speed: f64) -> Relaxation {
        self.custom.relaxation(load, speed)
    }

    fn rolling_resistance(&self, input: &Input, speed: f64) -> f64 {
        let coefficient = self.error.rolling_resistance(0.0, speed.abs());
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
        let error =
            ModelError { stiffness_load: -0.3, friction_load: 0.1, ..ModelError::default() };
        let tyre = ExtendedTyre::boxed(custom, 1250.0, &error);
        let input =
            |load| Input { slip_ratio: -0.02, slip_angle: 0.01, camber: -0.3, load, friction: 1.0 };
        assert_eq!(tyre.forces(&input(1250.0)), custom.forces(&input(1250.0)));
        let (own, plain) = (tyre.forces(&input(2500.0)), custom.forces(&input(2500.0)));
        assert!((own.force_y / plain.force_y - 0.7).abs() < 1e-12);
        assert!((own.force_x / plain.force_x - 0.9).abs() < 1e-12);
        assert_eq!(tyre.forces(&input(0.0)), Output::default());
    }
}
