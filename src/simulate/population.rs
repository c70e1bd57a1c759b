//! A population of motorcycles: complete machines, drawn at random over what is on the road, for rides
//! whose plant is neither the model that looks at them nor always the same.
//!
//! ```text
//! seed, number -> masses, lengths, bodies, tyres, carcass, suspension, sensors -> motorcycle + bike files
//! ```
//!
//! A machine depends on seed, number and the attempt alone. What is hidden in a [`Case`] is put into it by
//! the same formulas as into any other plant; [`BikeFile`] says how much its owner knows.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::hidden::{Case, Kind};
use super::imu::{Attitude, Imu, Satellite, Triad};
use super::motorcycle::Plant;
use super::multibody::{self, Build};
use super::population_bike::{self, BikeFile};
use super::population_tyre::{self, Carcasses, Make};
use super::ride::MultibodyRide;
use super::rider::Disturbance;
use super::scenario::Scenario;
use super::tour::Tour;
use crate::contract::channel::Channel;
use crate::effects::extended_tyre::ExtendedTyre;
use crate::effects::{ALL, ModelError};
use crate::model::dive::contact_arms;
use crate::motorcycle::Motorcycle;
use crate::statistics::random::Random;

/// Attempts at a machine that stands and a ride that does not fall.
pub const ATTEMPTS: usize = 8;
/// Density of the air, kg/m³.
const AIR: f64 = 1.225;

/// How a machine is sprung.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Springs {
    /// Wheels fixed in the frame.
    None,
    /// Touring.
    Soft,
    /// Road.
    Usual,
    /// Racing.
    Stiff,
}

/// One machine, before anything is hidden in it.
#[derive(Debug, Clone)]
pub struct Machine {
    /// Seed of the population.
    pub seed: u64,
    /// Its number.
    pub number: usize,
    /// How many drawn before it did not stand or fell.
    pub attempt: usize,
    /// Masses, lengths, tyres and what it has beyond that.
    pub plant: Plant,
    /// Bodies, springs and frame.
    pub build: Build,
    /// How it is sprung.
    pub springs: Springs,
    /// Whose tyres it has.
    pub make: Make,
    /// Its inertial unit; `None` is one that knows its attitude, with the scenario's errors.
    pub imu: Option<Imu>,
    /// Sensors' noise over the scenario's.
    pub noise: f64,
    /// Unsteadiness of rider, pads and air.
    pub disturbance: Disturbance,
    tyres: population_tyre::Pair,
    carcasses: Carcasses,
}

/// Even in the logarithm between two bounds.
fn spread(random: &mut Random, low: f64, high: f64) -> f64 {
    random.between(low.ln(), high.ln()).exp()
}

/// Normal, within `reach` standard deviations.
pub(super) fn within(random: &mut Random, mean: f64, sd: f64, reach: f64) -> f64 {
    mean + sd * random.normal().clamp(-reach, reach)
}

