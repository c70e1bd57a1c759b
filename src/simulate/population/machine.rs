//! One machine of the population. Ranges and the sources beside them are from memory and were not looked up
//! again: they are to be wide enough for real motorcycles, not to describe them.

use super::super::imu::Imu;
use super::super::motorcycle::Plant;
use super::super::rider::Disturbance;
use super::super::scenario::Scenario;
use super::build::{Springs, build, imu, usual_imperfections};
use super::draw::spread;
use super::tyre;
use super::tyre::{Carcasses, Make};
use crate::contract::bike::USUAL_WHEEL_INERTIA;
use crate::motorcycle::balance::USUAL_BRAKE_GAIN;
use crate::simulate::effects::extended_tyre::ExtendedTyre;
use crate::simulate::effects::{ALL, ModelError};
use crate::simulate::error::Error;
use crate::simulate::multibody::Motorcycle;
use crate::simulate::multibody_ride as multibody;
use crate::simulate::multibody_ride::Build;
use crate::statistics::random::Random;
use crate::tyre::dive::contact_arms;

/// Density of the air, kg/m³.
const AIR: f64 = 1.225;

/// One machine of the population, before anything is hidden in it: a plant, and the bodies, springs and sensors that
/// a multibody motorcycle needs beyond it. It has no bike file: that depends on how much its owner knows.
#[derive(Debug, Clone)]
pub struct DrawnMachine {
    /// Seed of the population.
    pub seed: u64,
    pub number: usize,
    /// Number of draws before it that did not stand or fell.
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
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub noise: f64,
    /// Unsteadiness of rider, pads and air.
    pub disturbance: Disturbance,
    tyres: tyre::Pair,
    carcasses: Carcasses,
}

impl std::fmt::Display for DrawnMachine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let vehicle = &self.plant.vehicle;
        let has = |key: &str| self.build.keys.contains_key(key);
        write!(
            f,
            "{:.0} kg, wheelbase {:.2} m, centre {:.2} m behind the front, {:.2} m up, {:?} tyres of {} in \
             front, springs {:?}, {}, {}, attitude by {}",
            vehicle.mass,
            vehicle.wheelbase,
            vehicle.cg_to_front,
            vehicle.cg_height,
            self.make,
            self.tyres.name(),
            self.springs,
            if has("chain.engine_x") { "chain" } else { "shaft" },
            if has("frame_twist.stiffness") { "frame twists" } else { "frame stiff" },
            if self.imu.is_some() { "a filter" } else { "a sensor" },
        )
    }
}

impl DrawnMachine {
    /// Draws a machine.
    ///
    /// # Errors
    /// A built-in scenario or tyre does not load (a defect that a test would find).
    pub fn draw(seed: u64, number: usize, attempt: usize) -> Result<Self, Error> {
        let mut random = Random::new(seed, &format!("machine {number} attempt {attempt}"));
        let r = &mut random;
        let mut scenario = Scenario::builtin("paper")?.certain();
        scenario.seed = scenario.seed.wrapping_add(seed).wrapping_add(1000 * attempt as u64);
        let mut plant = scenario.machine(number).plant;
        let v = &mut plant.vehicle;
        // 125 kg of a light sports motorcycle to 270 kg of a tourer (data sheets), riders of 60 to 95 kg
        v.mass = spread(r, 190.0, 350.0);
        // data sheets: 1.34 m (supersport 600) to 1.52 m (touring)
        v.wheelbase = r.between(1.34, 1.52);
        // 43 to 51 % of the weight on the front wheel with a rider (Cossalter 2006, sec. 3.2)
        v.cg_to_front = v.wheelbase * r.between(0.49, 0.57);
        // 0.5 to 0.68 m with a rider (Cossalter 2006, sec. 3.2): the longer, the higher
        v.cg_height = v.wheelbase * r.between(0.38, 0.45);
        // 22 deg (supersport) to 29 deg (touring), data sheets
        v.caster_angle = r.between(22.0, 29.0).to_radians();
        // faired and prone to naked and upright: 0.3 to 0.6 m2 (Cossalter 2006, sec. 3.5)
        v.drag = 0.5 * AIR * spread(r, 0.3, 0.6);
        // 17 inch wheels with tyre and disc: within 30 % (schemas/bike.v1.toml)
        v.wheel_inertia = USUAL_WHEEL_INERTIA.map(|usual| usual * r.between(0.7, 1.3));
        v.brake_gain = USUAL_BRAKE_GAIN.map(|usual| usual * r.between(0.8, 1.25));
        v.yaw_inertia = f64::NAN; // the bodies'
        v.roll_inertia = f64::NAN;
        let load = v.static_loads();
        let make = Make::draw(r);
        let (tyres, carcasses) = tyre::draw(make, &mut plant, load, r)?;
        let radius = [0, 1].map(|k| plant.tyres[k].rolling_radius);
        let v = &mut plant.vehicle;
        v.dive_arm = contact_arms(v.cg_height, radius, v.wheelbase, v.caster_angle);
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
            bend: 0.0,
            lean: r.between(0.003, 0.01),
        };
        Ok(DrawnMachine {
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
    pub fn motorcycle(&self, hidden: &ModelError) -> Result<Motorcycle, Error> {
        let plant = self.plant_with(hidden);
        let load = plant.vehicle.static_loads();
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
}
