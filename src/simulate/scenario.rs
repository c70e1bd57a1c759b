//! A scenario file: which bikes, tyres, rides and sensors a synthetic archive has.
//!
//! Built-in scenarios live in `pipelines/scenarios/`; `roadbench simulate` takes their name or
//! a file of the same form. Every number of `[bike]` that has an `[uncertainty]` is the bike
//! file's belief: the simulated truth is drawn around it, so that intervals can be tested.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::builtin;
use super::motorcycle::Plant;
use super::odd_manoeuvre::{self, OddManoeuvre};
use super::plan::Plan;
use super::rider::Disturbance;
use super::sensors::Sensors;
use crate::contract::bike::{Axle, Bike};
use crate::contract::channel::Channel;
use crate::contract::file_error::{FileError, FileName};
use crate::contract::file_kind::FileKind;
use crate::contract::key_error::KeyError;
use crate::contract::schema::closest;
use crate::contract::schema::refuse_infinite_in;
use crate::motorcycle::balance::USUAL_BRAKE_GAIN;
use crate::motorcycle::vehicle::Vehicle;
use crate::simulate::effects::{Effect, ModelError};
use crate::statistics::random::Random;
use crate::store::objects::files::read_text;
use crate::tyre::paper::NO_LIMIT;
use crate::tyre::tyre_model::USUAL_SHARE;
use crate::tyre::{MagicFormula, Stiffness, Tyre};

/// Built-in scenarios by name.
pub const BUILTIN: builtin::List = builtin::REDUCED;

/// Parameters of the simulation that the bike file does not have, with defaults: dotted path,
/// default, meaning.
pub(crate) const TRUTH: &[(&str, f64, &str)] = &[
    ("roll_inertia", 22.0, "about the centre of mass, kg m2"),
    ("yaw_inertia", 28.0, "about the centre of mass, kg m2"),
    ("drag", 0.35, "F = c v^2, kg/m"),
    ("rolling_resistance", 0.015, "both tyres"),
    ("deflection_share", USUAL_SHARE, "of a tyre's deflection, by which it rolls shorter"),
    ("friction", 1.0, "road friction over that of the tyre's characterisation"),
    ("brake_gain_front", USUAL_BRAKE_GAIN[0], "torque per pressure, N m/Pa"),
    ("brake_gain_rear", USUAL_BRAKE_GAIN[1], "torque per pressure, N m/Pa"),
    ("front_inertia", 0.45, "wheel spin inertia where the bike file has none, kg m2"),
    ("rear_inertia", 0.60, "wheel spin inertia where the bike file has none, kg m2"),
    ("front.radius_ratio", 0.99, "rolling radius over the bike file's nominal"),
    ("front.b", 13.0, "eq. 28"),
    ("front.c", 1.55, "eq. 28"),
    ("front.d", 1.05, "eq. 28"),
    ("front.e1", 0.3, "eq. 28; a front wheel is never driven, so e2 is zero"),
    ("front.cornering_stiffness", 12.5, "upright, 1/rad"),
    ("front.stiffness_decay", 0.6, "k_alpha = k0 tan(g)/g / (1 + decay g^2), 1/rad2"),
    ("front.overturning_stiffness", 0.045, "m; the rear's follows the tyre widths"),
    ("rear.radius_ratio", 0.99, "as front"),
    ("rear.b", 12.0, "eq. 28"),
    ("rear.c", 1.50, "eq. 28"),
    ("rear.d", 1.08, "eq. 28"),
    ("rear.e1", 0.25, "eq. 28"),
    ("rear.e2", -0.1, "eq. 28"),
    ("rear.cornering_stiffness", 13.2, "upright, 1/rad"),
    ("rear.stiffness_decay", 0.8, "as front"),
];

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    description: String,
    seed: u64,
    rate: f64,
    float32: bool,
    #[serde(default)]
    drop: Vec<String>,
    plans: Vec<Plan>,
    fleet: Fleet,
    bike: toml::Table,
    #[serde(default)]
    truth: toml::Table,
    #[serde(default)]
    spread: BTreeMap<String, f64>,
    #[serde(default)]
    effects: BTreeMap<String, f64>,
    #[serde(default)]
    disturbance: Disturbance,
    #[serde(default)]
    odd_manoeuvres: Vec<OddManoeuvre>,
    #[serde(default)]
    sensors: Sensors,
}

