//! A motocross scenario: which bike, on what lap, seen by which sensors.
//!
//! ```toml
//! name = "motocross"
//! lap = [{ kind = "jump", height = 1.6, ... }, ...]
//! [bike]          # the analyst's bike file, with [offroad]
//! [truth]         # what the machine really is, where the file is wrong
//! [effects]       # what the estimate's model leaves out, for `diagnose` to find
//! ```

use std::path::Path;

use serde::Deserialize;

use super::ground::{Ground, Part};
use super::machine::{ForwardModel, Touching, Tyre};
use super::passive::Passive;
use super::rider::Active;
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::file_error::{FileError, FileName};
use crate::contract::key_error::KeyError;
use crate::contract::schema::refuse_infinite_in;
use crate::motorcycle::offroad::planar::PlanarMotorcycle;
use crate::simulate::builtin::{self, text_with_key};
use crate::simulate::sensors::Sensors;
use crate::statistics::random::Random;

/// Built-in motocross scenarios by name.
pub const BUILTIN: builtin::List = builtin::MOTOCROSS;

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
    effects: Effects,
    #[serde(default)]
    sensors: Sensors,
}

fn fast() -> f64 {
    200.0
}

/// Vibration of the accelerometers by the engine.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Vibration {
    /// Amplitude, m/s².
    pub amplitude: f64,
    /// Lowest and highest frequency, Hz.
    pub frequency: [f64; 2],
}

/// Effects that the simulated ride has and the estimate's nominal model (rider B, the bike file's fork) has not.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Effects {
    /// How the rider moves up and down.
    pub rider_vertical_motion: VerticalMotion,
    /// Below this a rider without a body (one whose `rider_vertical_motion` is a number) follows the
    /// bike fore and aft, Hz; absent: always, as rider B.
    pub rider_horizontal_motion: Option<f64>,
    /// Coulomb friction in the fork beyond that of `[truth]`, N.
    pub fork_friction: f64,
}

impl Effects {
    /// Checks the numbers of a scenario file.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn check(&self) -> Result<(), KeyError> {
        let friction = self.fork_friction;
        if !(0.0..=2000.0).contains(&friction) {
            return Err(KeyError::Values(format!(
                "`fork_friction` = {friction} is not between 0 and 2000"
            )));
        }
        if let VerticalMotion::CutOff(cut_off) = self.rider_vertical_motion
            && !(0.0..=20.0).contains(&cut_off)
        {
            return Err(KeyError::Values(format!(
                "`rider_vertical_motion` = {cut_off} is neither \"active\" nor between 0 and 20"
            )));
        }
        match (self.rider_horizontal_motion, self.rider_vertical_motion) {
            (Some(_), VerticalMotion::Legs(_)) => {
                Err("`rider_horizontal_motion` needs a rider without a body: give \
                 `rider_vertical_motion` a number"
                    .into())
            }
            (Some(cut_off), _) if !(0.05..=20.0).contains(&cut_off) => Err(KeyError::Values(
                format!("`rider_horizontal_motion` = {cut_off} is not between 0.05 and 20"),
            )),
            _ => Ok(()),
        }
    }
}

/// How the simulated rider moves up and down: `"active"`, or a number.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum VerticalMotion {
    /// Rider C with this cut-off, Hz; at zero rider B.
    CutOff(f64),
    Legs(Legs),
}

impl Default for VerticalMotion {
    fn default() -> Self {
        VerticalMotion::Legs(Legs::Active)
    }
}

/// See [`VerticalMotion`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Legs {
    /// They push actively.
    Active,
}

#[derive(Debug, Clone)]
pub struct Motocross {
    /// Name: the start of the session ids.
    pub name: String,
    /// Purpose, in words.
    pub description: String,
    pub seed: u64,
    /// Of the log, Hz.
    pub rate: f64,
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
    /// The analyst's bike file.
    pub bike: Bike,
    pub machine: PlanarMotorcycle,
    /// Effects that `diagnose` may find.
    pub effects: Effects,
    lap: Vec<Part>,
    unevenness: f64,
    touching: Touching,
    tyres: [Tyre; 2],
}

impl Motocross {
    /// A built-in scenario by name, or a file; `None` when it is of another kind.
    ///
    /// # Errors
    /// Error text that names file and key.
    pub fn load(name_or_path: &str) -> Result<Option<Self>, FileError> {
        let found = text_with_key(BUILTIN, name_or_path, "lap");
        found.map(|(text, path)| Self::parse(&text, &path)).transpose()
    }

