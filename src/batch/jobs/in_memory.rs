//! One session in memory: the tables that a batch writes of it, and nothing is written.

use arrow::array::RecordBatch;

use super::bikes::BikeFile;
use super::diagnose::DiagnoseWork;
use super::run::note_unsafe_id;
use super::work::guarded;
use crate::batch::log_hash::hash_file;
use crate::batch::settings::Maps;
use crate::contract::rejection::{RejectionCode, Stage};
use crate::diagnose::{self, Diagnosis};
use crate::ingest::{self, Raw};
use crate::pipeline::{self, Input, Pipeline, Rejection};
use crate::simulate::effects::SessionRef;
use crate::store::objects::Location;

/// Where a session comes from.
#[derive(Debug)]
pub enum Log<'a> {
    /// A log file of any format.
    File(&'a Location),
    /// A table that was read already.
    Table(Box<Raw>),
}

/// `path` in the tables of a session that came from no file.
pub const NO_PATH: &str = "(table)";

/// Tables by name.
pub type Tables = Vec<(&'static str, RecordBatch)>;

/// A session's tables, as `run` would write them; a log that does not name its bike takes the bike
/// file's name.
///
/// # Errors
/// The log cannot be used.
pub fn run(
    log: Log<'_>,
    bike: &BikeFile,
    pipeline: &Pipeline,
    maps: &Maps,
    signals: bool,
) -> Result<Tables, Rejection> {
    let mut outcome = with_input(log, bike, pipeline, maps, |raw, mut input| {
        input.signals = signals;
        guarded(Stage::Pipeline, || pipeline::run_raw(raw, &input, &bike.bike, pipeline))
    })?;
    note_unsafe_id(&mut outcome);
    let tables = outcome.tables().map_err(|e| Rejection::unwritable(&e))?;
    Ok(tables.into_iter().map(|(spec, batch)| (spec.name, batch)).collect())
}

/// A session's diagnosis and its tables, as `diagnose` would write them; a log that does not name its
/// bike takes the bike file's name.
///
/// # Errors
/// The log cannot be used, or does not hold what a diagnosis needs.
pub fn diagnose(
    log: Log<'_>,
    bike: &BikeFile,
    pipeline: &Pipeline,
    maps: &Maps,
    work: &DiagnoseWork,
) -> Result<(Diagnosis, Tables), Rejection> {
    with_input(log, bike, pipeline, maps, |raw, input| {
        let settings = &work.settings;
        let d =
            guarded(Stage::Diagnose, || diagnose::run_raw(raw, &bike.bike, pipeline, settings))?;
        let tables = work.tables(&d, &input).map_err(|e| Rejection::unwritable(&e))?;
        Ok((d, tables.into_iter().map(|(spec, batch)| (spec.name, batch)).collect()))
    })
}

/// Reads a log and hands it on with what the tables say of it.
fn with_input<T>(
    log: Log<'_>,
    bike: &BikeFile,
    pipeline: &Pipeline,
    maps: &Maps,
    then: impl FnOnce(Raw, Input<'_>) -> Result<T, Rejection>,
) -> Result<T, Rejection> {
    let refuse = |code, message| Rejection { stage: Stage::Ingest, code, message, limits: None };
    let (at, input_hash) = match &log {
        Log::Table(raw) => (Location::Local(NO_PATH.into()), hash(raw)),
        Log::File(at) => {
            let hash = hash_file(at)
                .map_err(|e| refuse(RejectionCode::Unreadable, format!("cannot read {at}: {e}")))?;
            ((*at).clone(), hash)
        }
    };
    let mut raw = match log {
        Log::Table(raw) => *raw,
        Log::File(at) => guarded(Stage::Ingest, || {
            ingest::read(at, maps.list()).map_err(|e| refuse(e.code, e.message))
        })?,
    };
    if raw.meta.bike_id.is_empty() {
        raw.meta.bike_id.clone_from(&bike.bike.bike_id);
    }
    let map = maps.hash_of(raw.map.as_deref());
    let pipeline_hash = bike.hash_of(pipeline, &SessionRef::from(&raw.meta), &map);
    then(raw, Input { log: at, maps: maps.list(), input_hash, pipeline_hash, signals: false })
}

/// BLAKE3 of names and numbers, however they were cut into batches.
fn hash(raw: &Raw) -> String {
    let mut hasher = blake3::Hasher::new();
    for track in &raw.tracks {
        hasher.update(track.channel.name().as_bytes());
        hasher.update(&(track.values.len() as u64).to_le_bytes());
        for x in track.time.iter().chain(&track.values) {
            hasher.update(&x.to_le_bytes());
        }
    }
    hasher.finalize().to_hex().to_string()
}
