//! Machines of a scenario, ridden on the multibody motorcycle: archives whose plant is not the
//! model that looks at them.
//!
//! ```text
//! scenario, machine -> motorcycle (bodies scaled to the machine) + its tyres -> tour -> ride
//! ```
//!
//! The bodies are those of `sports_small`, moved and weighted so that mass, wheelbase, mass centre
//! and caster are the machine's; the tyres are the machine's own (the paper's) on a toroidal, springy
//! carcass. What is hidden in the machine comes along by the same formulas, but for what arises from
//! the construction ([`Multibody`](crate::effects::physics::Multibody)).

use std::path::Path;

use super::manoeuvre::Manoeuvre;
use super::motorcycle::Plant;
use super::pilot::Skill;
use super::ride::{self, MultibodyRide};
use super::scenario::{Machine, Scenario};
use super::tour::Tour;
use crate::GRAVITY;
use crate::contract::bike::Bike;
use crate::effects::ModelError;
use crate::effects::extended_tyre::ExtendedTyre;
use crate::model::custom::Custom;
use crate::motorcycle::{Model, Motorcycle, Road, description};

/// The machine that lends its bodies.
const BODIES: &str = "sports_small";
/// Density of the air, kg/m³.
const AIR: f64 = 1.225;
/// Longest integration step, s.
const STEP: f64 = 0.002;

/// The `number`-th session of the fleet on the multibody motorcycle, and the motorcycle's bike file.
///
/// The bike file is the machine's, with what a workshop would have measured of the bodies: trail and
/// yaw inertia.
///
/// # Errors
/// The machine cannot stand or cannot be ridden straight on; a sentence that says why.
pub fn session(
    scenario: &Scenario,
    machine: &Machine,
    number: usize,
) -> Result<(MultibodyRide, Bike), String> {
    let tour = tour(scenario, machine, number)?;
    // riders learn on a motorcycle as it should be, on a level road
    let usual = tour.model.clone().with(&ModelError::default());
    let skill = Skill::learn(&usual, ride::period(tour.rate))
        .map_err(|e| format!("{}: {e}", tour.bike.bike_id))?;
    let ridden = ride::ride(&tour, &skill, number);
    Ok((ridden, tour.bike))
}

/// What is ridden for it.
///
/// # Errors
/// The machine cannot stand.
pub fn tour(scenario: &Scenario, machine: &Machine, number: usize) -> Result<Tour, String> {
    let plant = &machine.plant;
    let motorcycle = motorcycle(plant)?;
    let mut bike = machine.bike.clone();
    bike = bike.with("trail", motorcycle.trail());
    bike = bike.with("yaw_inertia", motorcycle.inertia()[(2, 2)]);
    let error = plant.model_error;
    let road = Road { friction: plant.friction, ..Road::default() };
    Ok(Tour {
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
        bike,
        model: Model::new(motorcycle, road).with(&error),
    })
}

