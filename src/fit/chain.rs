//! The paper's fits in their order, and how each coefficient depends on what is upstream.
//!
//! METHOD: a coefficient's variance is that of its own manoeuvres (sandwich over clusters) plus,
//! for every independent upstream quantity `u` with standard error `s` (sensor zeros, latency,
//! radii, drag, and each uncertain number of the bike file), the square of its change when `u`
//! moves by `s`. The chain is simply run again with `u` moved, robust weights held: no
//! derivative is written by hand, and what depends on what is never stated twice.

use super::assemble::Assembled;
use super::coasting;
use super::config::Config;
use super::cornering::{self, K_X};
use super::data::Data;
use super::friction::{self, Friction, Rows};
use super::refit::{MOST_CORNER, Refit};
use super::rows::{friction_rows, front_overturning, lateral_rows};
use super::selection;
use super::slip_stiffness_load::{self, Gain, STEP};
use super::solution::{Fits, FittedSamples, Gathered, Solution, Upstream};
use super::variation::{Source, variations};
use crate::contract::bike::{Axle, Bike};
use crate::contract::coefficient::{Coefficient, Id, Part};
use crate::estimate::rolling_front::RollingFront;
use crate::estimate::signals::Inputs;
use crate::tyre::formulation::Formulation;

/// Runs the chain and all its variations.
#[cfg(feature = "internals")]
pub fn solve(data: &Data, bike: &Bike, formulation: Formulation, config: &Config) -> Solution {
    let mut solution = solve_once(data, bike, formulation, config);
    solution.upstream = upstream(&solution, data, bike, config);
    solution
}

/// Runs the chain alone: values without what moves them, so without the shares of upstream quantities in their errors.
pub(crate) fn solve_once(
    data: &Data,
    bike: &Bike,
    formulation: Formulation,
    config: &Config,
) -> Solution {
    let nominal = Inputs::nominal(bike, formulation, data.zeros);
    let mut fits = Fits {
        coasting: coasting::fit(&data.coast, &data.front_rolling, data.shows_coasting, &nominal),
        ..Fits::default()
    };
    let mut inputs = nominal.clone();
    for (k, radius) in fits.coasting.radii().into_iter().enumerate() {
        inputs.radius[k] = radius.unwrap_or(inputs.radius[k]);
    }
    if let Some(found) = fits.coasting.resistances() {
        inputs.drag = found.drag;
        inputs.rolling = found.rolling;
    }

    let mut samples =
        FittedSamples { gathered: Gathered::of_data(data), ..FittedSamples::default() };
    for (k, axle) in Axle::BOTH.into_iter().enumerate() {
        let signals = inputs.straight(&data.straight[k], &data.action[k]);
        let keep = selection::friction_samples(data, &signals, k, bike);
        let rows = |inputs: &Inputs| {
            friction_rows(data, inputs, &signals, k, &keep, &fits.coasting, &config.friction)
        };
        samples.friction[k] = rows(&inputs);
        fits.friction[k] = friction::fit(&samples.friction[k]);
        if let Some(known) = gain_known(&inputs, axle, fits.friction[k].as_ref(), rows) {
            inputs.bike = known;
            samples.friction[k] = rows(&inputs);
            let before = fits.friction[k].take();
            fits.friction[k] = before.and_then(|f| friction::fit_near(&samples.friction[k], &f));
        }
        samples.keep_straight[k] = keep;
        inputs.rolling_front = rolling_front(data, &fits, formulation);
    }
    let bike = &inputs.bike;
    let signals = inputs.corner(&data.corner, data.corner_rate, None);
    samples.keep_corner = selection::quasi_static(data, &signals, bike);
    samples.keep_steady = selection::steady(data, &samples.keep_corner);
    samples.overturning =
        cornering::overturning_rows(&signals, &data.corner.segment, &samples.keep_steady);
    fits.overturning = cornering::fit_overturning(&samples.overturning, bike.mass);
    for k in 0..2 {
        let rows = cornering::crown_rows(&signals, &data.corner.segment, &samples.keep_steady, k);
        if rows.moment.iter().all(|m| m.is_finite()) {
            fits.crowns[k] = cornering::fit_overturning(&rows, bike.mass);
            samples.crowns[k] = rows;
        }
    }
    // the crowns first: the driven rear wheel's pull beside the plane needs them
    let front = front_overturning(fits.overturning.as_ref().map(|f| f.theta[K_X]), &inputs);
    let signals = inputs.corner(&data.corner, data.corner_rate, front);
    for (k, axle) in Axle::BOTH.into_iter().enumerate() {
        samples.lateral[k] = lateral_rows(data, &signals, bike, &samples.keep_corner, axle);
        fits.lateral[k] = cornering::fit(&samples.lateral[k]);
    }

    let found = fits.parameters().assemble(&inputs);
    Solution { found, upstream: Vec::new(), fits, samples, inputs, ridden: [None, None] }
}

