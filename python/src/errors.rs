//! The library's errors as Python's, and the arguments that several functions take.

use std::path::Path;

use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use roadbench::{BatchError, Pipeline, Rejection};

/// `roadbench.Rejected`: it is Python's own class, so that it can be pickled.
pub fn rejected(py: Python<'_>, why: &Rejection) -> PyErr {
    let error =
        py.import("roadbench._errors").and_then(|module| module.getattr("Rejected")).and_then(
            |class| class.call1((why.stage.as_str(), why.code.as_str(), why.message.as_str())),
        );
    error.map_or_else(|e| e, PyErr::from_value)
}

/// A batch's error.
pub fn failed(e: BatchError) -> PyErr {
    let message = e.to_string();
    match e {
        BatchError::Usage(_) => PyValueError::new_err(message),
        BatchError::Output(_) => PyOSError::new_err(message),
        BatchError::Internal(_) => PyRuntimeError::new_err(message),
    }
}

/// A wrong argument, or a wrong file.
pub fn invalid(e: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(e.to_string())
}

/// A pipeline by the name of a built-in one, or from a file.
pub fn pipeline(name: &Path) -> PyResult<Pipeline> {
    Pipeline::read(name).map_err(invalid)
}
