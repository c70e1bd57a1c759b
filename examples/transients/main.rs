//! Cornering and camber stiffness from changing lean, against the truth of rides that this project did not simulate:
//! folders with `sessions/`, `bikes/` and `truth.json`.
//!
//! ```text
//! cargo run --release --example transients -- ../shared/data/independent_plant_transients ../shared/data/independent_plant
//! cargo run --release --example transients -- --population 40
//! cargo run --release --example transients -- --pooled 3 --each 30 --seed 9
//! cargo run --release --example transients -- --traps 6 --seed 9 --plan "full transient programme"
//! cargo run --release --example transients -- --speed --population 6
//! ```
//!
//! `--pooled` rides the same tyres again and again and pools what the rides give (table `tyres`), `--traps` plants faults that
//! the estimate does not know of, `--speed` takes the time of a session with and without the estimate.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Parser;
use rayon::prelude::*;
use roadbench::internals::contract::bike::{Axle, Bike};
use roadbench::internals::contract::coefficient::{Coefficient, Id};
use roadbench::internals::contract::session::Session;
use roadbench::internals::fit::transients::{self, OF_TYRE, QUANTITIES, Transients, law};
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::{self, Input, Outcome, Pipeline};
use roadbench::internals::simulate::hidden::{Kind, plan_named};
use roadbench::internals::simulate::population::bike::BikeFile;
use roadbench::internals::simulate::population::ride;
use roadbench::internals::store::objects::Location;
use roadbench::internals::tyre::formulation::Formulation;
use serde_json::Value;

mod pooled;
mod traps;

#[derive(Parser)]
struct Arguments {
    /// Folders of rides.
    rides: Vec<PathBuf>,
    /// Rides of the population of machines, each on one of its own.
    #[arg(long, default_value_t = 0)]
    population: usize,
    /// Seed of the population.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// What the population rides; without it each ride's own plan.
    #[arg(long)]
    plan: Option<String>,
    /// Machines whose rides are pooled.
    #[arg(long, default_value_t = 0)]
    pooled: usize,
    /// Rides of each of them.
    #[arg(long, default_value_t = 30)]
    each: usize,
    /// Machines that faults are planted in.
    #[arg(long, default_value_t = 0)]
    traps: usize,
    /// Time of a session with the estimate over that without.
    #[arg(long)]
    speed: bool,
    /// Every parameter of every ride.
    #[arg(long)]
    parameters: bool,
    /// The fit's settings, as in a pipeline's `[transients]`.
    #[arg(long, default_value = "")]
    settings: String,
}

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// What `run` makes of a session in a log of its own.
fn logged(
    session: &Session,
    log: &Path,
    bike: &Bike,
    pipeline: &Pipeline,
) -> Result<Outcome, Failure> {
    write_session(log, session, true)?;
    of_log(log, bike, pipeline)
}

/// What `run` makes of a log.
fn of_log(log: &Path, bike: &Bike, pipeline: &Pipeline) -> Result<Outcome, Failure> {
    let input = Input {
        log: Location::from(log),
        maps: &[],
        input_hash: String::new(),
        pipeline_hash: String::new(),
        signals: false,
    };
    Ok(pipeline::run(&input, bike, pipeline).map_err(|e| e.message)?)
}

/// Half widths of the 95 % intervals of stiffness, ratio and camber stiffness of both tyres, shares of the values.
fn half_widths(fitted: &transients::Fitted) -> [[f64; 3]; 2] {
    let law = law(fitted);
    [0, 1].map(|k| {
        let ratio = fitted.theta[k * OF_TYRE + 1];
        let half = |of: [f64; 2]| {
            let mut contrast = [0.0; 4];
            contrast[2 * k..2 * k + 2].copy_from_slice(&of);
            let relative = [of[0], of[1] * ratio];
            let of_law = law.map(|l| (l[0] * relative[0] + l[1] * relative[1]).powi(2));
            1.96 * (fitted.variance(&contrast) + of_law[0] + of_law[1]).sqrt()
        };
        [half([1.0, 0.0]), half([0.0, 1.0]) / ratio, half([1.0, 1.0 / ratio])]
    })
}

/// A ride as its user has it, and its truth.
struct Ride {
    name: String,
    session: Session,
    bike: Bike,
    /// Stiffness, ratio, camber stiffness and relaxation length of both tyres.
    truth: [[f64; 4]; 2],
}

