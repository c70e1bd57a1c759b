//! What rides of one motorcycle say of each other: their estimates, and what differs from the other rides.
//!
//! ```text
//! cargo run --release --example differences -- --plant ../shared/data/independent_plant
//! cargo run --release --example differences -- --rides 10 --seed 3 --machines 4
//! cargo run --release --example differences -- --shared 12 --seed 3 --machines 3
//! ```

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Parser;
use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::session::Session;
use roadbench::internals::diagnose::reference::{Ride, changes, clearness};
use roadbench::internals::diagnose::road::estimates::{Nominal, estimates};
use roadbench::internals::diagnose::road::fitted;
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::{self, Pipeline};
use roadbench::internals::simulate::effects::{ALL, Effect, ModelError};
use roadbench::internals::simulate::hidden::{Case, Kind};
use roadbench::internals::simulate::multibody_ride::ridden;
use roadbench::internals::simulate::population::DrawnMachine;
use roadbench::internals::simulate::population::bike::BikeFile;
use roadbench::internals::store::tables::rows::{
    ChangeRow, Circumstances, EffectTrace, EstimateRow, Ident,
};
use serde::{Deserialize, Serialize};

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
    /// Rides of each machine, some of which share a change: those of a rider, or more and more with time.
    #[arg(long, default_value_t = 0)]
    shared: usize,
    /// Share of the usual size that is hidden in the faulted rides.
    #[arg(long, default_value_t = 1.0)]
    size: f64,
    /// Where the estimates are written, as JSON lines.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Estimates that were written before.
    #[arg(long)]
    read: Vec<PathBuf>,
    /// Numbers of fault-free rides that each ride is compared with.
    #[arg(long, value_delimiter = ',', default_value = "3,5,10")]
    others: Vec<usize>,
}

mod shared;

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// What a ride says, and what is hidden in it.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Said {
    estimates: Vec<EstimateRow>,
    traces: Vec<EffectTrace>,
    /// `none`, or the effect with its size.
    #[serde(default)]
    hidden: String,
}

impl Said {
    fn ident(&self) -> Ident {
        self.estimates.first().map(|row| row.ident.clone()).unwrap_or_default()
    }

    fn id(&self) -> String {
        self.ident().session_id
    }

    fn bike(&self) -> String {
        self.ident().bike_id
    }

    fn effect(&self) -> &str {
        self.hidden.split(':').next().unwrap_or_default()
    }

    fn size(&self) -> f64 {
        self.hidden.split(':').nth(1).and_then(|s| s.parse().ok()).unwrap_or(f64::NAN)
    }

    fn ride(&self) -> Ride {
        let (estimates, traces) = (self.estimates.clone(), self.traces.clone());
        Ride { ident: self.ident(), circumstances: Circumstances::default(), estimates, traces }
    }
}

fn said(session: &Session, bike: &Bike, ident: &Ident, hidden: String) -> Result<Said, Failure> {
    let fit = fitted(session, bike, &Pipeline::onroad()).map_err(|e| e.message)?;
    let base = fit.base.clone().starting_point(&fit.samples, ALL).base;
    let (estimates, traces) = estimates(&fit.samples, &Nominal::alone(&base), ALL, ident);
    Ok(Said { estimates, traces, hidden })
}

/// What the independent simulator calls the effects.
const PLANT: &[(&str, &str)] = &[
    ("head_wind", "wind"),
    ("gnss_latency", "latency"),
    ("brake_fade", "pad_heat"),
    ("camber_rolling_radius", "radius_camber"),
    ("steer_offset", "steer_zero"),
];

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
    let truth = std::fs::read_to_string(folder.join("truth.json"))?;
    let truth: serde_json::Value = serde_json::from_str(&truth)?;
    let what = &truth["hidden_effects"][0];
    let hidden = match what["name"].as_str() {
        None | Some("none") => "none".to_owned(),
        Some(plant) => {
            let ours =
                PLANT.iter().find(|(name, _)| *name == plant).map_or(plant, |(_, ours)| ours);
            format!("{ours}:{}", what["size"])
        }
    };
    let ident = Ident { session_id: name(folder), bike_id: set, start_time: None };
    said(&session, &bike, &ident, hidden)
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
        odd: Vec::new(),
    };
    let (mut scenario, _) = none.machine()?;
    scenario.seed = 7919 * (ride as u64 + 1) + 31 * seed + number as u64;
    let mut error = ModelError::default();
    if let Some((effect, size)) = hidden {
        (effect.set)(&mut error, size);
    }
    let machine = DrawnMachine::draw(seed, number, 0)?;
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
    said(&session, &bike, &ident, what)
}

