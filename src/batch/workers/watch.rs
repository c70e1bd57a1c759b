//! Observers of a batch's progress.

use serde::{Deserialize, Serialize};

use crate::store::tables::rows::Rejected;

/// Outcome of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    Done,
    /// Was there already, made from the same.
    Unchanged,
    /// Not usable; has a row in `rejected`.
    Rejected,
}

/// One input that is through, for progress and logs.
#[derive(Debug)]
pub struct Finished<'a> {
    /// Path or URL of the log, as in the tables.
    pub log: &'a str,
    /// The session, if known.
    pub session_id: Option<&'a str>,
    pub state: State,
    /// Why, if it was rejected: code and message.
    pub why: Option<(&'a str, &'a str)>,
    /// Time it took, s.
    pub seconds: f64,
    /// Samples on the common clock.
    pub samples: i64,
    /// Size of the log, bytes.
    pub bytes: u64,
}

impl<'a> Finished<'a> {
    /// An input that was rejected.
    pub fn rejected(row: &'a Rejected) -> Self {
        Finished {
            log: &row.path,
            session_id: row.session_id.as_deref(),
            state: State::Rejected,
            why: Some((&row.code, &row.message)),
            seconds: 0.0,
            samples: 0,
            bytes: 0,
        }
    }
}

/// Follows a batch whose sessions give an `R` each beside their files.
pub trait Watch<R>: Sync {
    /// The inputs, in order of path, and the size of all of them in bytes are known.
    fn planned(&self, _logs: &[String], _bytes: u64) {}

    /// One more is through; called from the workers. There is a result where it was computed.
    fn finished(&self, _finished: &Finished<'_>, _result: Option<R>) {}
}

impl<R> Watch<R> for () {}
