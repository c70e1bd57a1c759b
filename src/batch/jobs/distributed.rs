//! The same batch over many machines: one process plans and keeps the accounts, others compute.
//!
//! ```text
//! Driver::open -> terms, a task per log -> Worker::run, anywhere -> answers -> Driver::close
//! ```
//!
//! All of them see logs and output under the same paths. The driver alone locks the output, looks
//! for what is there, and says at the end whether every input is accounted for; bike files, channel
//! maps and pipeline go to the workers as text. A worker writes a session as a run on one machine
//! does, with the same bytes. A task may be lost, repeated, or done twice at once: whole files
//! replace whole files of the same content.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::bikes::BikeFile;
use super::diagnose::DiagnoseWork;
pub(crate) use super::job_kind::JobKind;
use super::run::RunWork;
use super::session::{self, Ended};
use super::work::Work;
use crate::batch::discover::inputs;
use crate::batch::error::Error;
use crate::batch::plan;
use crate::batch::plan::{Job, Plan};
use crate::batch::settings::{Maps, Settings};
use crate::batch::store::contents::Contents;
use crate::batch::store::folder::Store;
use crate::batch::store::marker::Committed;
use crate::batch::workers::scheduler as engine;
use crate::batch::workers::scheduler::Accounts;
use crate::batch::workers::watch::State;
use crate::contract::bike::Bike;
use crate::contract::session::Meta;
use crate::diagnose;
use crate::pipeline::Pipeline;
use crate::store::objects::Location;
use crate::store::tables::registry;
use crate::store::tables::rows::Rejected;

/// Settings that all tasks share.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Terms {
    /// Version of the driver's roadbench, which every worker must have.
    pub version: String,
    /// Output folder, the same for all machines.
    pub out: Location,
    /// The pipeline, resolved, as TOML.
    pub pipeline: String,
    /// Channel maps: names and texts.
    pub maps: Vec<(String, String)>,
    /// Bike files by id.
    pub bikes: BTreeMap<String, BikeText>,
    /// Compute again what is there already.
    pub force: bool,
    /// Work on each log.
    pub what: JobKind,
}

pub(crate) fn run_work(signals: bool) -> RunWork {
    RunWork { signals }
}

pub(crate) fn diagnose_work(nulls: usize, advise: bool) -> Result<DiagnoseWork, Error> {
    let settings = diagnose::Settings { nulls, advise, ..diagnose::Settings::default() };
    DiagnoseWork::new(settings).map_err(|e| Error::Usage(format!("nulls: {e}")))
}

/// A bike file on its way to the workers.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct BikeText {
    /// Text of the file.
    pub text: String,
    /// As in [`BikeFile`].
    pub pipeline_hash: String,
}

/// One session to compute.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Task {
    /// Path or URL of the log, as in the tables.
    pub log: String,
    /// Its size, bytes.
    pub bytes: u64,
    /// Id of the session in the log.
    pub session_id: String,
    /// Bike that it was ridden on.
    pub bike_id: String,
    /// Hash of all that its tables are made from besides the log.
    pub pipeline_hash: String,
    /// When it began, microseconds since 1970.
    #[serde(default)]
    pub start: Option<i64>,
    /// Entries that the output has of the session already.
    pub there: Vec<Committed>,
}

/// Result of a task.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Answer {
    /// Path or URL of the log, as in the tables.
    pub log: String,
    /// Outcome of the log.
    pub state: State,
    /// Its row, if it was rejected.
    pub rejected: Option<Rejected>,
    /// BLAKE3 of the log's bytes, if it was computed.
    pub input_hash: Option<String>,
    /// Samples on the common clock.
    pub samples: i64,
    /// Time it took, s.
    pub seconds: f64,
}

impl Answer {
    /// Nothing is known yet of what became of a log.
    fn of(log: &str) -> Self {
        Answer {
            log: log.to_owned(),
            state: State::Done,
            rejected: None,
            input_hash: None,
            samples: 0,
            seconds: 0.0,
        }
    }

    fn take<R>(&mut self, ended: Ended<R>) {
        match ended {
            Ended::Unchanged => self.state = State::Unchanged,
            Ended::Rejected(row) => {
                self.state = State::Rejected;
                self.rejected = Some(row);
            }
            Ended::Done { input_hash, samples, .. } => {
                self.samples = samples;
                self.input_hash = Some(input_hash);
            }
        }
    }
}

fn ended<W: Work>(
    job: &Job,
    settings: &Settings<'_>,
    there: Vec<Committed>,
    work: &W,
) -> Result<Ended<W::Result>, Error> {
    session::run(job, settings, &Store::join(work.kind(), settings.out, there), work)
}

/// The process that plans; it holds the output until it is dropped.
#[derive(Debug)]
pub struct Driver {
    store: Store,
    inputs: usize,
    jobs: Vec<Job>,
    refused: Vec<Rejected>,
    bytes: u64,
    terms: Terms,
}

