//! Rides with one odd manoeuvre, and rides without: how often it is found at its place, and how often something is said
//! of a ride where nothing is odd.
//!
//! ```text
//! cargo run --release --example odd_manoeuvres -- --rides 100
//! cargo run --release --example odd_manoeuvres -- --rides 100 --multibody --scatter
//! cargo run --release --example odd_manoeuvres -- --logs ../shared/data/independent_plant
//! ```
//!
//! Odd is one manoeuvre of a ride: a front or rear stop with 15 or 30 % less friction, a coasting run in a head wind of
//! 4 or 8 m/s, a stop whose wheel locks. `--scatter` prints how much manoeuvres of rides
//! without anything odd differ, quantity by quantity: where the priors come from.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Parser;
use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::session::Session;
use roadbench::internals::fit::outlying::{Compared, Fitted, comparisons, find};
use roadbench::internals::pipeline::{self, Pipeline, characterise};
use roadbench::internals::simulate::hidden::{Case, Kind};
use roadbench::internals::simulate::odd_manoeuvre::{OddKind, OddManoeuvre};
use roadbench::internals::simulate::population::bike::BikeFile;
use roadbench::internals::simulate::population::ride as population;
use roadbench::internals::statistics::order::median;
use roadbench::internals::tyre::formulation::Formulation;

#[derive(Parser)]
struct Arguments {
    /// Rides of each kind.
    #[arg(long, default_value_t = 20)]
    rides: usize,
    /// Seed of the draw.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// On multibody motorcycles of a population instead of the reduced-order one.
    #[arg(long)]
    multibody: bool,
    /// Print how much manoeuvres differ where nothing is odd.
    #[arg(long)]
    scatter: bool,
    /// Rides from elsewhere instead: folders with `sessions/` and `bikes/`.
    #[arg(long)]
    logs: Option<PathBuf>,
    /// A line per finding.
    #[arg(long)]
    verbose: bool,
}

