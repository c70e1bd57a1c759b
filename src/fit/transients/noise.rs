//! How the residuals of a stretch are correlated, and how large their noise is.
//!
//! | part | of | standard deviation |
//! |---|---|---|
//! | axles | axles' residual | 0.25 mrad white |
//! | velocity | velocity's | 0.05 m/s over 1 s |
//! | integral | integral's | walk of 3 mm/s per root of a second, 2.5 mm/s white |
//! | force | force's | 4 mg over 1.5 s and 0.5 mg white, free start |
//! | attitude | all | pitch 3.5 mrad and roll 3 mrad over 6 s, each times what it does to the residuals |
//! | model | all others, each axle its own | 0.15 mrad over 0.7 s, 0.3 mrad over 10 s, 3 mm in the bend over 10 s |
//!
//! An attitude filter drifts by milliradians while it holds the shape of its rates. A wrong pitch makes yaw rate of roll rate, and that
//! looks like the gyroscopic moments which tell the stiffness. On three rides of the independent simulator, errors of cornering
//! stiffness were 9 % in front and 6 % at the rear, and 2 % with the true pitch in the log.
//!
//! White is white before the channels' kernel. The integral's start and drift are free besides. The parts are scaled by what the
//! residuals show ([`Scales`]), sensors' parts to no less than usual ones: gusts, a rider who moves and a frame that twists make the model's part several times larger than
//! still air does. Where it is taken too small, whitening favours what is fast, where such disturbances exceed the ride's own
//! forces, and stiffnesses come out too large.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::columns::{KERNEL, RATE};
use super::model::{Model, Residual};
use super::motion::Quantity;
use crate::statistics::blocked;

/// White noise of the axles' residual, rad.
const AXLES: f64 = 0.25e-3;
/// Noise of a receiver's lateral velocity, m/s, and its correlation time, s.
const VELOCITY: [f64; 2] = [0.05, 1.0];
/// Walk of the integral, m/s per root of a second, and its white noise, m/s.
const INTEGRAL: [f64; 2] = [3e-3, 2.5e-3];
/// Free start of the integral, m/s, and its free drift, m/s².
const FREE: [f64; 2] = [1.0, 0.05];
/// Slow error of a pitch, rad, measured and not measured.
const PITCH: [f64; 2] = [3.5e-3, 10e-3];
/// Slow error of the roll, rad.
const ROLL: f64 = 3e-3;
/// Correlation time of both, s.
const ATTITUDE_TIME: f64 = 6.0;
/// Errors of the model, rad, and their correlation times, s.
const MODEL: [[f64; 2]; 2] = [[0.15e-3, 0.7], [0.3e-3, 10.0]];
/// How far a contact lies from where it is taken to be, m, and for how long, s: springs, fork and carcass give way.
const PLACE: [f64; 2] = [3e-3, 10.0];
/// Gusts over the weight, and their correlation time, s.
const GUST: [f64; 2] = [4e-3, 1.5];
/// White noise of the lateral acceleration over that of gravity.
const PUSH: f64 = 0.5e-3;
/// Its free zero in a stretch, over that of gravity.
const PUSH_ZERO: f64 = 5e-3;
/// What a rider who moves makes of the side force, over the weight.
const SWAY: f64 = 1e-3;
/// Usual cornering stiffness over load, 1/rad, by which such a force is a slip angle.
const STIFFNESS: f64 = 15.0;
/// Keeps the factor regular, rad².
const REGULAR: f64 = 1e-10;

/// Number of parts.
pub(crate) const PARTS: usize = 5;
/// Place of the model's part.
const OF_MODEL: usize = 4;
/// Smallest and largest scale of each part. An acceleration is in response and force alike: its residual never counts as
/// less noisy. What residuals show of white and of slow parts goes from one into the other, so a sensor counts as no better than
/// usual.
const BOUNDS: [[f64; 2]; PARTS] = [[1.0, 20.0], [1.0, 20.0], [1.2, 20.0], [0.5, 20.0], [2.0, 20.0]];

/// Scale of each part's standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales(pub [f64; PARTS]);

impl Default for Scales {
    fn default() -> Self {
        Scales([1.0, 1.0, 1.6, 1.0, 2.0])
    }
}

