//! The chain run again with one upstream quantity moved, every robust weight held.
//!
//! METHOD: the change of a coefficient is a mean over the samples of what each sample changes by, and that is smooth over
//! a ride: of many corner samples every n-th gives it ([`MOST_CORNER`]; a test holds the changes to those of all samples).
//! It is the difference of two fits to the same samples, with and without the move.

use super::assemble::{Assembled, Curve, FittedNumbers};
use super::coasting;
use super::config::Config;
use super::cornering::{self, K_X, Lateral, crown_rows};
use super::data::Data;
use super::friction::Rows;
use super::rows::{friction_rows, front_overturning, lateral_rows};
use super::solution::{Fits, FittedSamples, Upstream};
use super::variation::Variation;
use crate::contract::bike::Axle;
use crate::estimate::samples::Samples;
use crate::estimate::signals::{HeldLag, Inputs};
use crate::statistics::clustered_fit;

/// Most corner samples of a refit.
pub const MOST_CORNER: usize = 1000;

/// Straight samples that tell whether an input moves a friction curve.
const PROBE: usize = 24;

/// At most about `most` of so many places, evenly.
fn evenly(all: usize, most: usize) -> Vec<usize> {
    (0..all).step_by(all.div_ceil(most).max(1)).collect()
}

/// Values at the given indices.
fn of<T: Copy>(all: &[T], places: &[usize]) -> Vec<T> {
    places.iter().filter_map(|&p| all.get(p).copied()).collect()
}

/// Data that all refits share: the samples of the fits that they need.
pub struct Refit<'a> {
    nominal: &'a Inputs,
    fits: &'a Fits,
    samples: &'a FittedSamples,
    config: &'a Config,
    data: Data,
    /// A few of the straight samples, and their rows with nothing moved.
    probe: Data,
    still_probe: [Rows; 2],
    /// Of the kept corner samples, all that `data` has, how the slip angles lag.
    lag: HeldLag,
    /// The lateral fits' weights of the same samples, and their indices.
    lateral: [Lateral; 2],
    corner: Vec<usize>,
    /// The steady corner samples, and the overturning fit's weights. Out of their context their lagged slip angles mean
    /// nothing, but the overturning moment does not depend on them.
    steady: Samples,
    steady_weights: Vec<f64>,
    /// Places of those samples among all steady ones.
    steady_places: Vec<usize>,
    /// Slip of the friction peaks, and its gradient.
    peak: [Option<(f64, Vec<f64>)>; 2],
}

