//! Tyre slips, loads and forces, sample by sample, from what was measured.
//!
//! Assumes a filtered session and its segments. [`zeros`] finds the sensors' zeros and the
//! velocity's latency, [`samples`] gathers the samples of the used segments, [`signals`] is the
//! algebra (eqs. 24-36), [`quasi_static`] selects the corner samples. Nothing is fitted here.

pub(crate) mod grade;
pub(crate) mod measured;
pub(crate) mod offroad;
pub(crate) mod quasi_static;
pub(crate) mod relaxation;
pub(crate) mod rolling_front;
pub(crate) mod samples;
pub(crate) mod signals;
pub(crate) mod table;
pub(crate) mod turn;
pub(crate) mod zeros;

use serde::{Deserialize, Serialize};

use crate::contract::key_error::KeyError;
use crate::tyre::formulation::Formulation;

/// Settings of the stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Which form of the equations.
    pub formulation: Formulation,
    /// Samples per second taken from straight manoeuvres, Hz.
    pub straight_rate: f64,
    /// Samples per second taken from corners, Hz.
    pub corner_rate: f64,
    /// Corner samples that roll faster are not quasi-static, rad/s.
    pub max_roll_rate: f64,
    /// Corner samples with less roll are too upright to determine anything by camber, rad.
    pub min_camber: f64,
    /// Samples slower than this are not used, m/s.
    pub min_speed: f64,
    /// Left out at the start of every segment, a quarter of it at the end, s: there the filter
    /// mixes in the manoeuvre before and after.
    pub trim: f64,
    /// Whether altitude and climb give the grade of the road.
    pub grade: bool,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            formulation: Formulation::Corrected,
            straight_rate: 50.0,
            corner_rate: 12.5,
            max_roll_rate: 0.1,
            min_camber: 0.07,
            min_speed: 3.0,
            trim: 0.2,
            grade: true,
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
            ("straight_rate", self.straight_rate, 1.0, 1000.0),
            ("corner_rate", self.corner_rate, 1.0, 1000.0),
            ("max_roll_rate", self.max_roll_rate, 0.01, 10.0),
            ("min_camber", self.min_camber, 0.0, 0.5),
            ("min_speed", self.min_speed, 1.0, 20.0),
            ("trim", self.trim, 0.0, 5.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(KeyError::Values(format!(
                    "[estimate] `{key}` = {value} is not between {low} and {high}"
                )));
            }
        }
        Ok(())
    }
}
