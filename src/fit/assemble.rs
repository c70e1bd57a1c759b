//! Every coefficient from the numbers that were fitted and the bike file.

use super::coasting::Resistance;
use super::cornering::{self, overturning_share};
use super::friction;
use crate::GRAVITY;
use crate::contract::bike::Axle;
use crate::contract::coefficient::{Coefficient as C, Part, Values};
use crate::estimate::signals::Inputs;
use crate::tyre::formulation::Formulation;
use crate::tyre::paper::trail_0;

/// Numbers of a ride's regressions, as far as each was possible; pairs are front and rear.
#[derive(Debug, Clone, Default)]
pub struct FittedNumbers {
    /// Rolling radii, m.
    pub radius: [Option<f64>; 2],
    /// Drag and rolling resistance.
    pub resistance: Option<Resistance>,
    pub friction: [Option<Curve>; 2],
    pub lateral: [cornering::Parameters; 2],
    /// See [`cornering::K_X`].
    pub overturning: Option<f64>,
    /// The same of each tyre by its own moment, where that was measured.
    pub crowns: [Option<f64>; 2],
}

/// The fitted numbers of a friction curve.
#[derive(Debug, Clone)]
pub struct Curve {
    /// In the order of [`friction::PARAMETERS`].
    pub theta: Vec<f64>,
    /// Slip at the peak, if there is one.
    pub peak_slip: Option<f64>,
}

/// A quotient of two uncertain numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quotient {
    pub numerator: f64,
    pub denominator: f64,
}

impl Quotient {
    fn value(self) -> f64 {
        self.numerator / self.denominator
    }
}

/// Coefficients, or the change of coefficients.
#[derive(Debug, Clone)]
pub struct Assembled {
    pub values: Values,
    /// `k_alpha0` of each tyre: `1 / t1`, or printed (39).
    pub stiffness: [Quotient; 2],
    /// Growth of its denominator with the square of camber, 1/rad²: `t2`, or `c3` as printed.
    pub growth: [f64; 2],
}

impl Assembled {
    /// `self - other`.
    #[must_use]
    pub fn minus(&self, other: &Assembled) -> Assembled {
        let difference = |k: usize| Quotient {
            numerator: self.stiffness[k].numerator - other.stiffness[k].numerator,
            denominator: self.stiffness[k].denominator - other.stiffness[k].denominator,
        };
        Assembled {
            values: self.values.minus(&other.values),
            stiffness: [difference(0), difference(1)],
            growth: [0, 1].map(|k| self.growth[k] - other.growth[k]),
        }
    }
}

impl FittedNumbers {
    /// The coefficients that these numbers and the inputs make.
    pub fn assemble(&self, inputs: &Inputs) -> Assembled {
        let mut v = Values::default();
        let (bike, formulation) = (&inputs.bike, inputs.formulation);
        let stiffness = [0, 1].map(|k| self.stiffness(inputs, k));
        for (k, axle) in Axle::BOTH.into_iter().enumerate() {
            let wheel = bike.wheel(axle);
            let lateral = &self.lateral[k];
            v[(axle, C::EffectiveRollingRadius)] = self.radius[k].unwrap_or(f64::NAN);
            if let Some(Curve { theta, peak_slip }) = &self.friction[k] {
                v[(axle, C::MfE2)] = 0.0; // where it is not fitted
                for (coefficient, value) in friction::PARAMETERS.into_iter().zip(theta) {
                    v[(axle, coefficient)] = *value;
                }
                v[(axle, C::PeakSlip)] = peak_slip.unwrap_or(f64::NAN);
            }
            if let Some([c1, c3]) = lateral.slip {
                v[(axle, C::SlipCamberC1)] = c1;
                v[(axle, C::SlipCamberC3)] = c3;
            }
            v[(axle, C::LateralFrictionCt)] = lateral.ct.unwrap_or(f64::NAN);
            let (k_alpha, ratio) = (stiffness[k].value(), wheel.side_force_ratio);
            v[(axle, C::CorneringStiffness0)] = k_alpha;
            v[(axle, C::CamberStiffness0)] = ratio * k_alpha; // (13)
            v[(axle, C::SlipStiffnessLoad)] = bike.slip_stiffness_load(axle);
            v[(axle, C::SideForceRatio)] = ratio;
            v[(axle, C::TwistingStiffness)] = wheel.twisting_stiffness;
            v[(axle, C::RelaxationLength)] = wheel.relaxation_length.unwrap_or(inputs.radius[k]);
            let share = match axle {
                Axle::Front => bike.cg_to_rear(),
                Axle::Rear => bike.cg_to_front,
            } / bike.wheelbase;
            let load = bike.mass * GRAVITY * share;
            v[(axle, C::PneumaticTrail0)] =
                trail_0(inputs.radius[k], wheel.vertical_stiffness, load);
        }
        if let Some(found) = self.resistance {
            v[(Part::Vehicle, C::Drag)] = found.drag;
            v[(Part::Vehicle, C::RollingResistance)] = found.rolling;
        }
        let k_x = self.overturning.unwrap_or(f64::NAN);
        for part in Part::ALL {
            let own = part.axle().and_then(|axle| self.crowns[axle as usize]);
            let shared = k_x * overturning_share(bike, formulation, part);
            v[(part, C::OverturningStiffness)] = own.unwrap_or(shared);
        }
        let growth = [0, 1].map(|k| self.growth(inputs, k));
        Assembled { values: v, stiffness, growth }
    }

    fn growth(&self, inputs: &Inputs, k: usize) -> f64 {
        let lateral = &self.lateral[k];
        let found = match inputs.formulation {
            Formulation::Corrected => lateral.t2,
            Formulation::Paper => lateral.slip.map(|[_, c3]| c3),
        };
        found.unwrap_or(f64::NAN)
    }

    fn stiffness(&self, inputs: &Inputs, k: usize) -> Quotient {
        let lateral = &self.lateral[k];
        let ratio = inputs.bike.wheel(Axle::BOTH[k]).side_force_ratio;
        match inputs.formulation {
            Formulation::Corrected => {
                Quotient { numerator: 1.0, denominator: lateral.t1.unwrap_or(f64::NAN) }
            }
            // (39); its sign as in (22b)
            Formulation::Paper => Quotient {
                numerator: -lateral.ct.unwrap_or(f64::NAN),
                denominator: lateral.slip.map_or(f64::NAN, |[c1, _]| c1) + ratio,
            },
        }
    }
}
