//! What the owner of a machine of the population knows of it: its bike file.

use std::path::Path;

use super::draw::within;
use super::machine::DrawnMachine;
use crate::contract::bike::{Bike, schema};
use crate::simulate::error::Error;
use crate::simulate::multibody::Motorcycle;
use crate::statistics::random::Random;

/// How much a bike file says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum BikeFile {
    /// Everything that a workshop and a tyre bench can measure, with its uncertainty.
    Full,
    /// The book's tutorial: the required numbers and the uncertainty of the mass.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    Tutorial,
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    Minimal,
    /// File of `roadbench bike new` from class, tyre sizes and weight.
    Wizard,
}

impl BikeFile {
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub const ALL: [BikeFile; 4] =
        [BikeFile::Full, BikeFile::Tutorial, BikeFile::Minimal, BikeFile::Wizard];

    pub fn name(self) -> &'static str {
        match self {
            BikeFile::Full => "full",
            BikeFile::Tutorial => "tutorial",
            BikeFile::Minimal => "minimal",
            BikeFile::Wizard => "wizard",
        }
    }
}

/// A bike file of a machine whose motorcycle, with nothing hidden in it, is given. Each number is measured
/// once: the files of a machine differ by what they leave out.
///
/// # Errors
/// A number is outside the schema's range (a defect that a test would find).
pub fn bike(machine: &DrawnMachine, usual: &Motorcycle, file: BikeFile) -> Result<Bike, Error> {
    if file == BikeFile::Wizard {
        return super::wizard::bike(machine);
    }
    let DrawnMachine { seed, number, attempt, plant, .. } = machine;
    let vehicle = &plant.vehicle;
    let mut random = Random::new(*seed, &format!("bike file {number} attempt {attempt}"));
    // key, truth, standard deviation of the measurement
    let mut known: Vec<(String, f64, f64)> = [
        ("mass", vehicle.mass, 2.0),             // two scales
        ("wheelbase", vehicle.wheelbase, 0.003), // tape
        ("cg_to_front", vehicle.cg_to_front, 0.007),
        ("cg_height", vehicle.cg_height, 0.01), // lifting the rear by a known height
        ("caster_angle", vehicle.caster_angle, 0.004),
        ("trail", usual.trail(), 0.004),
        ("yaw_inertia", usual.inertia()[(2, 2)], 0.08 * usual.inertia()[(2, 2)]),
    ]
    .map(|(key, truth, sd)| (key.to_owned(), truth, sd))
    .to_vec();
    for (k, end) in ["front", "rear"].into_iter().enumerate() {
        let tyre = &plant.tyres[k];
        let width = machine.width(k);
        let numbers = [
            ("radius", tyre.rolling_radius, 0.003),
            ("width", width, 0.001),
            ("wheel_inertia", vehicle.wheel_inertia[k], 0.04 * vehicle.wheel_inertia[k]), // swung
            ("vertical_stiffness", tyre.vertical_stiffness, 0.07 * tyre.vertical_stiffness),
            // a tyre bench
            ("side_force_ratio", tyre.side_force_ratio, 0.1 * tyre.side_force_ratio),
            ("twisting_stiffness", tyre.twisting_stiffness, 0.15 * tyre.twisting_stiffness.abs()),
            ("relaxation_length", tyre.relaxation_length, 0.15 * tyre.relaxation_length),
        ];
        known.extend(numbers.map(|(leaf, truth, sd)| (format!("{end}.{leaf}"), truth, sd)));
    }
    let schema = schema();
    let required = |key: &str| schema.keys.iter().any(|k| k.required && k.path == key);
    let mut text = String::new();
    let mut uncertain = String::new();
    for (key, truth, sd) in &known {
        let measured = within(&mut random, *truth, *sd, 2.0);
        if file != BikeFile::Full && !required(key) {
            continue;
        }
        text += &format!("{key} = {measured:.7}\n");
        // nominal numbers have none: they only check the channels
        let nominal = key.ends_with(".radius") || key.ends_with(".width");
        let said = match file {
            BikeFile::Full => !nominal,
            BikeFile::Tutorial => key == "mass",
            BikeFile::Minimal | BikeFile::Wizard => false,
        };
        if said {
            uncertain += &format!("\"{key}\" = {sd:.7}\n");
        }
    }
    if !uncertain.is_empty() {
        text += &format!("[uncertainty]\n{uncertain}");
    }
    let id = format!("machine_{number:04}");
    Bike::parse(&text, &id, Path::new(file.name())).map_err(|e| Error::Ride(e.to_string()))
}
