//! Why a log cannot be used.

use crate::objects::Location;

/// Why a log cannot be used; `code` is the `rejected` table's.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{message}")]
pub struct Error {
    /// Short stable name, snake case.
    pub code: &'static str,
    /// What was wrong, in which column and row, and what to do.
    pub message: String,
}

/// Code of what could not be fetched from an object store: it may be in order.
pub const UNREACHABLE: &str = "unreachable";

impl Error {
    pub(super) fn new(code: &'static str, message: impl Into<String>) -> Self {
        Error { code, message: message.into() }
    }

    pub(super) fn unreadable(log: &Location, error: &std::io::Error) -> Self {
        // no answer from a store does not mean that the log is bad
        let code = if log.is_remote() { UNREACHABLE } else { "unreadable" };
        Error::new(code, format!("cannot read {log}: {error}"))
    }
}
