//! Settings of the stage.

use serde::{Deserialize, Serialize};

use crate::ingest::checks::switches::Switches;

/// Settings of the stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Rate of the common clock, Hz; 0 takes the fastest channel's own.
    pub rate: f64,
    /// Longest gap that is interpolated over, s. A channel that is slower than that by nature
    /// (GPS at 1 Hz) is interpolated between its own samples, never over a lost one.
    pub max_gap: f64,
    /// A single sample is a spike when it stands out of its neighbourhood by this many times
    /// what the signal does there otherwise; 0 looks for none.
    pub spike_threshold: f64,
    /// A channel that does not change at all for this long while the bike moves is stuck, s;
    /// 0 looks for none.
    pub stuck_time: f64,
    /// Effect of each check of channels against physics.
    #[serde(skip_serializing_if = "Switches::is_empty")]
    pub check: Switches,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            rate: 0.0,
            max_gap: 0.25,
            spike_threshold: 8.0,
            stuck_time: 2.0,
            check: Switches::default(),
        }
    }
}