/// The multibody motorcycle of a plant.
///
/// # Errors
/// It cannot stand; a sentence that says why.
pub fn motorcycle(plant: &Plant) -> Result<Motorcycle, String> {
    let text = description::BUILTIN.iter().find(|(name, _)| *name == BODIES).map(|(_, text)| *text);
    let mut table: toml::Table =
        text.unwrap_or_default().parse().map_err(|e: toml::de::Error| e.to_string())?;
    let weight = plant.mass * GRAVITY / plant.wheelbase;
    let load = [plant.wheelbase - plant.cg_to_front, plant.cg_to_front].map(|l| weight * l);
    let tyres = [0, 1].map(|k| Custom::new(plant.tyres[k], load[k]));
    let given = Motorcycle::load(BODIES).map_err(|e| e.to_string())?;
    let mut put = |key: &str, value: f64| {
        let mut place = &mut table;
        let mut parts: Vec<&str> = key.split('.').collect();
        let leaf = parts.pop().unwrap_or_default();
        for part in parts {
            let inner = place
                .entry(part)
                .or_insert_with(|| toml::Value::Table(toml::Table::new()))
                .as_table_mut();
            match inner {
                Some(inner) => place = inner,
                None => return,
            }
        }
        place.insert(leaf.to_owned(), toml::Value::Float(value));
    };
    // the front end moves with the wheelbase and keeps its trail
    let longer = plant.wheelbase - given.wheelbase();
    let ground = plant.wheelbase + given.trail();
    put("gravity", GRAVITY);
    put("caster_angle", plant.caster_angle);
    put("steering.tilt", plant.caster_angle);
    put("fork.tilt", plant.caster_angle);
    put("steering.axis_x", ground - given.steering_axis.z * plant.caster_angle.tan());
    let steering_x = given.steering.centre.x + longer;
    let fork_x = given.fork.centre.x + longer;
    put("steering.x", steering_x);
    put("fork.x", fork_x);
    put("front.wheel.x", plant.wheelbase);
    let mut heights = [0.0; 2];
    for (k, end) in ["front", "rear"].into_iter().enumerate() {
        let tyre = &plant.tyres[k];
        heights[k] = tyre.rolling_radius - 2.0 / 3.0 * load[k] / tyre.vertical_stiffness;
        put(&format!("{end}.wheel.z"), heights[k]);
        put(&format!("{end}.wheel.spin_inertia"), plant.wheel_inertia[k]);
        put(&format!("brakes.gain_{end}"), plant.brake_gain[k]);
    }
    // the frame carries what is missing to the whole, where it is missing
    let others = [
        (given.swing_arm.mass, given.swing_arm.centre.x, given.swing_arm.centre.z),
        (given.steering.mass, steering_x, given.steering.centre.z),
        (given.fork.mass, fork_x, given.fork.centre.z),
        (given.wheels[0].mass, plant.wheelbase, heights[0]),
        (given.wheels[1].mass, 0.0, heights[1]),
    ];
    let sum = |f: &dyn Fn(&(f64, f64, f64)) -> f64| others.iter().map(f).sum::<f64>();
    let frame = plant.mass - sum(&|b| b.0);
    let centre = plant.wheelbase - plant.cg_to_front;
    // measured from the rear contact
    let centre_x = (plant.mass * centre - sum(&|b| b.0 * b.1)) / frame;
    let centre_z = (plant.mass * plant.cg_height - sum(&|b| b.0 * b.2)) / frame;
    put("frame.mass", frame);
    put("frame.x", centre_x);
    put("frame.z", centre_z);
    let error = &plant.model_error;
    put("aerodynamics.air_density", AIR);
    put("aerodynamics.drag_area", 2.0 * plant.drag / AIR);
    put("aerodynamics.lift_area", 2.0 * (2.0 * error.lift(0.0, 1.0)) / AIR);
    put("aerodynamics.x", centre);
    put("aerodynamics.z", plant.cg_height + error.pitch_moment(0.0, 1.0));
    let motorcycle = Motorcycle::parse(&table.to_string(), BODIES, Path::new(BODIES))
        .map_err(|e| e.to_string())?;
    let [front, rear] = [0, 1].map(|k| ExtendedTyre::boxed(tyres[k], load[k], error));
    Ok(motorcycle.with_tyres(front, rear))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_motorcycle_has_the_machines_mass_geometry_and_tyres() {
        let scenario = Scenario::builtin("paper").expect("scenario").certain();
        for index in 0..4 {
            let machine = scenario.machine(index);
            let plant = &machine.plant;
            let m = motorcycle(plant).expect("stands");
            let centre = m.centre();
            for (found, expected) in [
                (m.mass(), plant.mass),
                (m.wheelbase(), plant.wheelbase),
                (m.centres[0].x - centre.x, plant.cg_to_front),
                (centre.z, plant.cg_height),
                (m.caster_angle, plant.caster_angle),
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
