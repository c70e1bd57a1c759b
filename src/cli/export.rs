//! `roadbench export`.

use crate::cli::Failure;

/// Write a fitted tyre for other simulators
#[derive(Debug, clap::Args)]
pub struct Arguments {}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub fn run(_arguments: Arguments) -> Result<(), Failure> {
    Err(Failure::Usage("not there yet".into()))
}
