//! The parameters of the reduced-order motorcycle, and what they give at rest.

use crate::GRAVITY;
use crate::contract::bike::Axle;
use crate::simulate::effects::ModelError;
use crate::tyre::kinematics::height_in_plane;
use crate::tyre::paper::Tyre;
use crate::tyre::tyre_model::Carcass;

/// Everything true about the simulated bike. SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    /// Mass with rider.
    pub mass: f64,
    /// Front contact to mass centre.
    pub cg_to_front: f64,
    /// Wheelbase.
    pub wheelbase: f64,
    /// Mass centre height.
    pub cg_height: f64,
    /// Caster angle.
    pub caster_angle: f64,
    /// Roll inertia about the mass centre.
    pub roll_inertia: f64,
    /// Yaw inertia about the mass centre.
    pub yaw_inertia: f64,
    /// Wheel spin inertias, front and rear.
    pub wheel_inertia: [f64; 2],
    /// Tyres, front and rear.
    pub tyres: [Tyre; 2],
    /// Drag `F = c v^2`.
    pub drag: f64,
    /// Road friction.
    pub friction: f64,
    /// Brake torque per pressure, front and rear.
    pub brake_gain: [f64; 2],
    /// Crown radii of the unloaded tyres, m.
    pub crown: [f64; 2],
    /// Share of a tyre's deflection by which it rolls shorter.
    pub deflection_share: f64,
    /// Slip stiffness per load that the tyres gain with the load at rest once more, over itself.
    pub slip_stiffness_load: f64,
    /// How fast the contacts fall behind the mass centre per rate of dive, m.
    pub dive_arm: [f64; 2],
    /// Pitch inertia about the mass centre, kg m²: what a frame that begins to dive takes off the load transfer.
    pub pitch_inertia: f64,
    /// How far the front contact leaves the frame's plane per sine of the handlebar angle, m.
    pub normal_trail: f64,
    /// How far the springs of each end give under the load at rest, m, by which the frame comes down in a bend.
    pub sag: [f64; 2],
    /// What it has beyond all that; put in by [`Plant::with`].
    pub model_error: ModelError,
}

impl Plant {
    /// Radius of the crowns under their loads at rest, m: the overturning stiffness of both tyres.
    pub fn loaded_crown(&self) -> f64 {
        self.at_mass_centre(self.tyres.map(|t| t.overturning_stiffness))
    }

    /// How far the springs below the mass centre give under the load at rest, m.
    pub(super) fn loaded_sag(&self) -> f64 {
        self.at_mass_centre(self.sag)
    }

    /// Distance of the mass centre from the ground along the leaned plane, m: the frame comes down onto its springs.
    pub(in crate::simulate) fn height_in_plane(&self, cos_phi: f64) -> f64 {
        height_in_plane(self.cg_height, self.loaded_crown() - self.loaded_sag(), cos_phi)
    }

    /// What lies below the mass centre of something at the axles.
    fn at_mass_centre(&self, [front, rear]: [f64; 2]) -> f64 {
        front + (rear - front) * self.cg_to_front / self.wheelbase
    }

    /// The plant with a model error in it.
    #[must_use]
    pub fn with(mut self, error: &ModelError) -> Self {
        for (tyre, axle) in self.tyres.iter_mut().zip(Axle::BOTH) {
            error.put_into(tyre, axle);
        }
        self.wheel_inertia = self.wheel_inertia.map(|i| error.wheel_inertia(i));
        self.model_error = *error;
        self
    }

    /// The carcass of tyre `k`.
    pub(super) fn carcass(&self, k: usize, static_load: f64) -> Carcass {
        let Tyre { rolling_radius, vertical_stiffness, .. } = self.tyres[k];
        let (crown, share) = (self.crown[k], self.deflection_share);
        Carcass::of_rolling(rolling_radius, static_load, vertical_stiffness, crown, share)
    }

    /// Wheel loads at rest.
    pub(super) fn static_load(&self) -> [f64; 2] {
        let weight = self.mass * GRAVITY / self.wheelbase;
        [weight * (self.wheelbase - self.cg_to_front), weight * self.cg_to_front]
    }
}
