//! The bike file: what is known of the motorcycle before the ride.
//!
//! Keys, units, ranges and defaults are declared in `schemas/bike.v1.toml`. A number may be
//! given bare or, in the table `[uncertainty]` under the same key, with its standard
//! uncertainty, which the fits then pass on to every coefficient that depends on it:
//!
//! ```toml
//! mass = 260.0
//! [uncertainty]
//! mass = 2.0
//! ```
//!
//! A number that is given without one is exact. Of a number that is not given the schema says what
//! is taken instead and how far motorcycles differ from it ([`Prior`]): that is passed on too.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde::Deserialize;

use super::file_kind::FileKind;
use super::key_error::KeyError;
use super::schema::{Key, KeyTable, Removed};
use crate::GRAVITY;

/// Relaxation length of the slip ratio where the file gives none, m; as the schema says.
pub(crate) const USUAL_SLIP_LAG: f64 = 0.07;
/// Gain of slip stiffness per load with the load at rest once more where the file has none; as the schema says.
pub(crate) const USUAL_SLIP_STIFFNESS_LOAD: f64 = 0.2;
/// Spin inertia of the wheels where the file has none, front and rear, kg m²: 17 inch wheels with
/// tyre and disc; `assumed` in the schema.
pub(crate) const USUAL_WHEEL_INERTIA: [f64; 2] = [0.45, 0.60];
/// Trail where the file has none, m: `assumed` in the schema.
pub(crate) const USUAL_TRAIL: f64 = 0.1;
/// Yaw radius of gyration over the wheelbase where the file has no yaw inertia: usual for frames with rider.
const YAW_GYRATION: f64 = 0.235;

/// Name of the file, without its ending, that stands in for bikes that have none.
pub(crate) const DEFAULT: &str = "default";
/// Key that names the bike that the default file stands in for; the program puts it in.
pub(crate) const STANDS_IN_FOR: &str = "stands_in_for";

/// Errors of a bike file.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file is not there or cannot be read.
    #[error("cannot read bike file {path}: {source}")]
    Read {
        /// Path of the bike file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is not valid TOML.
    #[error("bike file {path} is not valid TOML: {message}")]
    Syntax {
        /// Path of the bike file.
        path: PathBuf,
        /// The parser's word, with line and column.
        message: String,
    },
    /// A key is missing, misspelt, of the wrong type or out of its physical range.
    #[error("bike file {path}: {source}")]
    Key {
        /// Path of the bike file.
        path: PathBuf,
        /// Error in the key, with its path in the file.
        source: KeyError,
    },
}

/// A number that the file does not give: what is taken instead, and how well that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// In the key's unit.
    pub value: f64,
    /// Standard deviation: the file's `[uncertainty]`, else the schema's, in the key's unit.
    pub sd: f64,
}

/// Known properties of one tyre before the ride. Symbols as in Bartolozzi et al. 2024.
#[derive(Debug, Clone, PartialEq)]
pub struct WheelData {
    /// Nominal rolling radius, m.
    pub radius: f64,
    /// Tyre width, m.
    pub width: f64,
    /// Tyre model, where the session does not say.
    pub model: Option<String>,
    /// Spin inertia, kg m², where given; see [`Bike::wheel_inertia`].
    pub wheel_inertia: Option<f64>,
    /// Camber-to-cornering stiffness ratio `C`.
    pub side_force_ratio: f64,
    /// Twisting torque coefficient `k_t`, m/rad.
    pub twisting_stiffness: f64,
    /// Vertical stiffness `K_z`, N/m.
    pub vertical_stiffness: f64,
    /// Share of the vertical deflection by which the rolling radius falls, where given; else about a
    /// third (`crate::tyre::tyre_model::USUAL_SHARE`).
    pub deflection_share: Option<f64>,
    /// Relaxation length of the slip ratio, m, where given; see [`Bike::longitudinal_relaxation`].
    pub longitudinal_relaxation: Option<f64>,
    /// Slip stiffness per load that is gained with the load at rest once more, over itself, where given; see
    /// [`Bike::slip_stiffness_load`].
    pub slip_stiffness_load: Option<f64>,
    /// Relaxation length, m; `None` means the wheel radius.
    pub relaxation_length: Option<f64>,
    /// `c_Fy_gamma` of eq. 15.
    pub camber_force_decay: f64,
    /// `c_Mz_gamma` of eq. 17.
    pub camber_moment_decay: f64,
}

