//! Each log in a process of its own that may die: a log is foreign input to native parsers.
//!
//! ```text
//! engine -> Sandboxed (a Work) -> pool: an idle worker, or a new one -> child: question, answer, deadline -> serve (the worker)
//!              quarantine        limits of memory and time             wire: frames over the pipes         sandbox
//! ```
//!
//! [`Sandboxed`] does what the work in it does, in workers: processes of the same program that read logs and give back the
//! files of a session through a pipe. They can write nothing and reach no network (`sandbox`). A worker that
//! crashes, or goes beyond its limits, costs the batch one log: a row of `rejected` with the code `crashed`,
//! `too_large` or `too_slow` and the limits that it had. As long as its bytes, the limits and roadbench are the same, it
//! is not tried again (`quarantine`). One that is killed from outside, or cannot be started, says nothing of its log: see
//! [`blame`](super::blame).

use std::ffi::OsString;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;
use serde::de::DeserializeOwned;

use self::child::Ended;
pub(crate) use self::limits::{LimitOptions, Limits};
use self::pool::Pool;
use self::quarantine::Quarantine;
use self::wire::{Answer, Place, Question, Setup};
use super::threads;
use crate::batch::error::Error;
use crate::batch::jobs::bikes::BikeFile;
use crate::batch::jobs::job_kind::JobKind;
use crate::batch::jobs::work::{EXTENSIONS, Output, SessionFile, Work};
use crate::batch::log_hash::hash_file;
use crate::batch::settings::Settings;
use crate::batch::store::kind::Kind;
use crate::contract::rejection::{RejectionCode, Stage};
use crate::ingest::Identified;
use crate::ingest::maps::ChannelMap;
use crate::pipeline::{Input, Pipeline, Rejection};
use crate::store::objects::{Location, source};
use crate::store::tables::registry;
use crate::store::tables::registry::TableSpec;

mod child;
pub(crate) mod limits;
mod pool;
mod quarantine;
mod sandbox;
pub(crate) mod serve;
mod wire;

/// First argument of the program that makes it a worker.
pub const WORKER: &str = "__worker";

/// Stage of a rejection of a log that does not get as far as telling whose it is.
const IDENTIFY: Stage = Stage::Ingest;

/// Command of a worker: the program and its arguments.
static PROGRAM: OnceLock<Vec<OsString>> = OnceLock::new();

/// Says what starts a worker where it is not this very program, as in a Python process. The first word wins.
pub fn started_by(program: Vec<OsString>) {
    let _ = PROGRAM.set(program);
}

fn program() -> Vec<OsString> {
    PROGRAM.get().cloned().unwrap_or_else(|| {
        // also where the file was replaced or removed meanwhile
        let own = match cfg!(target_os = "linux") {
            true => "/proc/self/exe".into(),
            false => std::env::current_exe().map(Into::into).unwrap_or_else(|_| "roadbench".into()),
        };
        vec![own, WORKER.into()]
    })
}

/// A work whose logs are read by workers.
#[derive(Debug)]
pub struct Sandboxed<W> {
    work: W,
    /// None where logs are read in this process.
    workers: Option<Workers>,
    /// Whether workers send what a session gives beside its files.
    wants_results: AtomicBool,
}

/// The worker processes that read logs.
#[derive(Debug)]
struct Workers {
    pool: Pool,
    asked: LimitOptions,
    jobs: usize,
    quarantine: Quarantine,
}