impl Machine {
    /// Draws a machine.
    ///
    /// # Errors
    /// A built-in scenario or tyre does not load (a defect that a test would find).
    pub fn draw(seed: u64, number: usize, attempt: usize) -> Result<Self, String> {
        let mut random = Random::new(seed, &format!("machine {number} attempt {attempt}"));
        let r = &mut random;
        let mut scenario = Scenario::builtin("paper")?.certain();
        scenario.seed = scenario.seed.wrapping_add(seed).wrapping_add(1000 * attempt as u64);
        let mut plant = scenario.machine(number).plant;
        // 125 kg of a light sports motorcycle to 270 kg of a tourer (data sheets), riders of 60 to 95 kg
        plant.mass = spread(r, 190.0, 350.0);
        // data sheets: 1.34 m (supersport 600) to 1.52 m (touring)
        plant.wheelbase = r.between(1.34, 1.52);
        // 43 to 52 % of the weight on the front wheel with a rider (Cossalter 2006, sec. 3.2)
        plant.cg_to_front = plant.wheelbase * r.between(0.48, 0.56);
        // 0.5 to 0.7 m with a rider (Cossalter 2006, sec. 3.2)
        plant.cg_height = r.between(0.55, 0.68);
        // 22 deg (supersport) to 29 deg (touring), data sheets
        plant.caster_angle = r.between(22.0, 29.0).to_radians();
        // faired and prone to naked and upright: 0.3 to 0.6 m2 (Cossalter 2006, sec. 3.5)
        plant.drag = 0.5 * AIR * spread(r, 0.3, 0.6);
        // 17 inch wheels with tyre and disc: within 30 % (schemas/bike.v1.toml)
        plant.wheel_inertia = [0.45, 0.6].map(|usual| usual * r.between(0.7, 1.3));
        plant.brake_gain = [2.4e-4, 1.6e-4].map(|usual| usual * r.between(0.8, 1.25));
        plant.yaw_inertia = f64::NAN; // the bodies'
        plant.roll_inertia = f64::NAN;
        let load = multibody::static_loads(&plant);
        let make = Make::draw(r);
        let (tyres, carcasses) = population_tyre::draw(make, &mut plant, load, r)?;
        let radius = [0, 1].map(|k| plant.tyres[k].rolling_radius);
        plant.dive_arm = contact_arms(plant.cg_height, radius, plant.wheelbase, plant.caster_angle);
        plant.model_error = usual_imperfections(r);
        let (springs, build) = build(&plant, r);
        let noise = spread(r, 0.5, 2.0);
        let imu = (r.between(0.0, 1.0) < 0.5).then(|| imu(noise, r));
        let disturbance = Disturbance {
            gust_x: r.between(2.0, 10.0),
            gust_y: r.between(4.0, 20.0),
            moment_z: 0.0,
            // sintered pads bite within 2 % from stop to stop
            brake_gain: r.between(0.0, 0.02),
            grade: r.between(0.0, 0.001),
            lean: r.between(0.003, 0.01),
        };
        Ok(Machine {
            seed,
            number,
            attempt,
            plant,
            build,
            springs,
            make,
            imu,
            noise,
            disturbance,
            tyres,
            carcasses,
        })
    }

    /// Width of a tyre, m, front (0) or rear (1).
    pub fn width(&self, k: usize) -> f64 {
        self.carcasses.width[k]
    }

    /// The plant with what is hidden in it.
    pub fn plant_with(&self, hidden: &ModelError) -> Plant {
        let mut error = self.plant.model_error;
        for effect in ALL {
            let size = (effect.get)(hidden);
            if size != 0.0 {
                (effect.set)(&mut error, size);
            }
        }
        self.plant.clone().with(&error)
    }

    /// The motorcycle with what is hidden in it.
    ///
    /// # Errors
    /// It cannot stand; a sentence that says why.
    pub fn motorcycle(&self, hidden: &ModelError) -> Result<Motorcycle, String> {
        let plant = self.plant_with(hidden);
        let load = multibody::static_loads(&plant);
        let error = &plant.model_error;
        let tyre = |k: usize| {
            let like = match self.make {
                Make::Paper => [plant.tyres[k]; 2],
                Make::Published => [self.plant.tyres[k], plant.tyres[k]],
            };
            let base = self.tyres.tyre(k, &plant.tyres[k], load[k], &self.carcasses);
            ExtendedTyre::of_any(base, like, load[k], error)
        };
        multibody::construct(&plant, &self.build, [tyre(0), tyre(1)])
    }

    /// What is ridden on it: a plan of a scenario with something hidden.
    ///
    /// # Errors
    /// It cannot stand; a sentence that says why.
    pub fn tour(
        &self,
        scenario: &Scenario,
        hidden: &ModelError,
        file: BikeFile,
    ) -> Result<Tour, String> {
        let usual = self.motorcycle(&ModelError::default())?;
        let bike = population_bike::bike(self, &usual, file)?;
        let motorcycle = self.motorcycle(hidden)?;
        let plant = self.plant_with(hidden);
        let mut tour = multibody::tour_on(scenario, &plant, motorcycle, bike, self.number);
        tour.disturbance = self.disturbance;
        for (name, sensor) in &mut tour.sensors {
            sensor.white *= self.noise;
            sensor.slow *= self.noise;
            let unit = INERTIAL.iter().any(|c| c.name() == name);
            if self.imu.is_some() && unit {
                *sensor = super::sensors::Sensor::default();
            }
        }
        tour.imu = self.imu;
        Ok(tour)
    }
}