/// Bike file of one motorcycle, checked. SI units.
///
/// The only type with optional keys, defaults and uncertainties: every other description of a motorcycle is made from
/// it, or drawn by a simulator.
#[derive(Debug, Clone, PartialEq)]
pub struct Bike {
    /// Id of the motorcycle: the file's name without extension.
    pub bike_id: String,
    /// Name in reports.
    pub name: Option<String>,
    /// Mass of motorcycle and rider, kg.
    pub mass: f64,
    /// Wheelbase `l`, m.
    pub wheelbase: f64,
    /// Centre of mass behind the front contact `l_f`, m.
    pub cg_to_front: f64,
    /// Height of the centre of mass `h_G`, m.
    pub cg_height: f64,
    /// Caster angle `epsilon`, rad.
    pub caster_angle: f64,
    /// Front wheel and tyre.
    pub front: WheelData,
    /// Rear wheel and tyre.
    pub rear: WheelData,
    /// Assumed drag, kg/m, where no coasting run gives it.
    pub drag: f64,
    /// Assumed rolling resistance coefficient.
    pub rolling_resistance: f64,
    /// Front brake torque per pressure, N m/Pa.
    pub brake_gain_front: Option<f64>,
    /// Rear brake torque per pressure, N m/Pa.
    pub brake_gain_rear: Option<f64>,
    /// Velocity reference point ahead of the centre of mass, m.
    pub velocity_sensor_x: f64,
    /// Velocity reference point above the centre of mass, m.
    pub velocity_sensor_z: f64,
    /// Standard uncertainty per key, in the key's unit.
    pub uncertainty: BTreeMap<String, f64>,
    /// Measured curves by key: pairs of abscissa and ordinate.
    pub curves: BTreeMap<String, Vec<[f64; 2]>>,
    /// Whether this is the folder's `default.toml`, for a bike that has no file of its own.
    pub stands_in: bool,
    /// Message about keys in the file that nothing reads any more.
    pub removed_keys: Vec<String>,
    keys: BTreeMap<String, f64>,
    /// Of keys that the file does not have. Apart from `uncertainty`: simulations draw the truth
    /// around that, and a default is none of theirs.
    prior: BTreeMap<String, Prior>,
}

/// The declaration of every key; parsed once.
pub fn schema() -> &'static KeyTable {
    static KEYS: OnceLock<KeyTable> = OnceLock::new();
    KEYS.get_or_init(|| KeyTable::embedded("bike"))
}

