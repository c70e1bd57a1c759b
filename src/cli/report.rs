//! `roadbench report`.

use std::path::PathBuf;

use crate::cli::Failure;
use crate::cli::say::say;
use crate::report::{self, Error};

/// Rebuild the HTML report from the tables
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// The folder that `roadbench run --out` wrote.
    out: PathBuf,
}

/// Runs the command; prints where the report is.
///
/// # Errors
/// See [`Failure`].
pub fn run(arguments: Arguments) -> Result<(), Failure> {
    let out = arguments.out;
    if !out.is_dir() {
        return Err(Failure::Usage(format!("{} is not a folder", out.display())));
    }
    report::write(&out).map_err(|e| match e {
        Error::NotAnOutput { .. } | Error::Read { .. } => Failure::Usage(e.to_string()),
        Error::Write(_) | Error::Template(_) | Error::Data(_) => Failure::Output(e.to_string()),
    })?;
    say!("{}", out.join("report").join("index.html").display());
    Ok(())
}
