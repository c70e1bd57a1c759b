//! The chain run again with one upstream quantity moved, every robust weight held.

use super::assemble::{Assembled, Curve, Parameters};
use super::coasting;
use super::config::Config;
use super::cornering::{self, K_X};
use super::data::Data;
use super::rows::{friction_rows, front_overturning, lateral_rows};
use super::solution::{Fits, FittedSamples};
use super::variation::Variation;
use crate::contract::bike::Axle;
use crate::estimate::samples::Samples;
use crate::estimate::signals::Inputs;
use crate::statistics::clustered_fit;

/// What every refit shares: the samples that the fits kept, and no more.
pub struct Refit<'a> {
    nominal: &'a Inputs,
    fits: &'a Fits,
    samples: &'a FittedSamples,
    config: &'a Config,
    data: Data,
    /// Of the kept straight samples: all of them.
    straight: [Vec<usize>; 2],
    /// The steady corner samples. Out of their context their lagged slip angles mean nothing,
    /// but the overturning moment does not depend on them.
    steady: Samples,
    /// Slip of the friction peaks, and its gradient.
    peak: [Option<(f64, Vec<f64>)>; 2],
}

impl<'a> Refit<'a> {
    /// `nominal` are the inputs before coasting changed them.
    pub fn new(
        data: &Data,
        nominal: &'a Inputs,
        fits: &'a Fits,
        samples: &'a FittedSamples,
        config: &'a Config,
    ) -> Self {
        let keep = &samples.keep_straight;
        let actions = |k: usize| keep[k].iter().map(|&i| data.action[k][i]).collect();
        Refit {
            nominal,
            fits,
            samples,
            config,
            data: Data {
                straight: [0, 1].map(|k| data.straight[k].select(&keep[k])),
                action: [actions(0), actions(1)],
                coast: data.coast.clone(),
                front_rolling: data.front_rolling.clone(),
                corner: data.corner.clone(),
                ..*data
            },
            straight: [0, 1].map(|k| (0..keep[k].len()).collect()),
            steady: data.corner.select(&samples.keep_steady),
            peak: [0, 1].map(|k| fits.friction[k].as_ref().and_then(|f| f.peak_slip())),
        }
    }

    /// The coefficients with one input moved. A variation of what coasting gave is not fed back into
    /// coasting's own coefficients: their own sandwich has it.
    pub fn with(&self, variation: &Variation) -> Assembled {
        let (inputs, radius, resistance) = self.moved(variation);
        let data = &self.data;
        let friction = [0, 1].map(|k| self.friction(&inputs, k));
        let overturning = self.fits.overturning.as_ref().and_then(|fitted| {
            let signals = inputs.corner(&self.steady, data.corner_rate, None);
            let (lever, moment) = (&signals.overturning_lever, &signals.overturning);
            clustered_fit::refit(&[lever], moment, &fitted.weights).map(|t| t[K_X])
        });
        let front = front_overturning(overturning, &inputs);
        let signals = inputs.corner(&data.corner, data.corner_rate, front);
        let lateral = Axle::BOTH.map(|axle| {
            let keep = &self.samples.keep_corner;
            let rows = lateral_rows(data, &signals, &inputs.bike, keep, axle);
            cornering::refit(&rows, &self.fits.lateral[axle as usize])
        });
        Parameters { radius, resistance, friction, lateral, overturning }.assemble(&inputs)
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
        (inputs, radius, resistance)
    }

    fn friction(&self, inputs: &Inputs, k: usize) -> Option<Curve> {
        let (fitted, data) = (self.fits.friction[k].as_ref()?, &self.data);
        let signals = inputs.straight(&data.straight[k], &data.action[k]);
        let all = &self.straight[k];
        let mut rows = friction_rows(
            data,
            inputs,
            &signals,
            k,
            all,
            &self.fits.coasting,
            &self.config.friction,
        );
        rows.both_signs = self.samples.friction[k].both_signs;
        let theta = fitted.refit_with_fixed_weights(&rows);
        // a curve without a peak still has its factors
        let peak_slip = self.peak[k].as_ref().map(|(peak, gradient)| {
            let changes = theta.iter().zip(&fitted.theta).zip(gradient);
            peak + changes.map(|((now, then), g)| (now - then) * g).sum::<f64>()
        });
        Some(Curve { theta, peak_slip })
    }
}
