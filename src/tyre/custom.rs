//! The paper's tyre as a tyre of the simulator: with the carcass that a characterisation implies.

use serde::{Deserialize, Serialize};

use super::magic_formula::MagicFormula;
use super::paper::{Input, Output, Stiffness, Tyre, slip_stiffness_under};
use super::tyre_model::{Carcass, Reference, Relaxation, TyreModel, USUAL_SHARE};
use crate::contract::bike::{USUAL_SLIP_LAG, USUAL_SLIP_STIFFNESS_LOAD, WheelData};
use crate::contract::coefficient::Coefficient as C;
use crate::contract::key_error::KeyError;

/// The paper's tyre (eqs. 1-22) and what a simulator needs beside it.
///
/// ```text
/// crown radius    rho = k_x + deflection      (k_x is the loaded one)
/// unloaded radius R   = R_rol + share deflection
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
    /// Slip stiffness per load that is gained with the nominal load once more, over itself; the paper has none.
    #[serde(default)]
    pub slip_stiffness_load: f64,
    /// Share of the deflection by which it rolls shorter.
    #[serde(default = "share")]
    pub deflection_share: f64,
    pub tyre: Tyre,
}

fn damping() -> f64 {
    200.0
}

fn lag_x() -> f64 {
    0.1
}

fn share() -> f64 {
    USUAL_SHARE
}

impl Custom {
    /// A tyre with the usual damping and a longitudinal lag of published tyres: what simulated ones have without the key.
    pub fn new(tyre: Tyre, nominal_load: f64) -> Self {
        Custom {
            nominal_load,
            vertical_damping: damping(),
            longitudinal_relaxation: lag_x(),
            slip_stiffness_load: 0.0,
            deflection_share: share(),
            tyre,
        }
    }

    /// From a characterisation: `value` gives the tyre's coefficients, `wheel` is the bike file's, `load` the static load (N), `rolling_resistance` the
    /// vehicle's, `friction` the road's during the ride.
    ///
    /// A friction curve that does not fall within the slips that were braked has no peak: the
    /// slip at which it reaches 99 % of its largest value counts for it.
    ///
    /// # Errors
    /// Names the coefficient that the characterisation does not have.
    pub fn characterised(
        value: impl Fn(C) -> Option<f64>,
        wheel: &WheelData,
        load: f64,
        rolling_resistance: f64,
        friction: f64,
    ) -> Result<Self, KeyError> {
        let get = |c: C| {
            value(c).ok_or_else(|| KeyError::Values(format!("a tyre to simulate needs `{c}`")))
        };
        let curve = MagicFormula {
            b: get(C::MfB)?,
            c: get(C::MfC)?,
            d: get(C::MfD)?,
            e1: get(C::MfE1)?,
            e2: value(C::MfE2).unwrap_or(0.0),
        };
        let peak_slip = value(C::PeakSlip).or_else(|| curve.peak_slip()).unwrap_or_else(|| {
            let reached = |s: f64| -curve.value(-s) / curve.d;
            let slip = (1..=500).map(|i| f64::from(i) * 1e-3).find(|&s| reached(s) >= 0.99);
            slip.map_or(0.2, |s| s / (1.0 - s))
        });
        let tyre = Tyre {
            friction: curve,
            stiffness: Stiffness {
                ct: get(C::LateralFrictionCt)?,
                c1: get(C::SlipCamberC1)?,
                c3: get(C::SlipCamberC3)?,
            },
            side_force_ratio: get(C::SideForceRatio)?,
            twisting_stiffness: get(C::TwistingStiffness)?,
            overturning_stiffness: get(C::OverturningStiffness)?,
            rolling_radius: get(C::EffectiveRollingRadius)?,
            rolling_resistance,
            relaxation_length: get(C::RelaxationLength)?,
            vertical_stiffness: wheel.vertical_stiffness,
            camber_force_decay: wheel.camber_force_decay,
            camber_moment_decay: wheel.camber_moment_decay,
            reference_friction: friction,
            peak_slip,
            lateral_peak: 0.0,
        };
        let gain = value(C::SlipStiffnessLoad).or(wheel.slip_stiffness_load);
        let slip_stiffness_load = gain.unwrap_or(USUAL_SLIP_STIFFNESS_LOAD);
        Ok(Custom {
            slip_stiffness_load,
            // as the fits take them: the bike file's, or the usual ones of its schema
            longitudinal_relaxation: wheel.longitudinal_relaxation.unwrap_or(USUAL_SLIP_LAG),
            deflection_share: wheel.deflection_share.unwrap_or(USUAL_SHARE),
            ..Custom::new(tyre, load)
        })
    }

    fn deflection(&self) -> f64 {
        self.nominal_load / self.tyre.vertical_stiffness
    }
}

impl TyreModel for Custom {
    fn forces(&self, input: &Input) -> Output {
        let extra_load = input.load / self.nominal_load - 1.0;
        let stiffer = slip_stiffness_under(self.slip_stiffness_load, extra_load);
        self.tyre.forces(&Input { slip_ratio: stiffer * input.slip_ratio, ..*input })
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
            radius: self.tyre.rolling_radius + self.deflection_share * self.deflection(),
            crown: self.tyre.overturning_stiffness + self.deflection(),
            stiffness: self.tyre.vertical_stiffness,
            damping: self.vertical_damping,
            deflection_share: self.deflection_share,
        }
    }

    fn reference(&self) -> Reference {
        Reference::WheelPlane
    }

    fn boxed_clone(&self) -> Box<dyn TyreModel> {
        Box::new(*self)
    }
}
