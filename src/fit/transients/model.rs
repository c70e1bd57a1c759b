//! Lateral velocity by each axle, and the residuals of the measurements.

use crate::GRAVITY;

use super::columns::{Columns, RATE};
use super::motion::{InverseDynamics, Motion, Quantity};
use super::parameters::*;

/// Friction at which the side force would reach its peak; between 0.9 and 1.4 it changes nothing.
const PEAK: f64 = 1.1;

/// A residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Residual {
    /// Front against rear axle: handlebar and yaw rate.
    Axles,
    /// Measured lateral velocity against the rear axle.
    Velocity,
    /// Integral of the lateral acceleration against the rear axle.
    Integral,
    /// Lateral acceleration against the forces of the tyres.
    Force,
}

/// The motion of a ride, and how it depends on what is known of motorcycle and sensors.
pub(crate) struct Model<'a> {
    /// Columns.
    pub columns: &'a Columns,
    /// The residuals that the channels allow.
    pub residuals: Vec<Residual>,
    dynamics: &'a InverseDynamics<'a>,
    mean: &'a [f64],
    quantities: &'a [Quantity],
    motion: Motion,
    /// Change of the motion by each quantity.
    changes: Vec<Motion>,
}

impl<'a> Model<'a> {
    pub(crate) fn new(
        columns: &'a Columns,
        dynamics: &'a InverseDynamics<'a>,
        parameters: &'a Prior,
    ) -> Self {
        let motion = dynamics.motion(columns, &dynamics.start);
        let of = |(k, quantity): (usize, &Quantity)| {
            let sd = parameters.sd[QUANTITIES + k];
            let mut moved = dynamics.start.clone();
            moved[*quantity] += sd;
            let mut change = dynamics.motion(columns, &moved);
            change.add(&motion, -1.0);
            change.scale(1.0 / sd);
            change
        };
        let changes = parameters.quantities.iter().enumerate().map(of).collect();
        let mut residuals = vec![Residual::Axles];
        if columns.measured.velocity {
            residuals.push(Residual::Velocity);
        }
        if columns.measured.acceleration {
            residuals.extend([Residual::Integral, Residual::Force]);
        }
        let quantities = &parameters.quantities;
        Model { columns, residuals, dynamics, mean: &parameters.mean, quantities, motion, changes }
    }

    /// The motion with the quantities of `theta`.
    fn moved(&self, theta: &[f64]) -> Motion {
        let mut out = self.motion.clone();
        for (k, change) in self.changes.iter().enumerate() {
            let by = theta[QUANTITIES + k] - self.mean[QUANTITIES + k];
            if by != 0.0 {
                out.add(change, by);
            }
        }
        out
    }

    /// Residuals.
    pub(crate) fn at(&self, theta: &[f64]) -> Vec<f64> {
        self.of_motion(&self.moved(theta), theta)
    }

    /// Residuals and their derivatives, a row for every parameter.
    pub(crate) fn linear(&self, theta: &[f64], sd: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
        let mut motion = self.moved(theta);
        let here = self.of_motion(&motion, theta);
        let mut rows = Vec::with_capacity(theta.len());
        let mut moved = theta.to_vec();
        for (j, sd) in sd.iter().enumerate() {
            let step = match j {
                _ if j >= 2 * OF_TYRE => 0.1 * sd,
                _ if j % OF_TYRE == LN_STIFFNESS => 1e-3,
                _ if j % OF_TYRE == RATIO => 1e-4,
                _ => 0.05 * sd,
            };
            moved[j] += step;
            let there = match j.checked_sub(QUANTITIES) {
                Some(k) => {
                    motion.add(&self.changes[k], step);
                    let there = self.of_motion(&motion, theta);
                    motion.add(&self.changes[k], -step);
                    there
                }
                None => self.of_motion(&motion, &moved),
            };
            moved[j] = theta[j];
            rows.push(there.iter().zip(&here).map(|(a, b)| (a - b) / step).collect());
        }
        (here, rows)
    }

