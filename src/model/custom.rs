//! The paper's tyre as a tyre of the simulator: with the carcass that a characterisation implies.

use serde::{Deserialize, Serialize};

use super::tyre::{Input, Output, Tyre};
use super::tyre_model::{Carcass, Reference, Relaxation, TyreModel};

/// The paper's tyre (eqs. 1-22) and what a simulator needs beside it.
///
/// ```text
/// crown radius    rho = k_x + deflection      (k_x is the loaded one)
/// unloaded radius R   = R_rol + deflection/3
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Custom {
    /// Load of the characterisation, N: gives the deflection above.
    pub nominal_load: f64,
    /// Vertical damping, N s/m.
    #[serde(default = "damping")]
    pub vertical_damping: f64,
    /// Relaxation length of the slip ratio, m; the paper has none.
    #[serde(default = "lag_x")]
    pub longitudinal_relaxation: f64,
    /// The tyre.
    pub tyre: Tyre,
}

fn damping() -> f64 {
    200.0
}

fn lag_x() -> f64 {
    0.1
}

/// Share of the deflection by which the rolling radius is smaller than the unloaded one.
const SHARE: f64 = 1.0 / 3.0;

impl Custom {
    /// A characterised tyre with the usual damping and longitudinal lag.
    pub fn new(tyre: Tyre, nominal_load: f64) -> Self {
        Custom { nominal_load, vertical_damping: damping(), longitudinal_relaxation: lag_x(), tyre }
    }

    fn deflection(&self) -> f64 {
        self.nominal_load / self.tyre.vertical_stiffness
    }
}

impl TyreModel for Custom {
    fn forces(&self, input: &Input) -> Output {
        self.tyre.forces(input)
    }

    fn relaxation(&self, _load: f64, _speed: f64) -> Relaxation {
        Relaxation {
            longitudinal: self.longitudinal_relaxation,
            lateral: self.tyre.relaxation_length,
            camber: None,
        }
    }

    fn rolling_resistance(&self, input: &Input, _speed: f64) -> f64 {
        self.tyre.rolling_resistance * input.load.max(0.0) * self.tyre.rolling_radius
    }

    fn carcass(&self) -> Carcass {
        Carcass {
            radius: self.tyre.rolling_radius + SHARE * self.deflection(),
            crown: self.tyre.overturning_stiffness + self.deflection(),
            stiffness: self.tyre.vertical_stiffness,
            damping: self.vertical_damping,
            deflection_share: SHARE,
        }
    }

    fn reference(&self) -> Reference {
        Reference::WheelPlane
    }

    fn boxed_clone(&self) -> Box<dyn TyreModel> {
        Box::new(*self)
    }
}
