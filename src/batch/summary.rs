//! What a run did, for machines: `run.json` beside the tables, and a text file for Prometheus.
//!
//! Written, never read again: whether a session is there is known from its own tables.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use jiff::Timestamp;
use serde::Serialize;

use super::error::Error;
use crate::batch::workers::scheduler::Accounts;
use crate::pipeline::Pipeline;
use crate::store::objects::Location;
use crate::store::objects::counts;
use crate::store::objects::counts::Counts;
use crate::store::tables::{file, output};

/// Counts of a run.
#[derive(Debug, Serialize)]
pub struct Summary<'a> {
    /// Version of roadbench.
    pub version: &'static str,
    /// Start of the run.
    pub started: Timestamp,
    /// How long it took, s.
    pub seconds: f64,
    /// Number of logs.
    pub inputs: usize,
    /// Sessions computed.
    pub computed: usize,
    /// Sessions that were there already.
    pub unchanged: usize,
    /// Logs that could not be used.
    pub rejected: usize,
    /// Logs that were not begun because the run was stopped.
    pub left: usize,
    /// Size of the logs, bytes.
    pub bytes: u64,
    /// Requests to object stores, where there were any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub requests: Option<Counts>,
    /// Rejections by their code.
    pub rejected_by_code: BTreeMap<&'a str, usize>,
    /// BLAKE3 of the pipeline as text.
    pub pipeline_hash: String,
    /// The pipeline, every key resolved.
    pub pipeline: &'a Pipeline,
}

impl<'a> Summary<'a> {
    /// Summary of a run from its accounts and settings.
    pub fn of(
        accounts: &'a Accounts,
        pipeline: &'a Pipeline,
        started: Timestamp,
        seconds: f64,
    ) -> Self {
        let mut rejected_by_code = BTreeMap::new();
        for row in &accounts.rejected {
            *rejected_by_code.entry(row.code.as_str()).or_default() += 1;
        }
        let text = toml::to_string(pipeline).unwrap_or_default();
        Summary {
            version: crate::VERSION,
            started,
            seconds,
            inputs: accounts.inputs,
            computed: accounts.done,
            unchanged: accounts.unchanged,
            rejected: accounts.rejected.len(),
            left: accounts.left,
            bytes: accounts.bytes,
            requests: Some(counts::so_far()).filter(|c| c.requests() > 0),
            rejected_by_code,
            pipeline_hash: blake3::hash(text.as_bytes()).to_hex().to_string(),
            pipeline,
        }
    }

    /// Writes `<out>/run.json`.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, out: &Location) -> Result<(), Error> {
        let text = serde_json::to_string_pretty(self)
            .map_err(|e| Error::Internal(format!("run.json: {e}")))?;
        Ok(file::write_bytes(out.join("run.json"), (text + "\n").as_bytes())?)
    }

    /// Writes a file in Prometheus' text format, for the text-file collector.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_metrics(&self, path: &Path) -> Result<(), Error> {
        Ok(output::write(path, self.metrics().as_bytes())?)
    }

    fn metrics(&self) -> String {
        let mut out = String::new();
        let mut metric = |name: &str, help: &str, rows: &[(String, f64)]| {
            let _ = writeln!(out, "# HELP roadbench_{name} {help}\n# TYPE roadbench_{name} gauge");
            for (labels, value) in rows {
                let _ = writeln!(out, "roadbench_{name}{labels} {value}");
            }
        };
        let states = [
            ("computed", self.computed),
            ("unchanged", self.unchanged),
            ("rejected", self.rejected),
            ("left", self.left),
        ];
        let labelled = |label: &str, value: &str, n: usize| {
            (format!("{{{label}=\"{value}\"}}"), n as f64) // codes and states are plain words
        };
        let single = |value: f64| [(String::new(), value)];
        metric(
            "sessions",
            "Logs of the last run, by what became of them.",
            &states.map(|(state, n)| labelled("state", state, n)),
        );
        let codes: Vec<_> =
            self.rejected_by_code.iter().map(|(code, n)| labelled("code", code, *n)).collect();
        metric("rejected", "Logs of the last run that could not be used, by code.", &codes);
        metric("input_bytes", "Size of the last run's logs.", &single(self.bytes as f64));
        metric("run_seconds", "Duration of the last run.", &single(self.seconds));
        metric(
            "run_start_time_seconds",
            "When the last run began.",
            &single(self.started.as_second() as f64),
        );
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tables::rows::Rejected;

    #[test]
    fn metrics_are_prometheus_text() {
        let rejected = |code: &str| Rejected { code: code.to_owned(), ..Rejected::default() };
        let accounts = Accounts {
            inputs: 5,
            done: 2,
            unchanged: 1,
            rejected: vec![rejected("empty"), rejected("empty")],
            bytes: 1234,
            ..Accounts::default()
        };
        let pipeline = Pipeline::onroad();
        let summary = Summary::of(&accounts, &pipeline, Timestamp::UNIX_EPOCH, 1.5);
        let text = summary.metrics();
        for line in [
            "# TYPE roadbench_sessions gauge",
            "roadbench_sessions{state=\"computed\"} 2",
            "roadbench_rejected{code=\"empty\"} 2",
            "roadbench_input_bytes 1234",
            "roadbench_run_seconds 1.5",
        ] {
            assert!(text.lines().any(|l| l == line), "{line} in\n{text}");
        }
    }
}
