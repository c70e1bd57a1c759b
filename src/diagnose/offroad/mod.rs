//! What the off-road estimate gets wrong, and why.
//!
//! ```text
//! session -> estimate with rider B -> residuals no tyre force explains -> fit of every candidate
//!                                           |                                 |
//!                              bike's uncertainty, own scatter = nulls -> calibration -> names
//! ```
//!
//! The base model is rider B on the bike of the file. Five equations leave something over once the
//! tyre forces have taken what they can ([`residuals`]); in flight they leave everything. There a
//! rider who follows the bike, friction in the fork or a heavier rider shows, though no tyre force
//! is known ([`effects`]). What a candidate must gain to be believed is seen on nulls of the same
//! ride ([`null`]).
//!
//! Source: `diagnosis.md`, section 2, with the equations of `offroad.md`.

pub mod effects;
pub mod fit;
pub mod ground;
pub mod name;
pub mod null;
pub mod residuals;
pub mod table;
pub mod tell;
pub mod uncertain;

use std::path::Path;

use crate::contract::bike::Bike;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::estimate::offroad::Estimate;
use crate::estimate::offroad::rider::{self, Rider};
use crate::ingest;
use crate::ingest::map::ChannelMap;
use crate::model::offroad::equations::Motion;
use crate::model::offroad::machine::{Machine, Noise};
use crate::pipeline::{self, OffroadForces, Pipeline, Rejection};
use crate::tables::rows::{CauseRow, DiscrepancyRow, Ident};

use fit::{Fit, Problem, long_run, weights};
use name::Naming;
use null::Calibration;
use residuals::Residuals;

/// Fewest blocks that are worth a diagnosis: half a minute on the ground.
const FEWEST: usize = 200;
/// Where the bike file gives no `[offroad.noise]`: that of the sensors of Vasquez et al. 2019, filtered
/// at 20 Hz, and of a fork on a test bench.
const USUAL: Noise = Noise { qdd: [0.5, 0.35, 0.8, 0.6, 1.0], fs: [40.0, 20.0], fr: 120.0 };

/// What a session says.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// Who and when.
    pub ident: Ident,
    /// Candidates, judged.
    pub naming: Naming,
    /// What nulls show.
    pub calibration: Calibration,
    /// The riders' settings with what is named of the rider: rider C with these is the extended model.
    pub rider: rider::Config,
    /// Rows of `causes`.
    pub causes: Vec<CauseRow>,
    /// Rows of `discrepancies`.
    pub discrepancies: Vec<DiscrepancyRow>,
    /// What the estimate noticed.
    pub warnings: Vec<Warning>,
}

/// Diagnoses a log.
///
/// # Errors
/// The log cannot be used, or does not hold what a diagnosis needs.
pub fn log(
    path: &Path,
    maps: &[ChannelMap],
    bike: &Bike,
    pipeline: &Pipeline,
    nulls: usize,
) -> Result<Diagnosis, Rejection> {
    let (session, _) = pipeline::prepare(path, maps, bike, pipeline)?;
    diagnose(&session, bike, pipeline, nulls)
}

/// Diagnoses a log that is in memory already.
///
/// # Errors
/// As [`log`].
pub fn raw(
    raw: ingest::Raw,
    bike: &Bike,
    pipeline: &Pipeline,
    nulls: usize,
) -> Result<Diagnosis, Rejection> {
    let (session, _) = pipeline::prepare_raw(raw, bike, pipeline)?;
    diagnose(&session, bike, pipeline, nulls)
}

