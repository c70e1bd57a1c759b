//! The state, its errors and what is believed before.

use nalgebra::{Rotation3, SMatrix, SVector, Vector3};

pub(crate) const N: usize = 42;
/// Position of the unit as the receiver sees it, world, m.
pub(crate) const P: usize = 0;
/// Velocity of the unit, world, m/s.
pub(crate) const V: usize = 3;
/// Attitude, body axes, rad.
pub(crate) const THETA: usize = 6;
/// Bias of the rates, rad/s.
pub(crate) const GYRO: usize = 9;
/// Bias of the specific forces, m/s².
pub(crate) const FORCE: usize = 12;
/// Scale and cross-axis errors of the rates, row by row.
pub(crate) const SCALE: usize = 15;
/// Antenna from the unit, body, m.
pub(crate) const ANTENNA: usize = 24;
/// Main frame from body, rad.
pub(crate) const MOUNT: usize = 27;
/// Delay of the receiver beyond the one that epochs are placed by, s.
pub(crate) const DELAY: usize = 30;
/// Correlated error of the receiver's velocity, m/s.
pub(crate) const DOPPLER: usize = 31;
/// Logarithms of the rolling radii over the usual one, front and rear.
pub(crate) const RADIUS: usize = 34;
/// Crown radii, front and rear, m.
pub(crate) const CROWN: usize = 36;
/// Error of the other sensor's lean, rad.
pub(crate) const LEAN: usize = 38;
/// Mean roll, pitch and side slip of straight running, rad: crosswind, road crown, a crabbing frame.
pub(crate) const STRAIGHT: usize = 39;

/// One number per error.
pub(crate) type Errors = SVector<f64, N>;
/// Covariance of the errors.
pub(crate) type Covariance = SMatrix<f64, N, N>;

/// Values from which errors count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct State {
    /// Position, m.
    pub position: Vector3<f64>,
    /// Velocity, m/s.
    pub velocity: Vector3<f64>,
    /// Body to world.
    pub attitude: Rotation3<f64>,
    /// All else, at its place among the errors.
    pub other: Errors,
}

impl State {
    /// At rest in the origin, everything else as is usual.
    pub(crate) fn usual() -> Self {
        let mut other = Errors::zeros();
        other[CROWN] = USUAL_CROWN[0];
        other[CROWN + 1] = USUAL_CROWN[1];
        State {
            position: Vector3::zeros(),
            velocity: Vector3::zeros(),
            attitude: Rotation3::identity(),
            other,
        }
    }

    /// Three of the other numbers.
    pub(crate) fn three(&self, at: usize) -> Vector3<f64> {
        self.other.fixed_rows::<3>(at).into_owned()
    }

    /// The state with its errors taken out.
    #[must_use]
    pub(crate) fn corrected(&self, errors: &Errors) -> Self {
        let three = |at: usize| errors.fixed_rows::<3>(at).into_owned();
        let mut other = self.other;
        for i in GYRO..N {
            other[i] += errors[i];
        }
        State {
            position: self.position + three(P),
            velocity: self.velocity + three(V),
            attitude: self.attitude * Rotation3::from_scaled_axis(three(THETA)),
            other,
        }
    }

    /// Body rate of a measured one.
    pub(crate) fn rate(&self, measured: &Vector3<f64>) -> Vector3<f64> {
        let w = measured - self.three(GYRO);
        let m = self.other.fixed_rows::<9>(SCALE);
        w - Vector3::from_fn(|i, _| (0..3).map(|j| m[3 * i + j] * w[j]).sum())
    }

    /// Specific force of a measured one, body axes.
    pub(crate) fn force(&self, measured: &Vector3<f64>) -> Vector3<f64> {
        measured - self.three(FORCE)
    }

    /// Main frame to world.
    pub(crate) fn frame(&self) -> Rotation3<f64> {
        self.attitude * Rotation3::from_scaled_axis(self.three(MOUNT))
    }
}

/// Usual rolling radius, m.
pub(crate) const USUAL_RADIUS: f64 = 0.31;
/// Usual crown radii, front and rear, m.
const USUAL_CROWN: [f64; 2] = [0.06, 0.09];

/// Correlation time of the receiver's velocity error, s.
pub(crate) const DOPPLER_TIME: f64 = 2.0;
/// Correlation time of the other sensor's lean error, s.
pub(crate) const LEAN_TIME: f64 = 30.0;

/// Standard deviations before the ride is looked at.
pub(crate) fn prior() -> Errors {
    let degree = 1_f64.to_radians();
    let mut sd = Errors::zeros();
    let mut put = |at: usize, values: &[f64]| {
        values.iter().enumerate().for_each(|(i, x)| sd[at + i] = *x);
    };
    put(P, &[5.0; 3]);
    put(V, &[0.5; 3]);
    put(THETA, &[4.0 * degree, 4.0 * degree, 6.0 * degree]);
    put(GYRO, &[0.7 * degree; 3]);
    put(FORCE, &[0.3; 3]);
    put(SCALE, &[0.004; 9]);
    put(ANTENNA, &[0.03; 3]);
    put(MOUNT, &[4.0 * degree; 3]);
    put(DELAY, &[0.1]);
    put(DOPPLER, &[0.06, 0.06, 0.09]);
    put(RADIUS, &[0.1; 2]);
    put(CROWN, &[0.02, 0.03]);
    put(LEAN, &[1.2 * degree]);
    // fast motorcycles squat by degrees
    put(STRAIGHT, &[0.3 * degree, 1.5 * degree, 0.2 * degree]);
    sd
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_blocks_fill_the_state_without_holes() {
        let sd = prior();
        assert!(sd.iter().all(|x| *x > 0.0), "{sd}");
        let blocks = [P, V, THETA, GYRO, FORCE, SCALE, ANTENNA, MOUNT, DELAY, DOPPLER];
        let sizes = [3, 3, 3, 3, 3, 9, 3, 3, 1, 3];
        for ((a, size), b) in blocks.iter().zip(sizes).zip(&blocks[1..]) {
            assert_eq!(a + size, *b);
        }
        assert_eq!(
            [DOPPLER + 3, RADIUS + 2, CROWN + 2, LEAN + 1, STRAIGHT + 3],
            [RADIUS, CROWN, LEAN, STRAIGHT, N]
        );
    }
}
