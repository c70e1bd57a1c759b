//! Why a batch did not take place.

use crate::report;
use crate::store::tables::output::Refusal;
use crate::store::tables::{file, read};

/// Why a batch did not take place, or had to end early.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The command or its configuration is wrong; nothing was written.
    #[error("{0}")]
    Usage(String),
    /// The output cannot be written, or what it holds not be read.
    #[error("{0}")]
    Output(String),
    /// A bug in roadbench.
    #[error("{0}; this is a mistake in roadbench, please report it")]
    Internal(String),
}

impl From<file::Error> for Error {
    fn from(e: file::Error) -> Self {
        Error::Output(e.to_string())
    }
}

impl From<Refusal> for Error {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Wrong(message) => Error::Usage(message),
            Refusal::Cannot(message) => Error::Output(message),
        }
    }
}

impl From<read::Error> for Error {
    fn from(e: read::Error) -> Self {
        Error::Output(e.to_string())
    }
}

impl From<report::Error> for Error {
    fn from(e: report::Error) -> Self {
        Error::Output(e.to_string())
    }
}