impl<W: Work> Sandboxed<W> {
    /// Puts a work behind the fence. A work that no worker knows, and one whose workers cannot be started, is done in
    /// this process; the latter is said.
    ///
    /// # Errors
    /// The pipeline cannot be written as text: our own mistake.
    pub fn new(work: W, settings: &Settings<'_>, asked: LimitOptions) -> Result<Self, Error> {
        let Some(what) = work.what().filter(|_| !asked.in_process) else {
            return Ok(Sandboxed::open(work));
        };
        let setup = Setup {
            version: crate::VERSION.to_owned(),
            pipeline: crate::batch::jobs::distributed::resolved(settings.pipeline)?,
            maps: settings.maps.given().to_vec(),
            what,
            // logs in an object store are fetched by the worker
            offline: !settings.inputs.iter().any(Location::is_remote),
        };
        let jobs = threads::taken(settings.jobs);
        let pool = match Pool::new(program(), setup, jobs.min(limits::most_workers())) {
            Ok(pool) => pool,
            Err(e) => {
                tracing::warn!(
                    "no worker process can be started ({}): logs are read in this process, without limits",
                    e.trim_end()
                );
                return Ok(Sandboxed::open(work));
            }
        };
        let quarantine = match settings.force {
            true => Quarantine::default(),
            false => Quarantine::read(settings.out),
        };
        let workers = Some(Workers { pool, asked, jobs, quarantine });
        Ok(Sandboxed { workers, ..Sandboxed::open(work) })
    }

    /// Runs the work in this process, without limits.
    pub fn open(work: W) -> Self {
        Sandboxed { work, workers: None, wants_results: AtomicBool::new(true) }
    }

    /// The work in it.
    pub fn inner(&self) -> &W {
        &self.work
    }
}

impl Workers {
    /// Limits of a worker for a log.
    fn limits(&self, log: &Location) -> Limits {
        let bytes = source::stat(log).map_or(0, |s| s.size);
        self.asked.limits(bytes, self.jobs, self.pool.setup().what.effort())
    }

    fn ask(
        &self,
        question: &Question,
        limits: &Limits,
        stage: Stage,
    ) -> Result<(Answer, Vec<u8>), Rejection> {
        self.pool.ask(question, limits).map_err(|ended| refused(ended, limits, stage))
    }
}

/// The rejection of a log that a worker did not survive.
fn refused(ended: Ended, limits: &Limits, stage: Stage) -> Rejection {
    let is_own =
        |code, message| Rejection { stage, code, message, limits: Some(limits.to_string()) };
    // the machine's: whatever the limits are, the next batch tries again
    let is_not = |code, message| Rejection { stage, code, message, limits: None };
    match ended {
        Ended::Memory => is_own(
            RejectionCode::TooLarge,
            format!(
                "reading this log takes more than {} of memory, so its worker was stopped: the log \
                 is damaged or large; for a large one raise --memory-limit GB",
                limits.memory_text()
            ),
        ),
        Ended::Time => is_own(
            RejectionCode::TooSlow,
            format!(
                "reading this log takes more than {} of processor time, so its worker was stopped: \
                 the log is damaged or long; for a long one raise --time-limit SECONDS",
                limits.time_text()
            ),
        ),
        Ended::Crash(how) => is_own(
            RejectionCode::Crashed,
            format!(
                "its worker crashed ({how}); this is a mistake in roadbench, please report it with the log"
            ),
        ),
        Ended::Killed(how) => is_not(
            RejectionCode::Killed,
            format!(
                "its worker was killed twice from outside ({how}), for example because the \
                 computer ran out of memory; the next run tries again: more memory or fewer --jobs help"
            ),
        ),
        Ended::NoMemory => is_not(
            RejectionCode::NoMemory,
            format!(
                "its worker ran out of memory below its limit of {}: the shell allows less \
                 (`ulimit -v`, `ulimit -d`); raise that or lower --memory-limit; the next run tries again",
                limits.memory_text()
            ),
        ),
        Ended::NotStarted(why) => is_not(
            RejectionCode::NoWorker,
            format!(
                "no worker process can be started: {}; free processes, memory or open files, or \
                 give fewer --jobs; the next run tries again",
                why.trim_end()
            ),
        ),
    }
}