/// What an inertial unit with a satellite receiver measures: its errors are its own.
const INERTIAL: [Channel; 10] = [
    Channel::VelocityX,
    Channel::VelocityY,
    Channel::AccelerationX,
    Channel::AccelerationY,
    Channel::Roll,
    Channel::Pitch,
    Channel::Yaw,
    Channel::RollRate,
    Channel::PitchRate,
    Channel::YawRate,
];

/// What no motorcycle and no road is free of, well below what a ride shows: a tenth of the usual sizes.
fn usual_imperfections(random: &mut Random) -> ModelError {
    let mut error = ModelError::default();
    let mut tenth = |typical: f64| 0.1 * typical * random.normal().clamp(-2.0, 2.0);
    error.road_grade = tenth(0.003);
    error.wind = tenth(1.0);
    error.pad_heat = tenth(0.01); // up to 4 % over twenty stops
    error.brake_fade = tenth(0.06);
    error
}

/// Bodies, springs, chain and frame.
fn build(plant: &Plant, r: &mut Random) -> (Springs, Build) {
    let bodies = ["sports_small", "sports_touring"][usize::from(plant.mass > 280.0)];
    let springs = match r.between(0.0, 6.0) as usize {
        0 => Springs::None,
        1 => Springs::Soft,
        2 | 3 => Springs::Usual,
        _ => Springs::Stiff,
    };
    let mut keys: BTreeMap<String, Option<f64>> = BTreeMap::new();
    let mut put = |key: &str, value: Option<f64>| {
        keys.insert(key.to_owned(), value);
    };
    // wheels with tyre and discs 9 to 13 kg in front, 11 to 16 kg behind (Sharp et al. 2004: 11.9, 14.7)
    put("front.wheel.mass", Some(r.between(9.0, 13.0)));
    put("rear.wheel.mass", Some(r.between(11.0, 16.0)));
    for (end, spin) in ["front", "rear"].into_iter().zip(plant.wheel_inertia) {
        // a disc has half its spin inertia across, a ring with a hub a little more
        put(&format!("{end}.wheel.diametral_inertia"), Some(r.between(0.55, 0.62) * spin));
    }
    put("fork.mass", Some(r.between(5.5, 9.0)));
    put("steering.damping", Some(r.between(4.0, 10.0)));
    put("engine.inertia", Some(r.between(0.0, 0.02)));
    // stiffness at the wheel over the lender's 17 kN/m each: 10 (touring) to 30 kN/m (racing)
    let stiffer = match springs {
        Springs::None => None,
        Springs::Soft => Some(r.between(0.6, 0.85)),
        Springs::Usual => Some(r.between(0.85, 1.2)),
        Springs::Stiff => Some(r.between(1.2, 1.8)),
    };
    // the damping ratio stays within a third
    for (name, stiffness, compression, rebound) in
        [("fork", 17e3, 700.0, 1300.0), ("swing_arm", 5142.5, 272.25, 393.25)]
    {
        let damped = stiffer.map(|s: f64| s.sqrt() * r.between(0.75, 1.33));
        put(&format!("{name}.stiffness"), stiffer.map(|s| s * stiffness));
        put(&format!("{name}.compression"), Some(damped.map_or(0.0, |d| d * compression)));
        put(&format!("{name}.rebound"), Some(damped.map_or(0.0, |d| d * rebound)));
    }
    put("swing_arm.pivot_x", Some(r.between(0.5, 0.6)));
    put("swing_arm.pivot_z", Some(r.between(0.36, 0.42)));
    if r.between(0.0, 1.0) < 0.7 {
        // sprockets of 15 to 17 and 40 to 46 teeth of 5/8 inch chains, the engine's ahead of the pivot
        put("chain.engine_x", Some(r.between(0.64, 0.70)));
        put("chain.engine_z", Some(r.between(0.36, 0.42)));
        put("chain.engine_radius", Some(r.between(0.038, 0.043)));
        put("chain.wheel_radius", Some(r.between(0.10, 0.117)));
    }
    if r.between(0.0, 1.0) < 0.5 {
        // 34 kN m/rad (Sharp and Alstead 1980) to 150 kN m/rad (Sharp et al. 2004: 100)
        put("frame_twist.stiffness", Some(spread(r, 34e3, 150e3)));
        put("frame_twist.damping", Some(100.0));
        put("frame_twist.x", Some(plant.wheelbase - 0.25));
        put("frame_twist.z", Some(0.8));
    }
    let lender = if bodies == "sports_small" { 260.0 } else { 308.0 };
    let trail = Some(r.between(0.085, 0.12)); // data sheets (schemas/bike.v1.toml)
    // the lender's radii of gyration, within a twelfth
    let frame_inertia = plant.mass / lender * r.between(0.85, 1.18);
    (springs, Build { bodies, frame_inertia, trail, keys })
}

