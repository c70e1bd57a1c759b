//! Warnings of this stage.

use crate::contract::channel::Channel;
use crate::contract::warning::Warning;

/// A warning of the stage `ingest`; `time` is in s since the start.
pub(super) fn warning(
    code: &'static str,
    channel: Option<Channel>,
    count: usize,
    time: Option<f64>,
    message: String,
) -> Warning {
    Warning { stage: "ingest", code, channel, count, time, message }
}
