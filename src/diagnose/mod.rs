//! What the model of a ride gets wrong, and why.
//!
//! ```text
//! road, offroad        residuals, candidates, null simulations: an Engine each
//!      engine          names causes: alarm, joint fits, equivalents, further causes
//!      tables          rows of causes and discrepancies
//!      summary         the verdict in words
//! levels               what several sessions share
//! ```
//!
//! The method is that of `book/src/diagnosis.md`, section 2. A [`Candidate`](cause::Candidate) is held against null
//! simulations ([`calibration`]): the ride again on the model as it is, in which nothing is left out. The
//! constants that decide are in [`tuning`].

pub mod calibration;
pub mod cause;
pub mod diagnosis;
pub mod engine;
pub mod held_out;
pub mod levels;
pub mod offroad;
pub mod road;
pub mod settings;
pub mod summary;
pub mod tables;
pub mod tuning;

pub use diagnosis::Diagnosis;
pub use settings::Settings;

use crate::contract::bike::Bike;
use crate::ingest;
use crate::pipeline::{self, Input, Pipeline, Rejection};

/// Diagnoses one log: off-road where the pipeline has `[offroad]`, on the road otherwise.
///
/// # Errors
/// The log cannot be used, or does not hold what a diagnosis needs.
pub fn run(
    input: &Input<'_>,
    bike: &Bike,
    pipeline: &Pipeline,
    settings: &Settings,
) -> Result<Diagnosis, Rejection> {
    run_raw(pipeline::read(input)?, bike, pipeline, settings)
}

/// As [`run`], of a log that is in memory already.
///
/// # Errors
/// As [`run`].
pub fn run_raw(
    raw: ingest::Raw,
    bike: &Bike,
    pipeline: &Pipeline,
    settings: &Settings,
) -> Result<Diagnosis, Rejection> {
    let (session, _) = pipeline::prepare_raw(raw, bike, pipeline)?;
    match pipeline.offroad {
        None => road::diagnose(&session, bike, pipeline, settings).map(Diagnosis::from),
        Some(_) => offroad::diagnose(&session, bike, pipeline, settings.nulls).map(Diagnosis::from),
    }
}