/// A fused inertial and satellite unit with an aided filter, its noise over the usual; as in
/// `pipelines/scenarios/characterise.toml`, with a gyroscope whose zero is tracked.
fn imu(noise: f64, r: &mut Random) -> Imu {
    let mounting = [0; 3].map(|_| 0.001 * r.normal());
    Imu {
        position: [r.between(-0.3, 0.3), r.between(-0.03, 0.03), r.between(0.0, 0.35)],
        mounting,
        accelerometer: Triad { white: 0.06 * noise, bias: 0.02, scale: 0.0 },
        gyro: Triad { white: 0.004 * noise, bias: 0.0002, scale: 0.0 },
        attitude: Attitude::Filter { time_constant: r.between(8.0, 20.0), speed_aided: true },
        antenna: [0.0; 3],
        satellite: Satellite { white: 0.01 * noise, slow: 0.02 * noise, slow_time: 2.0 },
    }
}

/// A case on a machine of the population.
#[derive(Debug, Clone)]
pub struct Ridden {
    /// The machine.
    pub machine: Machine,
    /// What was ridden.
    pub tour: Tour,
    /// The ride.
    pub ride: MultibodyRide,
    /// Why attempts before it failed.
    pub failed: Vec<String>,
}

/// Rides a case on the machine of its number: the first attempt that does not fall.
///
/// # Errors
/// None of [`ATTEMPTS`] can be ridden.
pub fn ride(case: &Case, file: BikeFile) -> Result<Ridden, String> {
    let (mut scenario, _) = case.machine()?;
    scenario.seed = scenario.seed.wrapping_add(case.number as u64);
    let mut hidden = ModelError::default();
    for (effect, value) in &case.hidden {
        (effect.set)(&mut hidden, *value);
    }
    let mut failed = Vec::new();
    for attempt in 0..ATTEMPTS {
        let machine = Machine::draw(case.seed, case.number, attempt)?;
        let ridden = machine
            .tour(&scenario, &hidden, file)
            .and_then(|tour| Ok((multibody::ridden(&tour, case.number)?, tour)));
        match ridden {
            Ok((mut ride, tour)) if ride.fall.is_none() => {
                case.distort(&mut ride.session);
                return Ok(Ridden { machine, tour, ride, failed });
            }
            Ok((ride, _)) => failed.push(ride.fall.map_or(String::new(), |f| f.to_string())),
            Err(why) => failed.push(why),
        }
    }
    Err(format!("machine {}: {}", case.number, failed.join("; ")))
}

/// Rides a case and writes log and bike file into a folder; the paths of both and the ride.
///
/// # Errors
/// It cannot be ridden, or the files cannot be written.
pub fn write(case: &Case, folder: &Path) -> Result<((PathBuf, PathBuf), Ridden), String> {
    let ridden = ride(case, BikeFile::Full)?;
    let files = super::hidden::files(folder, &ridden.ride.session, &ridden.tour.bike)?;
    Ok((files, ridden))
}

/// A case of a kind that this motorcycle can carry: effects that come from its construction are not hidden.
pub fn case(seed: u64, number: usize, kind: Kind, sizes: [f64; 2]) -> Case {
    use crate::effects::physics::Multibody;
    let fits = |c: &Case| c.hidden.iter().all(|(e, _)| e.multibody == Multibody::Hooks);
    let mut tries = (0..1000).map(|k| Case::draw(seed + 1000 * k, number, kind, sizes));
    let case = tries.find(fits).unwrap_or_else(|| Case::draw(seed, number, Kind::Null, sizes));
    Case { seed, ..case }
}
