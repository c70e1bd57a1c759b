//! The numbers of a motorcycle with its rider that the reduced simulator and the diagnosis share.

use crate::GRAVITY;
use crate::contract::bike::{Axle, Bike};
use crate::motorcycle::balance::USUAL_BRAKE_GAIN;
use crate::tyre::dive::{PITCH_GYRATION, contact_arms};
use crate::tyre::tyre_model::USUAL_SHARE;

/// Roll inertia of a motorcycle with rider about its centre of mass, per mass, m².
///
/// Of the simulated motorcycle, which no bike file says otherwise. The fit to changing lean starts from the middle of what
/// motorcycles have, with its uncertainty (transients of the fit: 0.095 m² and a fifth), and moves it. This number is not
/// moved: another one would change every simulated ride, and both are among the 0.08 to 0.11 of published motorcycles.
const ROLL_GYRATION: f64 = 0.085;

/// A motorcycle with its rider, and what both tyres have in common. SI; pairs are front and rear.
///
/// Apart from [`Bike`], which is a file with optional keys and uncertainties: here every number has a value. What the
/// tyres do is written in two forms, the simulator's coefficients and the diagnosis' parameters, and stands beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Vehicle {
    /// Mass with rider, kg.
    pub mass: f64,
    /// Centre of mass behind the front contact, m.
    pub cg_to_front: f64,
    /// Distance between the contacts, m.
    pub wheelbase: f64,
    /// Height of the centre of mass, m.
    pub cg_height: f64,
    /// Caster angle, rad.
    pub caster_angle: f64,
    /// Roll inertia about the centre of mass, kg m².
    pub roll_inertia: f64,
    /// Yaw inertia about the centre of mass, kg m².
    pub yaw_inertia: f64,
    /// Pitch inertia about the centre of mass over the mass, m².
    pub pitch_gyration: f64,
    /// Spin inertias of the wheels, kg m².
    pub wheel_inertia: [f64; 2],
    /// Drag area term `c` of `F = c v^2`, kg/m.
    pub drag: f64,
    /// Torque of the brakes per line pressure, N m/Pa.
    pub brake_gain: [f64; 2],
    /// How far the front contact leaves the frame's plane per sine of the handlebar angle, m.
    pub normal_trail: f64,
    /// Compression of the springs under the load at rest, m: as much again for every further load, so that in a corner
    /// the frame comes down between the wheels.
    pub sag: [f64; 2],
    /// How fast the contacts fall behind the centre of mass per rate of dive, m.
    pub dive_arm: [f64; 2],
    /// Share of a tyre's deflection by which it rolls shorter.
    pub deflection_share: f64,
    /// Slip stiffness per load that the tyres gain with the load at rest once more, over itself.
    pub slip_stiffness_load: f64,
}

impl Vehicle {
    /// The bike file's numbers, usual ones where it has none; rigid springs, and slip stiffness in proportion to load.
    pub(crate) fn of(bike: &Bike) -> Self {
        let radius = [bike.front.radius, bike.rear.radius];
        Vehicle {
            mass: bike.mass,
            cg_to_front: bike.cg_to_front,
            wheelbase: bike.wheelbase,
            cg_height: bike.cg_height,
            caster_angle: bike.caster_angle,
            roll_inertia: ROLL_GYRATION * bike.mass,
            yaw_inertia: bike.yaw_inertia(),
            pitch_gyration: PITCH_GYRATION[0],
            wheel_inertia: Axle::BOTH.map(|axle| bike.wheel_inertia(axle)),
            drag: bike.drag,
            brake_gain: [
                bike.brake_gain_front.unwrap_or(USUAL_BRAKE_GAIN[0]),
                bike.brake_gain_rear.unwrap_or(USUAL_BRAKE_GAIN[1]),
            ],
            normal_trail: bike.normal_trail(),
            sag: [0.0; 2],
            dive_arm: contact_arms(bike.cg_height, radius, bike.wheelbase, bike.caster_angle),
            deflection_share: bike.front.deflection_share.unwrap_or(USUAL_SHARE),
            slip_stiffness_load: 0.0,
        }
    }

    /// Wheel loads at rest, N.
    pub fn static_loads(&self) -> [f64; 2] {
        let per_length = self.mass * GRAVITY / self.wheelbase;
        [self.wheelbase - self.cg_to_front, self.cg_to_front].map(|l| per_length * l)
    }

    /// Value below the centre of mass of something that is known at the axles.
    pub(crate) fn at_mass_centre(&self, [front, rear]: [f64; 2]) -> f64 {
        front + (rear - front) * self.cg_to_front / self.wheelbase
    }

    /// Pitch inertia about the centre of mass, kg m².
    pub(crate) fn pitch_inertia(&self) -> f64 {
        self.pitch_gyration * self.mass
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_file_lacks_is_usual_and_loads_carry_the_weight() {
        let text = "mass = 200.0\nwheelbase = 1.4\ncg_to_front = 0.6\ncg_height = 0.6\n\
                    caster_angle = 0.42\nfront.radius = 0.3\nfront.width = 0.12\nrear.radius = 0.31\n\
                    rear.width = 0.18\nbrakes.gain_front = 3e-4\n";
        let bike = Bike::parse(text, "b", std::path::Path::new("b.toml")).expect("a bike");
        let vehicle = Vehicle::of(&bike);
        assert_eq!(vehicle.brake_gain, [3e-4, USUAL_BRAKE_GAIN[1]]);
        assert_eq!(vehicle.wheel_inertia, [0.45, 0.60]);
        assert_eq!(vehicle.pitch_inertia(), PITCH_GYRATION[0] * 200.0);
        // the centre of mass is nearer to the front wheel: 8/14 of the weight are on it
        let [front, rear] = vehicle.static_loads();
        assert!((front / (200.0 * GRAVITY) - 8.0 / 14.0).abs() < 1e-12);
        assert!((front + rear - 200.0 * GRAVITY).abs() < 1e-9);
        assert!((vehicle.at_mass_centre([0.1, 0.24]) - 0.16).abs() < 1e-12);
    }
}