/// Numbers of bikes and rides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fleet {
    /// Bikes, each with its own tyres.
    pub bikes: usize,
    pub sessions_per_bike: usize,
}

#[derive(Debug, Clone)]
pub struct Scenario {
    /// Name: the start of the session ids.
    pub name: String,
    /// Purpose, in words.
    pub description: String,
    pub seed: u64,
    /// Of the logs, Hz.
    pub rate: f64,
    /// Whether the logs are written in single precision.
    pub float32: bool,
    /// Channels that the logger does not have.
    pub drop: Vec<Channel>,
    /// Ride plans, taken in turn by a bike's sessions.
    pub plans: Vec<Plan>,
    /// Numbers of bikes and rides.
    pub fleet: Fleet,
    /// Unsteadiness of rider, road and air.
    pub disturbance: Disturbance,
    /// Manoeuvres that are not as the others of their ride.
    pub odd_manoeuvres: Vec<OddManoeuvre>,
    pub sensors: Sensors,
    bike: Bike,
    truth: BTreeMap<String, f64>,
    spread: BTreeMap<String, f64>,
    model_error: ModelError,
}

/// One motorcycle of the fleet: its file, which may be wrong, beside the truth.
#[derive(Debug, Clone)]
pub struct Machine {
    pub bike: Bike,
    pub plant: Plant,
}

impl Scenario {
    /// A built-in scenario.
    ///
    /// # Errors
    /// There is none of that name, or it does not load (a defect that a test would find).
    pub fn builtin(name: &str) -> Result<Self, FileError> {
        let found = BUILTIN.iter().find(|(n, _)| *n == name);
        let (_, text) = found.ok_or_else(|| FileError::Unknown(builtin::unknown(name)))?;
        Self::parse(text, name)
    }

    /// A built-in scenario by name, or a scenario file.
    ///
    /// # Errors
    /// The file cannot be read, or a key is wrong; the message names both.
    pub fn load(name_or_path: &str) -> Result<Self, FileError> {
        let path = Path::new(name_or_path);
        if BUILTIN.iter().any(|(n, _)| *n == name_or_path) || !path.exists() {
            return Self::builtin(name_or_path);
        }
        let text =
            read_text(path).map_err(|e| FileName::new("scenario", path.display()).unread(e))?;
        Self::parse(&text, name_or_path)
    }

