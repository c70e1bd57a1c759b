//! `roadbench.plan`.

use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::archive::json;
use crate::errors;
use roadbench::diagnose::road::ride_plan;

/// What the first session of a scenario would show of each cause, as JSON.
#[pyfunction]
pub fn plan(py: Python<'_>, scenario: &str, pipeline: PathBuf) -> PyResult<String> {
    let pipeline = errors::pipeline(&pipeline)?;
    let scenario = ride_plan::scenario(scenario).map_err(PyValueError::new_err)?;
    let plan = py.detach(|| ride_plan::plan(scenario, &pipeline));
    json(&plan.map_err(PyValueError::new_err)?)
}
