//! A scenario of the track: how many sessions, on which machines, seen by which sensors and loggers.
//!
//! ```toml
//! name = "track"
//! description = "..."
//! laps = 4                    # the key by which this kind of scenario is known
//! loggers = ["superbike"]
//! ```

use std::path::Path;

use serde::Deserialize;

use super::circuit::{Circuit, SMOOTHING};
use super::drivetrain::Drivetrain;
use super::rider::Pace;
use crate::GRAVITY;
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::file_error::{FileError, FileName};
use crate::contract::schema::refuse_infinite_in;
use crate::simulate::builtin::{self, text_with_key};
use crate::simulate::effects::ModelError;
use crate::simulate::error::Error;
use crate::simulate::imu::Imu;
use crate::simulate::loggers::profile::Profile;
use crate::simulate::multibody::road::Wave;
use crate::simulate::multibody::{Model, Motorcycle, Road};
use crate::simulate::population::DrawnMachine;
use crate::simulate::population::bike::{BikeFile, bike};
use crate::simulate::rider::Disturbance;
use crate::simulate::sensors::Sensors;
use crate::simulate::tour;
use crate::simulate::tyre_truth::bench;
use crate::statistics::random::Random;

/// Built-in tracks by name.
pub(crate) const BUILTIN: builtin::List = builtin::TRACKS;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    description: String,
    laps: usize,
    #[serde(default)]
    fade: f64,
    #[serde(default = "one")]
    sessions: usize,
    #[serde(default)]
    seed: u64,
    #[serde(default = "hundred")]
    rate: f64,
    #[serde(default)]
    float32: bool,
    #[serde(default)]
    drop: Vec<String>,
    #[serde(default = "sports")]
    motorcycle: String,
    #[serde(default)]
    varied: bool,
    #[serde(default = "usual_friction")]
    friction: [f64; 2],
    #[serde(default)]
    grade: [f64; 2],
    #[serde(default)]
    wind: [f64; 2],
    #[serde(default)]
    unevenness: [f64; 2],
    #[serde(default)]
    varied_circuit: bool,
    #[serde(default = "usual_smoothing")]
    smoothing: f64,
    #[serde(default)]
    disturbance: Disturbance,
    #[serde(default)]
    sensors: Sensors,
    imu: Option<Imu>,
    #[serde(default)]
    loggers: Vec<Profile>,
    #[serde(default)]
    belief: toml::Table,
}

fn one() -> usize {
    1
}
fn hundred() -> f64 {
    100.0
}
fn sports() -> String {
    "sports_small".to_owned()
}
fn usual_smoothing() -> f64 {
    SMOOTHING
}
fn usual_friction() -> [f64; 2] {
    [1.3, 1.45]
}

#[derive(Debug, Clone)]
pub struct Track {
    /// Name: the start of the session ids.
    pub name: String,
    /// Purpose, in words.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub description: String,
    /// Sessions; each has a machine of its own where they are varied.
    pub sessions: usize,
    pub laps: usize,
    /// Share of the tyres' horizontal forces that is gone at the end of a session; it goes evenly.
    pub fade: f64,
    pub seed: u64,
    /// Of the contract's log, Hz.
    pub rate: f64,
    /// Whether that is written in single precision.
    pub float32: bool,
    /// Channels that it leaves out.
    pub drop: Vec<Channel>,
    /// Whether machines after the first session's are drawn.
    pub varied: bool,
    /// Peak friction of the weaker tyre on this road, drawn between.
    pub friction: [f64; 2],
    /// Steepest slope, drawn between, rise over run.
    pub grade: [f64; 2],
    /// Wind speed, drawn between, m/s; it blows from anywhere.
    pub wind: [f64; 2],
    /// Unevenness of the road, drawn between: the density of its spectrum at 0.1 cycles/m, 1e-6 m³ (ISO 8608; a very
    /// good road has 16).
    pub unevenness: [f64; 2],
    /// Whether sessions after the first have circuits of their own.
    pub varied_circuit: bool,
    /// Width over which the corners of the line are smoothed, m.
    pub smoothing: f64,
    /// Gusts, pads that bite anew and a rider who trembles.
    pub disturbance: Disturbance,
    /// Errors by channel of the contract's log.
    pub sensors: Sensors,
    /// Its inertial unit; `None` is a perfect one.
    pub imu: Option<Imu>,
    /// Which foreign loggers are on board.
    pub loggers: Vec<Profile>,
    /// The motorcycle of the first session, and of all where they do not vary.
    pub own: Motorcycle,
    /// Keys of its bike file beside what can be weighed and measured; drawn machines have files of their own.
    pub belief: toml::Table,
}

