//! What is said of rides whose truth is known but that this project did not simulate: folders with `sessions/`,
//! `bikes/` and `truth.json`, as in the independent simulator's.
//!
//! ```text
//! cargo run --release --example plant -- ../shared/data/independent_plant
//! cargo run --release --example plant -- ../shared/data/independent_plant --residuals --sizes
//! ```

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Parser;
use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::session::Session;
use roadbench::internals::diagnose::Settings;
use roadbench::internals::diagnose::calibration::rms;
use roadbench::internals::diagnose::cause::Objection;
use roadbench::internals::diagnose::road::base::{self, Base};
use roadbench::internals::diagnose::road::null_calibration::{calibrate, cells};
use roadbench::internals::diagnose::road::null_simulation::NullSimulation;
use roadbench::internals::diagnose::road::parameters::BASE;
use roadbench::internals::diagnose::road::replay::From;
use roadbench::internals::diagnose::road::residuals::{CHANNELS, blocks};
use roadbench::internals::diagnose::road::samples::Samples;
use roadbench::internals::diagnose::road::scan::scan;
use roadbench::internals::diagnose::road::{self, Fitted};
use roadbench::internals::pipeline::{self, Pipeline};
use roadbench::internals::segment::manoeuvre::ManoeuvreKind;
use roadbench::internals::simulate::effects::Effect;
use roadbench::internals::store::tables::rows::SimulationError;
use serde_json::Value;

#[derive(Parser)]
struct Arguments {
    /// Folder of rides.
    rides: PathBuf,
    /// Only the folders of these names.
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// The rides' residuals against those of their fault-free simulations.
    #[arg(long)]
    residuals: bool,
    /// Every candidate's size with what fault-free simulations show of it.
    #[arg(long)]
    sizes: bool,
    /// Fault-free simulations of each ride.
    #[arg(long, default_value_t = 24)]
    nulls: usize,
}

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// A ride as its user has it, and its truth.
struct Ride {
    name: String,
    session: Session,
    bike: Bike,
    truth: Value,
}

impl Ride {
    fn read(folder: &Path) -> Result<Self, Failure> {
        let only = |part: &str| -> Result<PathBuf, Failure> {
            let mut files = std::fs::read_dir(folder.join(part))?;
            Ok(files.next().ok_or("no file")??.path())
        };
        let bike = Bike::read(&only("bikes")?)?;
        let (session, _) = pipeline::prepare(only("sessions")?, &[], &bike, &Pipeline::onroad())
            .map_err(|e| e.message)?;
        let truth = serde_json::from_slice(&std::fs::read(folder.join("truth.json"))?)?;
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Ride { name, session, bike, truth })
    }

    fn hidden(&self) -> String {
        let effects = self.truth["hidden_effects"].as_array().cloned().unwrap_or_default();
        let text = |e: &Value| format!("{} {}", e["name"].as_str().unwrap_or("?"), e["size"]);
        effects.iter().map(text).collect::<Vec<_>>().join(", ")
    }

    /// What diagnosis says.
    fn causes(&self, nulls: usize) -> Result<String, Failure> {
        let settings = Settings { nulls, ..Settings::default() };
        let found = road::diagnose(&self.session, &self.bike, &Pipeline::onroad(), &settings)
            .map_err(|e| e.message)?;
        let plan = self.truth["plan"].as_str().unwrap_or("?");
        let mut text = format!("{} ({plan}), hidden: {}\n", self.name, self.hidden());
        let said = |v: &str| ["named", "ambiguous", "unexplained"].contains(&v);
        for row in found.causes.iter().filter(|row| said(&row.verdict)) {
            let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.4}"));
            text += &format!(
                "    {} {} {} [{}, {}] {}; score {:.2}{}\n",
                row.verdict,
                row.effect,
                number(row.value),
                number(row.ci95_low),
                number(row.ci95_high),
                row.unit,
                row.score,
                row.equivalent_to.as_deref().map_or(String::new(), |e| format!("; or {e}")),
            );
            if row.effect == "unexplained" {
                text += &format!("        {}\n", row.reason);
            }
        }
        let count = |is: fn(&SimulationError) -> bool| {
            found.simulation_errors.iter().filter(|e| is(e)).count()
        };
        let (better, worse) = (count(SimulationError::is_better), count(SimulationError::is_worse));
        text += &format!("    signals of manoeuvres left out: {better} better, {worse} worse\n");
        for cause in found
            .identification
            .causes
            .iter()
            .filter(|c| c.objection == Some(Objection::WorseSimulation))
        {
            text += &format!("    taken back: {} {:.4}\n", cause.candidate.name, cause.value());
        }
        Ok(text)
    }
}

/// Residuals of a ride in one kind of manoeuvre, and of its simulation with and without noise.
#[derive(Clone, Copy)]
struct Compared {
    ride: f64,
    null: f64,
    clean: f64,
}

type Cells = BTreeMap<(ManoeuvreKind, usize), Compared>;