impl<'a> Refit<'a> {
    /// `nominal` are the inputs before coasting changed them, `found` after; at most about `most` corner samples take part.
    pub fn new(
        data: &Data,
        [nominal, found]: [&'a Inputs; 2],
        fits: &'a Fits,
        samples: &'a FittedSamples,
        config: &'a Config,
        most: usize,
    ) -> Self {
        let thinned = evenly(samples.keep_corner.len(), most);
        let corner = of(&samples.keep_corner, &thinned);
        let steady = evenly(samples.keep_steady.len(), most);
        let weights = fits.overturning.as_ref().map_or(&[][..], |fitted| &fitted.weights);
        let straight = |keep: [&[usize]; 2], corner: Samples| Data {
            straight: [0, 1].map(|k| data.straight[k].select(keep[k])),
            action: [0, 1].map(|k| keep[k].iter().map(|&i| data.action[k][i]).collect()),
            coast: data.coast.clone(),
            front_rolling: data.front_rolling.clone(),
            corner,
            sensors: data.sensors.clone(),
            ..*data
        };
        let keep = samples.keep_straight.each_ref().map(Vec::as_slice);
        let few = keep.map(|keep| of(keep, &evenly(keep.len(), PROBE)));
        let mut refit = Refit {
            nominal,
            fits,
            samples,
            config,
            data: straight(keep, data.corner.select(&corner)),
            probe: straight(few.each_ref().map(Vec::as_slice), Samples::default()),
            still_probe: Default::default(),
            lag: found.held_lag(&data.corner, data.corner_rate, &corner),
            lateral: [0, 1].map(|k| fits.lateral[k].with_weights_of(&thinned)),
            corner: (0..corner.len()).collect(),
            steady_weights: of(weights, &steady),
            steady_places: steady.clone(),
            steady: data.corner.select(&of(&samples.keep_steady, &steady)),
            peak: [0, 1].map(|k| fits.friction[k].as_ref().and_then(|f| f.peak_slip())),
        };
        let (still, ..) = refit.moved(&Variation::default());
        refit.still_probe = [0, 1].map(|k| refit.rows(&refit.probe, &still, k));
        refit
    }

    /// The changes of the coefficients by some variations.
    pub fn changes(&self, variations: Vec<Variation>) -> Vec<Upstream> {
        let still = self.with(&Variation::default());
        let change = |variation: Variation| Upstream {
            change: self.with(&variation).minus(&still),
            source: variation.source,
            missing: variation.missing,
        };
        variations.into_iter().map(change).collect()
    }

    /// The coefficients with one input moved. A variation of what coasting gave is not fed back into
    /// coasting's own coefficients: their own sandwich has it.
    fn with(&self, variation: &Variation) -> Assembled {
        let (inputs, radius, resistance) = self.moved(variation);
        let data = &self.data;
        let friction = [0, 1].map(|k| self.friction(&inputs, k));
        let overturning = self.fits.overturning.as_ref().and_then(|_| {
            let signals = inputs.corner(&self.steady, data.corner_rate, None);
            let (lever, moment) = (&signals.overturning_lever, &signals.overturning);
            clustered_fit::refit(&[lever], moment, &self.steady_weights).map(|t| t[K_X])
        });
        let crowns = [0, 1].map(|k| {
            let fitted = self.fits.crowns[k].as_ref()?;
            let signals = inputs.corner(&self.steady, data.corner_rate, None);
            let all: Vec<usize> = (0..self.steady.len()).collect();
            let rows = crown_rows(&signals, &self.steady.segment, &all, k);
            let weights = of(&fitted.weights, &self.steady_places);
            clustered_fit::refit(&[&rows.lever], &rows.moment, &weights).map(|t| t[K_X])
        });
        let front = front_overturning(overturning, &inputs);
        let signals = inputs.corner_with_lag(&data.corner, &self.lag, front);
        let lateral = Axle::BOTH.map(|axle| {
            let rows = lateral_rows(data, &signals, &inputs.bike, &self.corner, axle);
            cornering::refit(&rows, &self.lateral[axle as usize])
        });
        FittedNumbers { radius, resistance, friction, lateral, overturning, crowns }
            .assemble(&inputs)
    }

    /// The inputs as a variation moves them, and what coasting gives with them.
    fn moved(
        &self,
        variation: &Variation,
    ) -> (Inputs, [Option<f64>; 2], Option<coasting::Resistance>) {
        let mut inputs = self.nominal.clone();
        if let Some(bike) = &variation.bike {
            let nominal = Inputs::nominal(bike, inputs.formulation, inputs.zeros);
            inputs = Inputs { rolling_front: inputs.rolling_front, ..nominal };
        }
        if let Some(zeros) = variation.zeros {
            inputs.zeros = zeros;
        }
        let data = &self.data;
        let (radius, resistance) =
            coasting::refit(&data.coast, &data.front_rolling, &inputs, &self.fits.coasting);
        for k in 0..2 {
            inputs.radius[k] = radius[k].unwrap_or(inputs.radius[k]) + variation.radius[k];
        }
        if let Some(found) = resistance {
            inputs.drag = found.drag;
            inputs.rolling = found.rolling;
        }
        inputs.drag += variation.drag;
        inputs.rolling += variation.rolling;
        inputs.trail_ratio += variation.trail_ratio;
        inputs.pitch_gyration += variation.pitch_gyration;
        inputs.roll_scale += variation.roll_scale;
        inputs.slip_difference += variation.slip_difference;
        inputs.sensors = variation.sensors;
        (inputs, radius, resistance)
    }

    /// The friction rows of all straight samples of some data.
    fn rows(&self, data: &Data, inputs: &Inputs, k: usize) -> Rows {
        let signals = inputs.straight(&data.straight[k], &data.action[k]);
        let all: Vec<usize> = (0..data.straight[k].len()).collect();
        let (coasting, config) = (&self.fits.coasting, &self.config.friction);
        friction_rows(data, inputs, &signals, k, &all, coasting, config)
    }

    fn friction(&self, inputs: &Inputs, k: usize) -> Option<Curve> {
        let fitted = self.fits.friction[k].as_ref()?;
        // most inputs move some of the fits only: a few samples tell
        let moves = self.rows(&self.probe, inputs, k) != self.still_probe[k];
        let theta = if moves {
            let mut rows = self.rows(&self.data, inputs, k);
            rows.both_signs = self.samples.friction[k].both_signs;
            fitted.refit_with_fixed_weights(&rows)
        } else {
            fitted.theta.clone()
        };
        // a curve without a peak still has its factors
        let peak_slip = self.peak[k].as_ref().map(|(peak, gradient)| {
            let changes = theta.iter().zip(&fitted.theta).zip(gradient);
            peak + changes.map(|((now, then), g)| (now - then) * g).sum::<f64>()
        });
        Some(Curve { theta, peak_slip })
    }
}
