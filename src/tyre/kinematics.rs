//! Steering geometry: what handlebar angle and roll make of the front wheel (eqs. 30, 31).
//!
//! The wheel's axle is turned about the raked steering axis, then rolled; ISO axes. Both
//! signs differ from the print (book, Estimation, section 4).

use super::formulation::Formulation;
use crate::GRAVITY;

/// Speed below which the way a motorcycle is steered has nothing to do with its lean, m/s.
const SLOW: f64 = 4.0;

/// Kinematic steering angle `Delta` on the road, rad, eq. 30.
pub(crate) fn kinematic_steer(delta: f64, phi: f64, epsilon: f64, formulation: Formulation) -> f64 {
    let sign = match formulation {
        Formulation::Corrected => 1.0,
        Formulation::Paper => -1.0,
    };
    let (sin_delta, cos_delta) = delta.sin_cos();
    let (sin_phi, cos_phi) = phi.sin_cos();
    let (sin_eps, cos_eps) = epsilon.sin_cos();
    (sin_delta * cos_eps).atan2(cos_phi * cos_delta + sign * sin_phi * sin_delta * sin_eps) // (30)
}

/// Distance of the centre of mass from the ground along the plane of a leaned motorcycle, m. Its wheels stand on
/// crowns of radius `crown` (m, loaded): the crown's centre stays at its height over the ground.
pub(crate) fn height_in_plane(cg_height: f64, crown: f64, cos_phi: f64) -> f64 {
    cg_height + crown * (1.0 / cos_phi - 1.0)
}

/// How a contact lies below the centre of mass of a motorcycle that leans at a given sine and cosine of the roll angle:
/// how far beside it, m, and how fast it goes aside per roll rate, m. In a corner loads along the frame's plane grow by
/// `1/cos(phi)`: springs that give by `sag` (m) at rest let the frame come down by `sag (1/cos(phi) - 1)`.
#[inline(always)]
pub(crate) fn below_mass_centre(
    cg_height: f64,
    crown: f64,
    sag: f64,
    (sin_phi, cos_phi): (f64, f64),
) -> [f64; 2] {
    let tan = sin_phi / cos_phi;
    [
        (cg_height - crown) * sin_phi - sag * (tan - sin_phi),
        (cg_height - crown) * cos_phi + crown - sag * (1.0 + tan * tan - cos_phi),
    ]
}

/// How fast the handlebar turns, rad/s, of a motorcycle that leans in at `roll_rate` (rad/s) at an even `speed` (m/s)
/// and goes where it points: the rate of `delta = l r cos(phi) / (v cos(epsilon))`, `r = -g tan(phi) / v`.
pub(crate) fn steering_rate(
    wheelbase: f64,
    cos_caster: f64,
    cos_phi: f64,
    roll_rate: f64,
    speed: f64,
) -> f64 {
    let speed = speed.max(SLOW);
    -wheelbase * GRAVITY * cos_phi * roll_rate / (speed * speed * cos_caster)
}

/// The front wheel's attitude with the functions of its angles that come for free.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrontWheel {
    /// Sine and cosine of [`kinematic_steer`], times a length.
    pointing: (f64, f64),
    pub steer_sin_cos: (f64, f64),
    /// Camber of the wheel, rad, eq. 31a.
    pub camber: f64,
    pub camber_tan: f64,
    /// Sine of the handlebar angle.
    pub handlebar_sin: f64,
    pub camber_cos: f64,
}

impl FrontWheel {
    /// [`kinematic_steer`], rad: an arc tangent that few need.
    #[inline]
    pub(crate) fn steer(&self) -> f64 {
        self.pointing.0.atan2(self.pointing.1)
    }
}