impl Driver {
    /// Finds the logs and their bikes, locks the output and writes the rows of what is refused
    /// unread. `maps` are the texts that the settings' maps were made from.
    ///
    /// # Errors
    /// As [`super::run`] before any session.
    pub fn open(
        settings: &Settings<'_>,
        maps: Vec<(String, String)>,
        what: JobKind,
    ) -> Result<Self, Error> {
        match what {
            JobKind::Run { signals } => Self::with(settings, maps, &run_work(signals), what),
            JobKind::Diagnose { nulls, advise } => {
                Self::with(settings, maps, &diagnose_work(nulls, advise)?, what)
            }
        }
    }

    fn with(
        settings: &Settings<'_>,
        maps: Vec<(String, String)>,
        work: &impl Work,
        what: JobKind,
    ) -> Result<Self, Error> {
        let (found, bikes) = inputs(settings)?;
        let inputs = found.len();
        // every log is opened here: what is there is looked at by the workers
        let nothing = Contents::unknown(work.kind(), settings.out);
        let plan = plan::plan(found, &bikes, &nothing, settings, work)?;
        let bytes = plan.bytes();
        let Plan { mut jobs, refused } = plan;
        let store = Store::open(work.kind(), settings.out)?;
        let refused: Vec<Rejected> = refused.into_iter().map(|r| r.row).collect();
        for row in &refused {
            session::reject(&store, row, None)?;
        }
        jobs.sort_by(|a, b| b.bytes.cmp(&a.bytes).then_with(|| a.log.cmp(&b.log)));
        let text = |bike: &BikeFile| BikeText {
            text: bike.text.clone(),
            pipeline_hash: bike.pipeline_hash.clone(),
        };
        let terms = Terms {
            version: crate::VERSION.to_owned(),
            out: settings.out.clone(),
            pipeline: resolved(settings.pipeline)?,
            maps,
            bikes: jobs.iter().map(|j| (j.meta.bike_id.clone(), text(&j.bike))).collect(),
            force: settings.force,
            what,
        };
        Ok(Driver { store, inputs, jobs, refused, bytes, terms })
    }

    /// Settings that every worker needs.
    pub fn terms(&self) -> &Terms {
        &self.terms
    }

    /// Work on each log.
    pub fn what(&self) -> &JobKind {
        &self.terms.what
    }

    /// A task per session, the largest log first.
    pub fn tasks(&self) -> Vec<Task> {
        self.jobs.iter().map(|job| self.task(job)).collect()
    }

    fn task(&self, job: &Job) -> Task {
        Task {
            log: job.log.clone(),
            bytes: job.bytes,
            session_id: job.meta.session_id.clone(),
            bike_id: job.meta.bike_id.clone(),
            pipeline_hash: job.pipeline_hash.clone(),
            start: job.start,
            there: self.store.found().of(&job.key()).to_vec(),
        }
    }

    /// Answers for the other logs of a session: they are few, and are processed here once the first log has its answer.
    fn rivals(&self, by_log: &mut BTreeMap<String, Answer>) -> Result<(), Error> {
        let gave_rows = |job: &Job, answer: Option<&Answer>| match answer {
            None => false,
            Some(Answer { rejected: Some(row), .. }) => self.store.keeps(row, job.start),
            Some(_) => true,
        };
        for first in self.jobs.iter().filter(|job| !job.rivals.is_empty()) {
            let mut holder = Some(first).filter(|job| gave_rows(job, by_log.get(&job.log)));
            for job in &first.rivals {
                let answer = match holder {
                    None => Worker::new(self.terms.clone())?.run(self.task(job))?,
                    Some(holder) => Answer {
                        state: State::Rejected,
                        rejected: Some(session::reject_rival(job, &self.store, &holder.log)?),
                        ..Answer::of(&job.log)
                    },
                };
                if holder.is_none() && gave_rows(job, Some(&answer)) {
                    holder = Some(job);
                }
                by_log.insert(job.log.clone(), answer);
            }
        }
        Ok(())
    }

