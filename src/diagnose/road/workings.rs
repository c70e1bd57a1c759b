//! Intermediate results of the residuals, kept for a linearisation in sixty parameters: for each parameter only the
//! parts that it acts on are computed again.

use super::attitude::{Attitude, Posture, ReusableTerms};
use super::parameters::{Parameter, Parameters};
use super::residuals::{Blocks, Forces, Instant, blocks_of};
use super::samples::Samples;
use crate::contract::residual_channel::ResidualChannel;
use crate::simulate::effects::physics::Reach;

/// Largest change of the slip ratio over which a friction curve is taken as a parabola. All short series together err by
/// less than 0.03 % of the change of the residuals (`tests/it/effects.rs`).
const MAX_PARABOLA_SLIP_CHANGE: f64 = 2e-4;

/// A point of a friction curve: slip ratio, friction, slope, curvature.
type Point = [f64; 4];

/// Attitude, forces and friction of every sample at one set of parameters.
#[derive(Debug)]
pub struct LinearisationCache<'a> {
    samples: &'a Samples,
    values: &'a Parameters,
    posture: Posture,
    attitudes: Vec<Attitude>,
    forces: Vec<Forces>,
    curves: Vec<[Point; 2]>,
    /// The residuals at these parameters.
    pub blocks: Blocks,
}

impl<'a> LinearisationCache<'a> {
    /// Computes them at `values`.
    pub fn of(samples: &'a Samples, values: &'a Parameters) -> Self {
        let posture = Posture::of(values);
        let mut attitudes = Vec::with_capacity(samples.len());
        let mut forces = Vec::with_capacity(samples.len());
        let mut curves = vec![[[f64::NAN; 4]; 2]; samples.len()];
        let attitude = |i, cornering| {
            let own = Attitude::of(samples, &posture, i, cornering);
            attitudes.push(own);
            own
        };
        let all = |_, instant: &Instant<'_>| {
            let own = instant.longitudinal();
            forces.push(own);
            own
        };
        let curve = |k: usize, i: usize, ratio| {
            let [value, slope, curvature] = values.friction[k].value_slope_and_curvature(ratio);
            curves[i][k] = [ratio, value, slope, curvature];
            (value, slope)
        };
        let blocks = blocks_of(samples, values, Reach::ATTITUDE, attitude, all, curve);
        LinearisationCache { samples, values, posture, attitudes, forces, curves, blocks }
    }

    /// The residuals with one parameter at another value, and the channels that it acts on; all other channels are 0.
    pub fn near(&self, parameter: &Parameter, value: f64) -> (Blocks, Reach) {
        let mut near = self.values.clone();
        parameter.set(&mut near, value);
        let posture = Posture::of(&near);
        let reach = if posture == self.posture { parameter.reach } else { Reach::ATTITUDE };
        let known = ReusableTerms::of(&self.posture, &posture);
        let attitude = |i: usize, cornering| {
            let known = Some(known(&self.attitudes[i]));
            Attitude::near(self.samples, &posture, i, cornering, known)
        };
        let forces = |_, instant: &Instant<'_>| instant.longitudinal();
        // unchanged parts are borrowed: they are large
        let (same_attitude, same_forces) =
            (|i: usize, _| &self.attitudes[i], |i: usize, _: &Instant<'_>| &self.forces[i]);
        let same = near.friction == self.values.friction;
        let curve = |k: usize, i: usize, ratio: f64| {
            let [at, value, slope, curvature] = self.curves[i][k];
            let by = ratio - at;
            match same && by.abs() < MAX_PARABOLA_SLIP_CHANGE {
                true => (value + by * (slope + 0.5 * by * curvature), slope + by * curvature),
                false => near.friction[k].value_and_slope(ratio),
            }
        };
        let samples = self.samples;
        let blocks = match (reach.attitude, reach.forces) {
            (true, _) => blocks_of(samples, &near, reach, attitude, forces, curve),
            (false, true) => blocks_of(samples, &near, reach, same_attitude, forces, curve),
            (false, false) => blocks_of(samples, &near, reach, same_attitude, same_forces, curve),
        };
        (blocks, reach)
    }

    /// Derivatives of the residuals by a parameter, in its scales: the difference over `step` scales.
    pub fn column(&self, parameter: &Parameter, step: f64) -> Blocks {
        let value = parameter.get(self.values) + step * parameter.scale;
        let (mut column, reach) = self.near(parameter, value);
        for (channel, (there, here)) in
            ResidualChannel::ALL.into_iter().zip(column.iter_mut().zip(&self.blocks))
        {
            if reach.acts_on(channel) {
                // a residual that is missing at either value has no derivative
                there.iter_mut().zip(here).for_each(|(t, h)| {
                    let slope = (*t - h) / step;
                    *t = if slope.is_finite() { slope } else { 0.0 };
                });
            }
        }
        column
    }
}
