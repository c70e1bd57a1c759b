//! `roadbench.run` and `roadbench.diagnose`: whole archives, as the commands do it.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};

use jiff::Timestamp;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::errors::{self, failed, invalid};
use roadbench::{
    Accounts, BatchError, BatchSettings, DiagnoseWork, DiagnosisSettings, JobKind, LimitOptions,
    Location, Maps, Pages, Pipeline, RunWork, Sandboxed, Store, Summary, Work, finish_diagnose,
    finish_run, read_models, run_batch,
};

/// How often Python is asked whether the user wants to stop.
const LOOK: Duration = Duration::from_millis(100);

/// Options of a batch, as JSON.
#[derive(Debug, Deserialize)]
pub struct Options {
    inputs: Vec<PathBuf>,
    bikes: Option<PathBuf>,
    out: PathBuf,
    pipeline: PathBuf,
    maps: Vec<PathBuf>,
    #[serde(default)]
    jobs: usize,
    force: bool,
    /// Seconds since 1970.
    since: Option<f64>,
    #[serde(default)]
    signals: bool,
    /// Output of a diagnosis whose causes are removed from the recordings.
    #[serde(default)]
    model: Option<PathBuf>,
    #[serde(default)]
    nulls: usize,
    #[serde(default)]
    advise: bool,
    /// On a cluster: diagnose instead of run.
    #[serde(default)]
    diagnose: bool,
}

/// Options that were read: what [`Settings`] borrow from.
#[derive(Debug)]
pub struct Given {
    options: Options,
    inputs: Vec<Location>,
    bikes: Option<Location>,
    out: Location,
    since: Option<SystemTime>,
    /// The stages' settings.
    pub pipeline: Pipeline,
    /// Names and texts of the channel maps.
    pub map_texts: Vec<(String, String)>,
    maps: Maps,
}

impl Given {
    /// Reads what the options name.
    ///
    /// # Errors
    /// `ValueError`: an option is not what it should be.
    pub fn read(options: &str) -> PyResult<Self> {
        let options: Options = read(options)?;
        let at = |path: &PathBuf| {
            Location::parse(path).map_err(|e| PyValueError::new_err(e.to_string()))
        };
        let map_texts = Maps::texts(&options.maps).map_err(invalid)?;
        let mut pipeline = errors::pipeline(&options.pipeline)?;
        if let Some(model) = &options.model {
            if pipeline.offroad.is_some() {
                let message = "model is for road sessions; take a pipeline without [offroad]";
                return Err(PyValueError::new_err(message));
            }
            pipeline.models = Some(read_models(&at(model)?).map_err(invalid)?);
        }
        Ok(Given {
            inputs: options.inputs.iter().map(at).collect::<PyResult<_>>()?,
            bikes: options.bikes.as_ref().map(at).transpose()?,
            out: at(&options.out)?,
            since: options.since.map(moment).transpose()?,
            pipeline,
            maps: Maps::parse(&map_texts).map_err(invalid)?,
            map_texts,
            options,
        })
    }

    /// As the batch takes them.
    pub fn settings(&self) -> BatchSettings<'_> {
        BatchSettings {
            inputs: &self.inputs,
            bikes: self.bikes.as_ref(),
            out: &self.out,
            pipeline: &self.pipeline,
            maps: &self.maps,
            jobs: self.options.jobs,
            force: self.options.force,
            since: self.since,
        }
    }

    /// What is done with each log on a cluster.
    pub fn what(&self) -> JobKind {
        let Options { signals, nulls, advise, diagnose, .. } = self.options;
        match diagnose {
            true => JobKind::Diagnose { nulls, advise },
            false => JobKind::Run { signals },
        }
    }

    /// What `run` does.
    pub fn run_work(&self) -> RunWork {
        RunWork { signals: self.options.signals }
    }
}

/// Computes the sessions of an archive; gives back what `run.json` says.
#[pyfunction]
pub fn run(py: Python<'_>, options: &str) -> PyResult<String> {
    let given = Given::read(options)?;
    let (start, started) = (Instant::now(), Timestamp::now());
    let work = Sandboxed::new(given.run_work(), &given.settings(), LimitOptions::default())
        .map_err(failed)?;
    let (accounts, store) = compute(py, &given, &work)?;
    py.detach(|| {
        if accounts.left == 0 && store.is_behind() {
            finish_run(&store, Pages::Auto, |_| Ok(())).map_err(failed)?;
        }
        let seconds = start.elapsed().as_secs_f64();
        let summary = Summary::of(&accounts, &given.pipeline, started, seconds);
        summary.write(store.root()).map_err(failed)?;
        whole(&accounts)?;
        json(&summary)
    })
}

/// An error where the tables are not whole.
pub fn whole(accounts: &Accounts) -> PyResult<()> {
    accounts.damage.clone().map_or(Ok(()), |message| Err(failed(BatchError::Output(message))))
}

/// Diagnoses the sessions of an archive; gives back the same of it as [`run`].
#[pyfunction]
pub fn diagnose(py: Python<'_>, options: &str) -> PyResult<String> {
    let given = Given::read(options)?;
    let (start, started) = (Instant::now(), Timestamp::now());
    let Options { nulls, advise, .. } = given.options;
    let settings = DiagnosisSettings { nulls, advise, ..Default::default() };
    let work =
        DiagnoseWork::new(settings).map_err(|e| PyValueError::new_err(format!("nulls: {e}")))?;
    let work = Sandboxed::new(work, &given.settings(), LimitOptions::default()).map_err(failed)?;
    let (accounts, store) = compute(py, &given, &work)?;
    py.detach(|| {
        if accounts.left == 0 && store.is_behind() {
            finish_diagnose(&store).map_err(failed)?;
        }
        whole(&accounts)?;
        let seconds = start.elapsed().as_secs_f64();
        json(&Summary::of(&accounts, &given.pipeline, started, seconds))
    })
}

/// The batch in a thread of its own, while this one asks Python for signals: after Ctrl-C the sessions
/// under way are finished.
fn compute<W: Work>(py: Python<'_>, given: &Given, work: &W) -> PyResult<(Accounts, Store)> {
    let stop = AtomicBool::new(false);
    let mut interrupt = None;
    let done = py.detach(|| {
        std::thread::scope(|scope| {
            let batch = scope.spawn(|| run_batch(&given.settings(), work, &(), &stop));
            while !batch.is_finished() {
                std::thread::sleep(LOOK);
                if let Err(e) = Python::attach(|py| py.check_signals()) {
                    stop.store(true, Ordering::Relaxed);
                    interrupt.get_or_insert(e);
                }
            }
            batch.join()
        })
    });
    let done = done.map_err(|_| PyRuntimeError::new_err("the batch ended with a panic"))?;
    match interrupt {
        Some(e) => Err(e),
        None => done.map_err(failed),
    }
}

fn moment(seconds: f64) -> PyResult<SystemTime> {
    let after = Duration::try_from_secs_f64(seconds)
        .map_err(|e| PyValueError::new_err(format!("since: {e}")))?;
    Ok(SystemTime::UNIX_EPOCH + after)
}

/// A value as JSON.
///
/// # Errors
/// `RuntimeError`: it cannot be written; our own mistake.
pub fn json<T: Serialize>(value: &T) -> PyResult<String> {
    serde_json::to_string(value).map_err(|e| PyRuntimeError::new_err(e.to_string()))
}

/// A value from JSON.
///
/// # Errors
/// `ValueError`: it is not what it should be.
pub fn read<T: DeserializeOwned>(text: &str) -> PyResult<T> {
    serde_json::from_str(text).map_err(|e| PyValueError::new_err(e.to_string()))
}
