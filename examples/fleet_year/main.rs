//! A fleet of a year, simulated: are planted events found, and do the estimates of many rides contain the true value?
//!
//! ```text
//! cargo run --release --example fleet_year -- year --rides /tmp/year
//! cargo run --release --example fleet_year -- many --rides /tmp/many --machines 10 --each 100
//! ```
//!
//! Rides come from the simulator and go through the pipeline as logs do; what they gave is kept in the folder `--rides`,
//! and rides that are there are not ridden again. `year` draws 20,000 sessions from 748 rides: a session has the level
//! of its motorcycle's own rides and the deviations of one ride of the fleet, so that errors keep their sizes,
//! correlations and tails.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Parser, Subcommand};
use rayon::prelude::*;
use roadbench::internals::fleet;

mod machines;
mod many;
mod planted;
mod rides;
mod score;
mod variety;
mod year;

use machines::Fleet;
use many::Ridden;
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
        /// Only asks every week what is reported by then: how late events are reported.
        #[arg(long)]
        late: bool,
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
    /// Side-force ratio, crowns and height of the centre of mass by variety of rides: speeds, leans, riders.
    Variety {
        /// Folder of the rides.
        #[arg(long)]
        rides: PathBuf,
        /// Of all randomness.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Machines.
        #[arg(long, default_value_t = 6)]
        machines: usize,
    },
}

/// The rides of machines as they are, with the tyre model of each.
fn ridden(
    folder: &Path,
    states: Vec<State>,
    model: impl Fn(usize) -> usize,
) -> Result<Vec<Ridden>, Failure> {
    let usual = states.into_iter().filter(|s| s.name == planted::USUAL);
    let one = |state: State| {
        let rides = rides::read(folder, &state)?;
        Ok(Ridden { model: model(state.bike), machine: state.machine, rides })
    };
    usual.map(one).collect()
}

/// Machines on tyres of one model.
fn alike(fleet: &Fleet, machines: usize, rides: usize) -> Vec<State> {
    let state = |bike: usize| {
        let machine = fleet.machine(bike, [0; 2]);
        let file = machine.bike.clone();
        State {
            bike,
            name: planted::USUAL.to_owned(),
            machine,
            file,
            gains: [1.0; 2],
            first: 0,
            rides,
        }
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

/// The year: planted events, and those of them that are reported.
fn year_of(folder: &Path, states: &[State], seed: u64) -> Result<(), Failure> {
    let source = source(folder, states)?;
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
    // as it would be without the season and the site: of ten motorcycles nothing common is taken out
    let alone: Vec<_> = observations
        .chunk_by(|a, b| a.bike[..a.bike.len() - 1] == b.bike[..b.bike.len() - 1])
        .flat_map(fleet::analyse)
        .collect();
    println!("\nten motorcycles at a time, so that season and site are not taken out:");
    score::print(&alone, &planted, 1.0);
    Ok(())
}

/// How many days after the day it happened each planted event is reported, asked every week.
fn late_of(folder: &Path, states: &[State], seed: u64) -> Result<(), Failure> {
    let planted = planted::planted();
    let years = year::all(&source(folder, states)?, &planted, seed, false);
    let mut told: BTreeMap<usize, f64> = BTreeMap::new();
    let (mut wrong, mut asked) = (BTreeMap::<String, f64>::new(), 0);
    for week in 4..=52 {
        let now = 7.0 * f64::from(week);
        let until = |o: &&fleet::Observation| o.day.is_some_and(|day| day < year::BEGIN + now);
        let some: Vec<_> =
            years.iter().flat_map(|y| y.observations.iter().filter(until).cloned()).collect();
        asked += 1;
        for (number, bike) in fleet::analyse(&some).iter().enumerate() {
            for event in &bike.events {
                match score::verdict(bike, number, event, &planted) {
                    // an event that has not happened yet cannot be reported
                    score::Verdict::Of(i, ..) if planted[i].from < now => {
                        told.entry(i).or_insert(now);
                    }
                    score::Verdict::False => {
                        let name = format!("{number} {}", history_day(bike, event));
                        wrong.entry(name).or_insert(now);
                    }
                    _ => {}
                }
            }
        }
    }
    println!("asked {asked} times, every week; {} false events told at some time", wrong.len());
    score::print_late(&planted, &told);
    Ok(())
}

/// The day an event begins, in weeks: the same event reported again is one.
fn history_day(bike: &fleet::BikeAnalysis, event: &fleet::events::Event) -> i64 {
    let day = bike.history.days[event.sessions().start].unwrap_or(f64::NAN) - year::BEGIN;
    (day / 7.0) as i64
}

fn source(folder: &Path, states: &[State]) -> Result<year::Source, Failure> {
    let mut found = Vec::new();
    for state in states {
        let file = &state.machine.bike;
        let names = [file.front.model.clone(), file.rear.model.clone()];
        found.push((state.bike, state.name.clone(), names, rides::read(folder, state)?));
    }
    Ok(year::Source::new(&found))
}

fn main() -> Result<(), Failure> {
    match Arguments::parse().what {
        What::Year { rides, seed, late } => {
            let fleet = Fleet::new("year", seed)?;
            let states = planted::states(&fleet);
            rides::ride(&rides, &fleet.scenario, &states)?;
            if late {
                return late_of(&rides, &states, seed);
            }
            year_of(&rides, &states, seed)?;
            // the rides that the year is drawn from are real ones of 50 machines on tyres of 8 models
            let ridden = ridden(&rides, states, |bike| planted::models(bike)[0])?;
            many::print(&ridden);
            many::print_numbers(&ridden, 10);
        }
        What::Variety { rides, seed, machines } => {
            variety::print(&rides, &Fleet::new("variety", seed)?, machines)?;
        }
        What::Many { rides, seed, machines, each } => {
            let fleet = Fleet::new("many", seed)?;
            let states = alike(&fleet, machines, each);
            rides::ride(&rides, &fleet.scenario, &states)?;
            let ridden = ridden(&rides, states, |_| 0)?;
            many::print(&ridden);
            [10, 30, 100].into_iter().for_each(|n| many::print_numbers(&ridden, n));
        }
    }
    Ok(())
}
