//! What a ride would show of the causes that a diagnosis looks for, before it is ridden.

use serde::Serialize;

use super::advice::{ALIKE, Advice};
use super::null_calibration::RoadCalibration;
use super::session::{Fitted, Prepared, fitted};
use crate::contract::file_error::{FileError, FileName};
use crate::diagnose::settings::Settings;
use crate::pipeline::Pipeline;
use crate::pipeline::predicted::{Planned, Predicted, predict};
use crate::simulate;
use crate::simulate::effects::{ALL, Effect};
use crate::simulate::motocross::scenario::Motocross;
use crate::simulate::scenario::{BUILTIN, Scenario};
use crate::simulate::tour::Tour;
use crate::simulate::track::Track;

/// Prediction for the first session of a scenario.
#[derive(Debug, Serialize)]
pub struct RidePlan {
    /// Name of the scenario.
    pub scenario: String,
    /// How long the ride is, s; `None` where only side forces are predicted.
    pub duration: Option<f64>,
    /// Predicted intervals of the tyres' side forces.
    pub side_forces: Vec<Predicted>,
    /// Detection limit of each effect.
    pub effects: Vec<EffectLimit>,
    /// Pairs of effects that it could hardly separate.
    pub pairs: Vec<AlikePair>,
}

/// Detection limit of one effect.
#[derive(Debug, Serialize)]
pub struct EffectLimit {
    /// Name of the effect.
    pub effect: &'static str,
    /// Smallest size that is identified half of the time, in `unit`; none where no plausible size is.
    pub limit: Option<f64>,
    /// Unit of the limits.
    pub unit: &'static str,
    /// The same in the effect's usual size.
    pub limit_usual: Option<f64>,
    /// The parameter of the nominal model most like it.
    pub base: Option<&'static str>,
    /// The cosine of its response and that parameter's.
    pub base_cosine: Option<f64>,
    /// Additional riding that lowers the limit most.
    pub set: Option<&'static str>,
    /// The limit with that riding, in `unit`; none where no plausible size is identified even so.
    pub limit_after: Option<f64>,
}

/// Two effects of which the ride shows nearly the same.
#[derive(Debug, Serialize)]
pub struct AlikePair {
    pub pair: [&'static str; 2],
    /// Cosine of their responses.
    pub cosine: f64,
    /// Standard deviations of a usual size of the first from the second, of whatever size.
    pub separation: f64,
    /// Additional riding that separates them best.
    pub set: Option<&'static str>,
    /// The cosine with that riding.
    pub cosine_after: Option<f64>,
    /// The separation with that riding.
    pub separation_after: Option<f64>,
}

/// Simulates the first session of a scenario, a built-in one or a file, and works out what it shows: on the
/// reduced-order motorcycle side forces and effects, on the nonlinear one side forces.
///
/// # Errors
/// There is no such scenario, no plan is made for its simulator, or its ride does not hold what a diagnosis needs.
pub fn plan(name_or_path: &str, pipeline: &Pipeline) -> Result<RidePlan, FileError> {
    if let Some(tour) = Tour::load(name_or_path)? {
        return Ok(RidePlan {
            side_forces: predict(&Planned::Tour(&tour), pipeline)?,
            scenario: tour.name,
            duration: None,
            effects: Vec::new(),
            pairs: Vec::new(),
        });
    }
    let scenario = scenario(name_or_path)?;
    let side_forces = predict(&Planned::Fleet(&scenario), pipeline)?;
    Ok(RidePlan { side_forces, ..shown(scenario, pipeline)? })
}

/// The scenario of a plan of effects.
///
/// # Errors
/// There is none of that name, or another simulator rides it.
pub(crate) fn scenario(name_or_path: &str) -> Result<Scenario, FileError> {
    let others = [
        Motocross::load(name_or_path)?.is_some(),
        Track::load(name_or_path)?.is_some(),
        Tour::load(name_or_path)?.is_some(),
    ];
    if others.contains(&true) {
        let names: Vec<&str> = BUILTIN.iter().map(|(name, _)| *name).collect();
        let why = format!(
            "a plan is for rides of the reduced-order motorcycle, such as {}",
            names.join(", ")
        );
        return Err(FileName::new("scenario", name_or_path).wrong(why));
    }
    Scenario::load(name_or_path)
}

/// Limits of all effects in the first session of a scenario.
fn shown(scenario: Scenario, pipeline: &Pipeline) -> Result<RidePlan, FileError> {
    let machine = scenario.machine(0);
    let session = simulate::session(&scenario, &machine, 0).session;
    let fitted = fitted(&session, &machine.bike, pipeline)
        .map_err(|why| FileName::new("scenario", &scenario.name).wrong(why.message))?;
    let Fitted { session, samples, base, .. } = &fitted;
    let advice = Advice::new(session, samples, base, ALL, &machine.bike, pipeline);
    // the limits are those that a diagnosis of the ride would have
    let settings = Settings::default();
    let prepared = Prepared::new(&fitted, &settings);
    Ok(RidePlan {
        duration: Some(session.duration()),
        side_forces: Vec::new(),
        effects: effect_limits(&advice, prepared.calibration()),
        pairs: alike_pairs(&advice),
        scenario: scenario.name,
    })
}

fn effect_limits(advice: &Advice, calibration: &RoadCalibration) -> Vec<EffectLimit> {
    ALL.iter()
        .enumerate()
        .map(|(j, effect)| {
            let usual = smallest(effect, j, calibration);
            let size = effect.typical.abs();
            let change = advice.best_detection(effect.name);
            let after = change.and_then(|c| {
                let times = (c.separation[1] / c.separation[0]).powi(2);
                smallest(effect, j, &calibration.with_information(j, times))
            });
            EffectLimit {
                effect: effect.name,
                limit: usual.map(|x| x * size),
                unit: effect.unit,
                limit_usual: usual,
                base: advice.own.taken[j].map(|t| t.0),
                base_cosine: advice.own.taken[j].map(|t| t.1),
                set: change.map(|c| c.set),
                limit_after: after.map(|x| x * size),
            }
        })
        .collect()
}

/// Smallest size of effect `j` that is identified half of the time, in usual ones; none where that is not plausible.
fn smallest(effect: &Effect, j: usize, calibration: &RoadCalibration) -> Option<f64> {
    let usual = calibration.identified_half(j);
    let plausible = |sign: f64| effect.in_bounds(sign * usual * effect.typical);
    let is_identified = calibration.is_identifiable(j) && (plausible(1.0) || plausible(-1.0));
    is_identified.then_some(usual)
}

fn alike_pairs(advice: &Advice) -> Vec<AlikePair> {
    let mut out = Vec::new();
    for i in 0..ALL.len() {
        for j in i + 1..ALL.len() {
            let cosine = advice.own.cosine(i, j);
            if cosine.abs() <= ALIKE {
                continue;
            }
            let pair = [ALL[i].name, ALL[j].name];
            let change = advice.best_separation(pair[0], &pair[1..]);
            let with = change.and_then(|c| advice.with.iter().find(|(s, _)| s.words == c.set));
            out.push(AlikePair {
                pair,
                cosine,
                separation: advice.own.separation(i, &[j]),
                set: change.map(|c| c.set),
                cosine_after: with.map(|(_, known)| known.cosine(i, j)),
                separation_after: change.map(|c| c.separation[1]),
            });
        }
    }
    out
}
