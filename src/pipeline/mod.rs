//! The stages in their order, for one session.
//!
//! `stages` has each order once; `road` and `offroad` make the tables of what comes out, `predicted` asks what a planned
//! ride would give.

mod offroad;
pub(crate) mod outcome;
pub(crate) mod predicted;
mod road;
mod rows;
pub(crate) mod settings;
pub(crate) mod stages;

pub(crate) use outcome::{Input, Outcome, Rejection};
pub(crate) use settings::Pipeline;
pub(crate) use stages::{
    Characterised, OffroadForces, characterise, characterise_once, offroad_forces, prepare,
    prepare_raw, read, segmented,
};

use crate::contract::bike::Bike;
use crate::ingest::Raw;
use crate::store::objects::Location;

/// One log through every stage, with the channel maps that come with the program and without the hashes by which an
/// archive knows its sessions again.
///
/// # Errors
/// The first stage that cannot go on says why.
pub fn fit_log(
    log: impl Into<Location>,
    bike: &Bike,
    pipeline: &Pipeline,
) -> Result<Outcome, Rejection> {
    let (input_hash, pipeline_hash) = (String::new(), String::new());
    let input = Input { log: log.into(), maps: &[], input_hash, pipeline_hash, signals: false };
    run(&input, bike, pipeline)
}

/// One log through every stage.
///
/// # Errors
/// The first stage that cannot go on says why.
pub fn run(input: &Input<'_>, bike: &Bike, pipeline: &Pipeline) -> Result<Outcome, Rejection> {
    run_raw(read(input)?, input, bike, pipeline)
}

/// A log that is in memory already through every stage; `input` says where it came from, and is
/// not opened.
///
/// # Errors
/// As [`run`].
pub fn run_raw(
    raw: Raw,
    input: &Input<'_>,
    bike: &Bike,
    pipeline: &Pipeline,
) -> Result<Outcome, Rejection> {
    let (session, warnings) = prepare_raw(raw, bike, pipeline)?;
    match &pipeline.offroad {
        None => road::run(input, session, warnings, bike, pipeline),
        Some(config) => offroad::run(input, session, warnings, bike, pipeline, config),
    }
}
