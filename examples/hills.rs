//! What an altitude is worth on hilly roads: rides over slopes that the logger sees with a receiver's errors, and the same
//! rides without the altitude.
//!
//! ```text
//! cargo run --release --example hills -- --rides 40 --seed 1
//! ```
//!
//! Prints for drag, rolling resistance and what else depends on the slope how far off the value is, how wide the interval
//! and how often it contains the true value: of 40 rides on level road, and on slopes of 4.5 % (one standard deviation).

use std::collections::BTreeMap;

use rayon::prelude::*;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::coefficient::{Coefficient, Id, Part};
use roadbench::internals::fit::{self, coefficients};
use roadbench::internals::pipeline::{Pipeline, characterise};
use roadbench::internals::simulate::scenario::Scenario;
use roadbench::internals::simulate::sensors::Sensor;
use roadbench::internals::simulate::{session, truth};
use roadbench::internals::store::tables::rows::{Coefficient as Row, Status};
use roadbench::internals::tyre::formulation::Formulation;

/// What is compared.
pub const ASKED: [(Part, Coefficient); 7] = [
    (Part::Vehicle, Coefficient::Drag),
    (Part::Vehicle, Coefficient::RollingResistance),
    (Part::Front, Coefficient::EffectiveRollingRadius),
    (Part::Front, Coefficient::MfD),
    (Part::Rear, Coefficient::MfD),
    (Part::Front, Coefficient::SlipStiffness),
    (Part::Rear, Coefficient::SlipStiffness),
];

/// One coefficient of all rides.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// Value over truth less one, of every value.
    pub errors: Vec<f64>,
    /// Half width of the interval over the truth, of every `ok` value.
    pub widths: Vec<f64>,
    /// `ok` values.
    pub ok: usize,
    /// `ok` values whose interval contains the true value.
    pub inside: usize,
}

/// Coefficients of all rides, by name.
pub type Tallies = BTreeMap<String, Tally>;

/// Rides of as many motorcycles on slopes of a standard deviation (rise over run, from stretch to stretch): what comes out
/// where the logger has no altitude, and where it has one.
pub fn ridden(grade: f64, rides: usize, seed: u64) -> [Tallies; 2] {
    let mut scenario = Scenario::builtin("naturalistic").expect("built in");
    scenario.seed = seed;
    scenario.disturbance.grade = grade;
    scenario.disturbance.bend = 40.0;
    // a receiver: metres of slow error, decimetres of noise
    let receiver = Sensor {
        white: 0.2,
        slow: 2.0,
        slow_time: 60.0,
        bias: 5.0,
        quantum: 0.1,
        ..Sensor::default()
    };
    scenario.sensors.insert(Channel::Altitude.name().to_owned(), receiver);
    let pipeline = Pipeline::onroad();
    let of = |number: usize| {
        let machine = scenario.machine(number);
        let simulated = session(&scenario, &machine, number);
        let truth = truth::coefficients(&machine.plant, &simulated, &pipeline.estimate);
        let rows = [false, true].map(|has_altitude| {
            let mut log = simulated.session.clone();
            if !has_altitude {
                log.remove(Channel::Altitude);
            }
            let done = characterise(log, &machine.bike, &pipeline, Formulation::Corrected);
            coefficients::rows(
                &done.solution,
                &machine.bike,
                &fit::Config::default(),
                &|_| None,
                &Default::default(),
                &Default::default(),
            )
        });
        (rows, truth)
    };
    let all: Vec<_> = (0..rides).into_par_iter().map(of).collect();
    let mut tallies = [Tallies::new(), Tallies::new()];
    for (rows, truth) in &all {
        for (tallies, rows) in tallies.iter_mut().zip(rows) {
            add(tallies, rows, truth);
        }
    }
    tallies
}

/// Adds the coefficients of a ride.
fn add(tallies: &mut Tallies, rows: &[Row], truth: &[(Id, f64)]) {
    for (part, coefficient) in ASKED {
        let id = Id::from((part, coefficient));
        let Some((_, truth)) = truth.iter().find(|(of, _)| *of == id) else { continue };
        let is_it = |c: &&Row| c.tyre == part.name() && c.coefficient == coefficient.name();
        let Some(row) = rows.iter().find(is_it) else { continue };
        let tally: &mut Tally = tallies.entry(id.to_string()).or_default();
        tally.errors.extend(row.value.map(|value| value / truth - 1.0));
        if let (Status::Ok, Some(low), Some(high)) = (row.status, row.ci95_low, row.ci95_high) {
            tally.ok += 1;
            tally.inside += usize::from((low..=high).contains(truth));
            tally.widths.push(0.5 * (high - low) / truth);
        }
    }
}

/// Median of absolute values.
pub fn median(x: &[f64]) -> f64 {
    let mut x: Vec<f64> = x.iter().map(|x| x.abs()).collect();
    x.sort_by(f64::total_cmp);
    x.get(x.len() / 2).copied().unwrap_or(f64::NAN)
}

#[derive(clap::Parser)]
struct Arguments {
    /// Rides of each road, each on a motorcycle of its own.
    #[arg(long, default_value_t = 40)]
    rides: usize,
    /// Seed of all randomness.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[allow(dead_code)] // the tests use the rest
fn main() {
    let Arguments { rides, seed } = clap::Parser::parse();
    println!(
        "| slope | altitude | coefficient | median error | half width | `ok` | contain the true value |"
    );
    println!("|---|---|---|---|---|---|---|");
    for grade in [0.0, 0.045] {
        for (altitude, tallies) in [false, true].into_iter().zip(ridden(grade, rides, seed)) {
            for (id, t) in tallies {
                println!(
                    "| {:.1} % | {} | {id} | {:.1} % | {:.1} % | {} of {rides} | {} |",
                    100.0 * grade,
                    if altitude { "yes" } else { "no" },
                    100.0 * median(&t.errors),
                    100.0 * median(&t.widths),
                    t.ok,
                    t.inside
                );
            }
        }
    }
}