    /// Checks a scenario's text; `source` is for messages.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn parse(text: &str, source: &str) -> Result<Self, FileError> {
        let file = FileName::new("scenario", source);
        FileKind::Scenario.expect(text).map_err(|e| file.wrong(e))?;
        refuse_infinite_in(text).map_err(|e| file.wrong(e))?;
        let given: File = toml::from_str(text)
            .map_err(|e| file.wrong(crate::contract::schema::with_hint(&e.to_string())))?;
        if !(10.0..=1000.0).contains(&given.rate) {
            return Err(
                file.wrong(format!("`rate` = {} Hz is not between 10 and 1000", given.rate))
            );
        }
        if given.plans.is_empty() {
            return Err(file.wrong("`plans` is empty"));
        }
        let channel = |name: &String| Channel::named(name).map_err(|e| file.wrong(e));
        let drop = given.drop.iter().map(channel).collect::<Result<_, _>>()?;
        for name in given.sensors.keys() {
            channel(name)?;
        }
        let bike = Bike::parse(&given.bike.to_string(), &given.name, Path::new(source))
            .map_err(|e| file.wrong(e))?;
        let truth = truth_values(&given.truth).map_err(|e| file.wrong(e))?;
        for key in given.spread.keys() {
            let known = match key.strip_prefix("truth.") {
                Some(key) => truth.contains_key(key),
                None => bike.value(key).is_some(),
            };
            if !known {
                return Err(
                    file.wrong(format!("[spread]: `{key}` is neither a bike key nor `truth.*`"))
                );
            }
        }
        odd_manoeuvre::check(&given.odd_manoeuvres)
            .map_err(|e| file.wrong(format!("[[odd_manoeuvres]]: {e}")))?;
        let mut model_error = ModelError::default();
        for (name, value) in &given.effects {
            let effect = Effect::named(name).map_err(|e| file.wrong(format!("[effects]: {e}")))?;
            (effect.set)(&mut model_error, *value);
        }
        Ok(Scenario {
            model_error,
            name: given.name,
            description: given.description,
            seed: given.seed,
            rate: given.rate,
            float32: given.float32,
            drop,
            plans: given.plans,
            fleet: given.fleet,
            disturbance: given.disturbance,
            odd_manoeuvres: given.odd_manoeuvres,
            sensors: given.sensors,
            bike,
            truth,
            spread: given.spread,
        })
    }

    /// The same with bike files that are true.
    #[must_use]
    pub fn certain(mut self) -> Self {
        self.bike = self.bike.certain();
        self
    }

    /// The plant without any draw: bike file and truth as they stand.
    pub fn nominal_plant(&self) -> Plant {
        plant(&self.bike, &self.truth).with(&self.model_error)
    }

    /// The `index`-th bike of the fleet: its file and its truth.
    pub fn machine(&self, index: usize) -> Machine {
        let mut random = Random::new(self.seed, &format!("{} bike {index}", self.name));
        let mut bike = self.bike.clone();
        bike.bike_id = format!("{}_{:02}", self.name, index + 1);
        let mut truth = self.truth.clone();
        for (key, spread) in &self.spread {
            let factor = 1.0 + spread * random.between(-1.0, 1.0);
            if let Some(key) = key.strip_prefix("truth.") {
                if let Some(value) = truth.get_mut(key) {
                    *value *= factor;
                }
            } else if let Some(value) = bike.value(key) {
                bike = bike.with(key, legible(value * factor));
            }
        }
        let mut real = bike.clone();
        for (key, sd) in &bike.uncertainty {
            if let Some(value) = bike.value(key) {
                real = real.with(key, value + sd * random.normal());
            }
        }
        Machine { plant: plant(&real, &truth).with(&self.model_error), bike }
    }
}

/// Four significant digits: what somebody would write into a bike file.
fn legible(value: f64) -> f64 {
    if value == 0.0 {
        return value;
    }
    let unit = 10_f64.powi(3 - value.abs().log10().floor() as i32);
    (value * unit).round() / unit
}

fn truth_values(table: &toml::Table) -> Result<BTreeMap<String, f64>, KeyError> {
    let mut values: BTreeMap<String, f64> =
        TRUTH.iter().map(|(key, default, _)| ((*key).to_owned(), *default)).collect();
    let mut put = |key: String, value: &toml::Value| {
        let number = match value {
            toml::Value::Float(x) => *x,
            toml::Value::Integer(i) => *i as f64,
            _ => return Err(KeyError::Values(format!("[truth]: `{key}` must be a number"))),
        };
        match values.get_mut(&key) {
            Some(slot) => {
                *slot = number;
                Ok(())
            }
            None => {
                let near = closest(&key, TRUTH.iter().map(|(k, _, _)| *k));
                let hint = near.map(|n| format!("; did you mean `{n}`?")).unwrap_or_default();
                Err(KeyError::Values(format!("[truth]: unknown key `{key}`{hint}")))
            }
        }
    };
    for (key, value) in table {
        match value {
            toml::Value::Table(inner) => {
                for (leaf, value) in inner {
                    put(format!("{key}.{leaf}"), value)?;
                }
            }
            leaf => put(key.clone(), leaf)?,
        }
    }
    Ok(values)
}

