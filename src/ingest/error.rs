//! Why a log cannot be used.

use crate::store::objects::Location;
use crate::store::objects::plain::plain;

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
pub(crate) const UNREACHABLE: &str = "unreachable";
/// Code of what this machine could not read (no permission, a failing disk): it may be in order.
pub(crate) const UNREADABLE: &str = "unreadable";
/// Code of a log that was written anew while it was read.
pub(crate) const CHANGED: &str = "changed";
/// Code of a log whose bytes make no sense.
pub(crate) const DAMAGED: &str = "damaged";

impl Error {
    pub(crate) fn new(code: &'static str, message: impl Into<String>) -> Self {
        Error { code, message: message.into() }
    }

    /// Of a log that could not be read to its end: whether it is bad depends on who says so, the system (or a store), or what
    /// unpacks its bytes.
    pub fn unreadable(log: &Location, error: &std::io::Error) -> Self {
        use std::io::ErrorKind::{AlreadyExists, FileTooLarge, InvalidData, UnexpectedEof};
        let code = match error.kind() {
            InvalidData | UnexpectedEof | FileTooLarge => DAMAGED,
            // a store gives the bytes only that were listed
            AlreadyExists if log.is_remote() => CHANGED,
            _ if log.is_remote() => UNREACHABLE,
            _ => UNREADABLE,
        };
        Error::new(code, plain(&format!("cannot read {log}: {error}")))
    }
}