impl Bike {
    /// Checks the text of a bike file; `path` is for messages only.
    ///
    /// # Errors
    /// It is not TOML, or a key is missing, misspelt or out of range; the message names the key.
    pub fn parse(text: &str, bike_id: &str, path: &Path) -> Result<Self, Error> {
        let mut table: toml::Table = text.parse().map_err(|e: toml::de::Error| Error::Syntax {
            path: path.to_owned(),
            message: e.to_string(),
        })?;
        let fail = |source: KeyError| Error::Key { path: path.to_owned(), source };
        FileKind::Bike.expect(text).map_err(fail)?;
        let mut uncertainty = match table.remove("uncertainty") {
            None => toml::Table::new(),
            Some(toml::Value::Table(t)) => t,
            Some(_) => {
                let (path, wanted) = ("uncertainty".to_owned(), "a table".to_owned());
                return Err(fail(KeyError::Type { path, wanted }));
            }
        };
        let schema = schema();
        // nobody edits the files of an old archive: what changes nothing is passed by, and said
        let removed: BTreeSet<String> = [&mut table, &mut uncertainty]
            .into_iter()
            .flat_map(|table| schema.take_removed(table))
            .map(Removed::message)
            .collect();
        let values = schema.check(&table).map_err(fail)?;
        let uncertainty = schema.check_uncertainty(&uncertainty).map_err(fail)?;
        if let Some(linkage) = values.curve.get("offroad.linkage")
            && let Some(k) = linkage.windows(2).position(|w| w[1][1] <= w[0][1])
        {
            return Err(fail(KeyError::Values(format!(
                "`offroad.linkage` is not monotonic: row {} says {} rad at {} m after {} rad at {} m; \
                 the swing arm must rise with the shock's travel",
                k + 2,
                linkage[k + 1][1],
                linkage[k + 1][0],
                linkage[k][1],
                linkage[k][0]
            ))));
        }
        let stands_in = values.text.contains_key(STANDS_IN_FOR);
        let mut bike = Self::assemble(bike_id, values.text, values.number, uncertainty);
        bike.stands_in = stands_in;
        bike.removed_keys = removed.into_iter().collect();
        bike.curves = values.curve;
        bike.prior = bike.priors(schema, &values.defaulted);
        if bike.cg_to_front >= bike.wheelbase {
            return Err(fail(KeyError::Values(format!(
                "`cg_to_front` = {} m lies behind the rear contact (`wheelbase` = {} m)",
                bike.cg_to_front, bike.wheelbase
            ))));
        }
        Ok(bike)
    }

    /// The same bike with one numeric key changed: how uncertainty of the bike file is passed on.
    pub fn with(&self, key: &str, value: f64) -> Self {
        let (mut keys, mut prior) = (self.keys.clone(), self.prior.clone());
        keys.insert(key.to_owned(), value);
        prior.remove(key);
        let mut text = BTreeMap::new();
        for (k, v) in [
            ("name", &self.name),
            ("front.model", &self.front.model),
            ("rear.model", &self.rear.model),
        ] {
            if let Some(v) = v {
                text.insert(k.to_owned(), v.clone());
            }
        }
        let bike = Self::assemble(&self.bike_id, text, keys, self.uncertainty.clone());
        let removed_keys = self.removed_keys.clone();
        let stands_in = self.stands_in;
        Bike { curves: self.curves.clone(), prior, stands_in, removed_keys, ..bike }
    }

    /// The same bike with one numeric key known anew: varied by its standard deviation, and missing where it was.
    #[must_use]
    pub fn known(&self, key: &str, value: f64, sd: f64) -> Self {
        let mut bike = self.with(key, value);
        if self.prior.contains_key(key) {
            bike.prior.insert(key.to_owned(), Prior { value, sd });
        }
        bike.uncertainty.insert(key.to_owned(), sd);
        bike
    }

    /// Standard deviation of a numeric key, given or a default's; nothing of what is exact.
    pub fn deviation(&self, key: &str) -> f64 {
        let prior = self.prior.get(key).map(|prior| prior.sd);
        prior.or_else(|| self.uncertainty.get(key).copied()).unwrap_or(0.0)
    }

    /// To be called once numbers of the wheels were changed in place: [`Bike::with`] starts from the
    /// keys, and what is not given is varied from where it is now.
    pub fn sync_keys(&mut self) {
        for axle in Axle::BOTH {
            let wheel = self.wheel(axle);
            let numbers = [
                ("side_force_ratio", Some(wheel.side_force_ratio)),
                ("twisting_stiffness", Some(wheel.twisting_stiffness)),
                ("wheel_inertia", wheel.wheel_inertia),
                ("relaxation_length", wheel.relaxation_length),
            ];
            for (leaf, number) in numbers {
                let Some(value) = number else { continue };
                let key = format!("{}.{leaf}", axle.name());
                if let Some(prior) = self.prior.get_mut(&key) {
                    prior.value = value;
                }
                self.keys.insert(key, value);
            }
        }
    }

