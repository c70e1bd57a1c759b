//! The extended model on disk: what `diagnose` found in a session.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::remove::remove;
use super::{Effect, ModelError};
use crate::contract::bike::Bike;
use crate::contract::file_error::{FileError, FileName};
use crate::contract::file_kind::FileKind;
use crate::contract::schema::with_hint;
use crate::contract::session::Session;
use crate::store::objects::files::read_text;

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
    pub bike_id: String,
    /// Effects missing in the nominal model, by effect.
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
    pub fn to_toml(&self) -> String {
        let text = toml::to_string(self).unwrap_or_default();
        format!(
            "# The model of a ride with what `roadbench diagnose` found; for `run --model`.\n{text}"
        )
    }

    /// Reads a model file.
    ///
    /// # Errors
    /// Error text that names the file and the key.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let text = read_text(path).map_err(|e| FileName::new("model", path.display()).unread(e))?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Checks a model file's text; `name` is for messages.
    ///
    /// # Errors
    /// Error text that names the file and the key.
    pub fn parse(text: &str, name: &str) -> Result<Self, FileError> {
        let file = FileName::new("model", name);
        FileKind::Model.expect(text).map_err(|e| file.wrong(e))?;
        let model: ExtendedModel =
            toml::from_str(text).map_err(|e| file.wrong(with_hint(&e.to_string())))?;
        for (name, found) in &model.effects {
            let effect = Effect::named(name).map_err(|e| file.wrong(format!("[effects]: {e}")))?;
            effect
                .check_size(found.value)
                .map_err(|e| file.wrong(format!("effects.{name}.value: {e}")))?;
        }
        Ok(model)
    }

    /// Takes what was found out of the session that it was found on; gives back, by name, what stays in the
    /// coefficients because no recording can be freed of it.
    pub fn apply(&self, session: &mut Session, bike: &mut Bike) -> Vec<&'static str> {
        let mut error = ModelError::default();
        for (name, found) in &self.effects {
            // `parse` has looked the names up
            let Ok(effect) = Effect::named(name) else { continue };
            (effect.set)(&mut error, found.value);
        }
        remove(&error, session, bike)
    }
}
