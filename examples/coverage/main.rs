//! Do the intervals of `run` contain the true value? Rides of the population of machines, each read with what four
//! owners know of their motorcycle.
//!
//! ```text
//! cargo run --release --example coverage -- --rides 100 > coverage.md
//! cargo run --release --example coverage -- --rides 100 --learn
//! cargo run --release --example coverage -- --rides 100 --bands
//! cargo run --release --example coverage -- --rides 20 --plan "full transient programme"
//! cargo run --release --example coverage -- --plant ../shared/data/independent_plant
//! ```
//!
//! Prints, for every coefficient that riding determines and every status, the share of 95 % intervals that
//! contain the true value, how wide they are and how far off the value is.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Parser;
use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::coefficient::{Coefficient, Id, Part, Source};
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::{self, Input, Outcome, Pipeline};
use roadbench::internals::simulate::effects::ModelError;
use roadbench::internals::simulate::hidden::{self, Case, Kind};
use roadbench::internals::simulate::population::bike::{self, BikeFile};
use roadbench::internals::simulate::population::ride::{self, Ridden};
use roadbench::internals::store::objects::Location;

mod bands;
mod plant;

#[derive(Parser)]
struct Arguments {
    /// Rides, each on a machine of its own.
    #[arg(long, default_value_t = 100)]
    rides: usize,
    /// Seed of the population.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Every ride by this plan, instead of the paper's and mixed riding in turn: paper, naturalistic, "mixed + 2
    /// fast passes" or "full transient programme".
    #[arg(long, value_parser = plan_named)]
    plan: Option<&'static str>,
    /// Only with these bike files; may be repeated.
    #[arg(long = "file")]
    files: Vec<String>,
    /// Prints what is to be added to the intervals instead: `[fit.model_error]` of the pipeline.
    #[arg(long)]
    learn: bool,
    /// Prints for each chart how many points of its 95 % bands hold the true curve instead.
    #[arg(long)]
    bands: bool,
    /// A line per coefficient of every ride.
    #[arg(long)]
    verbose: bool,
    /// Only rides the machines: a line each, with what it is, how long the ride and its simulation took.
    #[arg(long)]
    machines: bool,
    /// Only writes the rides' logs and bike files into a folder.
    #[arg(long)]
    logs: Option<PathBuf>,
    /// Folder of rides of the independent simulator with their truth, instead of the population.
    #[arg(long)]
    plant: Option<PathBuf>,
}

type Failure = Box<dyn std::error::Error + Send + Sync>;
/// What a cell of the table is of.
type Key = (BikeFile, Part, Coefficient, &'static str);
/// Truth, value and interval of one coefficient of one ride.
type Compared = (Key, [f64; 4]);

/// What `run` says of one coefficient of one ride, by columns.
#[derive(Default)]
struct Cell {
    /// Rides, also those whose interval is not known; the columns are of the others.
    rides: usize,
    /// Whether the interval contains the true value.
    inside: Vec<bool>,
    /// Half the interval over the truth.
    width: Vec<f64>,
    /// The error over half the interval.
    error: Vec<f64>,
}

fn median(x: &[f64]) -> f64 {
    let mut x: Vec<f64> = x.iter().copied().filter(|x| x.is_finite()).collect();
    x.sort_by(f64::total_cmp);
    x.get(x.len() / 2).copied().unwrap_or(f64::NAN)
}

fn plan_named(name: &str) -> Result<&'static str, String> {
    let known = || {
        let more = hidden::TRANSIENT_PLANS.iter().map(|(name, _)| *name);
        hidden::PLANS.into_iter().chain(more).collect::<Vec<_>>().join(", ")
    };
    hidden::plan_named(name).ok_or_else(|| format!("no plan `{name}`; one of {}", known()))
}

/// The ride of a number, by a plan if one is asked for.
fn case(seed: u64, number: usize, plan: Option<&'static str>) -> Case {
    let drawn = ride::case(seed, number, Kind::Null, [1.0, 1.0]);
    Case { plan: plan.unwrap_or(drawn.plan), ..drawn }
}

/// What `run` makes of a log under a bike file.
fn outcome(log: &Path, bike: &Bike, pipeline: &Pipeline) -> Result<Outcome, Failure> {
    let input = Input {
        log: Location::from(log),
        maps: &[],
        input_hash: String::new(),
        pipeline_hash: String::new(),
        signals: false,
    };
    Ok(pipeline::run(&input, bike, pipeline).map_err(|e| e.message)?)
}

