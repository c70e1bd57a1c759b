//! `roadbench convert`.

use crate::cli::Failure;

/// Turn any supported log into a session.v1 Parquet file
#[derive(Debug, clap::Args)]
pub struct Arguments {}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub fn run(_arguments: Arguments) -> Result<(), Failure> {
    Err(Failure::Usage("not there yet".into()))
}
