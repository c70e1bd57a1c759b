//! The speed that the front wheel tells while the rear one brakes or drives alone.
//!
//! A wheel that rolls freely knows its speed better than a satellite does: its encoder has no slow drift. What it
//! slips itself follows from its own inertia and its tyre's slip stiffness.

use super::samples::Samples;
use crate::motorcycle::balance::USUAL_SLIP_STIFFNESS;
use crate::statistics::order::{SD_PER_MAD, median_or_zero};

/// Slip stiffnesses per load that a front tyre may have.
const SLIP_STIFFNESSES: [f64; 2] = [8.0, 40.0];
/// Least load of a front wheel that rolls with the road, over its load at rest.
pub(crate) const LEAST_LOAD: f64 = 0.2;

/// The front wheel as the measure of the rear one's slip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollingFront {
    /// Slip stiffness per load of its tyre.
    slip_stiffness: f64,
    /// How far the wheels' speeds are apart while both roll, m/s: standard deviation.
    pub error: f64,
}

impl RollingFront {
    /// Where the wheels of the coasting runs `coast` agree better with one another than the rear one does with the
    /// velocity, whose error is `velocity_error` (m/s); `radius` are the rolling radii found there, m.
    pub fn of(
        coast: &Samples,
        radius: [Option<f64>; 2],
        velocity_error: f64,
        slip_stiffness: Option<f64>,
    ) -> Option<Self> {
        let [front, rear] = [radius[0]?, radius[1]?];
        let [low, high] = SLIP_STIFFNESSES;
        let wheels = coast.omega[0].iter().zip(&coast.omega[1]);
        let apart = wheels.map(|(f, r)| (f * front - r * rear).abs());
        let apart: Vec<f64> = apart.filter(|d| d.is_finite()).collect();
        let error = SD_PER_MAD * median_or_zero(&apart);
        (error > 0.0 && error < velocity_error).then_some(RollingFront {
            slip_stiffness: slip_stiffness.unwrap_or(USUAL_SLIP_STIFFNESS).clamp(low, high),
            error,
        })
    }

    /// Speed of the front contact, m/s, by a wheel that goes round with `omega` (rad/s) on a rolling radius (m), with
    /// the friction that its own inertia asks for.
    pub fn speed(&self, omega: f64, radius: f64, friction: f64) -> f64 {
        omega * radius / (1.0 + friction / self.slip_stiffness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coast(noise: f64) -> Samples {
        let at = |k: usize, i: i32| {
            20.0 / [0.3, 0.31][k] + noise * (f64::from(i) * [1.3, 2.1][k]).sin() / 0.3
        };
        let omega = [0, 1].map(|k| (0..500).map(|i| at(k, i)).collect());
        Samples { omega, ..Samples::default() }
    }

    #[test]
    fn the_front_wheel_counts_where_it_agrees_better_than_the_velocity() {
        let radius = [Some(0.3), Some(0.31)];
        let found = RollingFront::of(&coast(0.01), radius, 0.05, None).expect("it agrees");
        assert!((0.005..0.02).contains(&found.error), "{}", found.error);
        assert_eq!(RollingFront::of(&coast(0.1), radius, 0.05, None), None);
        assert_eq!(RollingFront::of(&coast(0.01), [None, radius[1]], 0.05, None), None);
        assert_eq!(RollingFront::of(&Samples::default(), radius, 0.05, None), None);
        // a wheel that is slowed turns slower than the road: its own slip is added
        assert!((found.speed(100.0, 0.3, -0.01) / 30.0 - 1.000_526_3).abs() < 1e-6);
    }
}