/// A machine on the track: everything that one session is ridden with.
#[derive(Debug, Clone)]
pub struct Entry {
    /// The motorcycle on its road.
    pub model: Model,
    /// The analyst's bike file.
    pub bike: Bike,
    /// Engine and gears.
    pub drivetrain: Drivetrain,
    pub circuit: Circuit,
    /// Pace of the rider.
    pub pace: Pace,
    /// Wind in road axes, m/s.
    pub wind: [f64; 2],
    /// Steepest slope.
    pub grade: f64,
    /// Unsteadiness of rider, pads and air.
    pub disturbance: Disturbance,
}

impl Track {
    /// A built-in track by name, or a scenario file; `None` when it is a scenario of another kind.
    ///
    /// # Errors
    /// Error text that names file and key.
    pub fn load(name_or_path: &str) -> Result<Option<Self>, FileError> {
        let found = text_with_key(BUILTIN, name_or_path, "laps");
        found.map(|(text, path)| Self::parse(&text, &path)).transpose()
    }

    /// Checks a scenario's text; `path` is for messages.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn parse(text: &str, path: &Path) -> Result<Self, FileError> {
        let file = FileName::new("scenario", path.display());
        refuse_infinite_in(text).map_err(|e| file.wrong(e))?;
        let given: File = toml::from_str(text)
            .map_err(|e| file.wrong(crate::contract::schema::with_hint(&e.to_string())))?;
        let within = |name: &str, x: f64, low: f64, high: f64| {
            let ok = (low..=high).contains(&x);
            if ok {
                Ok(())
            } else {
                Err(file.wrong(format!("`{name}` = {x} is not between {low} and {high}")))
            }
        };
        within("laps", given.laps as f64, 1.0, 100.0)?;
        within("fade", given.fade, -0.5, 0.5)?;
        within("smoothing", given.smoothing, 3.0, 40.0)?;
        within("sessions", given.sessions as f64, 1.0, 100_000.0)?;
        within("rate", given.rate, 50.0, 500.0)?;
        for (name, range, [low, high]) in [
            ("friction", given.friction, [1.0, 1.8]),
            ("grade", given.grade, [0.0, 0.08]),
            ("wind", given.wind, [0.0, 12.0]),
            ("unevenness", given.unevenness, [0.0, 64.0]),
        ] {
            within(name, range[0], low, high)?;
            within(name, range[1], range[0], high)?;
        }
        let channel = |name: &String| Channel::named(name).map_err(|e| file.wrong(e));
        let drop = given.drop.iter().map(channel).collect::<Result<_, _>>()?;
        for name in given.sensors.keys() {
            channel(name)?;
        }
        let own = Motorcycle::load(&given.motorcycle).map_err(|e| file.wrong(e.to_string()))?;
        if own.tyres.is_none() {
            return Err(file.wrong(format!("motorcycle `{}` has no tyres", own.id)));
        }
        tour::believed(&own, &given.belief).map_err(|e| file.wrong(e))?;
        Ok(Track {
            name: given.name,
            description: given.description,
            sessions: given.sessions,
            laps: given.laps,
            fade: given.fade,
            seed: given.seed,
            rate: given.rate,
            float32: given.float32,
            drop,
            varied: given.varied,
            friction: given.friction,
            grade: given.grade,
            wind: given.wind,
            unevenness: given.unevenness,
            varied_circuit: given.varied_circuit,
            smoothing: given.smoothing,
            disturbance: given.disturbance,
            sensors: given.sensors,
            imu: given.imu,
            loggers: given.loggers,
            own,
            belief: given.belief,
        })
    }

    /// Machine and settings of the session of a number; another `attempt` has another machine, if they vary, and a
    /// rider who dares less.
    ///
    /// # Errors
    /// The machine cannot stand; a sentence that says why.
    pub fn entry(&self, number: usize, attempt: usize) -> Result<Entry, Error> {
        let mut random = Random::new(self.seed, &format!("{} entry {number} {attempt}", self.name));
        let r = &mut random;
        let drawn = self.varied && number > 0;
        let (mut motorcycle, mut bike, disturbance) = if drawn {
            let machine = DrawnMachine::draw(self.seed, number, attempt)?;
            let motorcycle = machine.motorcycle(&ModelError::default())?;
            let bike = bike(&machine, &motorcycle, BikeFile::Full)?;
            (motorcycle, bike, machine.disturbance)
        } else {
            let bike = tour::believed(&self.own, &self.belief)?;
            (self.own.clone(), bike, self.disturbance)
        };
        bike.bike_id = format!("{}_{:02}", self.name, if self.varied { number + 1 } else { 1 });
        // engines of half a litre to a litre and a bit; in front for what is drawn, a litre else
        let size = if drawn { r.between(0.8, 1.25) } else { 1.15 };
        motorcycle.engine_torque = 95.0 * size;
        let drivetrain = Drivetrain::of(
            &motorcycle,
            if drawn { r.between(3.0, 9.0) } else { 6.0 },
            if drawn { r.between(1.2, 2.2) } else { 1.7 },
            if drawn { r.between(0.012, 0.025) } else { 0.02 },
        );
        let peak = r.between(self.friction[0], self.friction[1]);
        let loads = motorcycle.static_loads();
        let weaker = |m: &Motorcycle| {
            let tyres = m.tyres.as_ref();
            tyres.map_or(1.0, |t| {
                let of = |k: usize| bench(t[k].as_ref(), loads[k], 1.0).peak_friction;
                of(0).min(of(1))
            })
        };
        let grade = r.between(self.grade[0], self.grade[1]);
        let (blow, from) =
            (r.between(self.wind[0], self.wind[1]), r.between(0.0, std::f64::consts::TAU));
        // leans of 45 to 55 degrees and four fifths of the grip; less after a fall, much less after the fourth
        let calm = 0.95_f64.powi(attempt as i32) * 0.88_f64.powi(attempt as i32 - 3).min(1.0);
        let daring = calm * r.between(0.95, 1.0);
        let lateral = (0.80 * peak).min(1.08) * GRAVITY * daring;
        let centre = motorcycle.centre();
        // what the front wheel can brake before the rear one lifts
        let ahead = motorcycle.wheelbase() - centre.x;
        let lifts = ahead / centre.z * GRAVITY;
        let wheelie = centre.x / centre.z * GRAVITY;
        let pace = Pace {
            lateral,
            brake: (0.92 * lifts).min(0.78 * peak * GRAVITY).min(10.0) * daring,
            drive: (0.42 * wheelie).min(4.2) * daring,
            fastest: 62.0,
        };
        // a stream of its own: what it draws changes nothing above
        let mut random = Random::new(self.seed, &format!("{} road {number}", self.name));
        let circuit = match self.varied_circuit && drawn {
            true => Circuit::drawn(grade, self.smoothing, &mut random),
            false => Circuit::new(grade, self.smoothing),
        };
        let density = random.between(self.unevenness[0], self.unevenness[1]);
        let friction = peak / weaker(&motorcycle);
        let road = Road { friction, waves: waves(density, &mut random), ..Road::default() };
        Ok(Entry {
            circuit,
            model: Model::new(motorcycle, road),
            bike,
            drivetrain,
            pace,
            wind: [blow * from.cos(), blow * from.sin()],
            grade,
            disturbance,
        })
    }
}

