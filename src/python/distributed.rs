//! The two ends of a batch on a cluster, for `roadbench.spark`; tasks and answers cross as JSON.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use jiff::Timestamp;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::pipeline;
use crate::batch::distributed::{self, Answer, Terms};
use crate::batch::summary::Summary;
use crate::batch::{Error, Maps, Settings, Stages};
use crate::pipeline::Pipeline;
use crate::report;

/// Plans a batch, holds its output, and keeps the accounts.
#[pyclass(frozen, module = "roadbench._roadbench")]
pub struct Driver {
    driver: Mutex<Option<distributed::Driver>>,
    pipeline: Pipeline,
    began: (Instant, Timestamp),
}

#[pymethods]
impl Driver {
    #[new]
    #[pyo3(signature = (inputs, bikes, out, pipeline, maps, force, since, signals))]
    #[expect(clippy::too_many_arguments, reason = "they are the command's options")]
    fn new(
        py: Python<'_>,
        inputs: Vec<PathBuf>,
        bikes: Option<PathBuf>,
        out: PathBuf,
        pipeline: PathBuf,
        maps: Vec<PathBuf>,
        force: bool,
        since: Option<f64>,
        signals: bool,
    ) -> PyResult<Self> {
        let began = (Instant::now(), Timestamp::now());
        let pipeline = self::pipeline(&pipeline)?;
        let texts = Maps::texts(&maps).map_err(PyValueError::new_err)?;
        let maps = Maps::parse(&texts).map_err(PyValueError::new_err)?;
        let settings = Settings {
            inputs: &inputs,
            bikes: bikes.as_deref(),
            out: &out,
            pipeline: &pipeline,
            maps: &maps,
            jobs: 0,
            force,
            since: since.map(moment).transpose()?,
            signals,
        };
        let driver = py.detach(|| distributed::Driver::open(&settings, texts, &Stages))?;
        Ok(Driver { driver: Mutex::new(Some(driver)), pipeline, began })
    }

    /// What every worker has to know.
    fn terms(&self) -> PyResult<String> {
        self.with(|driver| json(driver.terms()))
    }

    /// Log and task, the largest log first.
    fn tasks(&self) -> PyResult<Vec<(String, String)>> {
        self.with(|driver| {
            driver.tasks().into_iter().map(|task| Ok((task.log.clone(), json(&task)?))).collect()
        })
    }

    /// Checks the answers, writes the report and `run.json`, lets go of the output; gives back
    /// what `run.json` says.
    fn close(&self, py: Python<'_>, answers: Vec<String>) -> PyResult<String> {
        let answers: Vec<Answer> = answers.iter().map(|a| read(a)).collect::<PyResult<_>>()?;
        let driver = self.lock().take().ok_or_else(closed)?;
        py.detach(|| {
            let (run, store) = driver.close(answers)?;
            let out = store.root();
            #[cfg(feature = "fleet")]
            crate::batch::fleet::write(out)?;
            report::write(out).map_err(|e| Error::Output(e.to_string()))?;
            let (start, started) = self.began;
            let seconds = start.elapsed().as_secs_f64();
            let summary = Summary::of(&run, &self.pipeline, started, seconds);
            summary.write(out)?;
            json(&summary)
        })
    }

    /// Lets go of the output, whatever became of the run.
    fn abandon(&self) {
        *self.lock() = None;
    }
}

impl Driver {
    fn lock(&self) -> std::sync::MutexGuard<'_, Option<distributed::Driver>> {
        self.driver.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn with<T>(&self, what: impl FnOnce(&distributed::Driver) -> PyResult<T>) -> PyResult<T> {
        what(self.lock().as_ref().ok_or_else(closed)?)
    }
}

/// Computes and writes sessions.
#[pyclass(frozen, module = "roadbench._roadbench")]
pub struct Worker(distributed::Worker);

#[pymethods]
impl Worker {
    #[new]
    fn new(terms: &str) -> PyResult<Self> {
        let terms: Terms = read(terms)?;
        Ok(Worker(distributed::Worker::new(terms)?))
    }

    /// A task's answer.
    fn run(&self, py: Python<'_>, task: &str) -> PyResult<String> {
        let task = read(task)?;
        py.detach(|| json(&self.0.run(task, &Stages)?))
    }
}

fn closed() -> PyErr {
    PyRuntimeError::new_err("this run is closed")
}

fn moment(seconds: f64) -> PyResult<SystemTime> {
    let after = Duration::try_from_secs_f64(seconds)
        .map_err(|e| PyValueError::new_err(format!("since: {e}")))?;
    Ok(SystemTime::UNIX_EPOCH + after)
}

fn json<T: Serialize>(value: &T) -> PyResult<String> {
    serde_json::to_string(value).map_err(|e| PyRuntimeError::new_err(e.to_string()))
}

fn read<T: DeserializeOwned>(text: &str) -> PyResult<T> {
    serde_json::from_str(text).map_err(|e| {
        PyValueError::new_err(format!("not what another roadbench of this version sends: {e}"))
    })
}