fn main() -> Result<(), Failure> {
    let a = Arguments::parse();
    if a.shared > 0 {
        return shared::study(&a);
    }
    let mut rides: Vec<Said> = Vec::new();
    for path in &a.read {
        for line in std::fs::read_to_string(path)?.lines() {
            rides.push(serde_json::from_str(line)?);
        }
    }
    let mut add = |all: Vec<Result<Said, Failure>>| {
        for one in all {
            match one {
                Ok(ride) => rides.push(ride),
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
    if let Some(out) = &a.out {
        let lines: Result<Vec<String>, _> = rides.iter().map(serde_json::to_string).collect();
        std::fs::write(out, lines?.join("\n"))?;
    }
    for k in &a.others {
        judged(&rides, *k);
        limits(&rides, *k);
    }
    Ok(())
}

/// Each ride against so many fault-free rides of its motorcycle, and how often that is right.
fn judged(rides: &[Said], k: usize) {
    let outcomes: Vec<(&Said, Vec<ChangeRow>)> = rides
        .par_iter()
        .map(|ride| {
            let of_bike =
                |r: &&Said| r.bike() == ride.bike() && r.hidden == "none" && r.id() != ride.id();
            let others = rides.iter().filter(of_bike).take(k);
            // with dates, riders and sites: more sets that may differ by chance
            let own = others.chain([ride]).map(Said::ride).enumerate();
            let own = own.map(|(k, ride)| shared::placed(ride, k)).collect();
            let rows = changes(own).into_iter().filter(|row| row.ident.session_id == ride.id());
            (ride, rows.collect())
        })
        .collect();
    let mut counts = [[0usize; 2]; 4];
    println!("{k} other rides");
    for (ride, rows) in &outcomes {
        let found: Vec<&ChangeRow> = rows.iter().filter(|r| is_change(r)).collect();
        let is_right = |r: &&&ChangeRow| r.cause.as_deref() == Some(ride.effect());
        let is_rival =
            |r: &&&ChangeRow| r.rivals.iter().any(|r| r.split(", ").any(|n| n == ride.effect()));
        let place = match (ride.hidden == "none", &found[..]) {
            (true, []) => 0,
            (true, _) => 1,
            (false, []) => 0,
            (false, _) if found.iter().any(|r| is_right(&r) || is_rival(&r)) => 2,
            (false, _) => 3,
        };
        counts[place][usize::from(ride.hidden != "none")] += 1;
        if ride.hidden != "none" || !found.is_empty() {
            let says: Vec<&str> = found.iter().map(|r| r.sentence.as_str()).collect();
            let mark = ["-", "FALSE", "right", "other"][place];
            println!(
                "  {} {} {}: {mark} {}",
                ride.bike(),
                ride.id(),
                ride.hidden,
                says.join(" | ")
            );
        }
        let sizes = found.iter().filter(is_right).filter_map(|r| Some((r.ci95_low?, r.ci95_high?)));
        for (low, high) in sizes {
            let holds = (low..=high).contains(&ride.size());
            println!(
                "      interval {}",
                if holds { "contains the size" } else { "MISSES the size" }
            );
        }
    }
    println!(
        "  fault-free: {} as before, {} changed; faulted: {} right, {} other, {} not seen",
        counts[0][0], counts[1][0], counts[2][1], counts[3][1], counts[0][1]
    );
}

/// Sizes of each effect that half of the rides would show: its own size times what a change needs over what the ride shows.
fn limits(rides: &[Said], k: usize) {
    let mut by_effect: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for ride in rides.iter().filter(|r| r.hidden != "none") {
        let is_other = |r: &&Said| r.bike() == ride.bike() && r.hidden == "none";
        let own = rides.iter().filter(is_other).take(k).chain([ride]).map(Said::ride).collect();
        let shown = clearness(own, &ride.id());
        let shown = shown.into_iter().find(|(name, ..)| name == ride.effect());
        if let Some((_, t, needed)) = shown {
            by_effect.entry(ride.effect()).or_default().push(ride.size().abs() * needed / t.abs());
        }
    }
    println!("{k} other rides: size that half of the rides would show");
    for (effect, mut limits) in by_effect {
        limits.sort_by(f64::total_cmp);
        println!("  {effect} {:.3e} ({} rides)", limits[limits.len() / 2], limits.len());
    }
}

fn is_change(row: &ChangeRow) -> bool {
    matches!(row.verdict.as_str(), "named" | "ambiguous" | "changed")
}
