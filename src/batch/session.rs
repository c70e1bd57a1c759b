//! One log of a batch, from its bytes to its files or its row of `rejected`.

use super::error::Error;
use super::log_hash::hash_file;
use super::marker::Committed;
use super::parts;
use super::plan::{self, DUPLICATE_SESSION, Job};
use super::settings::Settings;
use super::store::Store;
use super::work::{Output, Work, guarded};
use crate::contract::instant;
use crate::ingest::UNREACHABLE;
use crate::pipeline::{Input, Rejection};
use crate::tables::registry;
use crate::tables::rows::Rejected;

/// What became of a log.
#[derive(Debug)]
pub enum Ended<R> {
    /// Computed and written.
    Done {
        /// Hash of the log's bytes.
        input_hash: String,
        /// Samples on the common clock.
        samples: i64,
        /// What the work gave beside the files, where somebody looks at it.
        result: Option<R>,
    },
    /// Was there already, made from the same.
    Unchanged,
    /// Not usable.
    Rejected(Rejected),
}

/// Computes and writes a session, if it is not there.
///
/// # Errors
/// The output cannot be written; all else is in [`Ended`].
pub fn run<W: Work>(
    job: &Job,
    settings: &Settings<'_>,
    store: &Store,
    work: &W,
) -> Result<Ended<W::Result>, Error> {
    let is_current = |hash: &str| {
        let wanted = job.wanted(hash.to_owned());
        !settings.force && store.stale(&wanted, |table| work.is_requested(table)).is_none()
    };
    if job.hash.as_deref().is_some_and(is_current) {
        store.remove_rejection(&job.log)?;
        return Ok(Ended::Unchanged);
    }
    // what is computed is hashed again: hours may lie between the plan and its turn
    let input_hash = match hash_file(&job.location) {
        Ok(hash) => hash,
        Err(e) => {
            let message = format!("cannot read {}: {e}", job.log);
            let why = Rejection { stage: "ingest", code: "unreadable", message, limits: None };
            return refuse(job, store, why, None);
        }
    };
    if is_current(&input_hash) {
        store.remove_rejection(&job.log)?;
        return Ok(Ended::Unchanged);
    }
    if let Some(there) = store.archived(&job.key(), &input_hash, job.start) {
        let why = plan::archived(there, job.start);
        return refuse(job, store, why, Some(input_hash));
    }
    if let Some(other) = store.found().copied_from(&job.wanted(input_hash.clone())) {
        let why = plan::duplicate(&other.path, &other.session_id);
        return refuse(job, store, why, Some(input_hash));
    }
    let input = Input {
        log: job.location.clone(),
        maps: settings.maps.list(),
        input_hash: input_hash.clone(),
        pipeline_hash: job.pipeline_hash.clone(),
        signals: work.is_requested(&registry::SIGNALS),
    };
    let output = guarded(work.kind().stage, || {
        work.run(&input, &job.bike, settings.pipeline).and_then(|output| same(job, output))
    });
    match output {
        Err(why) => refuse(job, store, why, Some(input_hash)),
        Ok(Output { ident, samples, files, result }) => {
            // some logs say only in their samples when they began
            let start = ident.start_time.as_deref().and_then(instant::microseconds);
            if let Some(there) = store.archived(&job.key(), &input_hash, start) {
                return refuse(job, store, plan::archived(there, start), Some(input_hash));
            }
            let part = parts::of(ident.start_time.as_deref());
            store.commit(&Committed { part, start, ..job.wanted(input_hash.clone()) }, &files)?;
            Ok(Ended::Done { input_hash, samples, result })
        }
    }
}

/// The session that was read must be the one that was identified: its files go there.
fn same<R>(job: &Job, output: Output<R>) -> Result<Output<R>, Rejection> {
    if output.ident.session_id == job.meta.session_id && output.ident.bike_id == job.meta.bike_id {
        return Ok(output);
    }
    let message = format!(
        "the log was identified as session `{}` and read as `{}`; this is a mistake in \
         roadbench, please report it",
        job.meta.session_id, output.ident.session_id
    );
    Err(Rejection { stage: "ingest", code: "internal_error", message, limits: None })
}

fn refuse<R>(
    job: &Job,
    store: &Store,
    why: Rejection,
    input_hash: Option<String>,
) -> Result<Ended<R>, Error> {
    let row = plan::row(job.log.clone(), Some(job.meta.clone()), why, input_hash);
    reject(store, &row, job.start)?;
    Ok(Ended::Rejected(row))
}

/// The row of a log whose session another log gives.
///
/// # Errors
/// The output cannot be written.
pub fn outrun(job: &Job, store: &Store, holder: &str) -> Result<Rejected, Error> {
    let hash = job.hash.clone().or_else(|| hash_file(&job.location).ok());
    let why = plan::same_session(&job.key(), holder);
    let row = plan::row(job.log.clone(), Some(job.meta.clone()), why, hash);
    reject(store, &row, job.start)?;
    Ok(row)
}

/// Writes a rejection; rows that the output has of this very log go, those of another log of the session, and of another ride than one
/// that begins at `start`, stay.
///
/// # Errors
/// The output cannot be written.
pub fn reject(store: &Store, row: &Rejected, start: Option<i64>) -> Result<(), Error> {
    // a duplicate's name belongs to the log that was used; what cannot be reached may be as it was
    if is_own_fault(&row.code)
        && let Some(key) = store.session_of(row, start)
    {
        store.remove(&key)?;
    }
    Ok(store.reject(row)?)
}

/// Whether a rejection says what the log's own content is like.
pub fn is_own_fault(code: &str) -> bool {
    ![DUPLICATE_SESSION, UNREACHABLE].contains(&code)
}
