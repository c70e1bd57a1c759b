//! What the system, or a store, did not give of a log that is open.
//!
//! Readers of logs are many, and libraries among them: some take an error for the end of the log, some for damage. Here it is
//! noted where it happens, so that nobody has to believe them.

use std::collections::HashMap;
use std::io::{Error, ErrorKind};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use super::location::Location;

/// The first of each log, until it is taken.
fn noted() -> MutexGuard<'static, HashMap<Location, Error>> {
    static NOTED: OnceLock<Mutex<HashMap<Location, Error>>> = OnceLock::new();
    NOTED.get_or_init(Mutex::default).lock().unwrap_or_else(PoisonError::into_inner)
}

/// Notes an error of a read; that the log ends before what was asked for is none.
pub(crate) fn note(log: &Location, error: &Error) {
    if matches!(error.kind(), ErrorKind::UnexpectedEof | ErrorKind::Interrupted) {
        return;
    }
    let copy = match error.raw_os_error() {
        Some(code) => Error::from_raw_os_error(code),
        None => Error::new(error.kind(), error.to_string()),
    };
    noted().entry(log.clone()).or_insert(copy);
}

/// Faults noted of a log since it was asked for last.
pub(crate) fn take(log: &Location) -> Option<Error> {
    noted().remove(log)
}
