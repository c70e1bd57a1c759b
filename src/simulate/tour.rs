//! A scenario for the nonlinear motorcycle: which machine, on what road, doing what, seen by
//! which sensors.
//!
//! ```toml
//! name = "lane_change"
//! description = "..."
//! motorcycle = "sports_touring"       # built in, or a motorcycle file
//! manoeuvres = [{ kind = "lane_change", ... }]
//! [road]
//! friction = 0.75
//! ```

use std::path::Path;

use serde::Deserialize;

use super::builtin::{self, text_with_key};
use super::imu::Imu;
use super::manoeuvre::Manoeuvre;
use super::odd_manoeuvre::{self, OddManoeuvre};
use super::rider::Disturbance;
use super::sensors::Sensors;
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::file_error::{FileError, FileName};
use crate::contract::schema::{KeyTable, refuse_infinite};
use crate::simulate::effects::ModelError;
use crate::simulate::effects::tyre_file;
use crate::simulate::multibody::{Model, Motorcycle, Road};
use crate::tyre::tyre_model::TyreModel;

/// Built-in rides by name.
pub(crate) const BUILTIN: builtin::List = builtin::TOURS;

/// Settings that are not numbers; numbers are in `schemas/ride.v1.toml` with their ranges.
#[derive(Debug, Deserialize)]
struct File {
    name: String,
    description: String,
    #[serde(default)]
    float32: bool,
    #[serde(default)]
    drop: Vec<String>,
    motorcycle: String,
    front_tyre: Option<String>,
    rear_tyre: Option<String>,
    manoeuvres: Vec<Manoeuvre>,
    #[serde(default)]
    odd_manoeuvres: Vec<OddManoeuvre>,
    #[serde(default)]
    road: Road,
    #[serde(default)]
    wind: [f64; 2],
    /// Keys of the bike file that differ from the machine.
    #[serde(default)]
    belief: toml::Table,
    #[serde(default)]
    sensors: Sensors,
    imu: Option<Imu>,
}

/// A checked scenario, ready to ride.
#[derive(Debug, Clone)]
pub struct Tour {
    /// Name: the start of the session ids.
    pub name: String,
    /// Purpose, in words.
    pub description: String,
    pub seed: u64,
    /// Of the log, Hz.
    pub rate: f64,
    /// Longest integration step, s.
    pub step: f64,
    /// Whether the log is written in single precision.
    pub float32: bool,
    /// Channels that the logger does not have.
    pub drop: Vec<Channel>,
    pub sessions: usize,
    /// Speed at the start, m/s; zero stands on its feet.
    pub start_speed: f64,
    pub manoeuvres: Vec<Manoeuvre>,
    /// Wind in road axes, m/s.
    pub wind: [f64; 2],
    /// Errors by channel.
    pub sensors: Sensors,
    /// The inertial unit; `None` is a perfect one.
    pub imu: Option<Imu>,
    /// Effects of brakes and sensors beyond that; tyres, road and air have theirs in them.
    pub model_error: ModelError,
    /// Unsteadiness of rider, pads and air.
    pub disturbance: Disturbance,
    /// Manoeuvres that are not as the others of their ride.
    pub odd_manoeuvres: Vec<OddManoeuvre>,
    /// The motorcycle on its road.
    pub model: Model,
    /// The analyst's bike file.
    pub bike: Bike,
}

impl Tour {
    /// A built-in ride by name, or a scenario file; `None` when it is a scenario of the
    /// reduced-order motorcycle.
    ///
    /// # Errors
    /// Error text that names file and key.
    pub fn load(name_or_path: &str) -> Result<Option<Self>, FileError> {
        let found = text_with_key(BUILTIN, name_or_path, "motorcycle");
        found.map(|(text, path)| Self::parse(&text, &path)).transpose()
    }

