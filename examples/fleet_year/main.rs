//! A fleet of a year, simulated: are planted events found, and do the estimates of many rides hold the truth?
//!
//! ```text
//! cargo run --release --example fleet_year -- year --rides /tmp/year
//! cargo run --release --example fleet_year -- many --rides /tmp/many --machines 10 --each 100
//! ```
//!
//! Rides come from the simulator and go through the pipeline as logs do; what they gave is kept in the folder `--rides`,
//! and rides that are there are not ridden again. `year` draws 20,000 sessions from 748 rides: a session has the level of its
//! motorcycle's own rides and the deviations of one ride of the fleet, so that errors keep their sizes, correlations and
//! tails.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Parser, Subcommand};
use rayon::prelude::*;
use roadbench::fleet;

mod machines;
mod planted;
mod rides;
mod score;
mod year;

use machines::Fleet;
use rides::{Failure, State};

#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Planted events of a year in 50 motorcycles: found, missed, false, late.
    Year {
        /// Folder of the rides.
        #[arg(long)]
        rides: PathBuf,
        /// Of all randomness.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// Machines on tyres of one model: error and coverage of tyre estimates by number of rides and machines.
    Many {
        /// Folder of the rides.
        #[arg(long)]
        rides: PathBuf,
        /// Of all randomness.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Machines.
        #[arg(long, default_value_t = 10)]
        machines: usize,
        /// Rides of each.
        #[arg(long, default_value_t = 100)]
        each: usize,
    },
}

/// Machines on tyres of one model.
fn alike(fleet: &Fleet, machines: usize, rides: usize) -> Vec<State> {
    let state = |bike: usize| {
        let machine = fleet.machine(bike, [0; 2]);
        let file = machine.bike.clone();
        State { bike, name: planted::USUAL.to_owned(), machine, file, gains: [1.0; 2], rides }
    };
    (0..machines).map(state).collect()
}

/// Peak of the memory that this program had, MB.
fn peak() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let kb = line.and_then(|l| l.split_whitespace().next()?.parse::<f64>().ok());
    kb.unwrap_or(f64::NAN) / 1024.0
}

/// The year: what was planted, and what of it is told.
fn year_of(folder: &Path, states: &[State], seed: u64) -> Result<(), Failure> {
    let mut found = Vec::new();
    for state in states {
        let file = &state.machine.bike;
        let names = [file.front.model.clone(), file.rear.model.clone()];
        found.push((state.bike, state.name.clone(), names, rides::read(folder, state)?));
    }
    let source = year::Source::new(&found);
    let planted = planted::planted();
    let years = year::all(&source, &planted, seed, false);
    let observations: Vec<_> = years.iter().flat_map(|y| y.observations.iter().cloned()).collect();
    println!(
        "{} motorcycles, {} sessions, {} values, {} rows of evidence; {:.0} MB",
        years.len(),
        years.len() * year::EACH,
        observations.len(),
        years.iter().map(|y| y.pieces.len()).sum::<usize>(),
        peak()
    );
    let begin = Instant::now();
    let bikes = fleet::analyse(&observations);
    println!("search and statistics: {:.1} s, {:.0} MB", begin.elapsed().as_secs_f64(), peak());
    let begin = Instant::now();
    let tyres: Vec<_> =
        bikes.par_iter().zip(&years).map(|(b, y)| fleet::tyres::of_bike(b, &y.pieces)).collect();
    println!(
        "combination: {:.1} s, {} estimates of tyres and motorcycles; {:.0} MB",
        begin.elapsed().as_secs_f64(),
        tyres.iter().map(|t| t.tyres.len()).sum::<usize>(),
        peak()
    );
    for rate in [1.0, 0.05, 0.01] {
        score::print(&bikes, &planted, rate);
    }
    score::print_false(&bikes, &planted);
    Ok(())
}

fn main() -> Result<(), Failure> {
    match Arguments::parse().what {
        What::Year { rides, seed } => {
            let fleet = Fleet::new("year", seed)?;
            let states = planted::states(&fleet);
            rides::ride(&rides, &fleet.scenario, &states)?;
            year_of(&rides, &states, seed)?;
        }
        What::Many { rides, seed, machines, each } => {
            let fleet = Fleet::new("many", seed)?;
            rides::ride(&rides, &fleet.scenario, &alike(&fleet, machines, each))?;
        }
    }
    Ok(())
}
