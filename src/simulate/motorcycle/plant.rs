//! The parameters of the reduced-order motorcycle.

use crate::contract::bike::Axle;
use crate::motorcycle::vehicle::Vehicle;
use crate::simulate::effects::ModelError;
use crate::tyre::kinematics::height_in_plane;
use crate::tyre::paper::Tyre;
use crate::tyre::tyre_model::Carcass;

/// The true motorcycle of the reduced simulator: numbers, tyres, road friction, and what is hidden in it. SI.
///
/// Apart from the diagnosis' parameters, because its tyres are the paper's coefficients: those have forms that no ride
/// shows, and the fit's stiffness is a quotient of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    /// Masses, lengths, inertias, brakes.
    pub vehicle: Vehicle,
    /// Tyres, front and rear.
    pub tyres: [Tyre; 2],
    /// Crown radii of the unloaded tyres, m.
    pub crown: [f64; 2],
    /// Road friction over that of the tyres' characterisation.
    pub friction: f64,
    /// Effects beyond all that; put in by [`Plant::with`].
    pub model_error: ModelError,
}

impl Plant {
    /// Radius of the crowns under their loads at rest, m: the overturning stiffness of both tyres.
    pub fn loaded_crown(&self) -> f64 {
        self.vehicle.at_mass_centre(self.tyres.map(|t| t.overturning_stiffness))
    }

    /// How far the springs below the centre of mass give under the load at rest, m.
    pub(super) fn loaded_sag(&self) -> f64 {
        self.vehicle.at_mass_centre(self.vehicle.sag)
    }

    /// Distance of the centre of mass from the ground along the leaned plane, m: the frame comes down onto its springs.
    pub(in crate::simulate) fn height_in_plane(&self, cos_phi: f64) -> f64 {
        height_in_plane(self.vehicle.cg_height, self.loaded_crown() - self.loaded_sag(), cos_phi)
    }

    /// Mass and what the wheels' spin adds to it, kg.
    pub(crate) fn moving_mass(&self) -> f64 {
        let Plant { vehicle: Vehicle { mass, wheel_inertia, .. }, tyres, .. } = self;
        mass + (0..2).map(|k| wheel_inertia[k] / tyres[k].rolling_radius.powi(2)).sum::<f64>()
    }

    /// The plant with a model error in it.
    #[must_use]
    pub fn with(mut self, error: &ModelError) -> Self {
        for (tyre, axle) in self.tyres.iter_mut().zip(Axle::BOTH) {
            error.put_into(tyre, axle);
        }
        self.vehicle.wheel_inertia = self.vehicle.wheel_inertia.map(|i| error.wheel_inertia(i));
        self.model_error = *error;
        self
    }

    /// The carcass of tyre `k`.
    pub(super) fn carcass(&self, k: usize, static_load: f64) -> Carcass {
        let Tyre { rolling_radius, vertical_stiffness, .. } = self.tyres[k];
        let (crown, share) = (self.crown[k], self.vehicle.deflection_share);
        Carcass::of_rolling(rolling_radius, static_load, vertical_stiffness, crown, share)
    }
}
