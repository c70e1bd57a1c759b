//! The Python module `roadbench._roadbench`; what people import is the package in `python/roadbench`.
//!
//! Thin: arguments in, the library's own functions with the GIL released, Arrow out. Tables cross
//! by the Arrow PyCapsule interface, so nothing here knows of pyarrow, polars or DuckDB.

use std::path::Path;

use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::batch;
use crate::cli;
use crate::pipeline::{Pipeline, Rejection};

mod distributed;
mod session;
mod simulate;
mod table;

#[pymodule]
fn _roadbench(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", crate::VERSION)?;
    module.add_class::<table::Table>()?;
    module.add_class::<table::Schema>()?;
    module.add_class::<distributed::Driver>()?;
    module.add_class::<distributed::Worker>()?;
    module.add_function(wrap_pyfunction!(session::run_session, module)?)?;
    module.add_function(wrap_pyfunction!(simulate::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(table::schema_of, module)?)?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    Ok(())
}

/// The command line; gives back the exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<String>) -> u8 {
    py.detach(|| cli::main_with(arguments))
}

/// `roadbench.Rejected`: it is Python's own class, so that it can be pickled.
fn rejected(py: Python<'_>, why: &Rejection) -> PyErr {
    let error = py
        .import("roadbench._errors")
        .and_then(|module| module.getattr("Rejected"))
        .and_then(|class| class.call1((why.stage, why.code, why.message.as_str())));
    error.map_or_else(|e| e, PyErr::from_value)
}

impl From<batch::Error> for PyErr {
    fn from(e: batch::Error) -> Self {
        let message = e.to_string();
        match e {
            batch::Error::Usage(_) => PyValueError::new_err(message),
            batch::Error::Output(_) => PyOSError::new_err(message),
            batch::Error::Internal(_) => PyRuntimeError::new_err(message),
        }
    }
}

/// A pipeline by the name of a built-in one, or from a file.
fn pipeline(name: &Path) -> PyResult<Pipeline> {
    Pipeline::read(name).map_err(PyValueError::new_err)
}
