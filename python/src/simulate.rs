//! `roadbench.simulate`.

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::invalid;
use crate::table::Table;
use roadbench::{Rideable, TableError, session_batch};

/// One session of a scenario: its tables, its bike file's text, and how it fell, if it did.
#[pyfunction]
#[pyo3(signature = (scenario, number))]
pub fn simulate<'py>(
    py: Python<'py>,
    scenario: &str,
    number: usize,
) -> PyResult<(Bound<'py, PyDict>, String, Option<String>)> {
    let ours = |e: TableError| PyRuntimeError::new_err(e.to_string());
    let (session, known, bike) = py.detach(|| {
        let rideable = Rideable::load(scenario).map_err(invalid)?;
        let count = rideable.sessions();
        if number >= count {
            return Err(PyValueError::new_err(format!(
                "scenario {scenario} has {count} sessions, numbered from 0"
            )));
        }
        let (known, bike) = rideable.ride(number).map_err(ours)?;
        let session = session_batch(&known.session, rideable.float32()).map_err(ours)?;
        Ok((session, known, bike))
    })?;
    let tables = PyDict::new(py);
    tables.set_item("session", Table::new("session", session))?;
    for (name, batch) in known.truth {
        tables.set_item(name, Table::new(name, batch))?;
    }
    Ok((tables, bike, known.fall))
}
