//! Whose fault it is that a log was not used.
//!
//! The log's own: its bytes are bad, or end the worker that reads them. Then it has no session any more, and the rows that it
//! had from an earlier batch go. Not the log's: the next batch may well read it. Then its rows stay as they are, and it is
//! tried again every time.

use crate::ingest::{CHANGED, UNREACHABLE, UNREADABLE};

/// There is no such file: what it was stays in the archive until it is forgotten.
pub(crate) const NOT_FOUND: &str = "not_found";
/// There is a folder, and no log in it.
pub(crate) const NO_LOGS: &str = "no_logs";
/// Another log of the batch has its session.
pub(crate) const DUPLICATE_ID: &str = "duplicate_session_id";
/// Its worker was killed by somebody else.
pub(crate) const KILLED: &str = "killed";
/// There was no worker for it.
pub(crate) const NO_WORKER: &str = "no_worker";
/// Its worker had less memory than it may have.
pub(crate) const NO_MEMORY: &str = "no_memory";

/// Its worker crashed over it.
pub(crate) const CRASHED: &str = "crashed";
/// It takes more memory than it may.
pub(crate) const TOO_LARGE: &str = "too_large";
/// It takes more time than it may.
pub(crate) const TOO_SLOW: &str = "too_slow";

/// Codes of rejections that are not the log's fault.
const NOT_ITS_OWN: [&str; 9] = [
    UNREACHABLE,
    UNREADABLE,
    CHANGED,
    NOT_FOUND,
    NO_LOGS,
    DUPLICATE_ID,
    KILLED,
    NO_WORKER,
    NO_MEMORY,
];

/// Codes of logs that ended a worker, and would again.
pub(crate) const ENDS_A_WORKER: [&str; 3] = [CRASHED, TOO_LARGE, TOO_SLOW];

/// Whether a log that was rejected so has no session any more.
pub(crate) fn is_the_logs(code: &str) -> bool {
    !NOT_ITS_OWN.contains(&code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_ends_a_worker_is_the_logs_and_what_ends_it_from_outside_is_not() {
        assert!(ENDS_A_WORKER.into_iter().all(is_the_logs));
        assert!(["damaged", "too_short", "internal_error"].into_iter().all(is_the_logs));
        assert!([KILLED, NO_WORKER, UNREADABLE, CHANGED].into_iter().all(|c| !is_the_logs(c)));
    }
}
