//! The settings of the stages: the files of `pipelines/`.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::contract::file_error::{FileError, FileName};
use crate::contract::file_kind::FileKind;
use crate::contract::schema::KeyTable;
use crate::segment::laps;
use crate::simulate::effects::models::Models;
use crate::store::objects::files::read_text;
use crate::{estimate, filter, fit, ingest, segment};

/// The resolved settings of every stage: one file of `pipelines/`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pipeline {
    /// Name of the pipeline, which the tables record.
    pub name: String,
    /// Settings of reading, cleaning and checking a log.
    #[serde(default)]
    pub ingest: ingest::Config,
    /// Settings of the low-pass filters.
    #[serde(default)]
    pub filter: filter::Config,
    /// Settings of the detection of manoeuvres.
    #[serde(default)]
    pub segment: segment::Config,
    /// Settings of the estimated signals.
    #[serde(default)]
    pub estimate: estimate::Config,
    /// Settings of the fits.
    #[serde(default)]
    pub fit: fit::Config,
    /// The fit to changing lean.
    #[serde(default)]
    pub transients: fit::transients::Config,
    /// The joint fit to rides in gear.
    #[serde(default)]
    pub in_gear: fit::in_gear::Config,
    /// Laps of a track.
    #[serde(default)]
    pub laps: laps::Config,
    /// Off-road: where it is there, tyre forces by inverse dynamics take the place of the fits.
    pub offroad: Option<estimate::offroad::Config>,
    /// Identified causes of a diagnosis, removed from its sessions and from those that share them. Its hash is each
    /// session's own part of it ([`Models::text_of`]).
    pub models: Option<Models>,
}

/// Built-in pipelines by name.
pub const BUILTIN: &[(&str, &str)] = &[
    ("onroad", include_str!("../../pipelines/onroad.toml")),
    ("paper", include_str!("../../pipelines/paper.toml")),
    ("offroad", include_str!("../../pipelines/offroad.toml")),
];

impl Pipeline {
    /// A built-in pipeline.
    ///
    /// # Panics
    /// If there is none of that name, which a test rules out for those of [`BUILTIN`].
    pub fn builtin(name: &str) -> Self {
        let text = BUILTIN.iter().find(|(n, _)| *n == name).map_or("", |(_, text)| text);
        Self::parse(text, &format!("pipelines/{name}.toml"))
            .unwrap_or_else(|e| panic!("built-in pipeline: {e}"))
    }

    /// The built-in `pipelines/onroad.toml`.
    pub fn onroad() -> Self {
        Self::builtin("onroad")
    }

    /// Reads and checks a pipeline file; the name of a built-in one does too, where there is no
    /// such file.
    ///
    /// # Errors
    /// Error text that names the file and the key.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let builtin = BUILTIN.iter().find(|(name, _)| path == Path::new(name));
        if let Some((name, _)) = builtin
            && !path.exists()
        {
            return Ok(Self::builtin(name));
        }
        let text = read_text(path).map_err(|e| {
            let names: Vec<&str> = BUILTIN.iter().map(|(name, _)| *name).collect();
            let word = path.to_string_lossy();
            let meant = crate::contract::schema::meant(&word, names.iter().copied());
            let remedy = format!("{meant}; built in are {}", names.join(", "));
            FileError::Read { file: FileName::new("pipeline", word), source: e, remedy }
        })?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Checks a pipeline file's text; `name` is for messages.
    ///
    /// # Errors
    /// Error text that names the file and the key.
    pub fn parse(text: &str, name: &str) -> Result<Self, FileError> {
        let file = FileName::new("pipeline", name);
        FileKind::Pipeline.expect(text).map_err(|e| file.wrong(e))?;
        // the text, not the settings: what it leaves out is in order
        let mut given: toml::Table = toml::from_str(text).map_err(|e| file.wrong(e.to_string()))?;
        let keys = KeyTable::embedded("pipeline");
        if let Some(removed) = keys.take_removed(&mut given).first() {
            return Err(file.wrong(removed.message()));
        }
        let pipeline: Pipeline = toml::from_str(text)
            .map_err(|e| file.wrong(crate::contract::schema::with_hint(&e.to_string())))?;
        keys.check_ranges(&given).map_err(|e| file.wrong(e))?;
        pipeline.estimate.check().map_err(|e| file.wrong(e))?;
        pipeline.fit.check().map_err(|e| file.wrong(e))?;
        pipeline.in_gear.check().map_err(|e| file.wrong(e))?;
        pipeline.transients.check().map_err(|e| file.wrong(e))?;
        pipeline.laps.check().map_err(|e| file.wrong(e))?;
        if let Some(offroad) = &pipeline.offroad {
            offroad.check().map_err(|e| file.wrong(e))?;
        }
        Ok(pipeline)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every number of a resolved pipeline, by dotted path.
    fn numbers(prefix: &str, table: &toml::Table, out: &mut Vec<String>) {
        for (key, value) in table {
            let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
            match value {
                toml::Value::Table(inner) => numbers(&path, inner, out),
                toml::Value::Float(_) | toml::Value::Integer(_) => out.push(path),
                _ => {}
            }
        }
    }

    /// What is no number, and what no setting may be.
    #[test]
    fn no_number_is_taken_that_means_nothing() {
        let mut all = Vec::new();
        for built_in in ["onroad", "offroad", "paper"] {
            let pipeline = Pipeline::builtin(built_in);
            let text = toml::to_string(&pipeline).expect("text");
            numbers("", &toml::from_str(&text).expect("a table"), &mut all);
        }
        all.sort();
        all.dedup();
        assert!(all.len() > 80, "{}", all.len());
        let mut taken = Vec::new();
        for path in all {
            for bad in ["nan", "inf", "-inf", "-1.0", "1e30"] {
                let (section, key) = path.rsplit_once('.').expect("every number is in a section");
                let text = format!("name = \"mine\"\n[{section}]\n{key} = {bad}\n");
                match Pipeline::parse(&text, "mine") {
                    Err(refused) if refused.to_string().contains(key) => {}
                    Err(other) => taken.push(format!("{path} = {bad}: {other}")),
                    Ok(_) => taken.push(format!("{path} = {bad}")),
                }
            }
        }
        assert!(taken.is_empty(), "{taken:#?}");
    }
}
