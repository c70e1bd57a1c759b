//! Machines of a scenario, ridden on the multibody motorcycle: archives whose plant is not the
//! model that looks at them.
//!
//! ```text
//! scenario, machine -> motorcycle (bodies scaled to the machine) + its tyres -> tour -> ride
//! ```
//!
//! The bodies are those of a built-in motorcycle, moved and weighted so that mass, wheelbase, centre of mass
//! and caster are the machine's; the tyres are the machine's own (the paper's) on a toroidal, springy
//! carcass, unless [`construct`] is given others. What is hidden in the machine comes along by the same formulas, but
//! for what arises from the construction ([`Multibody`](crate::simulate::effects::physics::Multibody)).

use std::collections::BTreeMap;
use std::path::Path;

use super::manoeuvre::Manoeuvre;
use super::motorcycle::Plant;
use super::pilot::Skill;
use super::ride::{self, MultibodyRide};
use super::scenario::{Machine, Scenario};
use super::tour::Tour;
use crate::GRAVITY;
use crate::contract::bike::Bike;
use crate::simulate::effects::ModelError;
use crate::simulate::effects::extended_tyre::ExtendedTyre;
use crate::simulate::error::Error;
use crate::simulate::multibody::{Model, Motorcycle, Road, description};
use crate::tyre::custom::Custom;
use crate::tyre::tyre_model::TyreModel;

/// Density of the air, kg/m³.
const AIR: f64 = 1.225;
/// Longest integration step, s.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
const STEP: f64 = 0.002;

/// The `number`-th session of the fleet on the multibody motorcycle, and the motorcycle's bike file.
///
/// The bike file is the machine's, with what a workshop would have measured of the bodies: trail and
/// yaw inertia.
///
/// # Errors
/// The machine cannot stand or cannot be ridden straight on; a sentence that says why.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn session(
    scenario: &Scenario,
    machine: &Machine,
    number: usize,
) -> Result<(MultibodyRide, Bike), Error> {
    let tour = tour(scenario, machine, number)?;
    let ridden = ridden(&tour, number)?;
    Ok((ridden, tour.bike))
}

/// A session of a tour by a rider who learnt on the motorcycle as it should be, on a level road.
///
/// # Errors
/// The machine cannot be ridden straight on; a sentence that says why.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn ridden(tour: &Tour, number: usize) -> Result<MultibodyRide, Error> {
    let usual = tour.model.clone().with(&ModelError::default());
    let skill = Skill::learn(&usual, ride::period(tour.rate))
        .map_err(|e| Error::Ride(format!("{}: {e}", tour.bike.bike_id)))?;
    Ok(ride::ride(tour, &skill, number))
}

/// Tour of the scenario.
///
/// # Errors
/// The machine cannot stand.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn tour(scenario: &Scenario, machine: &Machine, number: usize) -> Result<Tour, Error> {
    let motorcycle = motorcycle(&machine.plant)?;
    let mut bike = machine.bike.clone();
    bike = bike.with("trail", motorcycle.trail());
    bike = bike.with("yaw_inertia", motorcycle.inertia()[(2, 2)]);
    Ok(tour_on(scenario, &machine.plant, motorcycle, bike, number))
}

/// Tour of a motorcycle that stands for a plant.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub(crate) fn tour_on(
    scenario: &Scenario,
    plant: &Plant,
    motorcycle: Motorcycle,
    bike: Bike,
    number: usize,
) -> Tour {
    let error = plant.model_error;
    let road = Road { friction: plant.friction, ..Road::default() };
    Tour {
        name: scenario.name.clone(),
        description: scenario.description.clone(),
        seed: scenario.seed,
        rate: scenario.rate,
        step: STEP,
        float32: scenario.float32,
        drop: scenario.drop.clone(),
        sessions: 1,
        start_speed: 0.0,
        manoeuvres: vec![Manoeuvre::Plan { plan: scenario.plans[number % scenario.plans.len()] }],
        // a head wind blows against the first straight's heading
        wind: [-error.air_speed(0.0, 1.0), 0.0],
        sensors: scenario.sensors.clone(),
        imu: None,
        model_error: error,
        disturbance: scenario.disturbance,
        odd_manoeuvres: scenario.odd_manoeuvres.clone(),
        bike,
        model: Model::new(motorcycle, road).with(&error),
    }
}

/// How a motorcycle is built beyond what its plant says.
#[derive(Debug, Clone)]
pub struct Build {
    /// The built-in motorcycle that lends its bodies.
    pub bodies: &'static str,
    /// Its frame's moments of inertia over the lender's.
    pub frame_inertia: f64,
    /// Trail on the road, m; `None` is the lender's.
    pub trail: Option<f64>,
    /// Keys of the motorcycle file that are not the lender's; `None` takes a key away.
    pub keys: BTreeMap<String, Option<f64>>,
}

impl Default for Build {
    fn default() -> Self {
        Build { bodies: "sports_small", frame_inertia: 1.0, trail: None, keys: BTreeMap::new() }
    }
}

/// Puts a number into a table, or takes it away, by its dotted key.
fn put(table: &mut toml::Table, key: &str, value: Option<f64>) {
    match (key.split_once('.'), value) {
        (Some((above, below)), _) => {
            let empty = || toml::Value::Table(toml::Table::new());
            let inner = table.entry(above).or_insert_with(empty).as_table_mut();
            inner.into_iter().for_each(|inner| put(inner, below, value));
        }
        (None, Some(x)) => {
            table.insert(key.to_owned(), toml::Value::Float(x));
        }
        (None, None) => {
            table.remove(key);
        }
    }
}

