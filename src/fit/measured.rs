//! What the wheels' own sensors show beside what the balance of forces and the motion of the frame make of the same samples.

use super::data::Data;
use super::solution::Solution;
use crate::contract::bike::Axle;
use crate::contract::warning::Warning;
use crate::estimate::measured::Quantity;
use crate::estimate::samples::Samples;
use crate::estimate::signals::Action;
use crate::statistics::number_format::{decimals, fixed};

/// Estimated against measured of one sensor, sample by sample.
#[derive(Debug, Clone)]
pub struct Compared {
    pub quantity: Quantity,
    /// Of which wheel.
    pub axle: Axle,
    /// As the sensor shows it, N or rad.
    pub measured: Vec<f64>,
    /// Without the sensor.
    pub estimated: Vec<f64>,
    /// Manoeuvre of each sample.
    pub segment: Vec<usize>,
}

/// Quantities that are known without their sensors.
const COMPARED: [Quantity; 4] =
    [Quantity::SlipAngle, Quantity::ForceX, Quantity::ForceY, Quantity::Load];

/// Every sensor of a session that has an estimate beside it.
pub(crate) fn compared(data: &Data, solution: &Solution) -> Vec<Compared> {
    let asked: Vec<_> = data.sensors.iter().filter(|(q, _)| COMPARED.contains(q)).collect();
    if asked.is_empty() {
        return Vec::new();
    }
    let inputs = &solution.inputs;
    let corner = Samples { measured_slip_angle: Default::default(), ..data.corner.clone() };
    let corner = inputs.corner(&corner, data.corner_rate, None);
    let straight = [0, 1].map(|k| inputs.straight(&data.straight[k], &data.action[k]));
    let of = |&&(quantity, axle): &&(Quantity, Axle)| {
        let k = axle as usize;
        let mut out =
            Compared { quantity, axle, measured: vec![], estimated: vec![], segment: vec![] };
        let mut put = |x: &Samples, i: usize, estimated: f64| {
            if let Some(shown) = inputs.sensors.read(quantity, x, k, i)
                && estimated.is_finite()
            {
                out.measured.push(shown);
                out.estimated.push(estimated);
                out.segment.push(x.segment[i]);
            }
        };
        match quantity {
            Quantity::ForceX => {
                let x = &data.straight[k];
                for i in (0..x.len()).filter(|&i| data.action[k][i] != Action::Measured) {
                    // a measuring wheel has rolling resistance besides
                    let rolling = inputs.rolling * straight[k].load[k][i];
                    put(x, i, straight[k].force_x[k][i] - rolling);
                }
            }
            Quantity::Load => {
                for &i in &solution.samples.keep_corner {
                    put(&data.corner, i, corner.load[k][i]);
                }
                let x = &data.straight[k];
                (0..x.len()).for_each(|i| put(x, i, straight[k].load[k][i]));
            }
            Quantity::ForceY => {
                for &i in &solution.samples.keep_corner {
                    put(&data.corner, i, corner.force_y[k][i]);
                }
            }
            _ => {
                for &i in &solution.samples.keep_corner {
                    put(&data.corner, i, corner.slip_angle[k][i]);
                }
            }
        }
        out
    };
    let all: Vec<Compared> = asked.iter().map(of).collect();
    all.into_iter().filter(|c| c.measured.len() >= FEW).collect()
}

/// Samples of a comparison.
const FEW: usize = 30;
/// Cosine of sensor and estimate below which a scale or a sign is not what is wrong.
const ALIKE: f64 = 0.7;
/// Relative difference of sensor and estimate from which one of the two is wrong: beyond what 1 % of scale and the bike file
/// leave.
const DISAGREES: f64 = 0.1;

impl Compared {
    /// Estimated per measured: slope of the line through zero.
    fn slope(&self) -> f64 {
        let pairs = || self.measured.iter().zip(&self.estimated);
        let both: f64 = pairs().map(|(m, e)| m * e).sum();
        both / pairs().map(|(m, _)| m * m).sum::<f64>()
    }

    /// How well the estimate follows the sensor: cosine of the two, 1 where they are in proportion.
    fn likeness(&self) -> f64 {
        let square = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>();
        self.slope() * (square(&self.measured) / square(&self.estimated)).sqrt()
    }

    /// Text about a sensor that disagrees; slip angles have too much noise in the estimate to judge by.
    fn warning(&self) -> Option<Warning> {
        let slope = self.slope();
        if self.quantity == Quantity::SlipAngle || (slope - 1.0).abs() < DISAGREES {
            return None;
        }
        let channel = self.quantity.channels()[self.axle as usize];
        let likeness = self.likeness();
        let message = if likeness.is_nan() || likeness.abs() < ALIKE {
            format!(
                "{channel}: does not follow the balance of forces; is it this channel, and is the sensor alive?"
            )
        } else if slope < 0.0 {
            format!(
                "{channel}: its sign is the other one than the balance of forces has; map it with the other sign"
            )
        } else {
            format!(
                "{channel}: shows {} % of what the balance of forces gives; check its scale, its unit and the bike file's mass and lengths",
                fixed(100.0 / slope, decimals(100.0 / slope))
            )
        };
        Some(Warning {
            stage: "estimate",
            code: "sensor_disagrees",
            channel: Some(channel),
            count: self.measured.len(),
            time: None,
            message,
        })
    }
}

/// Warnings of sensors that disagree with the balance of forces.
pub(crate) fn warnings(compared: &[Compared]) -> Vec<Warning> {
    compared.iter().filter_map(Compared::warning).collect()
}
