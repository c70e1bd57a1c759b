//! `roadbench report`.

use crate::cli::Failure;

/// Rebuild the HTML report from the tables
#[derive(Debug, clap::Args)]
pub struct Arguments {}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub fn run(_arguments: Arguments) -> Result<(), Failure> {
    Err(Failure::Usage("not there yet".into()))
}
