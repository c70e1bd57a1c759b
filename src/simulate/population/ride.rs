//! Rides on machines of the population.

use std::path::{Path, PathBuf};

use super::bike::BikeFile;
use super::machine::DrawnMachine;
use super::tyre::Make;
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::contract::coefficient::{Coefficient as C, Id};
use crate::estimate;
use crate::simulate::effects::ModelError;
use crate::simulate::effects::physics::Multibody;
use crate::simulate::error::Error;
use crate::simulate::hidden::{self, Case, Kind};
use crate::simulate::multibody_ride as multibody;
use crate::simulate::ride::{self as simulated, MultibodyRide};
use crate::simulate::scenario::Scenario;
use crate::simulate::sensors::Sensor;
use crate::simulate::tour::Tour;
use crate::simulate::truth::{self, Truth};
use crate::simulate::tyre_truth;

/// Attempts at a machine that stands and a ride that comes to its end.
pub(crate) const ATTEMPTS: usize = 8;
/// Share of the largest braking friction of a ride from which it shows the friction curve's peak.
const HARD: f64 = 0.7;
/// A ride of this length did not come to its end, s.
const ENDLESS: f64 = 7000.0;

/// Channels of an inertial unit with a satellite receiver: its errors are its own.
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

impl DrawnMachine {
    /// Tour on it: a plan of a scenario with something hidden.
    ///
    /// # Errors
    /// It cannot stand; a sentence that says why.
    pub fn tour(
        &self,
        scenario: &Scenario,
        hidden: &ModelError,
        file: BikeFile,
    ) -> Result<Tour, Error> {
        let usual = self.motorcycle(&ModelError::default())?;
        let bike = super::bike::bike(self, &usual, file)?;
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

/// A case on a machine of the population.
#[derive(Debug, Clone)]
pub struct Ridden {
    pub machine: DrawnMachine,
    pub tour: Tour,
    pub ride: MultibodyRide,
    /// Why attempts before it failed.
    pub failed: Vec<String>,
}

impl Ridden {
    /// The true coefficients: what a bench would find of the tyres, their braking friction under the loads of
    /// the ride's hard braking, and what its corners show of the true slip angles, cambers and forces; of the
    /// paper's tyres also their friction curve.
    pub fn truth(&self, config: &estimate::Config) -> Truth {
        let model = &self.tour.model;
        let mut truth = tyre_truth::coefficients(model);
        let of = |axle: Axle, c: C| {
            let id = Id::from((axle, c));
            truth.iter().find(|(known, _)| *known == id).map_or(f64::NAN, |(_, value)| *value)
        };
        let ratio = Axle::BOTH.map(|axle| of(axle, C::SideForceRatio));
        let weight = model.motorcycle.mass() * model.motorcycle.gravity;
        let ridden = truth::of_corners(&self.ride, weight, ratio, config);
        truth.retain(|(id, _)| ridden.iter().all(|(known, _)| known != id));
        truth.extend(ridden);
        for (id, value) in &mut truth {
            let of_peak = match id.coefficient {
                C::MfD => 0,
                C::PeakSlip => 1,
                _ => continue,
            };
            let Some((k, tyres)) =
                id.part.axle().map(|a| a as usize).zip(model.motorcycle.tyres.as_ref())
            else {
                continue;
            };
            if let Some(load) = self.load_braked(k) {
                *value =
                    tyre_truth::braked_peak(tyres[k].as_ref(), load, model.road.friction)[of_peak];
            }
        }
        if self.machine.make == Make::Paper {
            for (axle, tyre) in Axle::BOTH.into_iter().zip(&self.machine.plant.tyres) {
                let f = tyre.friction;
                let numbers = [(C::MfB, f.b), (C::MfC, f.c), (C::MfE1, f.e1), (C::MfE2, f.e2)];
                truth.extend(numbers.map(|(c, value)| (Id::from((axle, c)), value)));
            }
        }
        truth
    }
}

impl Ridden {
    /// Mean load of a wheel, N, where it brakes nearly as hard as anywhere; `None` where it never does.
    fn load_braked(&self, k: usize) -> Option<f64> {
        let used = |s: &simulated::Sample| -s.wheels[k].force[0] / s.wheels[k].load.max(100.0);
        let most = self.ride.samples.iter().map(used).fold(0.0, f64::max);
        let hard = self.ride.samples.iter().filter(|s| most > 0.0 && used(s) > HARD * most);
        let (n, sum) = hard.fold((0, 0.0), |(n, sum), s| (n + 1, sum + s.wheels[k].load));
        (n > 0).then(|| sum / f64::from(n))
    }
}

/// Rides a case on the machine of its number: the first attempt that does not fall.
///
/// # Errors
/// None of [`ATTEMPTS`] can be ridden.
pub fn ride(case: &Case, file: BikeFile) -> Result<Ridden, Error> {
    let (mut scenario, _) = case.machine()?;
    scenario.seed = scenario.seed.wrapping_add(case.number as u64);
    let hidden = error(case);
    let mut failed = Vec::new();
    for attempt in 0..ATTEMPTS {
        let machine = DrawnMachine::draw(case.seed, case.number, attempt)?;
        if !possible(&machine, &hidden) {
            continue;
        }
        let ridden = machine
            .tour(&scenario, &hidden, file)
            .and_then(|tour| Ok((multibody::ridden(&tour, case.number)?, tour)));
        match ridden {
            Ok((ride, _)) if ride.session.duration() > ENDLESS => {
                failed.push("it does not come to its end".to_owned());
            }
            Ok((mut ride, tour)) if ride.fall.is_none() => {
                case.distort(&mut ride.session);
                return Ok(Ridden { machine, tour, ride, failed });
            }
            Ok((ride, _)) => {
                let why = ride.fall.map_or(String::new(), |fall| fall.to_string());
                let doing = ride.labels.last().map_or("", |label| label.0.name());
                failed.push(format!("{why}, {doing} ({machine})"));
            }
            Err(why) => failed.push(format!("{why} ({machine})")),
        }
    }
    Err(Error::Ride(format!("machine {}: {}", case.number, failed.join("; "))))
}

/// Rides a case and writes log and bike file into a folder; the paths of both and the ride.
///
/// # Errors
/// It cannot be ridden, or the files cannot be written.
pub fn write(case: &Case, folder: &Path) -> Result<((PathBuf, PathBuf), Ridden), Error> {
    let ridden = ride(case, BikeFile::Full)?;
    let files = hidden::files(folder, &ridden.ride.session, &ridden.tour.bike)?;
    Ok((files, ridden))
}

/// Hidden effects of a case, together.
fn error(case: &Case) -> ModelError {
    let mut error = ModelError::default();
    for (effect, value) in &case.hidden {
        (effect.set)(&mut error, *value);
    }
    error
}

/// Whether the tyres of a machine are tyres with something hidden in them: no motorcycle is ridden whose
/// camber pushes it out of the corner.
fn possible(machine: &DrawnMachine, hidden: &ModelError) -> bool {
    machine.plant_with(hidden).tyres.iter().all(|tyre| {
        tyre.side_force_ratio > 0.02
            && tyre.relaxation_length > 0.05
            && tyre.twisting_stiffness > -0.05
    })
}

/// A case of a kind that the machine of its number can carry: effects that come from its construction are
/// not hidden, nor what would make its tyres none.
pub fn case(seed: u64, number: usize, kind: Kind, sizes: [f64; 2]) -> Case {
    let machine = DrawnMachine::draw(seed, number, 0).ok();
    let fits = |c: &Case| {
        c.hidden.iter().all(|(e, _)| e.multibody == Multibody::Hooks)
            && machine.as_ref().is_none_or(|m| possible(m, &error(c)))
    };
    let mut tries = (0..1000).map(|k| Case::draw(seed + 1000 * k, number, kind, sizes));
    let case = tries.find(fits).unwrap_or_else(|| Case::draw(seed, number, Kind::Null, sizes));
    Case { seed, ..case }
}