/// Diagnoses a clean, unfiltered session with a pipeline that has `[offroad]`.
///
/// # Errors
/// The session does not hold what a diagnosis needs, or the bike file does not.
pub fn diagnose(
    session: &Session,
    bike: &Bike,
    pipeline: &Pipeline,
    nulls: usize,
) -> Result<Diagnosis, Rejection> {
    let mut config = pipeline.offroad.clone().unwrap_or_default();
    config.riders = vec![Rider::B];
    let OffroadForces { estimate: e, segments, warnings, .. } =
        pipeline::offroad_forces(session.clone(), bike, pipeline, &config)
            .map_err(|why| Rejection { stage: "diagnose", ..why })?;
    let residuals = Residuals::new(&e, &segments, config.rider.crossfade);
    if residuals.blocks.len() < FEWEST {
        return Err(too_little(residuals.blocks.len(), &warnings));
    }
    let ride = effects::Ride {
        residuals: &residuals,
        estimate: &e,
        rider: &config.rider,
        high_cut: pipeline.filter.high_cut,
    };
    let curves = effects::ALL.iter().map(|effect| effect.curve(&ride)).collect();
    let bare = with_rider_b(&residuals, &e, &config.rider);
    let blocks = residuals.blocks.clone();
    let sensors = residuals.floor(&covariance(&e.machine), pipeline.filter.high_cut);
    let weight = weights(&blocks, &long_run(&blocks, &bare), &sensors);
    let uncertain = uncertain::columns(&residuals, &e, bike);
    let problem = Problem { blocks, curves, uncertain, weight };
    let ident = Ident::from(&session.meta);
    let seed = seed(&ident.session_id);
    let mut found = Found::new(problem, &bare, &residuals, &sensors, nulls, seed);
    if table::wrong_on_the_ground(&residuals, &found.naming, &found.calibration) {
        // what nobody explains of the rider would pass for forces of the suspension: those are looked for
        // where a wheel is off the ground, and no rider enters
        let mut problem = found.problem;
        problem.off_the_ground();
        found = Found::new(problem, &bare, &residuals, &sensors, nulls, seed);
    }
    let Found { problem, left, calibration, naming } = found;
    let mut rider = config.rider.clone();
    for cause in naming.causes.iter().take(naming.named.len()) {
        match (effects::ALL[cause.effect].name, cause.value) {
            ("rider_vertical_motion", Some(cut_off)) => {
                (rider.cut_off, rider.zero_phase) = (cut_off, false);
            }
            ("rider_horizontal_motion", Some(cut_off)) => rider.horizontal_cut_off = Some(cut_off),
            _ => {}
        }
    }
    let tables = table::Tables {
        residuals: &residuals,
        problem: &problem,
        bare: &bare,
        everything: &left,
        naming: &naming,
        calibration: &calibration,
        estimate: &e,
        warnings: &warnings,
        ident: &ident,
    };
    let discrepancies = tables.discrepancies();
    let causes = tables.causes(&discrepancies);
    Ok(Diagnosis { ident, naming, calibration, rider, causes, discrepancies, warnings })
}

/// What one pass finds.
struct Found {
    problem: Problem,
    left: Fit,
    calibration: Calibration,
    naming: Naming,
}

impl Found {
    fn new(
        mut problem: Problem,
        bare: &[f64],
        residuals: &Residuals,
        sensors: &[f64; 7],
        nulls: usize,
        seed: u64,
    ) -> Self {
        // the scatter that is left when everything is free, and the weights that it gives
        let everything: Vec<usize> = (0..effects::ALL.len()).collect();
        let mut left = problem.fit(bare, &everything, None);
        for _ in 0..2 {
            let scatter = long_run(&problem.blocks, &left.residual);
            problem.weight = weights(&problem.blocks, &scatter, sensors);
            left = problem.fit(bare, &everything, Some(&left));
        }
        let calibration =
            Calibration::new(residuals, &problem, &left.residual, sensors, nulls, seed);
        let naming = name::name(&problem, bare, &calibration);
        Found { problem, left, calibration, naming }
    }
}

fn too_little(blocks: usize, warnings: &[Warning]) -> Rejection {
    let lost: Vec<&str> = warnings
        .iter()
        .filter(|w| matches!(w.code, "row_lost" | "negative_travel"))
        .map(|w| w.message.as_str())
        .collect();
    let message = match lost.is_empty() {
        true => format!(
            "only {:.0} s are driven, braked or flown with all that the equations need: {:.0} s are the \
             least for a diagnosis",
            0.1 * blocks as f64,
            0.1 * FEWEST as f64
        ),
        false => format!("no equation is left over to hold the model against: {}", lost.join("; ")),
    };
    let code = if lost.is_empty() { "too_few_manoeuvres" } else { "missing_column" };
    Rejection { stage: "diagnose", code, message }
}

/// Residuals under the base: rider B on the bike.
fn with_rider_b(residuals: &Residuals, e: &Estimate, config: &rider::Config) -> Vec<f64> {
    let mass = e.machine.rider.mass;
    let rider = residuals.response(|i, _| {
        let [_, down, forward, _] = rider::b::force(mass, residuals.acceleration[0][i], false);
        let (down, forward) = (residuals.hold[i] * down, residuals.hold[i] * forward);
        let levers = &residuals.levers[i];
        let lever = config.arms * levers[2] + (1.0 - config.arms) * levers[0];
        [-forward, -down, -levers[1] * down - lever * forward, 0.0, 0.0]
    });
    residuals.bike.iter().zip(&rider).map(|(b, r)| b + r).collect()
}

/// Covariance of the known side from the sensors and the suspension's forces.
fn covariance(machine: &Machine) -> [[f64; 5]; 5] {
    let noise = machine.noise.unwrap_or(USUAL);
    let m = machine.equations.at(&Motion { z_f: 0.1, a_r: 0.17, ..Motion::default() }).m;
    let mut out = [[0.0; 5]; 5];
    for i in 0..5 {
        for j in 0..5 {
            out[i][j] = (0..5).map(|k| m[i][k] * noise.qdd[k].powi(2) * m[j][k]).sum();
        }
    }
    out[3][3] += noise.fs[0].powi(2);
    out[4][4] += noise.fs[1].powi(2);
    out
}

/// A session's nulls depend on the session alone.
fn seed(session_id: &str) -> u64 {
    let hash = blake3::hash(session_id.as_bytes());
    hash.as_bytes().iter().take(8).fold(0, |seed, b| (seed << 8) | u64::from(*b))
}