    /// Checks a scenario's text; `path` is for messages.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn parse(text: &str, path: &Path) -> Result<Self, FileError> {
        let file = FileName::new("scenario", path.display());
        refuse_infinite_in(text).map_err(|e| file.wrong(e))?;
        let given: File = toml::from_str(text).map_err(|e| file.wrong(e.to_string()))?;
        for (key, value, low, high) in [
            ("rate", given.rate, 200.0, 10_000.0),
            ("truth_rate", given.truth_rate, 1.0, given.rate),
            ("duration", given.duration, 2.0, 7200.0),
            ("unevenness", given.unevenness, 0.0, 0.2),
        ] {
            if !(low..=high).contains(&value) {
                return Err(
                    file.wrong(format!("`{key}` = {value} is not between {low} and {high}"))
                );
            }
        }
        let lap: f64 = given.lap.iter().map(Part::length).sum();
        if lap.is_nan() || lap <= 20.0 {
            return Err(file.wrong(format!("`lap` is {lap:.0} m long, less than 20 m")));
        }
        for (k, part) in given.lap.iter().enumerate() {
            part.check().map_err(|e| file.wrong(format!("`lap`, part {}: {e}", k + 1)))?;
        }
        for (name, tyre) in [("tyre_front", &given.tyre_front), ("tyre_rear", &given.tyre_rear)] {
            tyre.check().map_err(|e| file.wrong(format!("[{name}] {e}")))?;
        }
        let [low, high] = given.vibration.frequency;
        if given.vibration.amplitude > 0.0 && !(low > 0.0 && low <= high && high < 1e4) {
            return Err(file.wrong(format!(
                "[vibration] `frequency` = [{low}, {high}] must rise, in Hz above 0"
            )));
        }
        let bike = Bike::parse(&given.bike.to_string(), &given.name, Path::new("[bike]"))
            .map_err(|e| file.wrong(e.to_string()))?;
        let mut true_bike = bike.clone();
        for (key, value) in flat(&given.truth) {
            let Some(number) = value.as_float().or(value.as_integer().map(|i| i as f64)) else {
                return Err(file.wrong(format!("[truth]: `{key}` must be a number")));
            };
            if true_bike.value(&key).is_none() {
                return Err(file.wrong(format!("[truth]: [bike] has no number `{key}`")));
            }
            true_bike = true_bike.with(&key, number);
        }
        let effects = given.effects;
        effects.check().map_err(|e| file.wrong(format!("[effects] {e}")))?;
        let friction = true_bike.value("offroad.fork_friction").unwrap_or(0.0);
        true_bike = true_bike.with("offroad.fork_friction", friction + effects.fork_friction);
        let machine = PlanarMotorcycle::new(&true_bike).map_err(|e| file.wrong(e))?;
        PlanarMotorcycle::new(&bike).map_err(|e| file.wrong(e))?;
        let drop = given
            .drop
            .iter()
            .map(|name| Channel::named(name))
            .collect::<Result<_, _>>()
            .map_err(|e| file.wrong(e))?;
        for name in given.sensors.keys() {
            Channel::named(name).map_err(|e| file.wrong(format!("[sensors]: {e}")))?;
        }
        Ok(Motocross {
            name: given.name,
            description: given.description,
            seed: given.seed,
            rate: given.rate,
            sessions: given.sessions,
            duration: given.duration,
            truth_rate: given.truth_rate,
            float32: given.float32,
            drop,
            vibration: given.vibration,
            sensors: given.sensors,
            bike,
            machine,
            effects,
            lap: given.lap,
            unevenness: given.unevenness,
            touching: given.touching,
            tyres: [given.tyre_front, given.tyre_rear],
        })
    }

    /// The bike on a session's own ground.
    pub fn forward_model(&self, number: usize) -> ForwardModel {
        let mut random = Random::new(self.seed, &format!("{} ground {number}", self.name));
        let ground = Ground::new(&self.lap, self.unevenness, &mut random);
        let mass = self.machine.rider.mass;
        let rider = Active { hip_mass: 0.6 * mass, torso_mass: 0.4 * mass, leg: 0.78 };
        let mut plant =
            ForwardModel::new(self.machine.clone(), self.tyres, ground, rider, self.touching);
        if let VerticalMotion::CutOff(cut_off) = self.effects.rider_vertical_motion {
            let horizontal = self.effects.rider_horizontal_motion;
            plant.passive = Some(Passive { mass, cut_off, horizontal });
        }
        plant
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
