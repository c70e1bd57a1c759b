//! What a stage noticed and the reader of the tables has to know.

use super::channel::Channel;

/// Code of the warning of a manoeuvre that is not as the others of its ride.
pub(crate) const OUTLYING_MANOEUVRE: &str = "outlying_manoeuvre";

/// Something odd that did not stop the session: a row of the `warnings` table.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// The stage that noticed: `ingest`, `filter`, `segment`, `estimate`, `fit`.
    pub stage: &'static str,
    /// Short stable name, snake case, e.g. `gap`, `clipped`, `time_backwards`.
    pub code: &'static str,
    /// The channel concerned, if it is one.
    pub channel: Option<Channel>,
    /// Number of samples or occurrences.
    pub count: usize,
    /// When it first happened, s since the start.
    pub time: Option<f64>,
    /// Text for people: the problem, its place and what was done about it.
    pub message: String,
}
