//! `roadbench.run_session`.

use std::path::{Path, PathBuf};

use arrow::array::RecordBatch;
use arrow::error::ArrowError;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pyo3_arrow::PyRecordBatchReader;

use super::table::Table;
use super::{pipeline, rejected};
use crate::batch::Maps;
use crate::batch::bikes::{BikeFile, hash_settings};
use crate::batch::in_memory::{self, Log, NO_PATH};
use crate::batch::work::guarded;
use crate::contract::session::Meta;
use crate::ingest;
use crate::pipeline::Rejection;

/// See `python/roadbench/__init__.pyi`.
#[pyfunction]
#[pyo3(signature = (path_or_table, bike, pipeline, maps, signals, session_id))]
pub fn run_session<'py>(
    py: Python<'py>,
    path_or_table: &Bound<'py, PyAny>,
    bike: &Bound<'py, PyAny>,
    pipeline: PathBuf,
    maps: Vec<PathBuf>,
    signals: bool,
    session_id: Option<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let pipeline = self::pipeline(&pipeline)?;
    let maps = Maps::read(&maps).map_err(PyValueError::new_err)?;
    let bike = bike_file(bike, &hash_settings(&pipeline, &maps, "")?)?;
    let source = Source::of(path_or_table)?;
    let tables = py.detach(|| {
        let log = match &source {
            Source::File(path) => Log::File(path),
            Source::Table(schema, batches) => {
                let session_id = session_id.unwrap_or_default();
                let known = Meta { session_id, ..Meta::default() };
                let read = || {
                    ingest::read_table(NO_PATH, schema, batches, known).map_err(|e| Rejection {
                        stage: "ingest",
                        code: e.code,
                        message: e.message,
                    })
                };
                Log::Table(Box::new(guarded("ingest", read)?))
            }
        };
        in_memory::run(log, &bike, &pipeline, &maps, signals)
    });
    let out = PyDict::new(py);
    for (name, batch) in tables.map_err(|why| rejected(py, &why))? {
        out.set_item(name, Table::new(name, batch))?;
    }
    Ok(out)
}

/// What was given as the log.
enum Source {
    File(PathBuf),
    Table(arrow::datatypes::SchemaRef, Vec<RecordBatch>),
}

impl Source {
    fn of(given: &Bound<'_, PyAny>) -> PyResult<Self> {
        if given.hasattr("__arrow_c_stream__")? {
            let reader = given.extract::<PyRecordBatchReader>()?.into_reader()?;
            let schema = reader.schema();
            let batches = reader
                .collect::<Result<_, ArrowError>>()
                .map_err(|e| PyValueError::new_err(format!("the table cannot be read: {e}")))?;
            return Ok(Source::Table(schema, batches));
        }
        given.extract().map(Source::File).map_err(|_| {
            PyTypeError::new_err("the log must be a path or have __arrow_c_stream__, as tables do")
        })
    }
}

/// A path to a bike file, or its text: a text has an equals sign and a line's end, a path has not.
fn bike_file(given: &Bound<'_, PyAny>, settings: &[u8]) -> PyResult<BikeFile> {
    let invalid = |e: crate::contract::bike::Error| PyValueError::new_err(e.to_string());
    if let Ok(text) = given.extract::<String>()
        && text.contains('=')
        && text.contains('\n')
    {
        return BikeFile::parse(text, "bike", Path::new("(text)"), settings).map_err(invalid);
    }
    let path: PathBuf = given.extract().map_err(|_| {
        PyTypeError::new_err("the bike must be the path of a bike file, or what such a file says")
    })?;
    let text = std::fs::read_to_string(&path).map_err(|source| {
        invalid(crate::contract::bike::Error::Read { path: path.clone(), source })
    })?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    BikeFile::parse(text, &stem, &path, settings).map_err(invalid)
}