    /// The same bike with every number exact.
    #[must_use]
    pub fn certain(mut self) -> Self {
        self.uncertainty.clear();
        self.prior.clear();
        self
    }

    /// Priors of the keys that the file does not have, by key; only of keys that the schema
    /// gives an uncertainty.
    pub fn priors_of_missing(&self) -> &BTreeMap<String, Prior> {
        &self.prior
    }

    /// See [`Bike::priors_of_missing`].
    fn priors(&self, schema: &KeyTable, defaulted: &BTreeSet<String>) -> BTreeMap<String, Prior> {
        let missing =
            |key: &&Key| defaulted.contains(&key.path) || !self.keys.contains_key(&key.path);
        let prior = |key: &Key| {
            let value = key.default.or(key.assumed).or_else(|| self.rule(&key.path))?;
            let relative = key.default_relative_uncertainty.map(|share| share * value);
            let width = key.default_uncertainty.or(relative)?;
            let sd = self.uncertainty.get(&key.path).copied().unwrap_or(width);
            Some((key.path.clone(), Prior { value, sd }))
        };
        schema.keys.iter().filter(missing).filter_map(prior).collect()
    }

    /// A key that follows from others where the file does not have it.
    fn rule(&self, key: &str) -> Option<f64> {
        match key {
            "yaw_inertia" => Some(self.yaw_inertia()),
            "front.relaxation_length" => Some(self.front.radius),
            "rear.relaxation_length" => Some(self.rear.radius),
            _ => None,
        }
    }

    /// Spin inertia of a wheel, kg m²: the file's, or a usual one. A wheel without inertia is none.
    pub fn wheel_inertia(&self, axle: Axle) -> f64 {
        self.wheel(axle).wheel_inertia.unwrap_or(USUAL_WHEEL_INERTIA[axle as usize])
    }

    /// Relaxation length of a wheel's slip ratio, m: the file's, or a usual one.
    pub fn longitudinal_relaxation(&self, axle: Axle) -> f64 {
        self.wheel(axle).longitudinal_relaxation.unwrap_or(USUAL_SLIP_LAG)
    }

    /// Relative gain of a tyre's slip stiffness per load when the load rises by the load at rest, over itself: the file's, or a
    /// usual one.
    pub fn slip_stiffness_load(&self, axle: Axle) -> f64 {
        self.wheel(axle).slip_stiffness_load.unwrap_or(USUAL_SLIP_STIFFNESS_LOAD)
    }

    /// Load of a wheel at rest, N.
    pub fn static_load(&self, axle: Axle) -> f64 {
        let arm = match axle {
            Axle::Front => self.cg_to_rear(),
            Axle::Rear => self.cg_to_front,
        };
        self.mass * GRAVITY * arm / self.wheelbase
    }

    /// A numeric key's value, given or default.
    pub fn value(&self, key: &str) -> Option<f64> {
        self.keys.get(key).copied()
    }

    /// Yaw inertia about the centre of mass, kg m²: the file's, or that of a radius of gyration of
    /// 0.235 wheelbases, usual for frames with rider. It matters while turning in and out. The fit to changing lean has a start
    /// of its own, 0.27 with an uncertainty, as it can move it.
    pub fn yaw_inertia(&self) -> f64 {
        let usual = || self.mass * (YAW_GYRATION * self.wheelbase).powi(2);
        self.value("yaw_inertia").unwrap_or_else(usual)
    }

    /// How far the front contact leaves the frame's plane per sine of the handlebar angle, m: the
    /// trail square to the steering axis, of the file's trail or a usual one.
    pub fn normal_trail(&self) -> f64 {
        self.value("trail").unwrap_or(USUAL_TRAIL) * self.caster_angle.cos()
    }