    /// Checks a scenario's text; motorcycle and tyre files are looked for beside `path`.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn parse(text: &str, path: &Path) -> Result<Self, FileError> {
        let file = FileName::new("scenario", path.display());
        let table: toml::Table =
            text.parse().map_err(|e: toml::de::Error| file.wrong(e.to_string()))?;
        refuse_infinite(&table).map_err(|e| file.wrong(e))?;
        let values = KeyTable::embedded("ride").check(&table).map_err(|e| file.wrong(e))?;
        let number = |key: &str| values.number.get(key).copied().unwrap_or(f64::NAN);
        let given: File = toml::from_str(text).map_err(|e| file.wrong(e.to_string()))?;
        if given.manoeuvres.is_empty() {
            return Err(file.wrong("`manoeuvres` is empty"));
        }
        for manoeuvre in &given.manoeuvres {
            manoeuvre.check().map_err(|e| file.wrong(e))?;
        }
        odd_manoeuvre::check(&given.odd_manoeuvres)
            .map_err(|e| file.wrong(format!("[[odd_manoeuvres]]: {e}")))?;
        given.road.check().map_err(|e| file.wrong(e))?;
        let channel = |name: &String| Channel::named(name).map_err(|e| file.wrong(e));
        let drop = given.drop.iter().map(channel).collect::<Result<_, _>>()?;
        for name in given.sensors.keys() {
            channel(name)?;
        }
        let beside = |name: &str| {
            let near = path.parent().unwrap_or(Path::new("")).join(name);
            if near.is_file() { near.to_string_lossy().into_owned() } else { name.to_owned() }
        };
        let mut motorcycle =
            Motorcycle::load(&beside(&given.motorcycle)).map_err(|e| file.wrong(e.to_string()))?;
        let tyre = |name: &Option<String>| match name {
            None => Ok(None),
            Some(name) => {
                tyre_file::load(&beside(name)).map(Some).map_err(|e| file.wrong(e.to_string()))
            }
        };
        let (front, rear) = (tyre(&given.front_tyre)?, tyre(&given.rear_tyre)?);
        let Some(own) = motorcycle.tyres.clone() else {
            return Err(file.wrong(format!("motorcycle `{}` has no tyres", motorcycle.id)));
        };
        let [own_front, own_rear] = own;
        motorcycle = motorcycle.with_tyres(front.unwrap_or(own_front), rear.unwrap_or(own_rear));
        let bike = believed(&motorcycle, &given.belief).map_err(|e| file.wrong(e))?;
        Ok(Tour {
            name: given.name,
            description: given.description,
            seed: number("seed") as u64,
            rate: number("rate"),
            step: number("step"),
            float32: given.float32,
            drop,
            sessions: number("sessions") as usize,
            start_speed: number("start_speed"),
            manoeuvres: given.manoeuvres,
            wind: given.wind,
            sensors: given.sensors,
            imu: given.imu,
            model_error: ModelError::default(),
            disturbance: Disturbance::default(),
            odd_manoeuvres: given.odd_manoeuvres,
            bike,
            model: Model::new(motorcycle, given.road),
        })
    }
}

impl Tour {
    /// Puts other tyres on.
    pub fn fit(&mut self, front: Option<Box<dyn TyreModel>>, rear: Option<Box<dyn TyreModel>>) {
        let Some([own_front, own_rear]) = self.model.motorcycle.tyres.clone() else { return };
        let motorcycle =
            self.model.motorcycle.with_tyres(front.unwrap_or(own_front), rear.unwrap_or(own_rear));
        self.model = Model::new(motorcycle, self.model.road.clone());
    }
}

/// The bike file of a motorcycle: what can be weighed and measured of it, and `[belief]`.
pub(super) fn believed(
    motorcycle: &Motorcycle,
    belief: &toml::Table,
) -> Result<Bike, crate::contract::bike::Error> {
    let m = motorcycle;
    let centre = m.centre();
    let mut table = toml::Table::new();
    let number = |x: f64| toml::Value::Float((x * 1e4).round() / 1e4);
    table.insert("name".into(), toml::Value::String(m.name.clone()));
    table.insert("mass".into(), number(m.mass()));
    table.insert("wheelbase".into(), number(m.wheelbase()));
    table.insert("cg_to_front".into(), number(m.centres[0].x - centre.x));
    table.insert("cg_height".into(), number(centre.z));
    table.insert("caster_angle".into(), number(m.caster_angle));
    table.insert("trail".into(), number(m.trail()));
    table.insert("yaw_inertia".into(), number(m.inertia()[(2, 2)]));
    for (i, end) in ["front", "rear"].into_iter().enumerate() {
        let mut wheel = toml::Table::new();
        if let Some(tyres) = &m.tyres {
            let carcass = tyres[i].carcass();
            wheel.insert("radius".into(), number(carcass.radius));
            wheel.insert("width".into(), number((2.0 * carcass.crown).max(0.03)));
            wheel.insert("vertical_stiffness".into(), number(carcass.stiffness));
            wheel.insert("deflection_share".into(), number(carcass.deflection_share));
        }
        wheel.insert("wheel_inertia".into(), number(m.wheels[i].about_origin[(1, 1)]));
        table.insert(end.into(), toml::Value::Table(wheel));
    }
    let mut brakes = toml::Table::new();
    for (i, key) in ["gain_front", "gain_rear"].into_iter().enumerate() {
        brakes.insert(key.into(), toml::Value::Float(m.brake_gain[i]));
    }
    table.insert("brakes".into(), toml::Value::Table(brakes));
    merge(&mut table, belief);
    Bike::parse(&table.to_string(), &m.id, Path::new("[belief]"))
}

/// Lays one table over another.
fn merge(below: &mut toml::Table, above: &toml::Table) {
    for (key, value) in above {
        match (below.get_mut(key), value) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(over)) => merge(inner, over),
            _ => {
                below.insert(key.clone(), value.clone());
            }
        }
    }
}