/// Waves of a road's unevenness.
const WAVES: usize = 20;
/// The longest and the shortest, m: longer ones are hills, shorter ones the tyre swallows.
const LENGTHS: [f64; 2] = [40.0, 0.8];
/// The wave number at which ISO 8608 gives the density, cycles/m.
const REFERENCE: f64 = 0.1;

/// Waves of a surface whose spectrum falls with the square of the wave number from a density (1e-6 m³) at
/// [`REFERENCE`]; each runs its own way.
fn waves(density: f64, random: &mut Random) -> Vec<Wave> {
    if density <= 0.0 {
        return Vec::new();
    }
    let ends = LENGTHS.map(|length| length.recip());
    let step = (ends[1] / ends[0]).powf(1.0 / WAVES as f64);
    let wave = |k: usize| {
        let low = ends[0] * step.powi(k as i32);
        let power = 1e-6 * density * REFERENCE.powi(2) * (1.0 / low - 1.0 / (low * step));
        let number = std::f64::consts::TAU * low * random.between(1.0, step);
        let way = random.between(0.0, std::f64::consts::TAU);
        Wave {
            height: (2.0 * power).sqrt(),
            number: [number * way.cos(), number * way.sin()],
            phase: random.between(0.0, std::f64::consts::TAU),
        }
    };
    (0..WAVES).map(wave).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::bike::Axle;

    /// What the first machine's file says of its tyres has an uncertainty, and the truth is within two of it.
    #[test]
    fn the_first_machines_file_does_not_deny_its_tyres() {
        let track = Track::load("track").expect("built in").expect("a track");
        let entry = track.entry(0, 0).expect("stands");
        let (motorcycle, bike) = (&entry.model.motorcycle, &entry.bike);
        let loads = motorcycle.static_loads();
        let tyres = motorcycle.tyres.as_ref().expect("shod");
        for (k, axle) in Axle::BOTH.into_iter().enumerate() {
            let truth = bench(tyres[k].as_ref(), loads[k], 1.0);
            let ratio = (truth.camber_stiffness / truth.cornering_stiffness).abs();
            let sd = bike.uncertainty[&format!("{}.side_force_ratio", axle.name())];
            let off = (bike.wheel(axle).side_force_ratio - ratio) / sd;
            assert!(off.abs() < 2.0, "{}: {ratio}, {off} standard deviations", axle.name());
        }
        let wrong = "name = 'x'\ndescription = 'x'\nlaps = 1\n[belief.front]\nside_forces = 0.1\n";
        let error = Track::parse(wrong, Path::new("x.toml")).expect_err("no such key").to_string();
        assert!(error.contains("side_forces"), "{error}");
    }
}
