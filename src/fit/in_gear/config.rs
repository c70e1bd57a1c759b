//! Settings of the in-gear fit.

use serde::{Deserialize, Serialize};

use crate::contract::key_error::KeyError;

/// Settings of the in-gear fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Whether rides without the ordinary manoeuvres are fitted as a whole.
    pub enabled: bool,
    /// Slowest samples that take part, m/s.
    pub min_speed: f64,
    /// Largest lean that takes part, rad.
    pub max_lean: f64,
    /// Shortest ride that is fitted, s.
    pub shortest_ride: f64,
    /// Fewest manoeuvres for an interval.
    pub min_manoeuvres: usize,
    /// How far a rolling radius is from the bike file's, a share: a log in km/h hides its circumference.
    pub radius_uncertainty: f64,
    /// Slip stiffness over load, before the ride.
    pub slip_stiffness: f64,
    /// Factor by which it may be larger or smaller, one standard deviation.
    pub slip_stiffness_factor: f64,
    /// Peak friction before the ride.
    pub peak_friction: f64,
    /// Its standard deviation, a share.
    pub peak_friction_uncertainty: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            enabled: true,
            min_speed: 8.0,
            max_lean: 0.87,
            shortest_ride: 60.0,
            min_manoeuvres: 8,
            radius_uncertainty: 0.03,
            slip_stiffness: 23.0,
            slip_stiffness_factor: 1.6,
            peak_friction: 1.32,
            peak_friction_uncertainty: 0.15,
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
            ("shortest_ride", self.shortest_ride, 20.0, 3600.0),
            ("min_manoeuvres", self.min_manoeuvres as f64, 4.0, 100.0),
            ("radius_uncertainty", self.radius_uncertainty, 1e-4, 0.2),
            ("slip_stiffness", self.slip_stiffness, 5.0, 100.0),
            ("slip_stiffness_factor", self.slip_stiffness_factor, 1.05, 5.0),
            ("peak_friction", self.peak_friction, 0.2, 2.5),
            ("peak_friction_uncertainty", self.peak_friction_uncertainty, 0.01, 1.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(KeyError::Values(format!(
                    "[in_gear] `{key}` = {value} is not between {low} and {high}"
                )));
            }
        }
        Ok(())
    }
}