/// What a ride and its fault-free simulations show of a candidate, in usual sizes.
struct Size {
    name: &'static str,
    /// On the ride.
    size: f64,
    /// Median on fault-free simulations.
    bias: f64,
    /// On a fault-free simulation without noise.
    bare: f64,
    /// Between fault-free simulations.
    spread: f64,
    /// Detection limit.
    limit: f64,
}

/// The cells of a ride, and its candidates.
fn compared(ride: &Ride, nulls: usize) -> Result<(Cells, Vec<Size>), Failure> {
    let pipeline = Pipeline::onroad();
    let effects = Settings::default().effects;
    let Fitted { session, ridden, samples, base, .. } =
        road::fitted(&ride.session, &ride.bike, &pipeline).map_err(|e| e.message)?;
    let start = base.starting_point(&samples, &effects);
    let simulation = NullSimulation::new(&session, &ridden.segments, &start.noise, 1)
        .with_parameters(&start.near.values);
    let calibration = calibrate(&simulation, &start.near, &effects, nulls);
    let own = blocks(&samples, &start.base.values);
    let clean_ride = simulation.noiseless(&start.near.values, From::Session);
    let clean_samples = Samples::take(&clean_ride, simulation.picks());
    let clean = blocks(&clean_samples, &start.near.values);
    let sizes = |samples, found| rms(cells(samples, found).map(|(cell, _, r)| (cell, r)));
    let clean = sizes(&clean_samples, &clean);
    let cells = sizes(&samples, &own)
        .into_iter()
        .map(|(cell, (size, _))| {
            let null = calibration.noise_rms.get(&cell).map_or(f64::NAN, |f| f[0]);
            let clean = clean.get(&cell).map_or(f64::NAN, |c| c.0);
            (cell, Compared { ride: size, null, clean })
        })
        .collect();
    let scores = scan(&samples, &start.near, &effects);
    let bare = base::fit_with(&clean_samples, &start.near.start, &start.near.values, BASE, None);
    let bare = Base { sigma: start.near.sigma, ..bare }.extended(&clean_samples, &[], 6);
    let bare = scan(&clean_samples, &bare, &effects);
    let size = |(j, e): (usize, &Effect)| Size {
        name: e.name,
        size: scores[j].delta,
        bias: calibration.bias[j],
        bare: bare[j].delta,
        spread: calibration.scale.spread[j],
        limit: calibration.limit(j),
    };
    let sizes = effects.iter().enumerate().map(size).collect();
    Ok((cells, sizes))
}

fn median(mut x: Vec<f64>) -> f64 {
    x.retain(|x| x.is_finite());
    x.sort_by(f64::total_cmp);
    x.get(x.len() / 2).copied().unwrap_or(f64::NAN)
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    let mut folders: Vec<PathBuf> = std::fs::read_dir(&arguments.rides)?
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|path| path.join("truth.json").is_file())
        .filter(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            arguments.only.is_empty() || arguments.only.contains(&name)
        })
        .collect();
    folders.sort();
    let rides: Vec<Ride> = folders.iter().map(|f| Ride::read(f)).collect::<Result<_, _>>()?;
    if !arguments.residuals && !arguments.sizes {
        let said: Vec<Result<String, Failure>> =
            rides.par_iter().map(|ride| ride.causes(arguments.nulls)).collect();
        for text in said {
            print!("{}", text?);
        }
        return Ok(());
    }
    let all: Vec<_> = rides
        .par_iter()
        .map(|ride| compared(ride, arguments.nulls))
        .collect::<Result<_, Failure>>()?;
    if arguments.residuals {
        println!("medians over rides: residual, its null simulations', their ratio, without noise");
        let keys: std::collections::BTreeSet<_> = all.iter().flat_map(|(c, _)| c.keys()).collect();
        for key in keys {
            let of = |f: &dyn Fn(&Compared) -> f64| {
                median(all.iter().filter_map(|(c, _)| c.get(key)).map(f).collect())
            };
            println!(
                "{:14} {:18} {:9.5} {:9.5} {:6.2} {:9.5}",
                CHANNELS[key.1],
                key.0.name(),
                of(&|c| c.ride),
                of(&|c| c.null),
                of(&|c| c.ride / c.null),
                of(&|c| c.clean),
            );
        }
    }
    if arguments.sizes {
        println!(
            "in usual sizes, ride by ride: size | bias of null simulations | without noise | spread"
        );
        for j in 0..all.first().map_or(0, |(_, sizes)| sizes.len()) {
            let text = |Size { size, bias, bare, spread, .. }: &Size| {
                format!("{size:6.2}|{bias:5.2}|{bare:5.2}|{spread:5.2}")
            };
            let texts: Vec<String> = all.iter().map(|(_, sizes)| text(&sizes[j])).collect();
            let limit = median(all.iter().map(|(_, sizes)| sizes[j].limit).collect());
            println!("{:24} {}   limit {limit:.2}", all[0].1[j].name, texts.join("  "));
        }
    }
    Ok(())
}
