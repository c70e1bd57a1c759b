//! What somebody knows of a machine who only looks at it: its class, the sizes printed on its tyres, and what it weighs.

use std::path::Path;

use super::draw::within;
use super::machine::DrawnMachine;
use crate::contract::bike::Bike;
use crate::motorcycle::catalogue::classes::{Class, Usual};
use crate::motorcycle::catalogue::file::text;
use crate::motorcycle::catalogue::{Catalogue, Owner, TyreSize};
use crate::simulate::error::Error;
use crate::statistics::random::Random;

/// Classes that machines of the population may look like.
const CLASSES: [&str; 3] = ["sports", "naked", "touring"];
/// Sizes that are sold for 17 inch rims, front and rear.
const SOLD: [&[&str]; 2] = [
    &["110/70ZR17", "110/80-17", "120/60ZR17", "120/70ZR17"],
    &[
        "150/60ZR17",
        "150/70R17",
        "160/60ZR17",
        "160/70-17",
        "170/60ZR17",
        "180/55ZR17",
        "190/50ZR17",
        "190/55ZR17",
    ],
];
/// How well the weight with rider is known, standard deviation, kg.
const WEIGHT: f64 = 3.0;

/// Statements of a new user about a machine.
///
/// # Errors
/// A size is none (a defect that a test would find).
pub(crate) fn owner(machine: &DrawnMachine) -> Result<Owner, Error> {
    let DrawnMachine { seed, number, attempt, plant, .. } = machine;
    let mut random = Random::new(*seed, &format!("wizard {number} attempt {attempt}"));
    let mut sizes = [None, None];
    for k in 0..2 {
        let tyre = &plant.tyres[k];
        let mut near: Option<(f64, &str)> = None;
        for printed in SOLD[k] {
            let size = TyreSize::parse(printed)?;
            // the width is printed; of the profiles of that width the one that is as high
            let far = 10.0 * (size.width - machine.width(k)).abs()
                + (size.radius() - 0.004 - tyre.rolling_radius).abs();
            if near.is_none_or(|(least, _)| far < least) {
                near = Some((far, printed));
            }
        }
        sizes[k] = near.map(|(_, printed)| printed.to_owned());
    }
    let weight = within(&mut random, plant.vehicle.mass, WEIGHT, 2.0);
    let class = looks_like(machine)?.name.clone();
    Ok(Owner { class: Some(class), sizes, weight: Some(weight), ..Owner::default() })
}

/// The class that is nearest in what is seen: length, size, fairing.
fn looks_like(machine: &DrawnMachine) -> Result<&'static Class, Error> {
    let vehicle = &machine.plant.vehicle;
    let off = |truth: f64, usual: &Usual| ((truth - usual.mean) / usual.sd).powi(2);
    let mut near: Option<(f64, &'static Class)> = None;
    for name in CLASSES {
        let class = Catalogue::builtin().class(name)?;
        let far = off(vehicle.wheelbase, &class.wheelbase)
            + off(vehicle.mass, &class.mass)
            + off(vehicle.drag, &class.drag);
        if near.is_none_or(|(least, _)| far < least) {
            near = Some((far, class));
        }
    }
    near.map(|(_, class)| class).ok_or_else(|| Error::Ride("no class".to_owned()))
}

/// The bike file that `roadbench bike new` writes for that.
///
/// # Errors
/// A number is outside the schema's range (a defect that a test would find).
pub(crate) fn bike(machine: &DrawnMachine) -> Result<Bike, Error> {
    let portrait = owner(machine)?.portrait(Catalogue::builtin())?;
    let id = format!("machine_{:04}", machine.number);
    let text = text(&portrait, &id)?;
    Bike::parse(&text, &id, Path::new("wizard")).map_err(|e| Error::Ride(e.to_string()))
}