impl Ride {
    /// A ride of the population.
    fn of_population(
        (seed, plan): (u64, Option<&str>),
        number: usize,
        folder: &Path,
    ) -> Result<Self, Failure> {
        let mut case = ride::case(seed, number, Kind::Null, [1.0, 1.0]);
        if let Some(name) = plan {
            case.plan = plan_named(name).ok_or("there is no such plan")?;
        }
        let ridden = ride::ride(&case, BikeFile::Full)?;
        let log = folder.join(format!("{number}.parquet"));
        write_session(&log, &ridden.ride.session, false)?;
        let bike = ridden.tour.bike.clone();
        let pipeline = Pipeline::onroad();
        let (session, _) =
            pipeline::prepare(log.clone(), &[], &bike, &pipeline).map_err(|e| e.message)?;
        std::fs::remove_file(log)?;
        let known = ridden.truth(&pipeline.estimate);
        let of = |axle: Axle, c: Coefficient| {
            let id = Id::from((axle, c));
            known.iter().find(|(known, _)| *known == id).map_or(f64::NAN, |(_, value)| *value)
        };
        let truth = Axle::BOTH.map(|axle| {
            let [k, g] = [Coefficient::CorneringStiffness0, Coefficient::CamberStiffness0]
                .map(|c| of(axle, c));
            [k, g / k, g, of(axle, Coefficient::RelaxationLength)]
        });
        let name = format!("{number} {}: {}", case.plan, ridden.machine);
        Ok(Ride { name, session, bike, truth })
    }

    fn read(folder: &Path) -> Result<Self, Failure> {
        let only = |part: &str| -> Result<PathBuf, Failure> {
            let mut files = std::fs::read_dir(folder.join(part))?;
            Ok(files.next().ok_or("no file")??.path())
        };
        let bike = Bike::read(&only("bikes")?)?;
        let (session, _) = pipeline::prepare(only("sessions")?, &[], &bike, &Pipeline::onroad())
            .map_err(|e| e.message)?;
        let truth: Value = serde_json::from_slice(&std::fs::read(folder.join("truth.json"))?)?;
        let truth = ["front", "rear"].map(|tyre| {
            let all = &truth["coefficients"][tyre];
            let of = |name: &str| all[name].as_f64().unwrap_or(f64::NAN);
            let lag = all["relaxation_length"]["15"].as_f64().unwrap_or(f64::NAN);
            let [k, g] = ["cornering_stiffness_0", "camber_stiffness_0"].map(of);
            [k, g / k, g, lag]
        });
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Ride { name, session, bike, truth })
    }
}

/// Relative error and half width of a 95 % interval.
type Found = [f64; 2];

/// Those of a ride: both tyres, four numbers each.
fn compared(ride: &Ride, found: &Transients) -> [[Found; 4]; 2] {
    let fitted = &found.fitted;
    let half = half_widths(fitted);
    [0, 1].map(|k| {
        let truth = ride.truth[k];
        let at = |j: usize| fitted.theta[k * OF_TYRE + j];
        let (stiffness, ratio, relaxation) = (at(0).exp(), at(1), at(5));
        // both as shares of the truth
        let of = |j: usize, value: f64, half: f64| {
            let share = value / truth[j];
            [share - 1.0, half * share.abs()]
        };
        [
            of(0, stiffness, half[k][0]),
            of(1, ratio, half[k][1]),
            of(2, stiffness * ratio, half[k][2]),
            of(3, relaxation, f64::NAN),
        ]
    })
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    let settings: transients::Config = toml::from_str(&arguments.settings)?;
    for folder in &arguments.rides {
        let mut folders: Vec<PathBuf> =
            std::fs::read_dir(folder)?.map(|e| e.map(|e| e.path())).collect::<Result<_, _>>()?;
        folders.retain(|f| f.is_dir());
        folders.sort();
        let rides: Vec<Ride> = folders.iter().map(|f| Ride::read(f)).collect::<Result<_, _>>()?;
        let fits = fitted(&rides, &settings);
        print(&rides, &fits, arguments.parameters);
    }
    let work = tempfile::tempdir()?;
    let riding = (arguments.seed, arguments.plan.as_deref());
    let asked = (arguments.seed, riding.1.unwrap_or("naturalistic"));
    if arguments.pooled > 0 {
        return pooled::run(arguments.seed, arguments.pooled, arguments.each, work.path());
    }
    if arguments.traps > 0 {
        return traps::run(asked, arguments.traps, work.path());
    }
    let of = |number| match Ride::of_population(riding, number, work.path()) {
        Ok(ride) => Some(ride),
        Err(why) => {
            eprintln!("{number}: {why}");
            None
        }
    };
    let rides: Vec<Ride> = (0..arguments.population).into_par_iter().filter_map(of).collect();
    if arguments.speed {
        return speed(&rides, work.path());
    }
    if !rides.is_empty() {
        print(&rides, &fitted(&rides, &settings), arguments.parameters);
    }
    Ok(())
}

/// How often each ride is timed.
const TIMED: usize = 5;