/// What `run` makes of a log under a bike file, beside the truth.
fn characterised(
    log: &Path,
    bike: &Bike,
    pipeline: &Pipeline,
    file: BikeFile,
    truth: &[(Id, f64)],
) -> Result<Vec<Compared>, Failure> {
    let outcome = outcome(log, bike, pipeline)?;
    let row = |c: &roadbench::internals::store::tables::rows::Coefficient| {
        let part = Part::from_name(&c.tyre)?;
        let coefficient = Coefficient::from_name(&c.coefficient)?;
        let id = Id::from((part, coefficient));
        let (_, truth) = truth.iter().find(|(known, t)| *known == id && t.is_finite())?;
        let key = (file, part, coefficient, c.status.name());
        let [value, low, high] = [c.value, c.ci95_low, c.ci95_high].map(|x| x.unwrap_or(f64::NAN));
        Some((key, [*truth, value, low, high]))
    };
    Ok(outcome.coefficients.iter().filter_map(row).collect())
}

/// Fewest intervals to learn from.
const MIN_INTERVALS: usize = 20;
/// Share of the intervals that are to contain the true value.
const LEVEL: f64 = 0.95;
/// Half a 95 % interval over its standard deviation.
const NORMAL: f64 = 1.96;

/// The smallest relative error that, added to the intervals, lets the level contain the true value.
fn needed(intervals: &[[f64; 4]]) -> f64 {
    let one = |[truth, value, low, high]: &[f64; 4]| {
        let (error, half) = (value - truth, 0.5 * (high - low));
        (error * error - half * half).max(0.0).sqrt() / (NORMAL * value.abs())
    };
    let mut all: Vec<f64> = intervals.iter().map(one).collect();
    all.sort_by(f64::total_cmp);
    // of few intervals the level is not known: one more counts as missed
    let rank = (LEVEL * (all.len() + 1) as f64).ceil() as usize;
    all[rank.min(all.len()) - 1]
}

/// Prints what the intervals `ok` with a full bike file lack, by coefficient.
fn learn(found: &[Vec<Compared>]) {
    let mut all: BTreeMap<Coefficient, Vec<[f64; 4]>> = BTreeMap::new();
    for ((file, _, coefficient, status), interval) in found.iter().flatten() {
        if *file == BikeFile::Full && *status == "ok" && interval.iter().all(|x| x.is_finite()) {
            // the camber stiffness is a multiple of the cornering stiffness
            let coefficient = match *coefficient {
                Coefficient::CamberStiffness0 => Coefficient::CorneringStiffness0,
                other => other,
            };
            all.entry(coefficient).or_default().push(*interval);
        }
    }
    println!("[fit.model_error]");
    for (coefficient, intervals) in all.iter().filter(|(_, all)| all.len() >= MIN_INTERVALS) {
        let inside = |[truth, _, low, high]: &&[f64; 4]| (low..=high).contains(&truth);
        let (name, n) = (coefficient.spec().name, intervals.len());
        let holds = intervals.iter().filter(inside).count();
        println!("{name} = {:.5} # {holds} of {n} held without", needed(intervals));
    }
}

/// One ride under every bike file.
fn compared(
    number: usize,
    case: &Case,
    pipeline: &Pipeline,
    work: &Path,
    files: &[BikeFile],
) -> Result<Vec<Compared>, Failure> {
    let ridden = ride::ride(case, BikeFile::Full)?;
    let log = work.join(format!("{number}.parquet"));
    write_session(&log, &ridden.ride.session, false)?;
    let mut truth = ridden.truth(&pipeline.estimate);
    // what no ride determines is not asked
    truth.retain(|(id, _)| id.coefficient.spec().source == Source::OnRoad);
    let Ridden { machine, .. } = &ridden;
    let usual = machine.motorcycle(&ModelError::default())?;
    let mut cells = Vec::new();
    for &file in files {
        let bike = bike::bike(machine, &usual, file)?;
        cells.extend(characterised(&log, &bike, pipeline, file, &truth)?);
    }
    std::fs::remove_file(&log)?;
    Ok(cells)
}

