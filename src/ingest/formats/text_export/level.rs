//! From an inertial unit's own frames to the level frame.
//!
//! The unit leans with the bike: its gyroscope measures the body's rates and its accelerometer
//! gravity too. With roll `r` and pitch `p` (x forward, y left, z up; z-y-x Euler angles)
//!
//! ```text
//! roll rate  = gx + (gy sin r + gz cos r) tan p        ax level = ax cos p + (ay sin r + az cos r) sin p
//! pitch rate = gy cos r - gz sin r                     ay level = ay cos r - az sin r
//! yaw rate   = (gy sin r + gz cos r) / cos p
//! ```
//!
//! and a velocity over the ground, x and y of any level frame with z up, turned by the yaw.

/// A channel that is computed.
#[derive(Debug)]
pub(super) struct Derived {
    pub name: &'static str,
    pub unit: &'static str,
    /// Columns that it is computed from.
    pub of: &'static [&'static str],
    /// How, from one row of those; angles in degrees.
    pub how: fn(&[f64]) -> f64,
}

/// Everything that can be computed. Rates in rad/s, accelerations in m/s².
pub(super) const ALL: &[Derived] = &[
    Derived { name: "velocity_x", unit: "m/s", of: &["Vel_X", "Vel_Y", "Yaw"], how: forward },
    Derived { name: "velocity_y", unit: "m/s", of: &["Vel_X", "Vel_Y", "Yaw"], how: left },
    Derived { name: "acceleration_x", unit: "m/s2", of: SPECIFIC, how: forward_acceleration },
    Derived { name: "acceleration_y", unit: "m/s2", of: SPECIFIC, how: left_acceleration },
    Derived { name: "roll_rate", unit: "rad/s", of: RATES, how: roll_rate },
    Derived { name: "pitch_rate", unit: "rad/s", of: RATES, how: pitch_rate },
    Derived { name: "yaw_rate", unit: "rad/s", of: RATES, how: yaw_rate },
];

const SPECIFIC: &[&str] = &["Acc_X", "Acc_Y", "Acc_Z", "Roll", "Pitch"];
const RATES: &[&str] = &["Gyr_X", "Gyr_Y", "Gyr_Z", "Roll", "Pitch"];

fn forward(row: &[f64]) -> f64 {
    let (sin, cos) = row[2].to_radians().sin_cos();
    row[0] * cos + row[1] * sin
}

fn left(row: &[f64]) -> f64 {
    let (sin, cos) = row[2].to_radians().sin_cos();
    row[1] * cos - row[0] * sin
}

/// The part of a body's vector that is across the pitched forward axis, before the pitch.
fn upright(row: &[f64]) -> f64 {
    let (sin, cos) = row[3].to_radians().sin_cos();
    row[1] * sin + row[2] * cos
}

fn forward_acceleration(row: &[f64]) -> f64 {
    let (sin, cos) = row[4].to_radians().sin_cos();
    row[0] * cos + upright(row) * sin
}

fn left_acceleration(row: &[f64]) -> f64 {
    pitch_rate(row) // the same projection, onto the level lateral axis
}

fn roll_rate(row: &[f64]) -> f64 {
    row[0] + upright(row) * row[4].to_radians().tan()
}

fn pitch_rate(row: &[f64]) -> f64 {
    let (sin, cos) = row[3].to_radians().sin_cos();
    row[1] * cos - row[2] * sin
}

fn yaw_rate(row: &[f64]) -> f64 {
    upright(row) / row[4].to_radians().cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Vector3};

    /// Against rotation matrices: attitudes are differentiated, vectors are rotated.
    #[test]
    fn what_the_unit_measures_becomes_what_is_meant() {
        let angles = |t: f64| (0.5 + 0.7 * t, 0.1 - 0.3 * t, 1.1 + 0.9 * t);
        let body = |t: f64| {
            let (roll, pitch, yaw) = angles(t);
            Rotation3::from_euler_angles(roll, pitch, yaw)
        };
        let h = 1e-6;
        // the body's own rates: R^T dR/dt is the matrix of the cross product
        let change =
            body(0.0).matrix().transpose() * (body(h).matrix() - body(-h).matrix()) / (2.0 * h);
        let gyro = [change[(2, 1)], change[(0, 2)], change[(1, 0)]];
        let (roll, pitch, yaw) = angles(0.0);
        let row = |v: [f64; 3]| [v[0], v[1], v[2], roll.to_degrees(), pitch.to_degrees()];
        for (how, rate) in
            [(roll_rate as fn(&[f64]) -> f64, 0.7), (pitch_rate, -0.3), (yaw_rate, 0.9)]
        {
            assert!((how(&row(gyro)) - rate).abs() < 1e-8, "{} not {rate}", how(&row(gyro)));
        }
        // an acceleration in the frame turned by yaw alone, with gravity, as the body feels it
        let level = Vector3::new(2.0, -3.0, 0.4);
        let turned = Rotation3::from_euler_angles(0.0, 0.0, yaw);
        let felt = body(0.0).inverse() * (turned * (level + Vector3::new(0.0, 0.0, 9.81)));
        let felt = row([felt.x, felt.y, felt.z]);
        assert!((forward_acceleration(&felt) - 2.0).abs() < 1e-12);
        assert!((left_acceleration(&felt) + 3.0).abs() < 1e-12);
        let ground = turned * Vector3::new(20.0, 0.5, 0.0);
        let row = [ground.x, ground.y, yaw.to_degrees()];
        assert!((forward(&row) - 20.0).abs() < 1e-12 && (left(&row) - 0.5).abs() < 1e-12);
    }
}