/// Quantities that move the coefficients of a solution besides their own manoeuvres; `data` and `bike` as it was solved with.
pub(crate) fn upstream(
    solution: &Solution,
    data: &Data,
    bike: &Bike,
    config: &Config,
) -> Vec<Upstream> {
    let Solution { found, fits, samples, inputs, .. } = solution;
    let formulation = inputs.formulation;
    let nominal = Inputs {
        rolling_front: inputs.rolling_front,
        bike: inputs.bike.clone(),
        ..Inputs::nominal(bike, formulation, data.zeros)
    };
    let refit = Refit::new(data, [&nominal, inputs], fits, samples, config, MOST_CORNER);
    let bike = &inputs.bike;
    let mut upstream =
        refit.changes(variations(bike, &data.zeros, &fits.coasting, formulation, &data.sensors));
    upstream.extend(model_errors(found, formulation, config));
    upstream
}

/// The bike with what a tyre's slip stiffness gains with its load, where the fit tells something of it; `rows` are the
/// fit's samples with other inputs.
fn gain_known(
    inputs: &Inputs,
    axle: Axle,
    fit: Option<&Friction>,
    rows: impl Fn(&Inputs) -> Rows,
) -> Option<Bike> {
    let key = format!("{}.{}", axle.name(), Coefficient::SlipStiffnessLoad);
    let Inputs { bike, formulation, .. } = inputs;
    let before = Gain { value: bike.slip_stiffness_load(axle), sd: bike.deviation(&key) };
    if *formulation == Formulation::Paper || before.sd <= 0.0 {
        return None;
    }
    let moved = Inputs { bike: bike.with(&key, before.value + STEP), ..inputs.clone() };
    let Gain { value, sd } = slip_stiffness_load::after(before, fit?, &rows(&moved))?;
    Some(bike.known(&key, value, sd))
}

/// The front wheel as the measure of the rear one's slip, where it measures better than the velocity does.
fn rolling_front(data: &Data, fits: &Fits, formulation: Formulation) -> Option<RollingFront> {
    let stiffness = fits.friction[0].as_ref().map(|f| f.formula.stiffness());
    let velocity_error = fits.coasting.radius[1].as_ref()?.quality.scale;
    match formulation {
        Formulation::Corrected => {
            RollingFront::of(&data.coast, fits.coasting.radii(), velocity_error, stiffness)
        }
        Formulation::Paper => None,
    }
}

/// Error of the model itself: each coefficient on its own.
fn model_errors(
    found: &Assembled,
    formulation: Formulation,
    config: &Config,
) -> impl Iterator<Item = Upstream> {
    let coefficient =
        |(name, share): (&String, &f64)| Some((Coefficient::from_name(name)?, *share));
    let all: Vec<(Coefficient, f64)> = match formulation {
        Formulation::Corrected => config.model_error.iter().filter_map(coefficient).collect(),
        Formulation::Paper => Vec::new(),
    };
    all.into_iter().flat_map(move |(coefficient, share)| {
        Part::ALL.into_iter().map(move |part| {
            let mut change = found.minus(found);
            match (coefficient, part.axle()) {
                // of a quotient the denominator is what was fitted
                (Coefficient::CorneringStiffness0, Some(axle)) => {
                    let stiffness = &mut change.stiffness[axle as usize];
                    stiffness.denominator = share * found.stiffness[axle as usize].denominator;
                    change.growth[axle as usize] = share * found.growth[axle as usize];
                }
                _ => {
                    let id = Id::from((part, coefficient));
                    change.values[id] = share * found.values[id];
                }
            }
            let source = Source::of_motorcycle("model", None);
            Upstream { source, missing: None, change }
        })
    })
}