    /// Distance of the centre of mass from the rear contact `l_r`, m.
    pub fn cg_to_rear(&self) -> f64 {
        self.wheelbase - self.cg_to_front
    }

    /// The bike as a bike file, for simulated archives.
    pub fn to_toml(&self) -> String {
        let mut root = toml::Table::new();
        let mut put = |key: &str, value: toml::Value| {
            let (table, leaf) = match key.split_once('.') {
                None => (&mut root, key),
                Some((head, leaf)) => {
                    let entry =
                        root.entry(head).or_insert_with(|| toml::Value::Table(toml::Table::new()));
                    match entry {
                        toml::Value::Table(t) => (t, leaf),
                        _ => return,
                    }
                }
            };
            table.insert(leaf.to_owned(), value);
        };
        if let Some(name) = &self.name {
            put("name", toml::Value::String(name.clone()));
        }
        for (key, model) in [("front.model", &self.front.model), ("rear.model", &self.rear.model)] {
            if let Some(model) = model {
                put(key, toml::Value::String(model.clone()));
            }
        }
        for (key, value) in &self.keys {
            if key.starts_with("offroad.") && self.curves.is_empty() {
                continue; // defaults of a bike that has no such suspension
            }
            put(key, toml::Value::Float(*value));
        }
        for (key, rows) in &self.curves {
            let pair = |row: &[f64; 2]| toml::Value::Array(row.map(toml::Value::Float).to_vec());
            put(key, toml::Value::Array(rows.iter().map(pair).collect()));
        }
        let uncertainty: toml::Table =
            self.uncertainty.iter().map(|(k, v)| (k.clone(), toml::Value::Float(*v))).collect();
        let mut text = root.to_string();
        if !uncertainty.is_empty() {
            // dotted keys are quoted by the writer, and read back as one flat key
            text.push_str("\n[uncertainty]\n");
            text.push_str(&uncertainty.to_string());
        }
        text
    }

    fn assemble(
        bike_id: &str,
        mut text: BTreeMap<String, String>,
        keys: BTreeMap<String, f64>,
        uncertainty: BTreeMap<String, f64>,
    ) -> Self {
        // `schema.check` has put in every required key and every default
        let get = |key: &str| keys.get(key).copied().unwrap_or(f64::NAN);
        let opt = |key: &str| keys.get(key).copied();
        let mut wheel = |end: &str| WheelData {
            radius: get(&format!("{end}.radius")),
            width: get(&format!("{end}.width")),
            model: text.remove(&format!("{end}.model")),
            wheel_inertia: opt(&format!("{end}.wheel_inertia")),
            side_force_ratio: get(&format!("{end}.side_force_ratio")),
            twisting_stiffness: get(&format!("{end}.twisting_stiffness")),
            vertical_stiffness: get(&format!("{end}.vertical_stiffness")),
            deflection_share: opt(&format!("{end}.deflection_share")),
            longitudinal_relaxation: opt(&format!("{end}.longitudinal_relaxation")),
            slip_stiffness_load: opt(&format!("{end}.slip_stiffness_load")),
            relaxation_length: opt(&format!("{end}.relaxation_length")),
            camber_force_decay: get(&format!("{end}.camber_force_decay")),
            camber_moment_decay: get(&format!("{end}.camber_moment_decay")),
        };
        let (front, rear) = (wheel("front"), wheel("rear"));
        Bike {
            bike_id: bike_id.to_owned(),
            name: text.remove("name"),
            mass: get("mass"),
            wheelbase: get("wheelbase"),
            cg_to_front: get("cg_to_front"),
            cg_height: get("cg_height"),
            caster_angle: get("caster_angle"),
            front,
            rear,
            drag: get("aerodynamics.drag"),
            rolling_resistance: get("aerodynamics.rolling_resistance"),
            brake_gain_front: opt("brakes.gain_front"),
            brake_gain_rear: opt("brakes.gain_rear"),
            velocity_sensor_x: get("sensors.velocity_x"),
            velocity_sensor_z: get("sensors.velocity_z"),
            uncertainty,
            curves: BTreeMap::new(),
            stands_in: false,
            removed_keys: Vec::new(),
            keys,
            prior: BTreeMap::new(),
        }
    }
}

