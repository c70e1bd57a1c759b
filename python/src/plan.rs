//! `roadbench.plan`.

use std::path::PathBuf;

use pyo3::prelude::*;

use crate::archive::json;
use crate::errors::{self, invalid};
use roadbench::plan_ride;

/// What the first session of a scenario would give of the side forces and show of each cause, as JSON.
#[pyfunction]
pub fn plan(py: Python<'_>, scenario: &str, pipeline: PathBuf) -> PyResult<String> {
    let pipeline = errors::pipeline(&pipeline)?;
    let plan = py.detach(|| plan_ride(scenario, &pipeline));
    json(&plan.map_err(invalid)?)
}