impl<W: Work> Work for Sandboxed<W>
where
    W::Result: Serialize + DeserializeOwned,
{
    type Result = W::Result;

    fn kind(&self) -> &'static Kind {
        self.work.kind()
    }

    fn settings(&self) -> String {
        self.work.settings()
    }

    fn is_requested(&self, table: &TableSpec) -> bool {
        self.work.is_requested(table)
    }

    fn planned(&self, logs: usize) {
        self.wants_results.store(self.work.is_result_wanted(logs), Ordering::Relaxed);
    }

    fn all_done(&self) {
        self.work.all_done();
        // workers keep the memory of their largest log
        if let Some(workers) = &self.workers {
            workers.pool.clear();
        }
    }

    fn identify(&self, log: &Location, maps: &[ChannelMap]) -> Result<Identified, Rejection> {
        let Some(workers) = &self.workers else { return self.work.identify(log, maps) };
        let limits = workers.limits(log);
        if !workers.quarantine.is_empty()
            && let Ok(hash) = hash_file(log)
            // one that ended its worker later tells whose it is as before
            && let Some(known) = workers.quarantine.of(&hash, &limits).filter(|k| k.stage == IDENTIFY)
        {
            return Err(known);
        }
        match workers.ask(&Question::Identify { log: Place::of(log) }, &limits, IDENTIFY)? {
            (Answer::Identified(who), _) => Ok(who),
            (answer, _) => Err(rejection(answer, IDENTIFY, &limits)),
        }
    }

    fn run(
        &self,
        input: &Input<'_>,
        bike: &BikeFile,
        pipeline: &Pipeline,
    ) -> Result<Output<W::Result>, Rejection> {
        let Some(workers) = &self.workers else { return self.work.run(input, bike, pipeline) };
        let stage = self.work.kind().stage;
        let limits = workers.limits(&input.log);
        if let Some(known) = workers.quarantine.of(&input.input_hash, &limits) {
            return Err(known);
        }
        let question = Question::Run {
            log: Place::of(&input.log),
            input_hash: input.input_hash.clone(),
            pipeline_hash: input.pipeline_hash.clone(),
            bike_id: bike.bike.bike_id.clone(),
            bike: bike.text.clone(),
            signals: input.signals,
            result: self.wants_results.load(Ordering::Relaxed),
        };
        match workers.ask(&question, &limits, stage)? {
            (Answer::Done { ident, samples, files, result }, body) => {
                let unreadable =
                    |how: &str| refused(Ended::Crash(format!("its answer {how}")), &limits, stage);
                let whole = cut(&files, result, &body);
                let (files, result) = whole.ok_or_else(|| unreadable("has no whole files"))?;
                let result = match result {
                    [] => None,
                    json => {
                        Some(serde_json::from_slice(json).map_err(|e| unreadable(&e.to_string()))?)
                    }
                };
                Ok(Output { ident, samples, files, result })
            }
            (answer, _) => Err(rejection(answer, stage, &limits)),
        }
    }
}

/// Why the log cannot be used, by an answer that has nothing else to say.
fn rejection(answer: Answer, stage: Stage, limits: &Limits) -> Rejection {
    match answer {
        Answer::Rejected { stage: own, code, message } => {
            Rejection { stage: own, code, message, limits: None }
        }
        other => refused(Ended::Crash(format!("it answered {}", other.kind())), limits, stage),
    }
}

/// The files in the body of an answer, and what is behind them.
fn cut<'a>(
    files: &[wire::File],
    result: u64,
    body: &'a [u8],
) -> Option<(Vec<SessionFile>, &'a [u8])> {
    let mut rest = body;
    let mut out = Vec::with_capacity(files.len());
    for file in files {
        let (bytes, behind) = rest.split_at_checked(usize::try_from(file.bytes).ok()?)?;
        rest = behind;
        let folder = registry::folders().find(|name| *name == file.folder)?;
        let extension = EXTENSIONS.into_iter().find(|e| *e == file.extension)?;
        out.push(SessionFile { folder, extension, bytes: bytes.to_vec() });
    }
    (rest.len() as u64 == result).then_some((out, rest))
}

impl JobKind {
    /// How much longer it takes than a run.
    fn effort(&self) -> f64 {
        match self {
            JobKind::Run { .. } => 1.0,
            JobKind::Diagnose { nulls, .. } => 10.0 + *nulls as f64,
        }
    }
}