/// The multibody motorcycle of a plant on its own tyres (the paper's).
///
/// # Errors
/// It cannot stand; a sentence that says why.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn motorcycle(plant: &Plant) -> Result<Motorcycle, Error> {
    let load = plant.vehicle.static_loads();
    let tyre = |k: usize| {
        let custom = Box::new(Custom::new(plant.tyres[k], load[k]));
        ExtendedTyre::of_any(custom, [plant.tyres[k]; 2], load[k], &plant.model_error)
    };
    construct(plant, &Build::default(), [tyre(0), tyre(1)])
}

/// The multibody motorcycle of a plant, built and shod as given.
///
/// # Errors
/// It cannot stand; a sentence that says why.
pub(crate) fn construct(
    plant: &Plant,
    build: &Build,
    tyres: [Box<dyn TyreModel>; 2],
) -> Result<Motorcycle, Error> {
    let vehicle = &plant.vehicle;
    let name = build.bodies;
    let text = description::BUILTIN.iter().find(|(n, _)| *n == name).map(|(_, text)| *text);
    let mut table: toml::Table = text
        .unwrap_or_default()
        .parse()
        .map_err(|e: toml::de::Error| Error::Ride(e.to_string()))?;
    let given = Motorcycle::load(name).map_err(|e| Error::Ride(e.to_string()))?;
    // the front end moves with the wheelbase
    let longer = vehicle.wheelbase - given.wheelbase();
    let ground = vehicle.wheelbase + build.trail.unwrap_or_else(|| given.trail());
    let caster = vehicle.caster_angle;
    let centre = vehicle.wheelbase - vehicle.cg_to_front;
    let error = &plant.model_error;
    let numbers = [
        ("gravity", GRAVITY),
        ("caster_angle", caster),
        ("steering.tilt", caster),
        ("fork.tilt", caster),
        ("steering.axis_x", ground - given.steering_axis.z * caster.tan()),
        ("steering.x", given.steering.centre.x + longer),
        ("fork.x", given.fork.centre.x + longer),
        ("front.wheel.x", vehicle.wheelbase),
        ("aerodynamics.air_density", AIR),
        ("aerodynamics.drag_area", 2.0 * vehicle.drag / AIR),
        ("aerodynamics.lift_area", 2.0 * (2.0 * error.lift(0.0, 1.0)) / AIR),
        ("aerodynamics.x", centre),
        ("aerodynamics.z", vehicle.cg_height + error.pitch_moment(0.0, 1.0)),
    ];
    for (key, value) in numbers {
        put(&mut table, key, Some(value));
    }
    let load = vehicle.static_loads();
    for (k, end) in ["front", "rear"].into_iter().enumerate() {
        let carcass = tyres[k].carcass();
        let height = carcass.radius - load[k] / carcass.stiffness;
        put(&mut table, &format!("{end}.wheel.z"), Some(height));
        put(&mut table, &format!("{end}.wheel.spin_inertia"), Some(vehicle.wheel_inertia[k]));
        put(&mut table, &format!("brakes.gain_{end}"), Some(vehicle.brake_gain[k]));
    }
    for (key, value) in &build.keys {
        put(&mut table, key, *value);
    }
    let parse = |table: &toml::Table| {
        Motorcycle::parse(&table.to_string(), name, Path::new(name))
            .map_err(|e| Error::Ride(e.to_string()))
    };
    // the frame carries what is missing to the whole, where it is missing
    let m = parse(&table)?;
    let others = m.mass() - m.frame.mass;
    let moment = m.centre() * m.mass() - m.frame.centre * m.frame.mass;
    let frame = vehicle.mass - others;
    put(&mut table, "frame.mass", Some(frame));
    put(&mut table, "frame.x", Some((vehicle.mass * centre - moment.x) / frame));
    put(&mut table, "frame.z", Some((vehicle.mass * vehicle.cg_height - moment.z) / frame));
    if let Some(own) = table.get_mut("frame").and_then(toml::Value::as_table_mut) {
        for key in ["ixx", "iyy", "izz", "ixz"] {
            if let Some(x) = own.get(key).and_then(toml::Value::as_float) {
                put(own, key, Some(x * build.frame_inertia));
            }
        }
    }
    let [front, rear] = tyres;
    Ok(parse(&table)?.with_tyres(front, rear))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_motorcycle_has_the_machines_mass_geometry_and_tyres() {
        let scenario = Scenario::builtin("paper").expect("scenario").certain();
        for index in 0..4 {
            let machine = scenario.machine(index);
            let vehicle = &machine.plant.vehicle;
            let m = motorcycle(&machine.plant).expect("stands");
            let centre = m.centre();
            for (found, expected) in [
                (m.mass(), vehicle.mass),
                (m.wheelbase(), vehicle.wheelbase),
                (m.centres[0].x - centre.x, vehicle.cg_to_front),
                (centre.z, vehicle.cg_height),
                (m.caster_angle, vehicle.caster_angle),
            ] {
                assert!((found / expected - 1.0).abs() < 1e-9, "{found} for {expected}");
            }
            // at rest the axles are where the tyres carry them
            let at_rest = Model::new(m, Road::default()).straight(0.0);
            assert!(at_rest.position.z.abs() < 1e-9 && at_rest.angles[2].abs() < 1e-9);
            let tour = tour(&scenario, &machine, 0).expect("stands");
            assert_eq!(tour.bike.value("trail"), Some(tour.model.motorcycle.trail()));
        }
    }
}
