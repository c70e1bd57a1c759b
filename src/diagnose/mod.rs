//! What the model of a ride gets wrong, and why.
//!
//! ```text
//! road, offroad        residuals, candidates, fault-free simulations: an Engine each
//!      engine          names causes: alarm, joint fits, equivalents, further causes
//!      tables          rows of causes and discrepancies
//!      summary         the verdict in words
//! levels               what several sessions share
//! ```
//!
//! The method is that of `book/src/diagnosis.md`, section 2. A [`Candidate`](cause::Candidate) is compared with
//! fault-free simulations ([`calibration`]): the ride again on the fitted model, which describes it completely. The
//! constants that decide are in [`tuning`].

pub(crate) mod calibration;
pub(crate) mod cause;
pub(crate) mod diagnosis;
pub(crate) mod engine;
pub(crate) mod held_out;
pub(crate) mod levels;
pub(crate) mod offroad;
pub(crate) mod reference;
pub(crate) mod road;
pub(crate) mod settings;
pub(crate) mod summary;
pub(crate) mod tables;
pub(crate) mod tuning;

pub(crate) use diagnosis::Diagnosis;
pub(crate) use settings::Settings;

use crate::contract::bike::Bike;
use crate::ingest;
use crate::pipeline::{self, Input, Pipeline, Rejection};

/// Diagnoses one log: off-road where the pipeline has `[offroad]`, on the road otherwise.
///
/// # Errors
/// The log cannot be used, or does not hold what a diagnosis needs.
pub(crate) fn run(
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
pub(crate) fn run_raw(
    raw: ingest::Raw,
    bike: &Bike,
    pipeline: &Pipeline,
    settings: &Settings,
) -> Result<Diagnosis, Rejection> {
    let (session, _) = pipeline::prepare_raw(raw, bike, pipeline)?;
    match (&pipeline.offroad, settings.nulls) {
        (None, 0) => road::estimated(&session, bike, pipeline).map(Diagnosis::from),
        (None, _) => road::diagnose(&session, bike, pipeline, settings).map(Diagnosis::from),
        (Some(_), nulls) => {
            let nulls = if nulls == 0 { Settings::default().nulls } else { nulls };
            offroad::diagnose(&session, bike, pipeline, nulls).map(Diagnosis::from)
        }
    }
}
