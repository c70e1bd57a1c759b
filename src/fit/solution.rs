//! The fits of a session, their samples, and the coefficients that come of them.

use super::assemble::{Assembled, Curve, FittedNumbers};
use super::coasting::Coasting;
use super::cornering::{self, K_X, Lateral, OverturningRows, overturning_share};
use super::data::Data;
use super::friction::{self, Friction, is_of_curve};
use super::variation::Source;
use crate::contract::coefficient::{Coefficient, Id};
use crate::estimate::samples::Samples;
use crate::estimate::signals::Inputs;
use crate::statistics::clustered_fit::{Fitted, Quality, Uncertainty, count};

/// Everything that was fitted; pairs are front and rear.
#[derive(Debug, Clone, Default)]
pub struct Fits {
    /// Radii, drag and rolling resistance.
    pub coasting: Coasting,
    pub friction: [Option<Friction>; 2],
    /// Slip angle, lateral friction and compliance over camber.
    pub lateral: [Lateral; 2],
    /// The overturning moment, see [`K_X`].
    pub overturning: Option<Fitted>,
    /// Each tyre's own overturning moment, where measuring wheels show it.
    pub crowns: [Option<Fitted>; 2],
}

impl Fits {
    pub fn parameters(&self) -> FittedNumbers {
        FittedNumbers {
            radius: self.coasting.radii(),
            resistance: self.coasting.resistances(),
            friction: [0, 1].map(|k| {
                let fit = self.friction[k].as_ref()?;
                Some(Curve { theta: fit.theta.clone(), peak_slip: fit.formula.peak_slip() })
            }),
            lateral: [0, 1].map(|k| self.lateral[k].parameters()),
            overturning: self.overturning.as_ref().map(|f| f.theta[K_X]),
            crowns: self.crowns.each_ref().map(|c| c.as_ref().map(|f| f.theta[K_X])),
        }
    }
}

/// Used manoeuvres that samples were gathered of, by what is fitted to them; pairs are front and rear.
#[derive(Debug, Clone, Copy, Default)]
pub struct Gathered {
    /// Rolling radii.
    pub rolling: [usize; 2],
    /// Drag and rolling resistance.
    pub coasting: usize,
    pub straight: [usize; 2],
    /// Everything lateral.
    pub corner: usize,
}

impl Gathered {
    /// Of the samples of a session.
    pub(super) fn of_data(data: &Data) -> Self {
        let of = |samples: &Samples| count(&samples.segment);
        Gathered {
            rolling: [&data.front_rolling, &data.coast].map(of),
            coasting: of(&data.coast),
            straight: data.straight.each_ref().map(of),
            corner: of(&data.corner),
        }
    }

    /// Those that a coefficient is fitted to.
    pub(super) fn of(&self, id: Id) -> usize {
        match (id.coefficient, id.part.axle()) {
            (Coefficient::EffectiveRollingRadius, Some(axle)) => self.rolling[axle as usize],
            (Coefficient::Drag | Coefficient::RollingResistance, _) => self.coasting,
            (coefficient, Some(axle)) if is_of_curve(coefficient) => self.straight[axle as usize],
            _ => self.corner,
        }
    }
}

/// The samples that the fits were made of; pairs are front and rear.
#[derive(Debug, Clone, Default)]
pub struct FittedSamples {
    /// Samples that they were chosen from.
    pub gathered: Gathered,
    pub friction: [friction::Rows; 2],
    pub lateral: [cornering::Rows; 2],
    pub overturning: OverturningRows,
    /// Each tyre's own overturning moment, as measuring wheels show it.
    pub crowns: [OverturningRows; 2],
    /// Indices of the straight samples that were kept.
    pub keep_straight: [Vec<usize>; 2],
    /// Indices of the corner samples that were kept: quasi-static and uncombined.
    pub keep_corner: Vec<usize>,
    /// Indices of the steadiest of those, for the overturning moment.
    pub keep_steady: Vec<usize>,
}

/// Effect of one standard error of one upstream quantity.
#[derive(Debug, Clone)]
pub struct Upstream {
    pub source: Source,
    /// The key that the bike file does not have, if the quantity is one.
    pub missing: Option<String>,
    /// Change of the coefficients.
    pub change: Assembled,
}

/// The coefficients of a session, and what moves them.
#[derive(Debug, Clone)]
pub struct Solution {
    pub found: Assembled,
    /// Quantities that move the coefficients besides their own manoeuvres.
    pub upstream: Vec<Upstream>,
    pub fits: Fits,
    pub samples: FittedSamples,
    /// Inputs of the algebra, as they were used.
    pub inputs: Inputs,
    /// Of tyres whose stiffness and side force ratio come from changes of lean: how that fit was reached; its clusters are
    /// stretches.
    pub ridden: [Option<Quality>; 2],
}

impl Solution {
    /// How well the fit of a coefficient knows it; without samples where it was not fitted.
    pub fn uncertainty(&self, id: Id) -> Uncertainty {
        if self.is_of_changing_lean(id)
            && let Some(ridden) =
                id.part.axle().and_then(|axle| self.ridden[axle as usize].as_ref())
        {
            let (dof, quality) = (f64::INFINITY, ridden.clone());
            return Uncertainty { variance: 0.0, dof, dispersion: None, quality };
        }
        let own = self.fits.coasting.uncertainty(id);
        let own = own.or_else(|| self.overturning(id)).or_else(|| {
            let k = id.part.axle()? as usize;
            let curve = || self.fits.friction[k].as_ref()?.uncertainty(id.coefficient);
            let lateral = || self.fits.lateral[k].uncertainty(id.coefficient);
            curve().or_else(lateral).or_else(|| self.stiffness(id))
        });
        own.unwrap_or_default()
    }

    fn overturning(&self, id: Id) -> Option<Uncertainty> {
        let (bike, formulation) = (&self.inputs.bike, self.inputs.formulation);
        if let (Coefficient::OverturningStiffness, Some(axle)) = (id.coefficient, id.part.axle())
            && let Some(crown) = &self.fits.crowns[axle as usize]
        {
            return Some(crown.uncertainty(K_X, 1.0));
        }
        let fitted = self.fits.overturning.as_ref()?;
        (id.coefficient == Coefficient::OverturningStiffness)
            .then(|| fitted.uncertainty(K_X, overturning_share(bike, formulation, id.part)))
    }

    /// Of a quotient only what the fit of its denominator knows.
    fn stiffness(&self, id: Id) -> Option<Uncertainty> {
        let (Coefficient::CorneringStiffness0 | Coefficient::CamberStiffness0) = id.coefficient
        else {
            return None;
        };
        let k = id.part.axle()? as usize;
        let fitted = self.fits.lateral[k].stiffness_fit(self.inputs.formulation)?;
        let scale = self.found.values[id] / self.found.stiffness[k].denominator;
        Some(fitted.uncertainty(0, scale.abs()))
    }
}
