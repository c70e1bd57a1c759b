//! `roadbench.export`.

use std::path::PathBuf;

use clap::ValueEnum;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyString};
use serde::Deserialize;

use crate::archive::read;
use roadbench::{
    ExportRequest, FormatChoice, Location, Reading, SetChoice, TyreChoice, Written, export_tyre,
    read_models,
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
            Some(read_models(&at).map_err(PyValueError::new_err)?)
        }
    };
    let request = ExportRequest {
        out: &options.out,
        session: &options.session,
        bike: options.bike.as_deref(),
        format: word::<FormatChoice>("format", &options.format)?.into(),
        tyre: options
            .tyre
            .as_deref()
            .map(|tyre| word::<TyreChoice>("tyre", tyre).map(Into::into))
            .transpose()?,
        bikes: options.bikes.as_deref(),
        set: word::<SetChoice>("set", &options.set)?.into(),
        friction: options.friction,
        load: options.load,
        models: models.as_ref(),
    };
    let written = py.detach(|| {
        let _reading = Reading::of(request.out).map_err(|e| e.to_string())?;
        export_tyre(&request)
    });
    Ok(match written.map_err(PyValueError::new_err)? {
        Written::Text(text) => PyString::new(py, &text).into_any(),
        Written::Binary(bytes) => PyBytes::new(py, &bytes).into_any(),
    })
}

/// One of an option's words.
fn word<T: ValueEnum>(option: &str, word: &str) -> PyResult<T> {
    T::from_str(word, false).map_err(|_| {
        let known = T::value_variants().iter().filter_map(ValueEnum::to_possible_value);
        let known: Vec<String> = known.map(|v| v.get_name().to_owned()).collect();
        PyValueError::new_err(format!("{option}: `{word}` is none of {}", known.join(", ")))
    })
}
