//! `roadbench.run_session` and `roadbench.diagnose_session`.

use std::path::{Path, PathBuf};

use arrow::array::RecordBatch;
use arrow::error::ArrowError;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pyo3_arrow::PyRecordBatchReader;

use crate::errors::{self, failed, invalid, rejected};
use crate::table::Table;
use roadbench::{
    BikeError, BikeFile, DiagnoseWork, DiagnosisSettings, Location, Log, Maps, Meta, NO_PATH,
    Rejection, Stage, Tables, Work, guarded, hash_settings, read_table, read_text,
};

/// A session's tables by name, as `roadbench run` would write them.
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
    let pipeline = errors::pipeline(&pipeline)?;
    let maps = Maps::read(&maps).map_err(invalid)?;
    let bike = bike_file(bike, &hash_settings(&pipeline, "").map_err(failed)?)?;
    let source = Source::of(path_or_table)?;
    let found = py.detach(|| {
        roadbench::run_session(source.log(session_id)?, &bike, &pipeline, &maps, signals)
    });
    dict(py, found.map_err(|why| rejected(py, &why))?)
}

/// What `roadbench diagnose` finds in a session: its tables by name, its verdict in words, and the
/// extended model as TOML; none off-road. `settings` are the number of nulls and whether to advise.
#[pyfunction]
#[pyo3(signature = (path_or_table, bike, pipeline, maps, settings, session_id))]
pub fn diagnose_session<'py>(
    py: Python<'py>,
    path_or_table: &Bound<'py, PyAny>,
    bike: &Bound<'py, PyAny>,
    pipeline: PathBuf,
    maps: Vec<PathBuf>,
    settings: (usize, bool),
    session_id: Option<String>,
) -> PyResult<(Bound<'py, PyDict>, String, Option<String>)> {
    let pipeline = errors::pipeline(&pipeline)?;
    let maps = Maps::read(&maps).map_err(invalid)?;
    let (nulls, advise) = settings;
    let work = DiagnoseWork::new(DiagnosisSettings { nulls, advise, ..Default::default() })
        .map_err(|e| PyValueError::new_err(format!("nulls: {e}")))?;
    let bike = bike_file(bike, &hash_settings(&pipeline, &work.settings()).map_err(failed)?)?;
    let source = Source::of(path_or_table)?;
    let found = py.detach(|| {
        roadbench::diagnose_session(source.log(session_id)?, &bike, &pipeline, &maps, &work)
    });
    let (d, tables) = found.map_err(|why| rejected(py, &why))?;
    Ok((dict(py, tables)?, d.summary, d.model.map(|model| model.to_toml())))
}

fn dict(py: Python<'_>, tables: Tables) -> PyResult<Bound<'_, PyDict>> {
    let out = PyDict::new(py);
    for (name, batch) in tables {
        out.set_item(name, Table::new(name, batch))?;
    }
    Ok(out)
}

/// What was given as the log.
enum Source {
    File(Location),
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
        let path: PathBuf = given.extract().map_err(|_| {
            PyTypeError::new_err("the log must be a path or have __arrow_c_stream__, as tables do")
        })?;
        let at = Location::parse(path).map_err(|e| PyValueError::new_err(e.to_string()))?;
        Ok(Source::File(at))
    }

    /// As the library takes it; `session_id` names a table that does not name itself.
    fn log(&self, session_id: Option<String>) -> Result<Log<'_>, Rejection> {
        let (schema, batches) = match self {
            Source::File(at) => return Ok(Log::File(at)),
            Source::Table(schema, batches) => (schema, batches),
        };
        let known = Meta { session_id: session_id.unwrap_or_default(), ..Meta::default() };
        let read = || read_table(NO_PATH, schema, batches, known).map_err(Rejection::from);
        Ok(Log::Table(Box::new(guarded(Stage::Ingest, read)?)))
    }
}

/// A path to a bike file, or its text: a text has an equals sign and a line's end, a path has not.
fn bike_file(given: &Bound<'_, PyAny>, settings: &[u8]) -> PyResult<BikeFile> {
    if let Ok(text) = given.extract::<String>()
        && text.contains('=')
        && text.contains('\n')
    {
        return BikeFile::parse(text, "bike", Path::new("(text)"), settings).map_err(invalid);
    }
    let path: PathBuf = given.extract().map_err(|_| {
        PyTypeError::new_err("the bike must be the path of a bike file, or what such a file says")
    })?;
    let text = read_text(&path)
        .map_err(|source| invalid(BikeError::Read { path: path.clone(), source }))?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    BikeFile::parse(text, &stem, &path, settings).map_err(invalid)
}
