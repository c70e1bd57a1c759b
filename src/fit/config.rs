//! Settings of the stage.

use serde::{Deserialize, Serialize};

/// Settings of the stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Settings of the friction curve.
    pub friction: FrictionConfig,
    /// A coefficient whose 95 % interval is wider than this share of its value on either side
    /// is `poorly_determined`.
    pub max_relative_interval: f64,
    /// Fewest manoeuvres for an interval.
    pub min_manoeuvres: usize,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            friction: FrictionConfig::default(),
            max_relative_interval: 0.5,
            min_manoeuvres: 3,
        }
    }
}

/// Settings of the friction curve's fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FrictionConfig {
    /// Smallest expected error of the measured friction.
    pub friction_error: f64,
    /// Smallest expected error of the forward velocity, m/s; the residuals of coasting may raise it.
    pub velocity_error: f64,
    /// Simplex iterations from each start.
    pub search_iterations: u64,
}

impl Default for FrictionConfig {
    fn default() -> Self {
        FrictionConfig { friction_error: 0.01, velocity_error: 0.005, search_iterations: 120 }
    }
}

impl Config {
    /// Checks the settings.
    ///
    /// # Errors
    /// A sentence that names the key.
    pub fn check(&self) -> Result<(), String> {
        for (key, value, low, high) in [
            ("max_relative_interval", self.max_relative_interval, 0.01, 10.0),
            ("min_manoeuvres", self.min_manoeuvres as f64, 2.0, 100.0),
            ("friction.friction_error", self.friction.friction_error, 1e-6, 1.0),
            ("friction.velocity_error", self.friction.velocity_error, 0.0, 1.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(format!("[fit] `{key}` = {value} is not between {low} and {high}"));
            }
        }
        Ok(())
    }
}