/// [`kinematic_steer`] and the front wheel's camber at once; `phi` and `epsilon` as sine and cosine.
pub(crate) fn front_wheel(
    delta: f64,
    phi: (f64, f64),
    epsilon: (f64, f64),
    formulation: Formulation,
) -> FrontWheel {
    let sign = match formulation {
        Formulation::Corrected => 1.0,
        Formulation::Paper => -1.0,
    };
    let (sin_delta, cos_delta) = delta.sin_cos();
    let ((sin_phi, cos_phi), (sin_eps, cos_eps)) = (phi, epsilon);
    let across = sign * sin_delta * sin_eps;
    let (y, x) = (sin_delta * cos_eps, cos_phi * cos_delta + sin_phi * across);
    let length = (x * x + y * y).sqrt();
    let down = cos_delta * sin_phi - cos_phi * across;
    let camber_cos = (1.0 - down * down).sqrt();
    FrontWheel {
        pointing: (y, x), // (30)
        steer_sin_cos: (y / length, x / length),
        camber: down.asin(), // (31a)
        camber_tan: down / camber_cos,
        handlebar_sin: sin_delta,
        camber_cos,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Camber of the front wheel, rad, eq. 31a.
    fn front_camber(delta: f64, phi: f64, epsilon: f64, formulation: Formulation) -> f64 {
        let sign = match formulation {
            Formulation::Corrected => -1.0,
            Formulation::Paper => 1.0,
        };
        (delta.cos() * phi.sin() + sign * phi.cos() * delta.sin() * epsilon.sin()).asin() // (31a)
    }

    #[test]
    fn both_at_once_are_each_alone() {
        for formulation in [Formulation::Corrected, Formulation::Paper] {
            for (delta, phi) in [(0.1_f64, -0.6_f64), (-0.2, 0.4), (0.0, 0.3), (0.3, 0.0)] {
                let epsilon = 0.42_f64;
                let w = front_wheel(delta, phi.sin_cos(), epsilon.sin_cos(), formulation);
                let near = |a: f64, b: f64| (a - b).abs() < 1e-14;
                assert!(near(w.steer(), kinematic_steer(delta, phi, epsilon, formulation)));
                assert!(near(w.camber, front_camber(delta, phi, epsilon, formulation)));
                assert!(near(w.steer_sin_cos.0, w.steer().sin()));
                assert!(near(w.steer_sin_cos.1, w.steer().cos()));
                assert!(near(w.camber_tan, w.camber.tan()));
                assert!(near(w.camber_cos, w.camber.cos()));
            }
        }
    }
    use nalgebra::{Rotation3, Unit, Vector3};

    /// The front axle (left-pointing) from rotations alone: about the raked axis, then roll.
    fn axle(delta: f64, phi: f64, epsilon: f64) -> Vector3<f64> {
        // the steering axis leans back: up and rearwards
        let steering = Unit::new_normalize(Vector3::new(-epsilon.sin(), 0.0, epsilon.cos()));
        let steer = Rotation3::from_axis_angle(&steering, delta);
        let roll = Rotation3::from_axis_angle(&Vector3::x_axis(), phi);
        roll * steer * Vector3::y()
    }

    #[test]
    fn both_follow_from_the_rotation_of_the_axle() {
        for phi in [-0.7, -0.3, 0.0, 0.5] {
            for delta in [-0.2, 0.03, 0.4] {
                let epsilon = 0.42;
                let a = axle(delta, phi, epsilon);
                // the wheel's heading is the horizontal direction square to its axle
                let heading = (-a.x).atan2(a.y);
                let camber = a.z.asin();
                let found = kinematic_steer(delta, phi, epsilon, Formulation::Corrected);
                assert!((found - heading).abs() < 1e-12, "{phi} {delta}: {found} {heading}");
                let found = front_camber(delta, phi, epsilon, Formulation::Corrected);
                assert!((found - camber).abs() < 1e-12, "{phi} {delta}: {found} {camber}");
            }
        }
    }

    /// A motorcycle on a crown, leaned: the load acts under the crown's centre, `crown tan(roll)` beside the line in
    /// which the plane meets the ground (eq. 18).
    #[test]
    fn the_mass_centre_is_as_far_from_the_ground_as_the_leaned_body_shows() {
        let (height, crown) = (0.6, 0.07);
        for roll in [-0.9_f64, -0.4, 0.0, 0.7] {
            let up = Rotation3::from_axis_angle(&Vector3::x_axis(), roll) * Vector3::z();
            let centre_of_crown = Vector3::new(0.0, 0.0, crown);
            let mass_centre = centre_of_crown + up * (height - crown);
            let on_ground = centre_of_crown - up * (crown / up.z);
            assert!(on_ground.z.abs() < 1e-12);
            let found = height_in_plane(height, crown, roll.cos());
            assert!((found - (mass_centre - on_ground).norm()).abs() < 1e-12, "{roll}");
            let beside = (centre_of_crown - on_ground).y;
            assert!((beside + crown * roll.tan()).abs() < 1e-12, "{roll}: {beside}");
        }
    }

    #[test]
    fn the_printed_camber_is_two_degrees_off_at_thirty() {
        let (phi, delta, eps) = (-30_f64.to_radians(), 3.0_f64.to_radians(), 0.42);
        let error = front_camber(delta, phi, eps, Formulation::Paper)
            - front_camber(delta, phi, eps, Formulation::Corrected);
        assert!((error.to_degrees() - 2.4).abs() < 0.4, "{}", error.to_degrees());
    }
}
