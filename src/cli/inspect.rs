//! `roadbench inspect`.

use crate::cli::Failure;

/// Show a log's channels, rates, gaps, and what can be estimated from it
#[derive(Debug, clap::Args)]
pub struct Arguments {}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub fn run(_arguments: Arguments) -> Result<(), Failure> {
    Err(Failure::Usage("not there yet".into()))
}
