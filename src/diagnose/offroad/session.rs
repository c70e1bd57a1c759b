//! One off-road session from its log to its causes.

use super::calibration::{OffroadCalibration, Source, calibrate};
use super::candidates::ALL;
use super::declaration::Ride;
use super::engine::{OffroadEngine, lost_rows};
use super::fit::{Fit, Problem, long_run, weights};
use super::residuals::Residuals;
use super::uncertain;
use crate::contract::bike::Bike;
use crate::contract::rejection::{RejectionCode, Stage};
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::diagnose::cause::Identification;
use crate::diagnose::engine::identify_causes;
use crate::diagnose::tables;
use crate::diagnose::tuning::OffroadTuning;
use crate::estimate::offroad::Estimate;
use crate::estimate::offroad::rider::{self, Rider};
use crate::ingest::maps::ChannelMap;
use crate::motorcycle::offroad::equations::Motion;
use crate::motorcycle::offroad::planar::{Noise, PlanarMotorcycle};
use crate::pipeline::{self, OffroadForces, Pipeline, Rejection};
use crate::store::objects::Location;
use crate::store::tables::rows::{CauseRow, DiscrepancyRow, Ident};

/// Fewest blocks that are worth a diagnosis: half a minute on the ground.
const MIN_BLOCKS: usize = 200;
/// Where the bike file gives no `[offroad.noise]`: that of the sensors of Vasquez et al. 2019, filtered
/// at 20 Hz, and of a fork on a test bench.
const USUAL: Noise = Noise { qdd: [0.5, 0.35, 0.8, 0.6, 1.0], fs: [40.0, 20.0], fr: 120.0 };

/// The diagnosis of an off-road session.
#[derive(Debug, Clone)]
pub struct OffroadDiagnosis {
    /// Session, bike and start.
    pub ident: Ident,
    /// Candidates with their verdicts.
    pub identification: Identification<Fit>,
    /// Calibration by fault-free simulations.
    pub calibration: OffroadCalibration,
    /// The riders' settings with the identified motion of the rider: rider C with these is the extended model.
    pub rider: rider::Config,
    /// Rows of `causes`.
    pub causes: Vec<CauseRow>,
    /// Rows of `discrepancies`.
    pub discrepancies: Vec<DiscrepancyRow>,
    /// Samples on the session's common clock.
    pub n_samples: i64,
}

/// Diagnoses a log.
///
/// # Errors
/// The log cannot be used, or does not hold what a diagnosis needs.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn log(
    log: impl Into<Location>,
    maps: &[ChannelMap],
    bike: &Bike,
    pipeline: &Pipeline,
    nulls: usize,
) -> Result<OffroadDiagnosis, Rejection> {
    let (session, _) = pipeline::prepare(log, maps, bike, pipeline)?;
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
) -> Result<OffroadDiagnosis, Rejection> {
    let mut config = pipeline.offroad.clone().unwrap_or_default();
    config.riders = vec![Rider::B];
    let OffroadForces { estimate: forces, segments, warnings, .. } =
        pipeline::offroad_forces(session.clone(), bike, pipeline, &config)
            .map_err(|why| Rejection { stage: Stage::Diagnose, ..why })?;
    let residuals = Residuals::new(&forces, &segments, config.rider.crossfade);
    if residuals.blocks.len() < MIN_BLOCKS {
        return Err(too_little(residuals.blocks.len(), &warnings));
    }
    let high_cut = pipeline.filter.high_cut;
    let ride = Ride { residuals: &residuals, estimate: &forces, rider: &config.rider, high_cut };
    let curves = ALL.iter().map(|candidate| (candidate.curve)(&ride)).collect();
    let bare = with_rider_b(&residuals, &forces, &config.rider);
    let blocks = residuals.blocks.clone();
    let sensors = residuals.sensor_noise(&covariance(&forces.machine), high_cut);
    let weight = weights(&blocks, &long_run(&blocks, &bare), &sensors);
    let uncertain = uncertain::columns(&residuals, &forces, bike);
    let mut problem = Problem { blocks, curves, uncertain, weight };
    let (ident, n_samples) = (Ident::from(&session.meta), session.len as i64);
    let session = Pass {
        residuals: &residuals,
        bare: &bare,
        sensors: &sensors,
        forces: &forces,
        warnings: &warnings,
        ident: &ident,
        nulls,
    };
    let mut found = session.run(&mut problem);
    if found.is_wrong_on_the_ground {
        // what nobody explains of the rider would pass for forces of the suspension: those are looked for
        // where a wheel is off the ground, and no rider enters
        problem.off_the_ground();
        found = session.run(&mut problem);
    }
    let PassResult { identification, calibration, causes, discrepancies, .. } = found;
    let rider = with_named(&config.rider, &identification);
    Ok(OffroadDiagnosis {
        ident,
        identification,
        calibration,
        rider,
        causes,
        discrepancies,
        n_samples,
    })
}