    /// What a change of a quantity adds to all residuals.
    pub(crate) fn moved_by(&self, theta: &[f64], quantity: Quantity, by: f64) -> Vec<f64> {
        let mut motion = self.moved(theta);
        let before = self.of_motion(&motion, theta);
        if let Some(k) = self.quantities.iter().position(|q| *q == quantity) {
            motion.add(&self.changes[k], by);
        }
        let after = self.of_motion(&motion, theta);
        after.iter().zip(&before).map(|(a, b)| a - b).collect()
    }

    fn of_motion(&self, motion: &Motion, theta: &[f64]) -> Vec<f64> {
        let [front, rear] = self.velocities(motion, theta);
        let mut out = Vec::with_capacity(self.residuals.len() * front.len());
        for residual in &self.residuals {
            for i in 0..front.len() {
                let mut scale = motion.along[1][i];
                let left = match residual {
                    Residual::Axles => front[i] - rear[i],
                    Residual::Velocity => motion.drift[i] - theta[VELOCITY_ZERO] - rear[i],
                    Residual::Integral => motion.integral[i] - rear[i],
                    Residual::Force => {
                        scale = GRAVITY;
                        motion.pushed[i]
                    }
                };
                out.push(left / scale);
            }
        }
        out
    }

    /// Lateral velocity of the centre of mass by each axle, m/s.
    fn velocities(&self, motion: &Motion, theta: &[f64]) -> [Vec<f64>; 2] {
        let n = motion.steer.len();
        let tyre = |k: usize| &theta[k * OF_TYRE..(k + 1) * OF_TYRE];
        let standing = self.dynamics.standing;
        let stretch = |k: usize, i: usize| (motion.load[k][i] / standing[k]).powf(tyre(k)[LOAD]);
        let thrust = |k: usize, gamma: f64| {
            let (t, square) = (tyre(k), gamma * gamma);
            t[RATIO] * gamma * (1.0 + square * (t[SECOND] + square * t[FOURTH]))
        };
        let stiffness = [0, 1].map(|k| tyre(k)[LN_STIFFNESS].exp());
        let mut slip = [vec![0.0; n], vec![0.0; n]];
        for i in 0..n {
            let growth = [stretch(0, i), stretch(1, i)];
            // the camber stiffness grows with the load itself: so does the angle that has no side force
            let camber = [0, 1].map(|k| growth[k] * thrust(k, motion.camber[k][i]));
            // the share of the side force that slip makes has the pneumatic trail as its arm
            let moment: f64 = (0..2)
                .map(|k| {
                    let leaning = stiffness[k] * camber[k] * motion.load[k][i] / growth[k];
                    -self.dynamics.pneumatic_trail[k] * (motion.force[k][i] + leaning)
                })
                .sum();
            for k in 0..2 {
                let force = motion.force[k][i] + moment * motion.per_moment[k][i];
                let bend = (force / motion.load[k][i] / PEAK).clamp(-0.99, 0.99).asin() * PEAK;
                let loss = 1.0 + tyre(k)[LOSS] * motion.camber[k][i].powi(2);
                slip[k][i] = -growth[k] * bend / stiffness[k] * loss - camber[k];
            }
        }
        [0, 1].map(|k| {
            let t = tyre(k);
            let mut out = Vec::with_capacity(n);
            for stretch in self.columns.stretches() {
                let slip = &slip[k][stretch.clone()];
                for (j, i) in stretch.enumerate() {
                    let along = motion.along[k][i];
                    let angle = slip[j] + t[RELAXATION] / along * rate(slip, j) + t[ZERO];
                    let points = if k == 0 { motion.steer[i] } else { 0.0 };
                    out.push(along * (angle + points).tan() - motion.aside[k][i]);
                }
            }
            out
        })
    }
}

/// Derivative over five samples, fewer at the ends, 1/s.
fn rate(x: &[f64], i: usize) -> f64 {
    let last = x.len() - 1;
    if i >= 2 && i + 2 <= last {
        return RATE * (8.0 * (x[i + 1] - x[i - 1]) - (x[i + 2] - x[i - 2])) / 12.0;
    }
    let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
    RATE * (x[b] - x[a]) / (b - a).max(1) as f64
}