impl Scales {
    /// Scaled by what the residuals have over what they should: `found` are sums of squares and their expectations.
    pub(crate) fn updated(self, found: &[[f64; 2]; PARTS]) -> Self {
        let mut out = self;
        for (k, [square, expected]) in found.iter().enumerate() {
            if *expected > 0.0 && square.is_finite() {
                let [low, high] = BOUNDS[k];
                out.0[k] = (out.0[k] * (square / expected).sqrt()).clamp(low, high);
            }
        }
        out
    }
}

/// A part's correlations by how many samples lie between.
struct Lags {
    white: Vec<f64>,
    velocity: Vec<f64>,
    attitude: Vec<f64>,
    model: Vec<f64>,
    place: Vec<f64>,
    gust: Vec<f64>,
}

impl Lags {
    fn new(n: usize) -> Self {
        let of = |f: &dyn Fn(f64) -> f64| (0..n).map(|k| f(k as f64 / RATE)).collect();
        Lags {
            white: of(&|t| (-t * t / (4.0 * KERNEL * KERNEL)).exp()),
            velocity: of(&|t| (-t / VELOCITY[1]).exp()),
            attitude: of(&|t| (-t / ATTITUDE_TIME).exp()),
            place: of(&|t| PLACE[0].powi(2) * (-t / PLACE[1]).exp()),
            gust: of(&|t| (-t / GUST[1]).exp()),
            model: of(&|t| MODEL.iter().map(|[sd, over]| sd * sd * (-t / over).exp()).sum()),
        }
    }
}

/// What slow errors of the attitude do to all residuals: for each, as many as there are, one standard deviation of it.
pub(crate) struct Attitude(Vec<Vec<f64>>);

impl Attitude {
    /// With the tyres and quantities of `theta`.
    pub(crate) fn new(model: &Model<'_>, theta: &[f64]) -> Self {
        let pitch = PITCH[usize::from(!model.columns.measured.pitch)];
        let of = |(quantity, sd)| model.moved_by(theta, quantity, sd);
        Attitude([(Quantity::UnitPitch, pitch), (Quantity::RollZero, ROLL)].map(of).into())
    }
}

/// The noise of one stretch.
pub(crate) struct Noise<'a> {
    residuals: &'a [Residual],
    time: &'a [f64],
    speed: &'a [f64],
    /// Residuals of the stretch, moved by each slow error of the attitude.
    attitude: Vec<Vec<f64>>,
    /// Yaw rate over speed, 1/m.
    bend: Vec<f64>,
    lags: Lags,
}

impl<'a> Noise<'a> {
    pub(crate) fn new(model: &'a Model<'_>, stretch: &Range<usize>, attitude: &Attitude) -> Self {
        let Model { columns, residuals, .. } = model;
        let own = |moved: &Vec<f64>| {
            let of = |a| &moved[a * columns.len()..][stretch.clone()];
            (0..residuals.len()).flat_map(of).copied().collect()
        };
        Noise {
            residuals,
            attitude: attitude.0.iter().map(own).collect(),
            time: &columns.time[stretch.clone()],
            speed: &columns.speed[stretch.clone()],
            bend: {
                let pairs =
                    columns.yaw[0][stretch.clone()].iter().zip(&columns.speed[stretch.clone()]);
                pairs.map(|(yaw, v)| yaw / v).collect()
            },
            lags: Lags::new(stretch.len()),
        }
    }

    /// Covariances of a pair of samples: of each part's own residual, of the model's, what is free, and what both axles have
    /// alike; rad².
    fn pair(&self, i: usize, j: usize) -> ([f64; PARTS], [f64; 2]) {
        let lag = i.abs_diff(j);
        let (time, lags) = (self.time, &self.lags);
        let per_speed = 1.0 / (self.speed[i] * self.speed[j]);
        let walk = INTEGRAL[0].powi(2) * time[i].min(time[j]);
        let white = INTEGRAL[1].powi(2) * lags.white[lag];
        let free = FREE[0].powi(2) + FREE[1].powi(2) * time[i] * time[j];
        let parts = [
            AXLES * AXLES * lags.white[lag],
            VELOCITY[0].powi(2) * lags.velocity[lag] * per_speed,
            (walk + white) * per_speed,
            GUST[0].powi(2) * lags.gust[lag] + PUSH * PUSH * lags.white[lag],
            lags.model[lag] + lags.place[lag] * self.bend[i] * self.bend[j],
        ];
        (parts, [free * per_speed, (SWAY / STIFFNESS).powi(2) * lags.gust[lag]])
    }

