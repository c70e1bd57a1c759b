//! What rides of one motorcycle say of each other: their estimates, and what differs from the other rides.
//!
//! ```text
//! cargo run --release --example differences -- --plant ../shared/data/independent_plant
//! cargo run --release --example differences -- --rides 10 --seed 3 --machines 4
//! ```

use std::path::{Path, PathBuf};

use clap::Parser;
use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::session::Session;
use roadbench::internals::diagnose::road::estimates::estimates;
use roadbench::internals::diagnose::road::fitted;
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::{self, Pipeline};
use roadbench::internals::simulate::effects::{ALL, Effect, ModelError};
use roadbench::internals::simulate::hidden::{Case, Kind};
use roadbench::internals::simulate::multibody_ride::ridden;
use roadbench::internals::simulate::population::Machine;
use roadbench::internals::simulate::population::bike::BikeFile;
use roadbench::internals::store::tables::rows::{EffectTrace, EstimateRow, Ident};

#[derive(Parser)]
struct Arguments {
    /// Folder of rides with `sessions/` and `bikes/` each.
    #[arg(long)]
    plant: Vec<PathBuf>,
    /// Fault-free rides of each machine of the population; faulted ones beside them.
    #[arg(long, default_value_t = 0)]
    rides: usize,
    /// Machines of the population.
    #[arg(long, default_value_t = 1)]
    machines: usize,
    /// Seed of the population.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Share of the usual size that is hidden in the faulted rides.
    #[arg(long, default_value_t = 1.0)]
    size: f64,
    /// Where the estimates are written, as JSON lines.
    #[arg(long)]
    out: PathBuf,
}

type Failure = Box<dyn std::error::Error + Send + Sync>;
type Said = (Vec<EstimateRow>, Vec<EffectTrace>);

fn said(session: &Session, bike: &Bike, ident: &Ident) -> Result<Said, Failure> {
    let fit = fitted(session, bike, &Pipeline::onroad()).map_err(|e| e.message)?;
    let base = fit.base.clone().starting_point(&fit.samples, ALL).base;
    Ok(estimates(&fit.samples, &base, ALL, ident))
}

fn of_plant(folder: &Path) -> Result<Said, Failure> {
    let only = |part: &str| -> Result<PathBuf, Failure> {
        let mut files = std::fs::read_dir(folder.join(part))?;
        Ok(files.next().ok_or("no file")??.path())
    };
    let bike = Bike::read(&only("bikes")?)?;
    let (session, _) = pipeline::prepare(only("sessions")?, &[], &bike, &Pipeline::onroad())
        .map_err(|e| e.message)?;
    let name = |p: &Path| p.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let set = folder.parent().map(name).unwrap_or_default();
    said(&session, &bike, &Ident { session_id: name(folder), bike_id: set, start_time: None })
}

/// The ride of a number of one machine, with something hidden or nothing.
fn of_machine(
    seed: u64,
    number: usize,
    ride: usize,
    hidden: Option<(&'static Effect, f64)>,
) -> Result<Said, Failure> {
    let none = Case {
        seed,
        number,
        kind: Kind::Null,
        plan: "naturalistic",
        hidden: Vec::new(),
        foreign: None,
    };
    let (mut scenario, _) = none.machine()?;
    scenario.seed = 7919 * (ride as u64 + 1) + 31 * seed + number as u64;
    let mut error = ModelError::default();
    if let Some((effect, size)) = hidden {
        (effect.set)(&mut error, size);
    }
    let machine = Machine::draw(seed, number, 0)?;
    let tour = machine.tour(&scenario, &error, BikeFile::Full)?;
    let ride_of = ridden(&tour, number)?;
    let what = hidden.map_or("none".to_owned(), |(e, size)| format!("{}:{size}", e.name));
    let ident = Ident {
        session_id: format!("{ride:03}/{what}"),
        bike_id: format!("machine {number}"),
        start_time: None,
    };
    let bike = tour.bike;
    let folder = tempfile::tempdir()?;
    let log = folder.path().join("ride.parquet");
    write_session(&log, &ride_of.session, false)?;
    let (session, _) =
        pipeline::prepare(log, &[], &bike, &Pipeline::onroad()).map_err(|e| e.message)?;
    said(&session, &bike, &ident)
}

fn main() -> Result<(), Failure> {
    let a = Arguments::parse();
    let mut text = String::new();
    let mut add = |all: Vec<Result<Said, Failure>>| {
        for one in all {
            match one {
                Ok((rows, traces)) => {
                    let line = serde_json::json!({ "estimates": rows, "traces": traces });
                    text += &format!("{line}\n");
                }
                Err(e) => eprintln!("{e}"),
            }
        }
    };
    for set in &a.plant {
        let mut folders: Vec<PathBuf> = std::fs::read_dir(set)?
            .filter_map(|e| Some(e.ok()?.path()).filter(|p| p.is_dir()))
            .collect();
        folders.sort();
        add(folders.par_iter().map(|f| of_plant(f)).collect());
    }
    for number in 0..a.machines {
        let mut wanted: Vec<(usize, Option<(&'static Effect, f64)>)> =
            (0..a.rides).map(|k| (k, None)).collect();
        if a.rides > 0 {
            wanted.extend(ALL.iter().enumerate().map(|(k, e)| {
                let size = a.size * e.typical;
                (500 + k, Some((e, size)))
            }));
        }
        add(wanted.par_iter().map(|(k, h)| of_machine(a.seed, number, *k, *h)).collect());
    }
    std::fs::write(&a.out, text)?;
    Ok(())
}
