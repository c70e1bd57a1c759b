//! Why a log cannot be used.

use crate::contract::rejection::RejectionCode;
use crate::store::objects::Location;
use crate::store::objects::plain::plain;

/// Why a log cannot be used; `code` is the `rejected` table's.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{message}")]
pub struct Error {
    /// Code of the rejection.
    pub code: RejectionCode,
    /// Error, in which column and row, and what to do.
    pub message: String,
}

impl Error {
    pub(crate) fn new(code: RejectionCode, message: impl Into<String>) -> Self {
        Error { code, message: message.into() }
    }

    /// Of a log that could not be read to its end: whether it is bad depends on who says so, the system (or a store), or what
    /// unpacks its bytes.
    pub fn unreadable(log: &Location, error: &std::io::Error) -> Self {
        use std::io::ErrorKind::{AlreadyExists, FileTooLarge, InvalidData, UnexpectedEof};
        let code = match error.kind() {
            InvalidData | UnexpectedEof | FileTooLarge => RejectionCode::Damaged,
            // a store gives the bytes only that were listed
            AlreadyExists if log.is_remote() => RejectionCode::Changed,
            _ if log.is_remote() => RejectionCode::Unreachable,
            _ => RejectionCode::Unreadable,
        };
        Error::new(code, plain(&format!("cannot read {log}: {error}")))
    }
}