/// Time of a whole session, log to tables, with the fit to changing lean over that without: each ride in turn, the median of
/// several.
fn speed(rides: &[Ride], work: &Path) -> Result<(), Failure> {
    let with = Pipeline::onroad();
    let mut without = with.clone();
    without.transients.enabled = false;
    let mut ratios = Vec::new();
    for (number, ride) in rides.iter().enumerate() {
        let log = work.join(format!("speed_{number}.parquet"));
        write_session(&log, &ride.session, true)?;
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..TIMED {
            for (times, pipeline) in times.iter_mut().zip([&with, &without]) {
                let begin = Instant::now();
                of_log(&log, &ride.bike, pipeline)?;
                times.push(begin.elapsed().as_secs_f64());
            }
        }
        let [a, b] = times.map(|mut x| {
            x.sort_by(f64::total_cmp);
            x[x.len() / 2]
        });
        println!("{}: {a:.3} s with, {b:.3} s without, {:.2}", ride.name, a / b);
        ratios.push(a / b);
    }
    ratios.sort_by(f64::total_cmp);
    let middle = ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN);
    println!("median {middle:.2} of {} sessions", ratios.len());
    Ok(())
}

fn fitted(rides: &[Ride], settings: &transients::Config) -> Vec<Option<Transients>> {
    let fit = |ride: &Ride| {
        let (session, pipeline) = (ride.session.clone(), Pipeline::onroad());
        let ridden = pipeline::characterise(session, &ride.bike, &pipeline, Formulation::Corrected);
        ridden.transients(settings)
    };
    rides.par_iter().map(fit).collect()
}

fn print(rides: &[Ride], fits: &[Option<Transients>], parameters: bool) {
    let names = ["k_alpha", "C", "k_gamma", "sigma"];
    let mut all: Vec<[[Found; 4]; 2]> = Vec::new();
    for (ride, fit) in rides.iter().zip(fits) {
        let Some(fit) = fit else {
            println!("{} no fit", ride.name);
            continue;
        };
        let found = compared(ride, fit);
        let text = |f: &Found| {
            let mark = if f[0].abs() <= f[1] { ' ' } else { '!' };
            format!("{:+6.1} ±{:5.1}{mark}", 100.0 * f[0], 100.0 * f[1])
        };
        let line = |k: usize| found[k].iter().map(text).collect::<Vec<_>>().join(" ");
        let f = &fit.fitted;
        println!(
            "{} front {} | rear {} | {} stretches {} samples fast {:.1} s steep {} scale {:.2?} light {:.3}",
            ride.name,
            line(0),
            line(1),
            f.stretches,
            f.samples,
            f.fast,
            f.steep,
            f.scale,
            f.outliers
        );
        if parameters {
            for (i, name) in ["front stiffness", "front ratio", "rear stiffness", "rear ratio"]
                .into_iter()
                .enumerate()
            {
                let mut parts: Vec<(f64, &str)> = f
                    .shifts
                    .iter()
                    .map(|(source, shift)| (shift[i].abs(), source.name.as_str()))
                    .collect();
                parts.push((f.noise[(i, i)].sqrt(), "noise"));
                parts.sort_by(|a, b| b.0.total_cmp(&a.0));
                let words: Vec<String> =
                    parts.iter().take(9).map(|(part, name)| format!("{name} {part:.3}")).collect();
                println!("    {name}: {}", words.join(", "));
            }
            let p = &fit.parameters;
            for j in 0..p.mean.len() {
                let name = match j.checked_sub(QUANTITIES) {
                    Some(k) => format!("{:?}", p.quantities[k]),
                    None => p.sources[j].name.clone(),
                };
                let by = (f.theta[j] - p.mean[j]) / p.sd[j];
                println!(
                    "    {name:28} {:10.5} prior {:10.5} ({by:+.2} sd)",
                    f.theta[j], p.mean[j]
                );
            }
        }
        all.push(found);
    }
    let median = |mut x: Vec<f64>| {
        x.sort_by(f64::total_cmp);
        100.0 * x.get(x.len() / 2).copied().unwrap_or(f64::NAN)
    };
    for (k, tyre) in ["front", "rear"].into_iter().enumerate() {
        for (j, name) in names.into_iter().enumerate() {
            let of = |f: fn(&Found) -> f64| all.iter().map(|x| f(&x[k][j])).collect::<Vec<f64>>();
            let hold = all.iter().filter(|x| x[k][j][0].abs() <= x[k][j][1]).count();
            let lacking = |x: &Found| (x[0] * x[0] - x[1] * x[1]).max(0.0).sqrt() / 1.96;
            let mut lacks: Vec<f64> = all.iter().map(|x| lacking(&x[k][j])).collect();
            lacks.sort_by(f64::total_cmp);
            let rank = ((0.95 * (lacks.len() + 1) as f64) as usize).min(lacks.len());
            let lack = lacks.get(rank.saturating_sub(1)).copied().unwrap_or(f64::NAN);
            println!(
                "{tyre:5} {name:8} |error| {:5.1} % bias {:+5.1} % half width {:5.1} % hold {hold} of {}, lacks {lack:.3}",
                median(of(|f| f[0].abs())),
                median(of(|f| f[0])),
                median(of(|f| f[1])),
                all.len()
            );
        }
    }
}
