//! `roadbench.export`.

use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyString};
use serde::Deserialize;

use crate::archive::read;
use crate::errors::{failed, invalid};
use roadbench::{
    CoefficientSet, ExportFormat, ExportRequest, ExportTyre, Location, Reading, Written,
    export_tyre, read_models,
};

/// What is asked for, as JSON.
#[derive(Debug, Deserialize)]
struct Options {
    out: PathBuf,
    session: String,
    bike: Option<String>,
    format: String,
    tyre: Option<String>,
    bikes: Option<PathBuf>,
    set: String,
    friction: f64,
    load: Option<f64>,
    model: Option<String>,
}

/// A session's tyres as a file: its text, or its bytes where it is none.
#[pyfunction]
pub fn export<'py>(py: Python<'py>, options: &str) -> PyResult<Bound<'py, PyAny>> {
    let options: Options = read(options)?;
    let models = match &options.model {
        None => None,
        Some(at) => {
            let at = Location::parse(at).map_err(|e| PyValueError::new_err(e.to_string()))?;
            Some(read_models(&at).map_err(invalid)?)
        }
    };
    // as on the command line
    let set = if options.set == "motorcycle" { "5.2" } else { &options.set };
    let request = ExportRequest {
        out: &options.out,
        session: &options.session,
        bike: options.bike.as_deref(),
        format: word("format", ExportFormat::NAMES, &options.format)?,
        tyre: match &options.tyre {
            Some(tyre) => Some(word("tyre", ExportTyre::NAMES, tyre)?),
            None => None,
        },
        bikes: options.bikes.as_deref(),
        set: word("set", CoefficientSet::NAMES, set)?,
        friction: options.friction,
        load: options.load,
        models: models.as_ref(),
    };
    let written = py.detach(|| {
        let tables = ExportRequest::TABLES;
        let _reading = Reading::of_session(request.out, tables, request.session).map_err(failed)?;
        export_tyre(&request).map_err(invalid)
    });
    Ok(match written? {
        Written::Text(text) => PyString::new(py, &text).into_any(),
        Written::Binary(bytes) => PyBytes::new(py, &bytes).into_any(),
    })
}

/// One of an option's words.
fn word<T: Copy>(option: &str, names: &[(&str, T)], word: &str) -> PyResult<T> {
    let found = names.iter().find(|(name, _)| *name == word).map(|(_, value)| *value);
    found.ok_or_else(|| {
        let known: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
        invalid(format!("{option}: `{word}` is none of {}", known.join(", ")))
    })
}
