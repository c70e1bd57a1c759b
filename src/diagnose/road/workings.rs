//! What the residuals are made of at some parameters, kept: a linearisation in sixty parameters works out anew for
//! each only what that one acts on.

use super::attitude::{Attitude, Posture};
use super::parameters::{Parameter, Parameters};
use super::residuals::{Blocks, Forces, Instant, blocks_of};
use super::samples::Samples;
use crate::contract::residual_channel::ResidualChannel;
use crate::effects::physics::Reach;

/// A point of a friction curve: slip ratio, value, slope.
type Point = [f64; 3];

/// Workings of the residuals at some parameters, sample by sample.
#[derive(Debug)]
pub struct Workings<'a> {
    samples: &'a Samples,
    values: &'a Parameters,
    posture: Posture,
    attitudes: Vec<Attitude>,
    forces: Vec<Forces>,
    curves: Vec<[Point; 2]>,
    /// The residuals there.
    pub blocks: Blocks,
}

impl<'a> Workings<'a> {
    /// Those at some parameters.
    pub fn of(samples: &'a Samples, values: &'a Parameters) -> Self {
        let posture = Posture::of(values);
        let mut attitudes = Vec::with_capacity(samples.len());
        let mut forces = Vec::with_capacity(samples.len());
        let mut curves = vec![[[f64::NAN; 3]; 2]; samples.len()];
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
            let (value, slope) = values.friction[k].value_and_slope(ratio);
            curves[i][k] = [ratio, value, slope];
            (value, slope)
        };
        let blocks = blocks_of(samples, values, Reach::ATTITUDE, attitude, all, curve);
        Workings { samples, values, posture, attitudes, forces, curves, blocks }
    }

    /// The residuals with one of the parameters elsewhere, and what it acts on: in other channels they are nil.
    pub fn near(&self, parameter: &Parameter, value: f64) -> (Blocks, Reach) {
        let mut near = self.values.clone();
        parameter.set(&mut near, value);
        let posture = Posture::of(&near);
        let reach = if posture == self.posture { parameter.reach } else { Reach::ATTITUDE };
        let attitude = |i: usize, cornering| match reach.attitude {
            true => Attitude::of(self.samples, &posture, i, cornering),
            false => self.attitudes[i],
        };
        let forces = |i: usize, instant: &Instant<'_>| match reach.forces {
            true => instant.longitudinal(),
            false => self.forces[i],
        };
        let same = near.friction == self.values.friction;
        let curve = |k: usize, i: usize, ratio: f64| {
            let [at, value, slope] = self.curves[i][k];
            match same && at == ratio {
                true => (value, slope),
                false => near.friction[k].value_and_slope(ratio),
            }
        };
        (blocks_of(self.samples, &near, reach, attitude, forces, curve), reach)
    }

    /// Derivatives of the residuals by a parameter, in its scales, by a difference over `step` of them.
    pub fn column(&self, parameter: &Parameter, step: f64) -> Blocks {
        let value = parameter.get(self.values) + step * parameter.scale;
        let (mut column, reach) = self.near(parameter, value);
        for (channel, (there, here)) in
            ResidualChannel::ALL.into_iter().zip(column.iter_mut().zip(&self.blocks))
        {
            if reach.acts_on(channel) {
                there.iter_mut().zip(here).for_each(|(t, h)| *t = (*t - h) / step);
            }
        }
        column
    }
}