/// Inputs of one pass over the candidates.
struct Pass<'a> {
    residuals: &'a Residuals,
    bare: &'a [f64],
    sensors: &'a [f64; 7],
    forces: &'a Estimate,
    warnings: &'a [Warning],
    ident: &'a Ident,
    nulls: usize,
}

struct PassResult {
    identification: Identification<Fit>,
    calibration: OffroadCalibration,
    causes: Vec<CauseRow>,
    discrepancies: Vec<DiscrepancyRow>,
    /// Whether on the ground more is left than sensors and bike file explain.
    is_wrong_on_the_ground: bool,
}

impl Pass<'_> {
    /// The pass, at the weights that the scatter gives which is left when every candidate is free.
    fn run(&self, problem: &mut Problem) -> PassResult {
        let Pass { residuals, bare, sensors, forces, warnings, ident, nulls } = *self;
        let everything: Vec<usize> = (0..ALL.len()).collect();
        let mut left = problem.fit(bare, &everything, None);
        for _ in 0..2 {
            let scatter = long_run(&problem.blocks, &left.residual);
            problem.weight = weights(&problem.blocks, &scatter, sensors);
            left = problem.fit(bare, &everything, Some(&left));
        }
        let seed = seed(&ident.session_id);
        let source = Source { residuals, problem, scatter: &left.residual, sensors, seed };
        let calibration = calibrate(&source, nulls);
        let engine = OffroadEngine {
            residuals,
            problem,
            bare,
            everything: &left,
            calibration: &calibration,
            forces,
            warnings,
            tuning: OffroadTuning::default(),
        };
        let identification = identify_causes(&engine);
        let is_wrong_on_the_ground = engine.is_wrong_on_the_ground(&identification);
        let discrepancies = tables::discrepancies(&engine, &identification, ident);
        let causes = tables::causes(&engine, &identification, &discrepancies, ident);
        PassResult { identification, calibration, causes, discrepancies, is_wrong_on_the_ground }
    }
}

/// A rider's settings with the identified motion of the rider.
fn with_named(rider: &rider::Config, identification: &Identification<Fit>) -> rider::Config {
    let mut rider = rider.clone();
    for cause in identification.named() {
        match (cause.candidate.name, cause.estimate.map(|e| e.value)) {
            ("rider_vertical_motion", Some(cut_off)) => {
                (rider.cut_off, rider.zero_phase) = (cut_off, false);
            }
            ("rider_horizontal_motion", Some(cut_off)) => rider.horizontal_cut_off = Some(cut_off),
            _ => {}
        }
    }
    rider
}

fn too_little(blocks: usize, warnings: &[Warning]) -> Rejection {
    let lost: Vec<&str> = lost_rows(warnings).map(|w| w.message.as_str()).collect();
    let message = match lost.is_empty() {
        true => format!(
            "only {:.0} s are driven, braked or flown with all that the equations need: {:.0} s are the \
             least for a diagnosis",
            0.1 * blocks as f64,
            0.1 * MIN_BLOCKS as f64
        ),
        false => format!("no equation remains to check the model with: {}", lost.join("; ")),
    };
    let code = if lost.is_empty() {
        RejectionCode::TooFewManoeuvres
    } else {
        RejectionCode::MissingColumn
    };
    Rejection { stage: Stage::Diagnose, code, message, limits: None }
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
fn covariance(machine: &PlanarMotorcycle) -> [[f64; 5]; 5] {
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

/// Seed of a session's fault-free simulations, which so depend on the session alone.
fn seed(session_id: &str) -> u64 {
    let hash = blake3::hash(session_id.as_bytes());
    hash.as_bytes().iter().take(8).fold(0, |seed, b| (seed << 8) | u64::from(*b))
}
