//! Settings of the fit to changing lean.

use serde::{Deserialize, Serialize};

use crate::contract::key_error::KeyError;

/// Settings of the fit to changing lean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Whether cornering and camber stiffness are estimated from changing lean.
    pub enabled: bool,
    /// Slowest samples that take part, m/s.
    pub min_speed: f64,
    /// Largest lean that takes part, rad.
    pub max_lean: f64,
    /// Strongest braking or driving that takes part, m/s².
    pub max_acceleration: f64,
    /// Roll rate from which the lean changes, rad/s.
    pub roll_rate: f64,
    /// Longest stretch, s: a longer one is cut.
    pub longest: f64,
    /// Fewest stretches.
    pub min_stretches: usize,
    /// How far the handlebar turns ahead of the wheel per torque about the steering axis, rad/(N m), one standard deviation.
    pub steering_compliance: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            enabled: true,
            min_speed: 5.0,
            max_lean: 0.5,
            max_acceleration: 1.2,
            roll_rate: 0.06,
            longest: 8.0,
            min_stretches: 4,
            steering_compliance: 1.0e-5,
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
            ("min_speed", self.min_speed, 3.0, 40.0),
            ("max_lean", self.max_lean, 0.05, 1.2),
            ("max_acceleration", self.max_acceleration, 0.1, 5.0),
            ("roll_rate", self.roll_rate, 0.01, 1.0),
            ("longest", self.longest, 4.0, 60.0),
            ("min_stretches", self.min_stretches as f64, 2.0, 100.0),
            ("steering_compliance", self.steering_compliance, 0.0, 1e-3),
        ] {
            if !(low..=high).contains(&value) {
                return Err(KeyError::Values(format!(
                    "[transients] `{key}` = {value} is not between {low} and {high}"
                )));
            }
        }
        Ok(())
    }
}
