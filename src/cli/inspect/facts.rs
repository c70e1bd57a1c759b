//! What `roadbench inspect` reports: as JSON field by field, as text by [`super::text`].

use std::path::PathBuf;

use serde::Serialize;

/// Everything that `inspect` reports of a log.
#[derive(Debug, Serialize)]
pub(super) struct Inspection {
    pub session: Facts,
    pub channels: Vec<ChannelFacts>,
    pub warnings: Vec<Noticed>,
    pub rejected: Option<Reason>,
    pub estimates: Vec<Estimate>,
    /// What the numbers cost that the bike file does not have, a line each.
    pub costs: Vec<String>,
}

/// The session as a whole.
#[derive(Debug, Serialize)]
pub(super) struct Facts {
    pub session_id: String,
    pub bike_id: String,
    pub start_time: Option<String>,
    pub tyre_front: Option<String>,
    pub tyre_rear: Option<String>,
    pub site: Option<String>,
    pub rider_id: Option<String>,
    /// s
    pub duration: f64,
    /// Of the common clock, Hz.
    pub rate: f64,
    pub samples: usize,
    /// Over what is recorded of the velocity, m.
    pub distance: Option<f64>,
    pub bike_file: Option<PathBuf>,
}

/// One channel.
#[derive(Debug, Serialize)]
pub(super) struct ChannelFacts {
    pub channel: &'static str,
    pub unit: String,
    /// Of the source, Hz.
    pub rate: Option<f64>,
    /// Recorded by the source.
    pub samples: usize,
    /// On the common clock, per cent.
    pub missing: f64,
    pub gaps: usize,
    /// s
    pub longest_gap: f64,
    pub min: Option<f64>,
    pub median: Option<f64>,
    pub max: Option<f64>,
    pub verdict: String,
}

/// A warning.
#[derive(Debug, Serialize)]
pub(super) struct Noticed {
    pub code: &'static str,
    pub channel: Option<&'static str>,
    pub count: usize,
    pub time: Option<f64>,
    pub message: String,
}

/// Why the session would be rejected.
#[derive(Debug, Serialize)]
pub(super) struct Reason {
    pub code: &'static str,
    pub message: String,
}

/// Coefficients that need the same.
#[derive(Debug, Serialize)]
pub(super) struct Estimate {
    pub tyre: &'static str,
    pub coefficients: Vec<&'static str>,
    /// `possible`, `assumed` or `not_available`.
    pub status: &'static str,
    pub missing_channels: Vec<&'static str>,
    pub riding: String,
}
