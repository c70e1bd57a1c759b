//! `roadbench run`.

use crate::cli::Failure;

/// Turn riding logs into tyre coefficients
#[derive(Debug, clap::Args)]
pub struct Arguments {}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub fn run(_arguments: Arguments) -> Result<(), Failure> {
    Err(Failure::Usage("not there yet".into()))
}
