//! Any log to one [`Session`](crate::session::Session) on one clean clock.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::channel::Channel;
use crate::session::{Meta, Session};
use crate::warning::Warning;

mod check;

pub use check::check;

/// Settings of the stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Rate of the common clock, Hz; 0 takes the fastest channel's own.
    pub rate: f64,
    /// Longest gap that is interpolated over, s.
    pub max_gap: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config { rate: 0.0, max_gap: 0.25 }
    }
}

/// One channel as recorded, on its own clock.
#[derive(Debug, Clone)]
pub struct Track {
    /// Which.
    pub channel: Channel,
    /// Stamps as recorded, s: may repeat, jump back or jitter.
    pub time: std::sync::Arc<Vec<f64>>,
    /// SI values, NaN where there is none.
    pub values: Vec<f64>,
}

/// A log as read: units are SI, the clocks are still the source's.
#[derive(Debug, Clone)]
pub struct Raw {
    /// Who, when, on what.
    pub meta: Meta,
    /// The channels.
    pub tracks: Vec<Track>,
}

/// Why a log cannot be used; `code` is the `rejected` table's.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{message}")]
pub struct Error {
    /// Short stable name, snake case.
    pub code: &'static str,
    /// What was wrong, in which column and row, and what to do.
    pub message: String,
}

/// Who and when, without reading the samples.
///
/// # Errors
/// The file cannot be read or is of no known kind.
pub fn identify(_path: &Path) -> Result<Meta, Error> {
    Err(Error { code: "unknown_format", message: String::new() })
}

/// Reads a log of any known format.
///
/// # Errors
/// The file cannot be read, or lacks what every session needs.
pub fn read(_path: &Path) -> Result<Raw, Error> {
    Err(Error { code: "unknown_format", message: String::new() })
}

/// Repairs the clocks and brings every channel onto one.
///
/// # Errors
/// Nothing usable is left.
pub fn run(_raw: Raw, _config: &Config) -> Result<(Session, Vec<Warning>), Error> {
    Err(Error { code: "unknown_format", message: String::new() })
}
