//! A tyre with what its formulas leave out: a tyre of the simulator that departs from them.

use super::ModelError;
use super::composed::{Acting, LEAST_UNDER_LOAD};
use super::physics::Rolling;
use crate::tyre::custom::Custom;
use crate::tyre::paper::{Input, Output, Tyre};
use crate::tyre::tyre_model::{Carcass, Reference, Relaxation, TyreModel};

/// A tyre whose stiffness, friction, trail, rolling resistance and rolling radius are not those of its formulas.
///
/// Errors of the paper's own numbers (side-force ratio, twisting stiffness, relaxation length) are in a
/// [`Custom`] already; on any other tyre they are the difference of two of the paper's tyres.
#[derive(Debug, Clone)]
pub struct ExtendedTyre {
    base: Box<dyn TyreModel>,
    /// The paper's tyre that is like the base, and that which the base should be like.
    like: [Tyre; 2],
    /// The paper's tyre that the base is, whose friction circle holds the forces.
    bounded: Option<Tyre>,
    /// Load to which changes are relative, N.
    load: f64,
    error: ModelError,
    /// Width over the front tyre's.
    crown: f64,
}

impl ExtendedTyre {
    /// On the heap, relative to its nominal load; the plain tyre where nothing departs. All that is a tyre's departs:
    /// beyond what its springs and its toroid do by themselves, too.
    /// `crown` is its width over the front tyre's.
    pub fn boxed(custom: Custom, error: &ModelError, crown: f64) -> Box<dyn TyreModel> {
        let (tyre, load) = (custom.tyre, custom.nominal_load);
        Self::departing((Box::new(custom), Some(tyre)), [tyre; 2], load, error, crown)
    }

    /// Of a tyre of any formulas, that is `like` the first and should be `like` the second of two of the
    /// paper's tyres. On a multibody motorcycle: what that has by its construction does not depart.
    pub fn of_any(
        base: Box<dyn TyreModel>,
        like: [Tyre; 2],
        load: f64,
        error: &ModelError,
    ) -> Box<dyn TyreModel> {
        Self::departing((base, None), like, load, &error.of_hooks(), 1.0)
    }

    fn departing(
        (base, bounded): (Box<dyn TyreModel>, Option<Tyre>),
        like: [Tyre; 2],
        load: f64,
        error: &ModelError,
        crown: f64,
    ) -> Box<dyn TyreModel> {
        if *error == ModelError::default() {
            return base;
        }
        Box::new(ExtendedTyre { base, like, bounded, load, error: *error, crown })
    }
}

impl TyreModel for ExtendedTyre {
    fn forces(&self, input: &Input) -> Output {
        let [is, should] = &self.like;
        let load = input.load.max(0.0);
        let acting = Acting {
            tyre: should,
            slip_angle: input.slip_angle,
            camber: input.camber,
            load,
            reference_load: self.load,
            extra_load: input.load / self.load - 1.0,
        };
        let mut out = self.base.forces(input);
        let ratio = should.side_force_ratio - is.side_force_ratio;
        if ratio != 0.0 {
            let k_alpha = is.stiffness.k_alpha(input.camber, is.side_force_ratio);
            out.force_y -= ratio * k_alpha * load * input.camber; // (15)
        }
        out.moment_z -= (should.twisting_stiffness - is.twisting_stiffness) * load * input.camber;
        let out = self.error.bounded_output(out, &acting);
        let Some(tyre) = &self.bounded else { return out };
        let share = self.error.relative_friction(1.0, acting.extra_load).max(LEAST_UNDER_LOAD);
        out.within(share * tyre.circle(input.friction) * load)
    }

    fn relaxation(&self, load: f64, speed: f64) -> Relaxation {
        let [is, should] = &self.like;
        let base = self.base.relaxation(load, speed);
        let longer = should.relaxation_length / is.relaxation_length;
        Relaxation { lateral: base.lateral * longer, ..base }
    }

    fn rolling_resistance(&self, input: &Input, speed: f64) -> f64 {
        let coefficient = self.error.rolling_resistance(0.0, speed.abs());
        self.base.rolling_resistance(input, speed)
            + coefficient * input.load.max(0.0) * self.like[0].rolling_radius
    }

    fn carcass(&self) -> Carcass {
        self.base.carcass()
    }

    fn rolling_radius(&self, load: f64, versine: f64, speed: f64) -> f64 {
        let extra_load = load - self.load;
        let rolling = Rolling { speed, extra_load, versine, crown: self.crown };
        self.error.radius(self.base.rolling_radius(load, versine, speed), rolling)
    }

    fn reference(&self) -> Reference {
        self.base.reference()
    }

    fn boxed_clone(&self) -> Box<dyn TyreModel> {
        Box::new(self.clone())
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
        let tyre = ExtendedTyre::boxed(custom, &error, 1.0);
        let input =
            |load| Input { slip_ratio: -0.02, slip_angle: 0.01, camber: -0.3, load, friction: 1.0 };
        assert_eq!(tyre.forces(&input(1250.0)), custom.forces(&input(1250.0)));
        let (own, plain) = (tyre.forces(&input(2500.0)), custom.forces(&input(2500.0)));
        assert!((own.force_y / plain.force_y - 0.7).abs() < 1e-12);
        assert!((own.force_x / plain.force_x - 0.9).abs() < 1e-12);
        assert_eq!(tyre.forces(&input(0.0)), Output::default());
    }
}