/// Which end of the bike.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axle {
    /// Front wheel and tyre.
    Front,
    /// Rear wheel and tyre.
    Rear,
}

impl Axle {
    /// Both, front first.
    pub const BOTH: [Axle; 2] = [Axle::Front, Axle::Rear];

    /// `front` or `rear`, as in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Axle::Front => "front",
            Axle::Rear => "rear",
        }
    }
}

impl Bike {
    /// Wheel and tyre of one end.
    pub fn wheel(&self, axle: Axle) -> &WheelData {
        match axle {
            Axle::Front => &self.front,
            Axle::Rear => &self.rear,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHORT: &str = "mass = 260.0\nwheelbase = 1.4\ncg_to_front = 0.7\ncg_height = 0.6\n\
        caster_angle = 0.42\nfront.radius = 0.3\nfront.width = 0.12\nrear.radius = 0.31\n\
        rear.width = 0.18\n";

    fn bike(more: &str) -> Bike {
        Bike::parse(&format!("{SHORT}{more}"), "b", Path::new("b.toml")).expect("a bike file")
    }

    #[test]
    fn what_is_not_given_has_an_uncertainty_apart_from_the_files() {
        let bike = bike("");
        assert!(bike.uncertainty.is_empty());
        let prior = bike.priors_of_missing();
        let of = |key: &str| (prior[key].value, prior[key].sd);
        assert_eq!(of("front.side_force_ratio"), (0.095, 0.0475));
        assert_eq!(of("front.wheel_inertia"), (USUAL_WHEEL_INERTIA[0], 0.135));
        assert_eq!(of("rear.wheel_inertia"), (USUAL_WHEEL_INERTIA[1], 0.18));
        assert_eq!(of("trail").0, USUAL_TRAIL);
        assert_eq!(of("yaw_inertia").0, bike.yaw_inertia());
        let (length, sd) = of("rear.relaxation_length");
        assert!(length == 0.31 && (sd - 0.425 * 0.31).abs() < 1e-12, "{sd}");
        assert!(!prior.contains_key("mass"));
        // and a bike file that is written says nothing of them
        assert!(!bike.to_toml().contains("wheel_inertia") && !bike.to_toml().contains("trail"));
    }

    #[test]
    fn what_was_changed_in_place_stays_when_another_number_moves() {
        let mut bike = bike("");
        bike.rear.side_force_ratio = 0.06;
        bike.rear.wheel_inertia = Some(0.7);
        bike.sync_keys();
        let moved = bike.with("mass", 262.0);
        assert_eq!((moved.rear.side_force_ratio, moved.rear.wheel_inertia), (0.06, Some(0.7)));
        assert_eq!(moved.front, bike.front);
        assert_eq!(bike.priors_of_missing()["rear.wheel_inertia"].value, 0.7);
    }

    #[test]
    fn what_is_given_is_exact_and_an_uncertainty_of_the_file_counts() {
        let bike = bike(
            "front.wheel_inertia = 0.5\n[uncertainty]\n\"rear.wheel_inertia\" = 0.1\n\
             \"front.side_force_ratio\" = 0.02\n",
        );
        let prior = bike.priors_of_missing();
        assert!(!prior.contains_key("front.wheel_inertia"));
        assert_eq!(prior["rear.wheel_inertia"].sd, 0.1);
        assert_eq!(prior["front.side_force_ratio"].sd, 0.02);
        assert!(!bike.with("rear.wheel_inertia", 0.7).prior.contains_key("rear.wheel_inertia"));
        assert!(bike.certain().prior.is_empty());
    }
}
