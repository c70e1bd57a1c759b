//! A motocross scenario: which bike, on what lap, seen by which sensors.
//!
//! ```toml
//! name = "motocross"
//! lap = [{ kind = "jump", height = 1.6, ... }, ...]
//! [bike]          # the analyst's bike file, with [offroad]
//! [truth]         # what the machine really is, where the file is wrong
//! ```

use std::path::Path;

use serde::Deserialize;

use super::ground::{Ground, Part};
use super::machine::{Plant, Touching, Tyre};
use super::rider::Active;
use crate::bike::Bike;
use crate::channel::Channel;
use crate::estimate::offroad::machine::Machine;
use crate::simulate::random::Random;
use crate::simulate::sensors::Sensors;
use crate::simulate::text_with_key;

/// Built-in motocross scenarios by name.
pub const BUILTIN: &[(&str, &str)] =
    &[("motocross", include_str!("../../../pipelines/scenarios/motocross.toml"))];

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    description: String,
    seed: u64,
    rate: f64,
    sessions: usize,
    duration: f64,
    #[serde(default = "fast")]
    truth_rate: f64,
    #[serde(default)]
    float32: bool,
    #[serde(default)]
    drop: Vec<String>,
    lap: Vec<Part>,
    unevenness: f64,
    #[serde(default)]
    touching: Touching,
    #[serde(default)]
    tyre_front: Tyre,
    #[serde(default)]
    tyre_rear: Tyre,
    #[serde(default)]
    vibration: Vibration,
    bike: toml::Table,
    #[serde(default)]
    truth: toml::Table,
    #[serde(default)]
    sensors: Sensors,
}

fn fast() -> f64 {
    200.0
}

/// What the engine does to the accelerometers.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Vibration {
    /// Amplitude, m/s².
    pub amplitude: f64,
    /// Lowest and highest frequency, Hz.
    pub frequency: [f64; 2],
}

/// A checked scenario.
#[derive(Debug, Clone)]
pub struct Motocross {
    /// Its name.
    pub name: String,
    /// What it is for.
    pub description: String,
    /// Of all randomness.
    pub seed: u64,
    /// Of the log, Hz.
    pub rate: f64,
    /// Sessions.
    pub sessions: usize,
    /// Length of each, s.
    pub duration: f64,
    /// Of the table of truth, Hz.
    pub truth_rate: f64,
    /// Whether the log is written in single precision.
    pub float32: bool,
    /// Channels that the logger does not have.
    pub drop: Vec<Channel>,
    /// Engine.
    pub vibration: Vibration,
    /// Errors by channel.
    pub sensors: Sensors,
    /// What the analyst's bike file says.
    pub bike: Bike,
    /// What the machine is.
    pub machine: Machine,
    lap: Vec<Part>,
    unevenness: f64,
    touching: Touching,
    tyres: [Tyre; 2],
}

impl Motocross {
    /// A built-in scenario by name, or a file; `None` when it is of another kind.
    ///
    /// # Errors
    /// A sentence that names file and key.
    pub fn load(name_or_path: &str) -> Result<Option<Self>, String> {
        let found = text_with_key(BUILTIN, name_or_path, "lap");
        found.map(|(text, path)| Self::parse(&text, &path)).transpose()
    }

    /// Checks a scenario's text; `path` is for messages.
    ///
    /// # Errors
    /// A sentence that names the key.
    pub fn parse(text: &str, path: &Path) -> Result<Self, String> {
        let fail = |e: String| format!("scenario {}: {e}", path.display());
        let file: File = toml::from_str(text).map_err(|e| fail(e.to_string()))?;
        for (key, value, low, high) in [
            ("rate", file.rate, 200.0, 10_000.0),
            ("truth_rate", file.truth_rate, 1.0, file.rate),
            ("duration", file.duration, 2.0, 7200.0),
            ("unevenness", file.unevenness, 0.0, 0.2),
        ] {
            if !(low..=high).contains(&value) {
                return Err(fail(format!("`{key}` = {value} is not between {low} and {high}")));
            }
        }
        let lap: f64 = file.lap.iter().map(Part::length).sum();
        if lap.is_nan() || lap <= 20.0 {
            return Err(fail(format!("`lap` is {lap:.0} m long, less than 20 m")));
        }
        for (k, part) in file.lap.iter().enumerate() {
            part.check().map_err(|e| fail(format!("`lap`, part {}: {e}", k + 1)))?;
        }
        for (name, tyre) in [("tyre_front", &file.tyre_front), ("tyre_rear", &file.tyre_rear)] {
            tyre.check().map_err(|e| fail(format!("[{name}] {e}")))?;
        }
        let [low, high] = file.vibration.frequency;
        if file.vibration.amplitude > 0.0 && !(low > 0.0 && low <= high && high < 1e4) {
            return Err(fail(format!(
                "[vibration] `frequency` = [{low}, {high}] must rise, in Hz above 0"
            )));
        }
        let bike = Bike::parse(&file.bike.to_string(), &file.name, Path::new("[bike]"))
            .map_err(|e| fail(e.to_string()))?;
        let mut true_bike = bike.clone();
        for (key, value) in flat(&file.truth) {
            let Some(number) = value.as_float().or(value.as_integer().map(|i| i as f64)) else {
                return Err(fail(format!("[truth]: `{key}` must be a number")));
            };
            if true_bike.value(&key).is_none() {
                return Err(fail(format!("[truth]: [bike] has no number `{key}`")));
            }
            true_bike = true_bike.with(&key, number);
        }
        let machine = Machine::new(&true_bike).map_err(fail)?;
        Machine::new(&bike).map_err(fail)?;
        let drop = file
            .drop
            .iter()
            .map(|name| Channel::named(name))
            .collect::<Result<_, _>>()
            .map_err(fail)?;
        for name in file.sensors.keys() {
            Channel::named(name).map_err(|e| fail(format!("[sensors]: {e}")))?;
        }
        Ok(Motocross {
            name: file.name,
            description: file.description,
            seed: file.seed,
            rate: file.rate,
            sessions: file.sessions,
            duration: file.duration,
            truth_rate: file.truth_rate,
            float32: file.float32,
            drop,
            vibration: file.vibration,
            sensors: file.sensors,
            bike,
            machine,
            lap: file.lap,
            unevenness: file.unevenness,
            touching: file.touching,
            tyres: [file.tyre_front, file.tyre_rear],
        })
    }

    /// The bike on a session's own ground.
    pub fn plant(&self, number: usize) -> Plant {
        let mut random = Random::new(self.seed, &format!("{} ground {number}", self.name));
        let ground = Ground::new(&self.lap, self.unevenness, &mut random);
        let mass = self.machine.rider.mass;
        let rider = Active { hip_mass: 0.6 * mass, torso_mass: 0.4 * mass, leg: 0.78 };
        Plant::new(self.machine.clone(), self.tyres, ground, rider, self.touching)
    }
}

/// Leaves by dotted path.
fn flat(table: &toml::Table) -> Vec<(String, toml::Value)> {
    let mut out = Vec::new();
    for (key, value) in table {
        match value {
            toml::Value::Table(inner) => {
                out.extend(flat(inner).into_iter().map(|(k, v)| (format!("{key}.{k}"), v)));
            }
            leaf => out.push((key.clone(), leaf.clone())),
        }
    }
    out
}
