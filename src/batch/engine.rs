//! The batch itself: a session per worker, results to the store as they come.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::discover::{Found, bikes_beside, discover};
use super::plan::{self, Job, Plan};
use super::store::{Committed, Contents, Stale, Store};
use super::{Error, Settings, Work, guarded};
use crate::ingest::UNREACHABLE;
use crate::objects::source;
use crate::pipeline::{Input, Outcome, Rejection};
use crate::tables::file;
use crate::tables::names::is_plain;
use crate::tables::rows::{Rejected, WarningRow};

/// What became of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Computed and written.
    Done,
    /// Was there already, made from the same.
    Unchanged,
    /// Not usable; has a row in `rejected`.
    Rejected,
}

/// One input that is through, for progress and logs.
#[derive(Debug)]
pub struct Finished<'a> {
    /// The log.
    pub log: &'a str,
    /// The session, where it could be told.
    pub session_id: Option<&'a str>,
    /// What became of it.
    pub state: State,
    /// Why, if it was rejected: code and message.
    pub why: Option<(&'a str, &'a str)>,
    /// Time it took, s.
    pub seconds: f64,
    /// Samples on the common clock.
    pub samples: i64,
    /// Size of the log, bytes.
    pub bytes: u64,
}

/// Who wants to know how far a run is.
pub trait Watch: Sync {
    /// Inputs and their bytes are known.
    fn planned(&self, _inputs: usize, _bytes: u64) {}
    /// One more is through. Called from the workers.
    fn finished(&self, _finished: &Finished<'_>) {}
}

impl Watch for () {}

/// What a run did.
#[derive(Debug, Default)]
pub struct Run {
    /// Inputs found.
    pub inputs: usize,
    /// The sessions that came through, by id.
    pub sessions: BTreeSet<String>,
    /// Computed and written.
    pub done: usize,
    /// Were there already.
    pub unchanged: usize,
    /// Not usable, in order of path.
    pub rejected: Vec<Rejected>,
    /// Not begun, because the run was stopped.
    pub left: usize,
    /// Size of all logs, bytes.
    pub bytes: u64,
    /// The outcome, where there was one log only; without its time series.
    pub only: Option<Outcome>,
}

/// Runs the batch. `stop` ends it early: sessions under way are finished, no other is begun.
///
/// Gives back the output too, still locked: no other run writes there until it is dropped. A
/// single log is always computed, so that its coefficients can be shown.
///
/// # Errors
/// Before anything is written: bad usage. Later: the output cannot be written.
pub fn run(
    settings: &Settings<'_>,
    work: &impl Work,
    watch: &impl Watch,
    stop: &AtomicBool,
) -> Result<(Run, Store), Error> {
    let (found, bikes) = inputs(settings)?;
    let inputs = found.len();
    let threads = match settings.jobs {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        jobs => jobs,
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.min(inputs).max(1))
        .build()
        .map_err(|e| Error::Usage(format!("--jobs {threads}: {e}")))?;
    let before = Contents::read(settings.out)?;
    let (pipeline, maps) = (settings.pipeline, settings.maps);
    let Plan { mut jobs, refused } =
        pool.install(|| plan::plan(found, &bikes, &before, pipeline, maps, work))?;
    let bytes = jobs.iter().map(|j| j.bytes).chain(refused.iter().map(|r| r.bytes)).sum();
    let store = Store::open_again(settings.out, &before)?;
    watch.planned(inputs, bytes);

    let mut rejected = Vec::new();
    let mut unwritten = 0;
    for refused in refused {
        if stop.load(Ordering::Relaxed) {
            unwritten += 1;
            continue;
        }
        let row = refused.row;
        reject(&store, &row)?;
        watch.finished(&Finished { bytes: refused.bytes, ..rejection(&row) });
        rejected.push(row);
    }

    // The largest log first, so that no worker is left with it at the end. Workers take the next
    // job themselves instead of being rayon tasks: a worker that waits for parallel work inside
    // a session can then never begin a second session on top of it.
    jobs.sort_by(|a, b| b.bytes.cmp(&a.bytes).then_with(|| a.found.path.cmp(&b.found.path)));
    let shared = Shared {
        settings: Settings { force: settings.force || inputs == 1, ..*settings },
        keep: inputs == 1,
        store: &store,
        jobs: &jobs,
        next: AtomicUsize::new(0),
        halt: AtomicBool::new(false),
        stop,
        tally: Mutex::default(),
    };
    pool.broadcast(|_| shared.worker(work, watch));
    let mut tally = shared.tally.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Some(error) = tally.error {
        return Err(Error::Output(error.to_string()));
    }
    rejected.append(&mut tally.rejected);
    rejected.sort_by(|a, b| a.path.cmp(&b.path));
    let left = unwritten + jobs.len() - tally.done - tally.unchanged - tally.refused;
    let run = Run {
        inputs,
        sessions: tally.sessions,
        done: tally.done,
        unchanged: tally.unchanged,
        rejected,
        left,
        bytes,
        only: tally.only,
    };
    if run.sessions.len() + run.rejected.len() + run.left != run.inputs
        || (run.left > 0 && !stop.load(Ordering::Relaxed))
    {
        return Err(Error::Internal(format!(
            "{} inputs but {} sessions, {} rejected and {} left",
            run.inputs,
            run.sessions.len(),
            run.rejected.len(),
            run.left
        )));
    }
    Ok((run, store))
}

/// What a run would do with an input, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Intended {
    /// The log.
    pub log: String,
    /// The session, where it can be told.
    pub session_id: Option<String>,
    /// What would become of it; [`State::Rejected`] stands for what is refused before it is read.
    pub state: State,
    /// Why, in words; empty where nothing would be done.
    pub why: String,
}