/// What a machine is and how it was ridden, in a line.
fn described(number: usize, case: &Case) -> String {
    let begin = std::time::Instant::now();
    match ride::ride(case, BikeFile::Full) {
        Err(why) => why.to_string(),
        Ok(Ridden { machine, ride, failed, .. }) => format!(
            "{number} {}: {machine}; ride {:.0} s, simulated in {:.1} s{}",
            case.plan,
            ride.session.duration(),
            begin.elapsed().as_secs_f64(),
            failed.iter().map(|why| format!("\n    before: {why}")).collect::<String>(),
        ),
    }
}

/// The folders in a folder, in their order.
fn folders(of: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(of).expect("the folder of --plant");
    let mut all: Vec<PathBuf> =
        entries.flatten().map(|e| e.path()).filter(|p| p.is_dir()).collect();
    all.sort();
    all
}

fn main() {
    let Arguments {
        rides,
        seed,
        plan,
        files,
        learn: learns,
        bands,
        verbose,
        machines,
        logs,
        plant,
    } = Arguments::parse();
    let case = |number: usize| case(seed, number, plan);
    let mut taken = BikeFile::ALL.to_vec();
    taken.retain(|f| files.is_empty() || files.iter().any(|name| name == f.name()));
    if machines {
        (0..rides)
            .into_par_iter()
            .for_each(|number| println!("{}", described(number, &case(number))));
        return;
    }
    if let Some(folder) = logs {
        (0..rides).into_par_iter().for_each(|number| {
            let case = case(number);
            match ride::write(&case, &folder.join(number.to_string())) {
                Ok((_, ridden)) => println!("{number} {}: {}", case.plan, ridden.machine),
                Err(why) => println!("{number}: {why}"),
            }
        });
        return;
    }
    let mut pipeline = Pipeline::onroad();
    if learns {
        pipeline.fit.model_error.clear();
    }
    let work = tempfile::tempdir().expect("a folder for the logs");
    if bands {
        return bands::print(rides, case, &pipeline, work.path());
    }
    let one = |(name, found): (String, Result<Vec<Compared>, Failure>)| match found {
        Ok(cells) => {
            if verbose {
                for ((file, part, coefficient, status), [truth, value, low, high]) in &cells {
                    let (file, c) = (file.name(), coefficient.spec().name);
                    eprintln!(
                        "{name} {file} {part} {c} {status} {truth:.5} {value:.5} [{low:.5}, {high:.5}]"
                    );
                }
            }
            Some(cells)
        }
        Err(why) => {
            eprintln!("{name}: {why}");
            None
        }
    };
    let found: Vec<Vec<Compared>> = match plant {
        None => (0..rides)
            .into_par_iter()
            .map(|number| {
                (
                    number.to_string(),
                    compared(number, &case(number), &pipeline, work.path(), &taken),
                )
            })
            .filter_map(one)
            .collect(),
        Some(folder) => folders(&folder)
            .into_par_iter()
            .map(|ride| (ride.display().to_string(), plant::compared(&ride)))
            .filter_map(one)
            .collect(),
    };
    if learns {
        return learn(&found);
    }
    let mut table: BTreeMap<Key, Cell> = BTreeMap::new();
    for (key, [truth, value, low, high]) in found.iter().flatten() {
        let cell = table.entry(*key).or_default();
        let half = 0.5 * (high - low);
        cell.rides += 1;
        if half.is_finite() {
            cell.inside.push((low..=high).contains(&truth));
            cell.width.push(half / truth.abs());
            cell.error.push((value - truth).abs() / half);
        }
    }
    println!(
        "| bike file | tyre | coefficient | status | rides | interval holds the truth | half interval, % of the truth | error over half interval |"
    );
    println!("|---|---|---|---|---:|---:|---:|---:|");
    for ((file, part, coefficient, status), cell) in &table {
        let n = cell.inside.len();
        let inside = cell.inside.iter().filter(|x| **x).count();
        let number = |x: f64| if x.is_finite() { format!("{x:.2}") } else { "-".to_owned() };
        println!(
            "| {} | {part} | {} | {} | {} | {} | {} | {} |",
            file.name(),
            coefficient.spec().name,
            status.replace('_', " "),
            cell.rides,
            if n > 0 {
                format!("{inside} of {n} ({:.0} %)", 100.0 * inside as f64 / n as f64)
            } else {
                "-".into()
            },
            number(100.0 * median(&cell.width)),
            number(median(&cell.error)),
        );
    }
}
