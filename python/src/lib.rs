//! The Python module `roadbench._roadbench`; what people import is the package `roadbench` beside this folder.
//!
//! Thin: arguments in, the library's own functions with the GIL released, Arrow out. Tables cross
//! by the Arrow PyCapsule interface, so nothing here knows of pyarrow, polars or DuckDB.

use pyo3::prelude::*;

mod archive;
mod compare;
mod distributed;
mod errors;
mod export;
mod plan;
mod session;
mod simulate;
mod table;

#[pymodule]
fn _roadbench(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", roadbench::VERSION)?;
    if let Some(python) = executable(module.py())? {
        roadbench::started_by(vec![
            python.into(),
            "-m".into(),
            "roadbench".into(),
            roadbench::WORKER.into(),
        ]);
    }
    module.add_class::<table::Table>()?;
    module.add_class::<table::Schema>()?;
    module.add_class::<distributed::Driver>()?;
    module.add_class::<distributed::Worker>()?;
    module.add_function(wrap_pyfunction!(session::run_session, module)?)?;
    module.add_function(wrap_pyfunction!(session::diagnose_session, module)?)?;
    module.add_function(wrap_pyfunction!(archive::run, module)?)?;
    module.add_function(wrap_pyfunction!(archive::diagnose, module)?)?;
    module.add_function(wrap_pyfunction!(plan::plan, module)?)?;
    module.add_function(wrap_pyfunction!(compare::compare, module)?)?;
    module.add_function(wrap_pyfunction!(export::export, module)?)?;
    module.add_function(wrap_pyfunction!(simulate::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(table::schema_of, module)?)?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    Ok(())
}

/// The interpreter that this module is loaded into; none where it is embedded in another program.
fn executable(py: Python<'_>) -> PyResult<Option<String>> {
    let executable = py.import("sys")?.getattr("executable")?;
    Ok(executable.extract::<Option<String>>()?.filter(|path| !path.is_empty()))
}

/// The command line; gives back the exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<String>) -> u8 {
    py.detach(|| roadbench::command_with(arguments))
}
