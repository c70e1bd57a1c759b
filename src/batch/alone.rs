//! One session in memory: the batch's tables of it, and nothing is written.

use std::path::Path;

use arrow::array::RecordBatch;

use super::engine::note_unsafe_id;
use super::plan::{BikeFile, hash_file};
use super::{Maps, guarded};
use crate::ingest::{self, Raw};
use crate::pipeline::{self, Input, Pipeline, Rejection};

/// Where a session comes from.
#[derive(Debug)]
pub enum Log<'a> {
    /// A log file of any format.
    File(&'a Path),
    /// A table that was read already.
    Table(Box<Raw>),
}

/// What `path` says in the tables of a session that came from no file.
pub const NO_PATH: &str = "(table)";

/// A session's tables by name, as a run would write them; a log that does not name its bike takes
/// the bike file's name.
///
/// # Errors
/// The log cannot be used.
pub fn run(
    log: Log<'_>,
    bike: &BikeFile,
    pipeline: &Pipeline,
    maps: &Maps,
    signals: bool,
) -> Result<Vec<(&'static str, RecordBatch)>, Rejection> {
    let refuse = |e: ingest::Error| Rejection { stage: "ingest", code: e.code, message: e.message };
    let (path, input_hash) = match &log {
        Log::Table(raw) => (Path::new(NO_PATH), hash(raw)),
        Log::File(path) => {
            let hash = hash_file(path).map_err(|e| Rejection {
                stage: "ingest",
                code: "unreadable",
                message: format!("cannot read {}: {e}", path.display()),
            })?;
            (*path, hash)
        }
    };
    let input = Input {
        path,
        maps: &maps.list,
        input_hash,
        pipeline_hash: bike.pipeline_hash.clone(),
        signals,
    };
    let mut outcome = guarded("pipeline", || {
        let mut raw = match log {
            Log::File(path) => ingest::read(path, &maps.list).map_err(refuse)?,
            Log::Table(raw) => *raw,
        };
        if raw.meta.bike_id.is_empty() {
            raw.meta.bike_id.clone_from(&bike.bike.bike_id);
        }
        pipeline::run_raw(raw, &input, &bike.bike, pipeline)
    })?;
    note_unsafe_id(&mut outcome);
    let tables = outcome.tables().map_err(|e| Rejection {
        stage: "write",
        code: "internal_error",
        message: format!("{e}; this is a mistake in roadbench, please report it"),
    })?;
    Ok(tables.into_iter().map(|(spec, batch)| (spec.name, batch)).collect())
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
