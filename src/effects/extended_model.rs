//! The extended model on disk: what `diagnose` found, and what `run --model` takes out of a session.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::remove::remove;
use super::{Effect, Level, ModelError};
use crate::contract::bike::Bike;
use crate::contract::session::Session;
use crate::contract::warning::Warning;

/// The size of an effect and its standard error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// In `unit`.
    pub value: f64,
    /// Standard error, in `unit`.
    pub std_error: f64,
    /// That of the effect.
    pub unit: String,
}

/// A tyre's or the vehicle's coefficient once the effects are taken out: that of `run --model`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coefficient {
    /// In `unit`.
    pub value: f64,
    /// 95 % interval, in `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ci95: Option<[f64; 2]>,
    /// As in the table `coefficients`.
    pub unit: String,
    /// As in the table `coefficients`.
    pub status: String,
}

/// The extended model of a ride.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExtendedModel {
    /// The ride it was found on.
    pub session_id: String,
    /// Its motorcycle.
    pub bike_id: String,
    /// What the base model leaves out, by effect.
    #[serde(default)]
    pub effects: BTreeMap<String, Estimate>,
    /// Coefficients of the ride without these effects, by tyre (`front`, `rear`, `vehicle`) and name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub coefficients: BTreeMap<String, BTreeMap<String, Coefficient>>,
    /// The diagnosis' own fit, in files of older versions.
    #[serde(default, skip_serializing)]
    pub base: BTreeMap<String, f64>,
}

impl ExtendedModel {
    /// As a file.
    pub fn to_toml(&self) -> String {
        let text = toml::to_string(self).unwrap_or_default();
        format!(
            "# The model of a ride with what `roadbench diagnose` found; for `run --model`.\n{text}"
        )
    }

    /// Reads a model file.
    ///
    /// # Errors
    /// A sentence that names the file and the key.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(path)
            .map_err(|e| format!("cannot read model {}: {e}", path.display()))?;
        let fail = |e: String| format!("model {}: {e}", path.display());
        let model: ExtendedModel = toml::from_str(&text).map_err(|e| fail(e.to_string()))?;
        for (name, found) in &model.effects {
            let effect = Effect::named(name).map_err(|e| fail(format!("[effects]: {e}")))?;
            if !effect.in_bounds(found.value) {
                let [low, high] = effect.bounds;
                return Err(fail(format!(
                    "effects.{name}: {} {} is not between {low} and {high}",
                    found.value, effect.unit
                )));
            }
        }
        Ok(model)
    }

    /// Takes what was found out of a session of the same motorcycle: what belongs to the motorcycle
    /// out of each of them, what belongs to a road or a day out of the session it was found on.
    pub fn apply(&self, session: &mut Session, bike: &mut Bike) -> Vec<Warning> {
        let meta = &session.meta;
        if meta.bike_id != self.bike_id {
            return Vec::new();
        }
        let own = meta.session_id == self.session_id;
        let mut error = ModelError::default();
        let mut taken = Vec::new();
        for (name, found) in &self.effects {
            // `read` has looked the names up
            let Ok(effect) = Effect::named(name) else { continue };
            if own || effect.level == Level::Bike {
                (effect.set)(&mut error, found.value);
                taken.push(name.as_str());
            }
        }
        let left = remove(&error, session, bike);
        taken.retain(|name| !left.contains(name));
        let warning = |code, message| Warning {
            stage: "ingest",
            code,
            channel: None,
            count: 1,
            time: None,
            message,
        };
        let mut warnings = Vec::new();
        if !taken.is_empty() {
            let message = format!("the model's {} taken out", taken.join(", "));
            warnings.push(warning("model_applied", message));
        }
        if !left.is_empty() {
            let message = format!(
                "the model's {} cannot be taken out of a recording: they stay in the coefficients",
                left.join(", ")
            );
            warnings.push(warning("model_left", message));
        }
        warnings
    }
}
