//! What differs from manoeuvre to manoeuvre: pads that bite anew at every stop, a road whose slope is
//! not quite the same everywhere.
//!
//! Such scatter is neither an effect nor noise within a manoeuvre; fault-free simulations must have it, or what six
//! stops happen to share looks certain.

use super::parameters::Parameters;
use super::problem::{Linear, Problem};
use super::residuals::Blocks;
use super::samples::{BLOCK, Samples};
use crate::statistics::order::{SD_PER_MAD, median};
use crate::statistics::random::Random;

/// Base parameters that differ between manoeuvres.
const GAINS: [&str; 2] = ["brake_gain_front", "brake_gain_rear"];
/// Curvature from which a manoeuvre tells a parameter: to half a scale.
const KNOWN: f64 = 4.0;
/// Standard deviation, as a share, of what a brake's gain differs by over the range of pressures of a ride, as
/// well over that of speeds and over the heat of its stops. The nominal model has it constant; that of an
/// independent simulator without a fault, whose lever arm follows a tyre on another suspension, differs by 0.3 %.
const INCONSTANT: f64 = 0.005;
/// Fewest manoeuvres that a spread is made from.
const MIN_MANOEUVRES: usize = 4;

/// Spreads between manoeuvres.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Scatter {
    /// Of base parameters: place among the parameters, standard deviation in scales.
    pub gains: Vec<(usize, f64)>,
    /// Base parameters that are not quite constant: place, value in scales.
    pub inconstant: Vec<(usize, f64)>,
    /// Of the longitudinal force, m/s².
    pub level: f64,
}

impl Scatter {
    /// That of a ride at a fit's optimum, where `linear` was made.
    pub(crate) fn of(
        samples: &Samples,
        problem: &Problem<'_>,
        linear: &Linear,
        values: &Parameters,
    ) -> Self {
        let blocks = |k: usize| {
            let range = &samples.manoeuvres[k].1;
            range.start / BLOCK..range.end / BLOCK
        };
        let manoeuvres = 0..samples.manoeuvres.len();
        let (mut gains, mut inconstant) = (Vec::new(), Vec::new());
        for name in GAINS {
            let Some(j) = problem.parameters.iter().position(|p| p.name == name) else { continue };
            let parameter = problem.parameters[j];
            inconstant.push((j, parameter.get(values) / parameter.scale));
            let known: Vec<(f64, f64)> = manoeuvres
                .clone()
                .map(|k| problem.along(linear, blocks(k), &[j], &[1.0]))
                .filter(|(_, own)| *own > KNOWN)
                .map(|(pull, own)| (pull / own, 1.0 / own))
                .collect();
            if let Some(sd) = spread(&known) {
                gains.push((j, sd));
            }
        }
        let level: Vec<(f64, f64)> = manoeuvres
            .filter_map(|k| {
                let own: Vec<f64> =
                    blocks(k).map(|b| linear.residuals[0][b]).filter(|r| r.is_finite()).collect();
                let n = own.len() as f64;
                let sigma = problem.sigma[0];
                (n > 4.0).then(|| (own.iter().sum::<f64>() / n, sigma * sigma / n))
            })
            .collect();
        Scatter { gains, inconstant, level: spread(&level).unwrap_or(0.0) }
    }

    /// Adds scatter to the residuals of a fault-free simulation.
    pub(crate) fn add(
        &self,
        samples: &Samples,
        linear: &Linear,
        random: &mut Random,
        to: &mut Blocks,
    ) {
        self.add_inconstant(samples, linear, random, to);
        for (_, range) in &samples.manoeuvres {
            let level = self.level * random.normal();
            let gains: Vec<(usize, f64)> =
                self.gains.iter().map(|(j, sd)| (*j, sd * random.normal())).collect();
            for b in range.start / BLOCK..range.end / BLOCK {
                to[0][b] += level;
                for (j, by) in &gains {
                    for (channel, column) in to.iter_mut().zip(linear.columns[*j].iter()) {
                        // where a channel says nothing it goes on saying nothing
                        channel[b] += if column[b].is_finite() { by * column[b] } else { 0.0 };
                    }
                }
            }
        }
    }
}

impl Scatter {
    /// Adds what gains that are not quite constant change, the same in all manoeuvres.
    fn add_inconstant(
        &self,
        samples: &Samples,
        linear: &Linear,
        random: &mut Random,
        to: &mut Blocks,
    ) {
        for (k, (j, value)) in self.inconstant.iter().enumerate() {
            let heat: Vec<f64> = samples.brakes.iter().map(|b| b.whole.stop).collect();
            for variable in [&samples.pressure[k], &samples.v, &heat] {
                let by = INCONSTANT * value * random.normal();
                let largest = variable.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
                for b in 0..samples.blocks() {
                    let x = 2.0 * variable[b * BLOCK + BLOCK / 2] / largest - 1.0;
                    for (channel, column) in to.iter_mut().zip(linear.columns[*j].iter()) {
                        let change = by * x * column[b];
                        channel[b] += if change.is_finite() { change } else { 0.0 };
                    }
                }
            }
        }
    }
}

/// Standard deviation of values beyond what each is uncertain by, by medians.
fn spread(known: &[(f64, f64)]) -> Option<f64> {
    if known.len() < MIN_MANOEUVRES {
        return None;
    }
    let median_of =
        |f: &dyn Fn(&(f64, f64)) -> f64| median(&mut known.iter().map(f).collect::<Vec<f64>>());
    let middle = median_of(&|k| k.0)?;
    let off = SD_PER_MAD * median_of(&|k| (k.0 - middle).abs())?;
    let own = median_of(&|k| k.1)?;
    Some((off * off - own).max(0.0).sqrt())
}