    /// Holds the answers against the tasks and against what is in the output, and clears what
    /// killed workers left. Gives back the output, still locked.
    ///
    /// # Errors
    /// An input is not accounted for, or a session that was said to be done is not whole.
    pub fn close(self, answers: Vec<Answer>) -> Result<(Accounts, Store), Error> {
        let mut by_log: BTreeMap<String, Answer> =
            answers.into_iter().map(|a| (a.log.clone(), a)).collect();
        let logs = || self.jobs.iter().flat_map(|job| std::iter::once(job).chain(&job.rivals));
        self.rivals(&mut by_log)?;
        self.store.tidy()?;
        self.store.merge()?;
        let there = self.store.found().read_again()?;
        let signals = matches!(self.terms.what, JobKind::Run { signals: true });
        self.store.expect(logs());
        let mut accounts = Accounts {
            inputs: self.inputs,
            rejected: self.refused,
            bytes: self.bytes,
            ..Accounts::default()
        };
        for job in logs() {
            let Some(answer) = by_log.remove(&job.log) else {
                return Err(Error::Output(format!(
                    "{}: no worker returned a result of this log; run the same command again",
                    job.log
                )));
            };
            if let Some(row) = answer.rejected {
                accounts.rejected.push(row);
                continue;
            }
            let hash = answer.input_hash.or_else(|| there.input_hash(&job.key()));
            let wanted = job.wanted(hash.unwrap_or_default());
            if let Some(stale) =
                there.stale(&wanted, |table| signals && table.is(&registry::SIGNALS))
            {
                return Err(Error::Output(format!(
                    "{}: a worker wrote its tables, but they are not in {} ({}); is that folder \
                     the same on every machine?",
                    job.log,
                    self.store.root(),
                    stale.words()
                )));
            }
            self.store.remove_superseded(&wanted)?;
            accounts.sessions.insert(job.key());
            match answer.state {
                State::Unchanged => accounts.unchanged += 1,
                State::Done | State::Rejected => accounts.done += 1,
            }
        }
        self.store.merge()?;
        accounts.damage = engine::damage(&self.store);
        accounts.rejected.sort_by(|a, b| a.path.cmp(&b.path));
        Ok((accounts, self.store))
    }
}

/// The pipeline as text, made sure of: it must read back as itself.
pub(crate) fn resolved(pipeline: &Pipeline) -> Result<String, Error> {
    let fail = |e: String| Error::Internal(format!("pipeline {}: {e}", pipeline.name));
    let text = toml::to_string(pipeline).map_err(|e| fail(e.to_string()))?;
    let back = Pipeline::parse(&text, &pipeline.name).map_err(|e| fail(e.to_string()))?;
    if back == *pipeline {
        Ok(text)
    } else {
        Err(fail("its text does not read back as the same settings".into()))
    }
}

/// A process that computes.
#[derive(Debug)]
pub struct Worker {
    terms: Terms,
    pipeline: Pipeline,
    maps: Maps,
    bikes: BTreeMap<String, Arc<BikeFile>>,
}

impl Worker {
    /// Gets ready.
    ///
    /// # Errors
    /// The driver's roadbench is another one.
    pub fn new(terms: Terms) -> Result<Self, Error> {
        if terms.version != crate::VERSION {
            return Err(Error::Usage(format!(
                "this worker has roadbench {}, the driver {}: install the same wheel on all machines",
                crate::VERSION,
                terms.version
            )));
        }
        let pipeline = Pipeline::parse(&terms.pipeline, "driver")
            .map_err(|e| Error::Internal(e.to_string()))?;
        let maps = Maps::parse(&terms.maps).map_err(|e| Error::Internal(e.to_string()))?;
        let mut bikes = BTreeMap::new();
        for (id, BikeText { text, pipeline_hash }) in &terms.bikes {
            let bike =
                Bike::parse(text, id, Path::new(id)).map_err(|e| Error::Internal(e.to_string()))?;
            let (text, pipeline_hash) = (text.clone(), pipeline_hash.clone());
            bikes.insert(id.clone(), Arc::new(BikeFile { bike, text, pipeline_hash }));
        }
        Ok(Worker { terms, pipeline, maps, bikes })
    }

    /// Computes a session and writes its tables, or its row in `rejected`.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn run(&self, task: Task) -> Result<Answer, Error> {
        let start = Instant::now();
        let Some(bike) = self.bikes.get(&task.bike_id) else {
            return Err(Error::Internal(format!("{}: no bike {}", task.log, task.bike_id)));
        };
        let job = Job {
            location: Location::parse(&task.log).map_err(|e| Error::Usage(e.to_string()))?,
            log: task.log.clone(),
            bytes: task.bytes,
            meta: Meta { session_id: task.session_id, bike_id: task.bike_id, ..Meta::default() },
            bike: Arc::clone(bike),
            pipeline_hash: task.pipeline_hash,
            hash: None,
            start: task.start,
            rivals: Vec::new(),
        };
        let settings = Settings {
            inputs: &[],
            bikes: None,
            out: &self.terms.out,
            pipeline: &self.pipeline,
            maps: &self.maps,
            jobs: 1,
            force: self.terms.force,
            since: None,
        };
        let mut answer = Answer::of(&task.log);
        match self.terms.what {
            JobKind::Run { signals } => {
                answer.take(ended(&job, &settings, task.there, &run_work(signals))?);
            }
            JobKind::Diagnose { nulls, advise } => {
                let work = diagnose_work(nulls, advise)?;
                answer.take(ended(&job, &settings, task.there, &work)?);
            }
        }
        answer.seconds = start.elapsed().as_secs_f64();
        Ok(answer)
    }
}