/// What [`run`] would do, in order of path. Writes nothing and needs no lock.
///
/// # Errors
/// As [`run`] before it writes.
pub fn intend(settings: &Settings<'_>, work: &impl Work) -> Result<Vec<Intended>, Error> {
    let (found, bikes) = inputs(settings)?;
    let force = settings.force || found.len() == 1; // as `run` does
    let there = Contents::read(settings.out)?;
    let (pipeline, maps) = (settings.pipeline, settings.maps);
    let Plan { jobs, refused } = plan::plan(found, &bikes, &there, pipeline, maps, work)?;
    let refused = refused.into_iter().map(|r| Intended {
        log: r.row.path,
        session_id: r.row.session_id,
        state: State::Rejected,
        why: r.row.message,
    });
    let jobs: Vec<Intended> = jobs
        .par_iter()
        .map(|job| {
            let hash = job.hash.clone().map_or_else(|| plan::hash_file(&job.found.path), Ok);
            let (state, why) = match hash {
                Err(e) => (State::Rejected, format!("cannot read {}: {e}", job.log)),
                Ok(hash) => {
                    let stale = there
                        .stale(&wanted(job, hash), settings.signals)
                        .or(force.then_some(Stale::Forced));
                    match stale {
                        Some(stale) => (State::Done, stale.words().to_owned()),
                        None => (State::Unchanged, String::new()),
                    }
                }
            };
            let session_id = Some(job.meta.session_id.clone());
            Intended { log: job.log.clone(), session_id, state, why }
        })
        .collect();
    let mut all: Vec<Intended> = refused.chain(jobs).collect();
    all.sort_by(|a, b| a.log.cmp(&b.log));
    Ok(all)
}

/// The logs and the folder of bike files.
pub(super) fn inputs(settings: &Settings<'_>) -> Result<(Vec<Found>, PathBuf), Error> {
    let mut found = discover(settings.inputs, settings.out)?;
    if let Some(since) = settings.since {
        // what cannot be dated is looked at
        let old = |f: &Found| {
            f.problem.is_none() && source::stat(&f.path).is_ok_and(|stat| stat.modified < since)
        };
        found.retain(|f| !old(f));
    }
    let beside = bikes_beside(settings.inputs)?;
    let bikes = settings.bikes.map(Path::to_owned).or(beside).ok_or_else(|| {
        Error::Usage("which bikes? Give the folder of bike files with --bikes DIR".to_owned())
    })?;
    Ok((found, bikes))
}

/// What a session's tables would be made from.
pub(super) fn wanted(job: &Job, input_hash: String) -> Committed {
    Committed {
        session_id: job.meta.session_id.clone(),
        bike_id: job.meta.bike_id.clone(),
        path: job.log.clone(),
        input_hash,
        pipeline_hash: job.bike.pipeline_hash.clone(),
        version: crate::VERSION.to_owned(),
    }
}

/// What the workers share.
struct Shared<'a> {
    settings: Settings<'a>,
    keep: bool,
    store: &'a Store,
    jobs: &'a [Job],
    next: AtomicUsize,
    halt: AtomicBool,
    stop: &'a AtomicBool,
    tally: Mutex<Tally>,
}

#[derive(Default)]
struct Tally {
    sessions: BTreeSet<String>,
    done: usize,
    unchanged: usize,
    refused: usize,
    rejected: Vec<Rejected>,
    only: Option<Outcome>,
    error: Option<Error>,
}

impl Shared<'_> {
    fn worker(&self, work: &impl Work, watch: &impl Watch) {
        while !self.halt.load(Ordering::Relaxed) && !self.stop.load(Ordering::Relaxed) {
            let Some(job) = self.jobs.get(self.next.fetch_add(1, Ordering::Relaxed)) else {
                break;
            };
            let start = Instant::now();
            let result = session(job, &self.settings, self.store, work);
            let seconds = start.elapsed().as_secs_f64();
            let mut tally = self.tally.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            let mut finished = Finished {
                log: &job.log,
                session_id: Some(&job.meta.session_id),
                state: State::Done,
                why: None,
                seconds,
                samples: 0,
                bytes: job.bytes,
            };
            match result {
                Err(error) => {
                    self.halt.store(true, Ordering::Relaxed);
                    tally.error.get_or_insert(error);
                    return;
                }
                Ok(Ended::Unchanged) => {
                    tally.sessions.insert(job.meta.session_id.clone());
                    tally.unchanged += 1;
                    finished.state = State::Unchanged;
                    watch.finished(&finished);
                }
                Ok(Ended::Rejected(row)) => {
                    tally.refused += 1;
                    watch.finished(&Finished { seconds, bytes: job.bytes, ..rejection(&row) });
                    tally.rejected.push(row);
                }
                Ok(Ended::Done(outcome)) => {
                    tally.sessions.insert(job.meta.session_id.clone());
                    tally.done += 1;
                    finished.samples = outcome.session.n_samples;
                    watch.finished(&finished);
                    if self.keep {
                        tally.only = Some(Outcome { signals: None, ..*outcome });
                    }
                }
            }
        }
    }
}

