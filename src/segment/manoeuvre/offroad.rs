//! Settings of the off-road manoeuvres.

use serde::{Deserialize, Serialize};

/// Thresholds of the off-road detectors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Shortest flight of both wheels, s.
    pub shortest_flight: f64,
    /// Pitch beyond its mean over a second that makes a wave, rad.
    pub whoops_pitch: f64,
    /// Fewest waves of whoops.
    pub whoops_count: usize,
    /// Speed lost before and won after the slowest point of a corner, m/s.
    pub corner_speed: f64,
    /// Deceleration of a braking, m/s².
    pub braking: f64,
    /// Acceleration of a drive, m/s².
    pub driving: f64,
    /// Shortest braking and drive, s.
    pub shortest: f64,
    /// Share of missing samples beyond which a segment is not used.
    pub missing: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            shortest_flight: 0.15,
            whoops_pitch: 0.06,
            whoops_count: 3,
            corner_speed: 2.0,
            braking: 1.2,
            driving: 0.8,
            shortest: 0.3,
            missing: 0.1,
        }
    }
}
