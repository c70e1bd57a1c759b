//! How the residuals of a stretch are correlated.
//!
//! Every residual has white noise through the channels' kernel, or a correlated one, and what the model itself is wrong by,
//! which the rear axle puts into all three. Standard deviations, rad or m/s:
//!
//! | residual | noise |
//! |---|---|
//! | axles | 0.25 mrad white |
//! | velocity | 0.05 m/s over 1 s |
//! | integral | walk of 3 mm/s per root of a second, 2.5 mm/s white, free start and drift, pitch of 1.5 mrad over 6 s times `tan(phi)` |
//! | all | 0.15 mrad over 0.7 s and 0.3 mrad over 10 s of the model, each axle its own |
//!
//! Whitened by the Cholesky factor, stretch by stretch. The first three are scaled by what the residuals show.

use std::ops::Range;

use nalgebra::DMatrix;

use super::columns::{Columns, KERNEL};
use super::model::Residual;

/// White noise of the axles' residual, rad.
const AXLES: f64 = 0.25e-3;
/// Noise of a receiver's lateral velocity, m/s, and its correlation time, s.
const VELOCITY: [f64; 2] = [0.05, 1.0];
/// Walk of the integral, m/s per root of a second, and its white noise, m/s.
const INTEGRAL: [f64; 2] = [3e-3, 2.5e-3];
/// Free start of the integral, m/s, and its free drift, m/s².
const FREE: [f64; 2] = [1.0, 0.05];
/// Slow error of the pitch, rad, measured and not measured, and its correlation time, s.
const PITCH: [f64; 3] = [1.5e-3, 6e-3, 6.0];
/// Errors of the model, rad, and their correlation times, s.
const MODEL: [[f64; 2]; 2] = [[0.15e-3, 0.7], [0.3e-3, 10.0]];
/// Keeps the factor regular, rad².
const REGULAR: f64 = 1e-10;

/// Least scale of each noise: an acceleration is in response and force alike, so its residual never counts as less noisy.
pub(crate) const LEAST: [f64; 3] = [0.5, 0.5, 1.6];

/// Cholesky factor of the covariance of a stretch's residuals, in the order of the model's; `None` where it has none.
pub(crate) fn factor(
    columns: &Columns,
    stretch: &Range<usize>,
    residuals: &[Residual],
    scale: &[f64; 3],
) -> Option<DMatrix<f64>> {
    let n = stretch.len();
    let time = &columns.time[stretch.clone()];
    let speed = &columns.speed[stretch.clone()];
    let lean: Vec<f64> = columns.roll[0][stretch.clone()].iter().map(|phi| phi.tan()).collect();
    let pitch = PITCH[usize::from(!columns.measured.pitch)];
    let own = |residual: Residual, i: usize, j: usize, apart: f64, white: f64| {
        let per_speed = 1.0 / (speed[i] * speed[j]);
        match residual {
            Residual::Axles => (scale[0] * AXLES).powi(2) * white,
            Residual::Velocity => {
                let [sd, over] = VELOCITY;
                (scale[1] * sd).powi(2) * (-apart / over).exp() * per_speed
            }
            Residual::Integral => {
                let walk = INTEGRAL[0].powi(2) * time[i].min(time[j]);
                let white = (scale[2] * INTEGRAL[1]).powi(2) * white;
                let free = FREE[0].powi(2) + FREE[1].powi(2) * time[i] * time[j];
                let tilt = pitch * pitch * lean[i] * lean[j] * (-apart / PITCH[2]).exp();
                (walk + white + free) * per_speed + tilt
            }
        }
    };
    let mut out = DMatrix::zeros(residuals.len() * n, residuals.len() * n);
    for i in 0..n {
        for j in 0..=i {
            let apart = (time[i] - time[j]).abs();
            let white = (-apart * apart / (4.0 * KERNEL * KERNEL)).exp();
            let axle: f64 =
                MODEL.iter().map(|[sd, over]| sd * sd * (-apart / over).exp()).sum();
            for (a, first) in residuals.iter().enumerate() {
                for b in 0..=a {
                    let mut value = axle;
                    if a == b {
                        value += own(*first, i, j, apart, white);
                        value += if *first == Residual::Axles { axle } else { 0.0 };
                        value += if i == j { REGULAR } else { 0.0 };
                    }
                    out[(a * n + i, b * n + j)] = value;
                    out[(a * n + j, b * n + i)] = value;
                }
            }
        }
    }
    // the lower triangle alone is read
    Some(out.cholesky()?.unpack())
}