/// One log from its bytes to its tables. An error is the output's; all else is in `Ended`.
pub(super) fn session(
    job: &Job,
    settings: &Settings<'_>,
    store: &Store,
    work: &impl Work,
) -> Result<Ended, Error> {
    let refuse = |why: Rejection, hash: Option<String>| {
        let row = plan::row(job.log.clone(), Some(job.meta.clone()), why, hash);
        reject(store, &row)?;
        Ok(Ended::Rejected(row))
    };
    if let Some(hash) = &job.hash
        && !settings.force
        && store.stale(&wanted(job, hash.clone()), settings.signals).is_none()
    {
        store.forgive(&job.log).map_err(output)?;
        return Ok(Ended::Unchanged);
    }
    // what is computed is hashed again: hours may lie between the plan and its turn
    let input_hash = match plan::hash_file(&job.found.path) {
        Ok(hash) => hash,
        Err(e) => {
            let message = format!("cannot read {}: {e}", job.log);
            return refuse(Rejection { stage: "ingest", code: "unreadable", message }, None);
        }
    };
    let wanted = wanted(job, input_hash);
    if !settings.force && store.stale(&wanted, settings.signals).is_none() {
        store.forgive(&job.log).map_err(output)?;
        return Ok(Ended::Unchanged);
    }
    let input = Input {
        log: (&job.found.path).into(),
        maps: &settings.maps.list,
        input_hash: wanted.input_hash.clone(),
        pipeline_hash: wanted.pipeline_hash.clone(),
        signals: settings.signals,
    };
    let outcome = guarded("pipeline", || work.run(&input, &job.bike.bike, settings.pipeline));
    let mut outcome = match outcome {
        Ok(outcome) => outcome,
        Err(why) => return refuse(why, Some(wanted.input_hash)),
    };
    if outcome.session.ident.session_id != job.meta.session_id
        || outcome.session.ident.bike_id != job.meta.bike_id
    {
        let message = format!(
            "the log was identified as session `{}` and read as `{}`; this is a mistake in \
             roadbench, please report it",
            job.meta.session_id, outcome.session.ident.session_id
        );
        let why = Rejection { stage: "ingest", code: "internal_error", message };
        return refuse(why, Some(wanted.input_hash));
    }
    note_unsafe_id(&mut outcome);
    let files = match store.encode(&outcome) {
        Ok(files) => files,
        Err(e) => {
            let message = format!("{e}; this is a mistake in roadbench, please report it");
            let why = Rejection { stage: "write", code: "internal_error", message };
            return refuse(why, Some(wanted.input_hash));
        }
    };
    store.commit(&wanted.session_id, &wanted.bike_id, &job.log, &files).map_err(output)?;
    Ok(Ended::Done(Box::new(outcome)))
}

/// What became of a log.
pub(super) enum Ended {
    Done(Box<Outcome>),
    Unchanged,
    Rejected(Rejected),
}

/// Writes a rejection; tables that the session had from an earlier run go.
pub(super) fn reject(store: &Store, row: &Rejected) -> Result<(), Error> {
    // a duplicate's name belongs to the log that was used; what cannot be reached may be as it was
    if !["duplicate_session_id", UNREACHABLE].contains(&row.code.as_str()) {
        let session = row.session_id.as_deref().or_else(|| store.once_was(&row.path));
        if let Some(session) = session {
            store.remove(session).map_err(output)?;
        }
    }
    store.reject(row).map_err(output)
}

fn rejection(row: &Rejected) -> Finished<'_> {
    Finished {
        log: &row.path,
        session_id: row.session_id.as_deref(),
        state: State::Rejected,
        why: Some((&row.code, &row.message)),
        seconds: 0.0,
        samples: 0,
        bytes: 0,
    }
}

/// The tables keep the id as it is; whoever looks for the file has to know it is named otherwise.
pub(super) fn note_unsafe_id(outcome: &mut Outcome) {
    let id = &outcome.session.ident.session_id;
    if is_plain(id) {
        return;
    }
    outcome.warnings.push(WarningRow {
        ident: outcome.session.ident.clone(),
        stage: "ingest".to_owned(),
        code: "unsafe_session_id".to_owned(),
        channel: None,
        count: 1,
        time: None,
        message: format!(
            "the session id cannot be a file name as it is; its tables are stored as {}.parquet",
            crate::tables::names::file_name(id)
        ),
    });
    outcome.session.n_warnings += 1;
}

fn output(e: file::Error) -> Error {
    Error::Output(e.to_string())
}
