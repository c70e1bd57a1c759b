//! `roadbench.compare`.

use std::path::PathBuf;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::errors::failed;
use crate::table::Table;
use roadbench::compare_sets;

/// Two sets of sessions of an output against each other, or, without `b`, an output against another one.
#[pyfunction]
#[pyo3(signature = (out, a, b=None, same_tyres=false))]
pub fn compare(
    py: Python<'_>,
    out: PathBuf,
    a: &str,
    b: Option<&str>,
    same_tyres: bool,
) -> PyResult<Table> {
    let found = py.detach(|| compare_sets(&out, a, b, same_tyres)).map_err(failed)?;
    let rows = found.table().map_err(|e| PyRuntimeError::new_err(e.to_string()))?;
    Ok(Table::new("comparison", rows))
}