    /// Lower triangle of the covariance of all residuals.
    fn covariance(&self, scales: &Scales) -> DMatrix<f64> {
        let n = self.time.len();
        let square = scales.0.map(|s| s * s);
        let mut out = DMatrix::zeros(self.residuals.len() * n, self.residuals.len() * n);
        for i in 0..n {
            for j in 0..=i {
                let (parts, [free, gust]) = self.pair(i, j);
                let axle = square[OF_MODEL] * parts[OF_MODEL];
                for (a, residual) in self.residuals.iter().enumerate() {
                    let k = *residual as usize;
                    let own = square[k] * parts[k]
                        + match residual {
                            Residual::Axles => axle,
                            Residual::Velocity => 0.0,
                            Residual::Integral => free,
                            Residual::Force => PUSH_ZERO * PUSH_ZERO,
                        }
                        + if i == j { REGULAR } else { 0.0 };
                    for b in 0..=a {
                        let is_force = *residual == Residual::Force;
                        let apart = is_force != (self.residuals[b] == Residual::Force);
                        // what both axles have alike is not between them
                        let is_between =
                            *residual == Residual::Axles || self.residuals[b] == Residual::Axles;
                        let alike = if is_between { 0.0 } else { gust };
                        let common = if is_force || apart { 0.0 } else { axle + alike };
                        let value = common + if a == b { own } else { 0.0 };
                        let drift = |p: usize, q: usize| {
                            let both = self.attitude.iter().map(|moved| moved[p] * moved[q]);
                            self.lags.attitude[i - j] * both.sum::<f64>()
                        };
                        let [p, q] = [a * n + i, b * n + j];
                        out[(p, q)] = value + drift(p, q);
                        let [p, q] = [a * n + j, b * n + i];
                        out[(p, q)] = value + drift(p, q);
                    }
                }
            }
        }
        out
    }

    /// Cholesky factor of that; `None` where it has none.
    pub(crate) fn factor(&self, scales: &Scales) -> Option<DMatrix<f64>> {
        blocked::cholesky(self.covariance(scales))
    }

    /// How large each part is in whitened residuals, and how large it should be: what `r' K^-1 C K^-1 r` and the trace of
    /// `K^-1 C` are for the part's covariance `C`.
    pub(crate) fn shares(
        &self,
        factor: &DMatrix<f64>,
        whitened: &DVector<f64>,
    ) -> [[f64; 2]; PARTS] {
        let n = self.time.len();
        let mut inverse = DMatrix::identity(factor.nrows(), factor.nrows());
        blocked::solve_lower(factor, &mut inverse);
        let left = inverse.tr_mul(whitened);
        let precision = inverse.transpose() * inverse;
        let mut out = [[0.0; 2]; PARTS];
        for i in 0..n {
            for j in 0..n {
                let (parts, _) = self.pair(i, j);
                let mut rear = [0.0; 2];
                for (a, residual) in self.residuals.iter().enumerate() {
                    for b in 0..self.residuals.len() {
                        let (p, q) = (a * n + i, b * n + j);
                        let by = [left[p] * left[q], precision[(p, q)]];
                        let own = if a == b { parts[*residual as usize] } else { 0.0 };
                        let forces = [*residual, self.residuals[b]].map(|r| r == Residual::Force);
                        let kinematic = if forces == [false; 2] { 1.0 } else { 0.0 };
                        let front = a == b && *residual == Residual::Axles;
                        for m in 0..2 {
                            out[*residual as usize][m] += own * by[m];
                            rear[m] += kinematic * by[m] * if front { 2.0 } else { 1.0 };
                        }
                    }
                }
                (0..2).for_each(|m| out[OF_MODEL][m] += parts[OF_MODEL] * rear[m]);
            }
        }
        out
    }
}