/// The plant of a bike whose file is true, and of a truth.
fn plant(bike: &Bike, truth: &BTreeMap<String, f64>) -> Plant {
    let get = |key: &str| truth.get(key).copied().unwrap_or(f64::NAN);
    let crown_front = get("front.overturning_stiffness");
    let tyre = |axle: Axle| {
        let wheel = bike.wheel(axle);
        let end = axle.name();
        let get = |key: &str| truth.get(&format!("{end}.{key}")).copied();
        let value = |key: &str| get(key).unwrap_or(f64::NAN);
        let friction = MagicFormula {
            b: value("b"),
            c: value("c"),
            d: value("d"),
            e1: value("e1"),
            e2: get("e2").unwrap_or(0.0),
        };
        let ratio = wheel.side_force_ratio;
        let rolling_radius = wheel.radius * value("radius_ratio");
        Tyre {
            friction,
            // any c1 gives the same k_alpha: only c1 + C enters
            stiffness: Stiffness {
                ct: -value("cornering_stiffness") * ratio,
                c1: 0.0,
                c3: value("stiffness_decay") * ratio,
            },
            side_force_ratio: ratio,
            twisting_stiffness: wheel.twisting_stiffness,
            overturning_stiffness: match axle {
                Axle::Front => crown_front,
                Axle::Rear => crown_front * bike.rear.width / bike.front.width,
            },
            rolling_radius,
            rolling_resistance: truth["rolling_resistance"],
            relaxation_length: wheel.relaxation_length.unwrap_or(rolling_radius),
            vertical_stiffness: wheel.vertical_stiffness,
            camber_force_decay: wheel.camber_force_decay,
            camber_moment_decay: wheel.camber_moment_decay,
            reference_friction: 1.0,
            peak_slip: friction.peak_slip().unwrap_or(1.0),
            // the rides of the archive stay as they are: their side force has no limit yet
            lateral_peak: NO_LIMIT,
        }
    };
    let tyres = [tyre(Axle::Front), tyre(Axle::Rear)];
    let vehicle = Vehicle {
        roll_inertia: get("roll_inertia"),
        yaw_inertia: get("yaw_inertia"),
        wheel_inertia: [
            bike.front.wheel_inertia.unwrap_or(get("front_inertia")),
            bike.rear.wheel_inertia.unwrap_or(get("rear_inertia")),
        ],
        drag: get("drag"),
        brake_gain: [get("brake_gain_front"), get("brake_gain_rear")],
        deflection_share: get("deflection_share"),
        ..Vehicle::of(bike)
    };
    let load = vehicle.static_loads();
    // the overturning stiffness is the crown of the loaded tyre
    let crown =
        [0, 1].map(|k| tyres[k].overturning_stiffness + load[k] / tyres[k].vertical_stiffness);
    let (friction, model_error) = (get("friction"), ModelError::default());
    Plant { vehicle, tyres, crown, friction, model_error }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn builtin_scenarios_load_and_every_tyre_has_a_peak() {
        for (name, _) in BUILTIN {
            let scenario = Scenario::builtin(name).expect(name);
            for i in 0..scenario.fleet.bikes {
                let machine = scenario.machine(i);
                for tyre in machine.plant.tyres {
                    assert!(tyre.friction.peak_slip().is_some(), "{name} {i}: {tyre:?}");
                }
            }
        }
    }

    #[test]
    fn wrong_keys_are_named() {
        let text = BUILTIN[1].1.replace("[bike]", "[truth]\nfrontt.b = 2\n[bike]");
        let message = Scenario::parse(&text, "x").expect_err("unknown key").to_string();
        assert!(message.contains("frontt.b") && message.contains("front.b"), "{message}");
    }
}
