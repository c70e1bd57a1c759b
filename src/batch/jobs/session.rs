//! One log of a batch, from its bytes to its files or its row of `rejected`.

use std::fs::Metadata;
use std::time::SystemTime;

use super::work::{Output, Work, guarded};
use crate::batch::error::Error;
use crate::batch::log_hash::hash_file;
use crate::batch::plan;
use crate::batch::plan::Job;
use crate::batch::settings::Settings;
use crate::batch::store::folder::Store;
use crate::batch::store::marker::Committed;
use crate::batch::store::parts;
use crate::contract::instant;
use crate::contract::rejection::{RejectionCode, Stage};
use crate::ingest::{self, Identified};
use crate::pipeline::{Input, Rejection};
use crate::store::objects::Location;
use crate::store::tables::registry;
use crate::store::tables::rows::{Ident, Rejected};

/// Outcome of a log.
#[derive(Debug)]
pub(crate) enum Ended<R> {
    Done {
        /// Hash of the log's bytes.
        input_hash: String,
        /// Samples on the common clock.
        samples: i64,
        /// Result in addition to the files, if it is shown.
        result: Option<R>,
    },
    /// The output has the session, computed from the same inputs.
    Unchanged,
    /// The log cannot be used.
    Rejected(Rejected),
}

/// Computes and writes a session, unless it is up to date.
///
/// # Errors
/// The output cannot be written; all else is in [`Ended`].
pub(crate) fn run<W: Work>(
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
    // the log is hashed again: hours may have passed since the plan
    let stamp = Stamp::of(&job.location);
    let input_hash = match hash_file(&job.location) {
        Ok(hash) => hash,
        Err(e) => {
            let why = ingest::Error::unreadable(&job.location, &e);
            return refuse(job, store, why.into(), None);
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
        let output = work.run(&input, &job.bike, settings.pipeline)?;
        same(job, output, || work.identify(&job.location, settings.maps.list()))
    });
    // what was read may be neither the old log nor the new one
    let output = match stamp.is_changed(&job.location, &input_hash) {
        true => Err(changed(job, "its bytes have changed")),
        false => output,
    };
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

/// Checks that the session that was read is the one that was planned, after which its files are named.
fn same<R>(
    job: &Job,
    output: Output<R>,
    identify: impl FnOnce() -> Result<Identified, Rejection>,
) -> Result<Output<R>, Rejection> {
    let is_planned = |session_id: &str, bike_id: &str| {
        session_id == job.meta.session_id && bike_id == job.meta.bike_id
    };
    let Ident { session_id, bike_id, .. } = &output.ident;
    if is_planned(session_id, bike_id) {
        return Ok(output);
    }
    let how = format!(
        "it was session `{}` of `{}` when the run began, and is `{session_id}` of `{bike_id}` now",
        job.meta.session_id, job.meta.bike_id
    );
    // an unchanged log still identifies itself as the planned session
    match identify() {
        Ok(now) if is_planned(&now.meta.session_id, &now.meta.bike_id) => {}
        _ => return Err(changed(job, &how)),
    }
    let message = format!(
        "the log was identified as session `{}` and read as `{session_id}`; this is a mistake in \
         roadbench, please report it",
        job.meta.session_id
    );
    Err(Rejection {
        stage: Stage::Ingest,
        code: RejectionCode::InternalError,
        message,
        limits: None,
    })
}

/// Rejection of a log that changed while it was read.
fn changed(job: &Job, how: &str) -> Rejection {
    let message = format!(
        "{} changed while it was read ({how}); the next run reads it again: nothing should write to it then",
        job.log
    );
    Rejection { stage: Stage::Ingest, code: RejectionCode::Changed, message, limits: None }
}

/// Stamp that shows whether a file changed; `None` for an object, whose bytes are requested by their ETag.
#[derive(Debug, PartialEq, Eq)]
struct Stamp(Option<(u64, SystemTime, [i64; 3])>);

impl Stamp {
    fn of(log: &Location) -> Self {
        let meta = log.as_path().and_then(|path| std::fs::metadata(path).ok());
        let of = |meta: Metadata| {
            let written = meta.modified().unwrap_or(SystemTime::UNIX_EPOCH);
            (meta.len(), written, identity(&meta))
        };
        Stamp(meta.map(of))
    }

    /// Whether the bytes of a log have changed; `false` if it is gone or cannot be read.
    fn is_changed(&self, log: &Location, hash: &str) -> bool {
        *self != Stamp::of(log) && hash_file(log).is_ok_and(|now| now != hash)
    }
}

/// Inode of a file, and the time of the last change of its bytes or name.
#[cfg(unix)]
fn identity(meta: &Metadata) -> [i64; 3] {
    use std::os::unix::fs::MetadataExt;
    [meta.ino() as i64, meta.ctime(), meta.ctime_nsec()]
}

#[cfg(not(unix))]
fn identity(_: &Metadata) -> [i64; 3] {
    [0; 3]
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
pub(crate) fn reject_rival(job: &Job, store: &Store, holder: &str) -> Result<Rejected, Error> {
    let hash = job.hash.clone().or_else(|| hash_file(&job.location).ok());
    let why = plan::same_session(&job.key(), holder);
    let row = plan::row(job.log.clone(), Some(job.meta.clone()), why, hash);
    reject(store, &row, job.start)?;
    Ok(row)
}

/// Writes a rejection. Rows that the output has from this log are removed. Rows from another log, or from a ride with
/// another start than `start`, stay.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn reject(store: &Store, row: &Rejected, start: Option<i64>) -> Result<(), Error> {
    // the session of a duplicate belongs to the log that was used; an unreachable log may be unchanged
    if let Some(key) = store.given_up(row, start) {
        store.remove(&key)?;
    }
    Ok(store.reject(row)?)
}