/// What is odd, and the quantities that may show it.
type Planted = (&'static str, Option<OddManoeuvre>, &'static [&'static str]);

fn planted() -> Vec<Planted> {
    let odd = |kind: OddKind, friction: f64, head_wind: f64, slip: Option<f64>| {
        Some(OddManoeuvre { kind, number: 2, friction, head_wind, slip })
    };
    use OddKind::{Coasting, FrontBraking, RearBraking};
    vec![
        ("nothing", None, &[]),
        ("front stop, friction -15 %", odd(FrontBraking, -0.15, 0.0, None), &["friction_front"]),
        ("front stop, friction -30 %", odd(FrontBraking, -0.3, 0.0, None), &["friction_front"]),
        ("rear stop, friction -30 %", odd(RearBraking, -0.3, 0.0, None), &["friction_rear"]),
        ("coasting, head wind 4 m/s", odd(Coasting, 0.0, 4.0, None), &["resistance"]),
        ("coasting, head wind 8 m/s", odd(Coasting, 0.0, 8.0, None), &["resistance"]),
        ("front wheel locks", odd(FrontBraking, 0.0, 0.0, Some(-1.0)), &["locked_front"]),
        ("rear wheel locks", odd(RearBraking, 0.0, 0.0, Some(-1.0)), &["locked_rear"]),
    ]
}

/// What came of one ride.
struct Judged {
    /// Said at the right manoeuvre in a right quantity.
    found: bool,
    /// Said of other manoeuvres.
    others: usize,
    said: Vec<String>,
    all: Vec<(&'static str, Vec<Compared>)>,
}

fn judge(log: Session, bike: &Bike, right: &[&str], odd: Option<[f64; 2]>) -> Judged {
    let pipeline = Pipeline::onroad();
    let done = characterise(log, bike, &pipeline, Formulation::Corrected);
    let fitted = Fitted {
        session: &done.session,
        segments: &done.segments,
        data: &done.data,
        solution: &done.solution,
    };
    let mut judged =
        Judged { found: false, others: 0, said: Vec::new(), all: comparisons(&fitted) };
    for o in find(&fitted) {
        let segment = &done.segments[o.compared.segment];
        let [start, end] = [segment.start, segment.end].map(|i| done.session.time(i));
        // the manoeuvre itself, or what the rider does about it
        let there = odd.is_some_and(|[from, to]| start < to && end > from);
        judged.found |= there && right.contains(&o.quantity.name);
        judged.others += usize::from(!there);
        judged.said.push(format!(
            "{} at {start:.1} s: {} {:.4} for {:.4} ({:+.1} sd of {} others){}",
            segment.kind.name(),
            o.quantity.name,
            o.compared.value,
            o.compared.expected,
            o.compared.t,
            o.compared.others,
            if there { "" } else { " ELSEWHERE" },
        ));
    }
    judged
}

/// Start and end of the odd manoeuvre, s, by the truth's labels.
fn place(labels: &[(String, f64, f64)], odd: &OddManoeuvre) -> Option<[f64; 2]> {
    let name = match odd.kind {
        OddKind::FrontBraking => "front_braking",
        OddKind::RearBraking => "rear_braking",
        OddKind::Coasting => "coasting",
        OddKind::Cornering => "cornering",
    };
    labels.iter().filter(|(kind, ..)| kind == name).nth(odd.number - 1).map(|(_, a, b)| [*a, *b])
}

fn ridden(arguments: &Arguments, number: usize, planted: &Planted) -> Result<Judged, String> {
    let (_, odd, right) = planted;
    let case = Case {
        odd: odd.iter().copied().collect(),
        ..Case::draw(arguments.seed, number, Kind::Null, [1.0; 2])
    };
    let (log, bike, labels) = if arguments.multibody {
        let done = population::ride(&case, BikeFile::Full).map_err(|e| e.to_string())?;
        let labels = done.ride.labels.iter().map(|l| (l.0.name().to_owned(), l.1, l.2));
        (done.ride.session.clone(), done.tour.bike.clone(), labels.collect())
    } else {
        let (scenario, machine) = case.machine().map_err(|e| e.to_string())?;
        let simulated = roadbench::internals::simulate::session(&scenario, &machine, number);
        let labels = simulated.labels.iter().map(|l| (l.0.name().to_owned(), l.1, l.2));
        (simulated.session.clone(), machine.bike, labels.collect::<Vec<_>>())
    };
    let at = odd.as_ref().and_then(|odd| place(&labels, odd));
    Ok(judge(log, &bike, right, at))
}

fn from_elsewhere(folder: &Path) -> Result<Judged, String> {
    let only = |part: &str| -> Result<PathBuf, String> {
        let mut files = std::fs::read_dir(folder.join(part)).map_err(|e| e.to_string())?;
        Ok(files.next().ok_or("no file")?.map_err(|e| e.to_string())?.path())
    };
    let bike = Bike::read(&only("bikes")?).map_err(|e| e.to_string())?;
    let (session, _) = pipeline::prepare(only("sessions")?, &[], &bike, &Pipeline::onroad())
        .map_err(|e| e.message)?;
    Ok(judge(session, &bike, &[], None))
}

/// Standard deviations of the rides' manoeuvres about what the others say, by quantity.
fn print_scatter(all: &[Judged]) {
    let mut by: BTreeMap<&str, Vec<(f64, usize)>> = BTreeMap::new();
    let mut tails: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for judged in all {
        for (quantity, compared) in &judged.all {
            let n = compared.len();
            if n >= 2 {
                let squares: f64 = compared.iter().map(|c| (c.value - c.expected).powi(2)).sum();
                // a difference from the mean of the others is larger than one from the truth
                let sd = (squares / n as f64 * (n as f64 - 1.0) / n as f64).sqrt();
                by.entry(quantity).or_default().push((sd, n));
                tails.entry(quantity).or_default().extend(compared.iter().map(|c| c.chance));
            }
        }
    }
    println!(
        "quantity | rides | manoeuvres a ride | sd: 10, 50, 90 % | chance < 0.01, < 0.001, < 0.0001"
    );
    for (quantity, sds) in by {
        let mut sorted: Vec<f64> = sds.iter().map(|(sd, _)| *sd).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share) as usize];
        let n = median(&mut sds.iter().map(|(_, n)| *n as f64).collect::<Vec<_>>()).unwrap_or(0.0);
        let chances = &tails[quantity];
        let below = |least: f64| {
            chances.iter().filter(|c| **c < least).count() as f64 / chances.len() as f64
        };
        println!(
            "{quantity} | {} | {n} | {:.5} {:.5} {:.5} | {:.4} {:.5} {:.5}",
            sds.len(),
            at(0.1),
            at(0.5),
            at(0.9),
            below(1e-2),
            below(1e-3),
            below(1e-4)
        );
    }
}

fn main() {
    let arguments = Arguments::parse();
    if let Some(logs) = &arguments.logs {
        let mut folders: Vec<PathBuf> = std::fs::read_dir(logs)
            .map(|entries| entries.flatten().map(|e| e.path()).filter(|p| p.is_dir()).collect())
            .unwrap_or_default();
        folders.sort();
        let judged: Vec<_> = folders.par_iter().map(|folder| from_elsewhere(folder)).collect();
        for (folder, judged) in folders.iter().zip(&judged) {
            match judged {
                Ok(judged) => println!("{}: {:?}", folder.display(), judged.said),
                Err(why) => println!("{}: {why}", folder.display()),
            }
        }
        if arguments.scatter {
            print_scatter(&judged.into_iter().flatten().collect::<Vec<_>>());
        }
        return;
    }
    println!("odd | rides | found at its place | something said of another manoeuvre");
    for planted in planted() {
        let all: Vec<Judged> = (0..arguments.rides)
            .into_par_iter()
            .filter_map(|number| ridden(&arguments, number, &planted).ok())
            .collect();
        let found = all.iter().filter(|j| j.found).count();
        let false_ones = all.iter().filter(|j| j.others > 0).count();
        println!("{} | {} | {found} | {false_ones}", planted.0, all.len());
        if arguments.verbose {
            for (number, judged) in all.iter().enumerate().filter(|(_, j)| !j.said.is_empty()) {
                println!("    {number}: {}", judged.said.join("; "));
            }
        }
        if arguments.scatter && planted.1.is_none() {
            print_scatter(&all);
        }
    }
}
