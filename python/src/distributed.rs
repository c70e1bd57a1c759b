//! The two ends of a batch on a cluster, for `roadbench.spark`; tasks and answers cross as JSON.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use jiff::Timestamp;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::archive::{Given, json, read, whole};
use crate::errors::failed;
use roadbench::{Answer, JobKind, Pages, Pipeline, Summary, Terms, finish_diagnose, finish_run};

/// Plans a batch, holds its output, and keeps the accounts.
#[pyclass(frozen, module = "roadbench._roadbench")]
pub struct Driver {
    driver: Mutex<Option<roadbench::Driver>>,
    pipeline: Pipeline,
    began: (Instant, Timestamp),
}

#[pymethods]
impl Driver {
    #[new]
    fn new(py: Python<'_>, options: &str) -> PyResult<Self> {
        let began = (Instant::now(), Timestamp::now());
        let given = Given::read(options)?;
        let (settings, what) = (given.settings(), given.what());
        let texts = given.map_texts.clone();
        let driver =
            py.detach(|| roadbench::Driver::open(&settings, texts, what)).map_err(failed)?;
        Ok(Driver { driver: Mutex::new(Some(driver)), pipeline: given.pipeline, began })
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
            let what = driver.what().clone();
            let (accounts, store) = driver.close(answers).map_err(failed)?;
            if store.is_behind() {
                match what {
                    JobKind::Run { .. } => finish_run(&store, Pages::Auto, |_| Ok(())).map(drop),
                    JobKind::Diagnose { .. } => finish_diagnose(&store).map(drop),
                }
                .map_err(failed)?;
            }
            let (start, started) = self.began;
            let seconds = start.elapsed().as_secs_f64();
            let summary = Summary::of(&accounts, &self.pipeline, started, seconds);
            if let JobKind::Run { .. } = what {
                summary.write(store.root()).map_err(failed)?;
            }
            whole(&accounts)?;
            json(&summary)
        })
    }

    /// Lets go of the output, whatever became of the run.
    fn abandon(&self) {
        *self.lock() = None;
    }
}

impl Driver {
    fn lock(&self) -> std::sync::MutexGuard<'_, Option<roadbench::Driver>> {
        self.driver.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn with<T>(&self, what: impl FnOnce(&roadbench::Driver) -> PyResult<T>) -> PyResult<T> {
        what(self.lock().as_ref().ok_or_else(closed)?)
    }
}

/// Computes and writes sessions.
#[pyclass(frozen, module = "roadbench._roadbench")]
pub struct Worker(roadbench::Worker);

#[pymethods]
impl Worker {
    #[new]
    fn new(terms: &str) -> PyResult<Self> {
        let terms: Terms = read(terms)?;
        Ok(Worker(roadbench::Worker::new(terms).map_err(failed)?))
    }

    /// A task's answer.
    fn run(&self, py: Python<'_>, task: &str) -> PyResult<String> {
        let task = read(task)?;
        py.detach(|| json(&self.0.run(task).map_err(failed)?))
    }
}

fn closed() -> PyErr {
    PyRuntimeError::new_err("this run is closed")
}
