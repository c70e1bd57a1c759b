//! What the model of a ride gets wrong, and why.
//!
//! ```text
//! session -> samples -> residuals of the base model -> base fit -> scan of every effect
//!                                                        |              |
//!                                   replay + noise = nulls -> the same -> calibration -> names
//! ```
//!
//! The base model is the one that [`fit`](crate::fit) characterises, written as eight residuals that
//! vanish when it is right ([`residuals`]): block means of 0.3 s, channel by channel. A *world*
//! ([`world`]) holds every number that enters them, those of the base and those of the [`effects`]
//! that the base leaves out. What a candidate must score to be believed is not computed but seen: on
//! the same ride, ridden again by the simulator on the base model alone, and once a cause is named on
//! the model that has it ([`null`]).
//!
//! The method is that of `diagnosis.md`, section 2. What is left without an explanation is looked for
//! over the variables of the ride ([`generic`]); what several sessions share is in [`levels`]; the
//! extended model is a file ([`model`]) that `run` takes out of sessions ([`undo`]); what to ride next
//! is computed in [`advice`]. Off-road sessions have residuals and candidates of their own:
//! [`offroad`].

pub mod advice;
pub mod attitude;
pub mod base;
pub mod diagnosis;
pub mod dive;
pub mod extended_model;
pub mod generic;
pub mod levels;
pub mod name;
pub mod null_calibration;
pub mod null_simulation;
pub mod offroad;
pub mod parameters;
pub mod problem;
pub mod replay;
pub mod residuals;
pub mod ride;
pub mod ride_plan;
pub mod samples;
pub mod scan;
pub mod scatter;
pub mod sensor_drift;
pub mod show;
pub mod summary;

pub use diagnosis::{Diagnosis, Settings};

use crate::contract::bike::Bike;
use crate::ingest::{self, Raw};
use crate::pipeline::{Input, Pipeline, Rejection};

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
    let raw = ingest::read(&input.log, input.maps).map_err(|e| Rejection {
        stage: "ingest",
        code: e.code,
        message: e.message,
    })?;
    run_raw(raw, bike, pipeline, settings)
}

/// As [`run`], of a log that is in memory already.
///
/// # Errors
/// As [`run`].
pub fn run_raw(
    raw: Raw,
    bike: &Bike,
    pipeline: &Pipeline,
    settings: &Settings,
) -> Result<Diagnosis, Rejection> {
    match pipeline.offroad {
        None => ride::raw(raw, bike, pipeline, settings).map(Diagnosis::from),
        Some(_) => offroad::raw(raw, bike, pipeline, settings.nulls).map(Diagnosis::from),
    }
}
