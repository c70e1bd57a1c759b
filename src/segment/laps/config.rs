//! Settings of the laps.

use serde::{Deserialize, Serialize};

use crate::contract::key_error::KeyError;

/// Settings of the laps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Whether sessions are looked through for laps.
    pub enabled: bool,
    /// The start line from one end to the other, `[[latitude, longitude], [latitude, longitude]]`,
    /// degrees; without it the logger's own lap counter or, where there is none, the fastest part is taken.
    pub line: Option<[[f64; 2]; 2]>,
    /// Shortest lap, m.
    pub shortest_lap: f64,
    /// Half the width of a line that was found, m: pit lanes and wide tracks.
    pub half_width: f64,
    /// Share of the ride's distance that must be on the lap, for it to be a track.
    pub least_on_track: f64,
    /// Slow error of a receiver's position, one standard deviation, m.
    pub position_error: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            enabled: true,
            line: None,
            shortest_lap: 400.0,
            half_width: 20.0,
            least_on_track: 0.6,
            position_error: 1.5,
        }
    }
}

impl Config {
    /// Checks the settings.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn check(&self) -> Result<(), KeyError> {
        for (key, value, low, high) in [
            ("shortest_lap", self.shortest_lap, 100.0, 100_000.0),
            ("half_width", self.half_width, 3.0, 100.0),
            ("least_on_track", self.least_on_track, 0.1, 1.0),
            ("position_error", self.position_error, 0.01, 50.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(KeyError::Values(format!(
                    "[laps] `{key}` = {value} is not between {low} and {high}"
                )));
            }
        }
        for [latitude, longitude] in self.line.iter().flatten() {
            if !(latitude.abs() <= 90.0 && longitude.abs() <= 180.0) {
                return Err(KeyError::Values(format!(
                    "[laps] `line`: [{latitude}, {longitude}] is no latitude and longitude in degrees"
                )));
            }
        }
        Ok(())
    }
}
