//! Settings of the stage.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::contract::coefficient::{Coefficient, Source};
use crate::contract::key_error::KeyError;

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
    /// Errors of the model on real motorcycles, by coefficient: a standard deviation over the value, on top
    /// of what the ride and the bike file leave open. `examples/coverage --learn` finds it.
    pub model_error: BTreeMap<String, f64>,
}

/// Of 100 simulated motorcycles whose construction is not the model's (`examples/coverage --rides 100 --seed 2301
/// --learn`); the camber stiffness has that of the cornering stiffness, which 60 others (seed 4242) showed to be
/// larger than those 100 do.
const MODEL_ERROR: [(&str, f64); 11] = [
    ("effective_rolling_radius", 0.00015),
    ("drag", 0.004),
    ("rolling_resistance", 0.0034),
    ("peak_slip", 0.0135),
    ("mf_b", 0.20),
    ("mf_c", 0.14),
    ("mf_d", 0.012),
    ("mf_e2", 0.38),
    ("lateral_friction_ct", 0.0011),
    ("cornering_stiffness_0", 0.15),
    ("overturning_stiffness", 0.0123),
];

impl Default for Config {
    fn default() -> Self {
        Config {
            friction: FrictionConfig::default(),
            max_relative_interval: 0.5,
            min_manoeuvres: 3,
            model_error: MODEL_ERROR.map(|(name, share)| (name.to_owned(), share)).into(),
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
}

impl Default for FrictionConfig {
    fn default() -> Self {
        FrictionConfig { friction_error: 0.01, velocity_error: 0.005 }
    }
}

impl Config {
    /// Checks the settings.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn check(&self) -> Result<(), KeyError> {
        for (key, value, low, high) in [
            ("max_relative_interval", self.max_relative_interval, 0.01, 10.0),
            ("min_manoeuvres", self.min_manoeuvres as f64, 2.0, 100.0),
            ("friction.friction_error", self.friction.friction_error, 1e-6, 1.0),
            ("friction.velocity_error", self.friction.velocity_error, 0.0, 1.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(KeyError::Values(format!(
                    "[fit] `{key}` = {value} is not between {low} and {high}"
                )));
            }
        }
        for (name, share) in &self.model_error {
            let known = Coefficient::from_name(name).filter(|c| c.spec().source == Source::OnRoad);
            if known.is_none_or(|c| c == Coefficient::CamberStiffness0) {
                let of = "names no coefficient that is fitted by itself";
                return Err(KeyError::Values(format!("[fit.model_error] `{name}` {of}")));
            }
            if !(0.0..=1.0).contains(share) {
                return Err(KeyError::Values(format!(
                    "[fit.model_error] `{name}` = {share} is not between 0 and 1"
                )));
            }
        }
        Ok(())
    }
}
