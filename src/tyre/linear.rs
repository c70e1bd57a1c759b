//! A linear tyre whose whole side force lags: the tyre of Sharp (1971).

use super::keys::{Keys, Missing};
use super::paper::{Input, Output};
use super::tyre_model::{Carcass, Reference, Relaxation, TyreModel};

/// Side force `-(C_alpha alpha + C_gamma gamma)` whatever the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Linear {
    /// Cornering stiffness, N/rad.
    pub cornering_stiffness: f64,
    /// Camber stiffness, N/rad.
    pub camber_stiffness: f64,
    /// N per slip ratio.
    pub slip_stiffness: f64,
    /// m, of the whole side force.
    pub relaxation_length: f64,
    /// Shape and vertical spring.
    pub carcass: Carcass,
}

impl Linear {
    /// From a property file's keys.
    ///
    /// # Errors
    /// Names the first key that is missing.
    pub(crate) fn from_keys(keys: &Keys) -> Result<Self, Missing> {
        Ok(Linear {
            cornering_stiffness: keys.number("CORNERING_STIFFNESS")?,
            camber_stiffness: keys.number("CAMBER_STIFFNESS")?,
            slip_stiffness: keys.number("SLIP_STIFFNESS")?,
            relaxation_length: keys.number("RELAXATION_LENGTH")?,
            carcass: Carcass {
                radius: keys.number("UNLOADED_RADIUS")?,
                crown: keys.or("CROWN_RADIUS", 0.0),
                stiffness: keys.number("VERTICAL_STIFFNESS")?,
                damping: keys.number("VERTICAL_DAMPING")?,
                deflection_share: keys.or("EFFECTIVE_RADIUS_SHARE", 1.0 / 3.0),
            },
        })
    }
}

impl TyreModel for Linear {
    fn forces(&self, input: &Input) -> Output {
        if input.load <= 0.0 {
            return Output::default(); // off the ground
        }
        Output {
            force_x: self.slip_stiffness * input.slip_ratio,
            force_y: -self.cornering_stiffness * input.slip_angle
                - self.camber_stiffness * input.camber,
            ..Output::default()
        }
    }

    fn relaxation(&self, _load: f64, _speed: f64) -> Relaxation {
        let length = self.relaxation_length;
        Relaxation { longitudinal: length, lateral: length, camber: Some(length) }
    }

    fn rolling_resistance(&self, _input: &Input, _speed: f64) -> f64 {
        0.0
    }

    fn carcass(&self) -> Carcass {
        self.carcass
    }

    fn reference(&self) -> Reference {
        Reference::Carcass
    }

    fn boxed_clone(&self) -> Box<dyn TyreModel> {
        Box::new(*self)
    }
}
