//! A population of motorcycles: complete machines, drawn at random over what is on the road, for rides
//! whose plant is neither the model that looks at them nor always the same.
//!
//! ```text
//! seed, number -> masses, lengths, bodies, tyres, carcass, suspension, sensors -> motorcycle + bike files
//! ```
//!
//! A machine depends on seed, number and the attempt alone. What is hidden in a [`Case`] is put into it by
//! the same formulas as into any other plant; [`BikeFile`] says how much its owner knows.

use super::imu::Imu;
use super::motorcycle::Plant;
use super::multibody::{self, Build};
use super::rider::Disturbance;
use super::scenario::Scenario;
use super::sensors::Sensor;
use super::tour::Tour;
use crate::contract::channel::Channel;
use crate::effects::extended_tyre::ExtendedTyre;
use crate::effects::{ALL, ModelError};
use crate::model::dive::contact_arms;
use crate::motorcycle::Motorcycle;
use crate::statistics::random::Random;
use bike::BikeFile;
use build::{build, imu, usual_imperfections};
use tyre::{Carcasses, Make};

pub mod bike;
mod build;
pub mod ride;
pub mod tyre;

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
    tyres: tyre::Pair,
    carcasses: Carcasses,
}

impl std::fmt::Display for Machine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let p = &self.plant;
        let has = |key: &str| self.build.keys.contains_key(key);
        write!(
            f,
            "{:.0} kg, wheelbase {:.2} m, centre {:.2} m behind the front, {:.2} m up, {:?} tyres of {} in \
             front, springs {:?}, {}, {}, attitude by {}",
            p.mass,
            p.wheelbase,
            p.cg_to_front,
            p.cg_height,
            self.make,
            self.tyres.name(),
            self.springs,
            if has("chain.engine_x") { "chain" } else { "shaft" },
            if has("frame_twist.stiffness") { "frame twists" } else { "frame stiff" },
            if self.imu.is_some() { "a filter" } else { "a sensor" },
        )
    }
}

/// Even in the logarithm between two bounds.
fn spread(random: &mut Random, low: f64, high: f64) -> f64 {
    random.between(low.ln(), high.ln()).exp()
}

/// Normal, within `reach` standard deviations.
fn within(random: &mut Random, mean: f64, sd: f64, reach: f64) -> f64 {
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
        // 43 to 51 % of the weight on the front wheel with a rider (Cossalter 2006, sec. 3.2)
        plant.cg_to_front = plant.wheelbase * r.between(0.49, 0.57);
        // 0.5 to 0.68 m with a rider (Cossalter 2006, sec. 3.2): the longer, the higher
        plant.cg_height = plant.wheelbase * r.between(0.38, 0.45);
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
        let (tyres, carcasses) = tyre::draw(make, &mut plant, load, r)?;
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
        let bike = bike::bike(self, &usual, file)?;
        let motorcycle = self.motorcycle(hidden)?;
        let plant = self.plant_with(hidden);
        let mut tour = multibody::tour_on(scenario, &plant, motorcycle, bike, self.number);
        tour.disturbance = self.disturbance;
        for (name, sensor) in &mut tour.sensors {
            sensor.white *= self.noise;
            sensor.slow *= self.noise;
            let unit = INERTIAL.iter().any(|c| c.name() == name);
            if self.imu.is_some() && unit {
                *sensor = Sensor::default();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motorcycle::{Model, Road};

    fn draw(number: usize) -> Machine {
        Machine::draw(3, number, 0).expect("built in")
    }

    #[test]
    fn a_machine_depends_on_seed_number_and_attempt_alone() {
        let text = |m: &Machine| format!("{m:?}");
        let first: Vec<String> = (0..6).map(|n| text(&draw(n))).collect();
        for number in (0..6).rev() {
            assert_eq!(text(&draw(number)), first[number]);
        }
        assert!(first[0] != text(&Machine::draw(3, 0, 1).expect("built in")));
        assert!(first[0] != first[1] && first[0] != text(&Machine::draw(4, 0, 0).expect("it")));
    }

    #[test]
    fn the_first_forty_stand_and_are_what_was_drawn() {
        for number in 0..40 {
            let machine = draw(number);
            let m = machine.motorcycle(&ModelError::default()).expect("stands");
            let (plant, centre) = (&machine.plant, m.centre());
            for (found, expected) in [
                (m.mass(), plant.mass),
                (m.wheelbase(), plant.wheelbase),
                (m.centres[0].x - centre.x, plant.cg_to_front),
                (centre.z, plant.cg_height),
                (m.caster_angle, plant.caster_angle),
                (m.trail(), machine.build.trail.expect("drawn")),
            ] {
                assert!((found / expected - 1.0).abs() < 1e-9, "{number}: {found} for {expected}");
            }
            assert!(m.frame.mass > 80.0, "{number}: {}", m.frame.mass);
            let at_rest = Model::new(m, Road::default()).straight(0.0);
            assert!(at_rest.position.z.abs() < 1e-9 && at_rest.angles[2].abs() < 1e-9);
        }
    }

    #[test]
    fn a_bike_file_tells_nothing_of_what_is_hidden_and_a_short_one_less() {
        let scenario = Scenario::builtin("paper").expect("scenario");
        for number in 0..8 {
            let machine = draw(number);
            let bike = |hidden: &ModelError, file| {
                machine.tour(&scenario, hidden, file).expect("stands").bike
            };
            let mut hidden = ModelError::default();
            for name in ["wheel_inertia", "side_force_ratio_rear", "relaxation_length"] {
                let effect = crate::effects::Effect::named(name).expect("an effect");
                (effect.set)(&mut hidden, effect.typical);
            }
            let full = bike(&ModelError::default(), BikeFile::Full);
            assert_eq!(full, bike(&hidden, BikeFile::Full));
            let minimal = bike(&hidden, BikeFile::Minimal);
            assert!(minimal.mass == full.mass && minimal.uncertainty.is_empty());
            assert!(minimal.value("trail").is_none() && full.value("trail").is_some());
            let tutorial = bike(&hidden, BikeFile::Tutorial);
            assert_eq!(tutorial.uncertainty.keys().collect::<Vec<_>>(), ["mass"]);
        }
    }

    /// The tyres of either make show on the bench what the plant, and so the bike file, says.
    #[test]
    fn hidden_numbers_of_tyres_are_in_tyres_of_any_make() {
        use super::super::tyre_truth::bench;
        let mut hidden = ModelError::default();
        for name in ["side_force_ratio_front", "twisting_stiffness", "relaxation_length"] {
            let effect = crate::effects::Effect::named(name).expect("an effect");
            (effect.set)(&mut hidden, effect.typical);
        }
        for number in 0..8 {
            let machine = draw(number);
            for hidden in [ModelError::default(), hidden] {
                let m = machine.motorcycle(&hidden).expect("stands");
                let plant = machine.plant_with(&hidden);
                let tyre = &m.tyres.as_ref().expect("shod")[0];
                let b = bench(tyre.as_ref(), m.static_loads()[0], 1.0);
                let is = &plant.tyres[0];
                for (found, expected) in [
                    (b.camber_stiffness / b.cornering_stiffness, is.side_force_ratio),
                    (b.twisting_stiffness, is.twisting_stiffness),
                    (b.relaxation_length, is.relaxation_length),
                    (b.rolling_radius, is.rolling_radius),
                    (b.overturning_stiffness, is.overturning_stiffness),
                ] {
                    assert!(
                        (found - expected).abs() < 2e-3 * expected.abs(),
                        "{number} {found} {expected}"
                    );
                }
            }
        }
    }
}
