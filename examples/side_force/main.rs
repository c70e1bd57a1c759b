//! Which riding tells the side-force ratio and the twisting stiffness of tyres from the rest of the model, and how
//! well; and whether an estimate with the best of it finds ratios that are not the bike file's.
//!
//! ```text
//! cargo run --release --example side_force -- > side_force.md
//! cargo run --release --example side_force -- --only verify --machines 20
//! ```

mod assumed;
mod fleet;
mod joint;
mod riding;

use clap::Parser;
use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::simulate::hidden::{Case, Kind as Hidden};
use roadbench::internals::simulate::scenario::{Machine, Scenario};
use roadbench::internals::statistics::random::Random;

use joint::{ASKED, Free, Known, Ride};
use riding::{CONTROL, KINDS, On, VERIFIED, Way};

#[derive(Parser)]
struct Arguments {
    /// Only one part: information, assumed, verify, fleet or multibody.
    #[arg(long)]
    only: Option<String>,
    /// Machines with drawn ratios that are estimated.
    #[arg(long, default_value_t = 20)]
    machines: usize,
    /// Seed of the draw.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Share of the value that an estimate is to be known to.
const KNOWN: f64 = 0.1;
/// Most rides that are asked of anybody.
const MOST: f64 = 1000.0;

/// A machine of the paper's scenario whose bike file is true, and sensors of the usual noise.
fn usual(seed: u64, number: usize) -> (Scenario, Machine) {
    let case = Case {
        seed,
        number,
        kind: Hidden::Null,
        plan: "paper",
        hidden: Vec::new(),
        foreign: None,
        odd: Vec::new(),
    };
    case.machine().expect("built in")
}

/// What a bike file says of what is asked for.
fn assumed(bike: &Bike) -> [f64; 4] {
    [
        bike.front.side_force_ratio,
        bike.rear.side_force_ratio,
        bike.front.twisting_stiffness,
        bike.rear.twisting_stiffness,
    ]
}

fn information(seed: u64) {
    let free = Free::new();
    let (scenario, one) = usual(seed, 0);
    let sizes = assumed(&one.bike);
    println!("| riding | {} |", ASKED.map(|a| format!("{a}: sd, rides")).join(" | "));
    println!("|---|---:|---:|---:|---:|");
    let rows: Vec<String> = KINDS
        .par_iter()
        .enumerate()
        .map(|(n, kind)| {
            let of = |k: usize, way: &Way| {
                let machine = riding::machine(&one, way.on);
                let session = riding::ride(&scenario, &machine, way, 100 * n + k);
                Ride::new(&session, &machine.bike, way.on, &one.bike)
            };
            let rides: Result<Vec<Ride>, String> =
                kind.ways.iter().enumerate().map(|(k, way)| of(k, way)).collect();
            let rides = match rides {
                Ok(rides) => rides,
                Err(why) => return format!("| {} | {why} |", kind.name),
            };
            // time is shared among the ways
            let share = 1.0 / rides.len() as f64;
            let Some(known) = Known::of(&rides, &free) else {
                return format!("| {} | singular |", kind.name);
            };
            let at = |times: f64| known.deviations(&free, times * share).unwrap_or([f64::NAN; 4]);
            let once = at(1.0);
            let cells: Vec<String> = (0..4)
                .map(|k| {
                    let enough = |n: &f64| at(*n)[k] <= KNOWN * sizes[k];
                    let rides = (1..).map(f64::from).take_while(|n| *n <= MOST).find(enough);
                    let rides = rides.map_or(format!("over {MOST}"), |n| n.to_string());
                    format!("{:.4}, {rides}", once[k])
                })
                .collect();
            format!("| {} | {} |", kind.name, cells.join(" | "))
        })
        .collect();
    rows.iter().for_each(|row| println!("{row}"));
}

/// The machine with ratios of its own, and its bike file that does not know them: 0.6 to 1.5 times.
fn with_own_ratios(one: &Machine, seed: u64) -> Machine {
    let mut random = Random::new(seed, &format!("ratios {}", one.bike.bike_id));
    let mut m = one.clone();
    for tyre in &mut m.plant.tyres {
        let factor = random.between(0.6_f64.ln(), 1.5_f64.ln()).exp();
        // k_alpha stays what it is
        tyre.side_force_ratio *= factor;
        tyre.stiffness.ct *= factor;
        tyre.stiffness.c1 *= factor;
        tyre.stiffness.c3 *= factor;
    }
    m
}

fn verify(machines: usize, seed: u64) {
    let free = Free::new();
    println!("| riding | ratio | rides | error, rms | deviation, mean | in 95 % interval |");
    println!("|---|---|---:|---:|---:|---:|");
    for (name, ways) in [("hung off, leaning out", VERIFIED), ("twice as usual", CONTROL)] {
        let found: Vec<[[f64; 3]; 2]> = (0..machines)
            .into_par_iter()
            .filter_map(|number| {
                let (scenario, one) = usual(seed, number);
                let machine = with_own_ratios(&one, seed);
                let of = |(k, way): (usize, &Way)| {
                    let session = riding::ride(&scenario, &machine, way, 10 * number + k);
                    Ride::new(&session, &machine.bike, On::One, &machine.bike)
                };
                let rides: Result<Vec<Ride>, String> = ways.iter().enumerate().map(of).collect();
                let mut rides = rides.inspect_err(|why| eprintln!("{number}: {why}")).ok()?;
                let estimate = joint::estimate(&mut rides, &free)?;
                let row = |k: usize| {
                    let truth = machine.plant.tyres[k].side_force_ratio;
                    [truth, estimate[k][0], estimate[k][1]]
                };
                eprintln!("{name} {number}: {:.4?} {:.4?}", row(0), row(1));
                Some([row(0), row(1)])
            })
            .collect();
        summary(name, &found);
    }
}

fn summary(name: &str, found: &[[[f64; 3]; 2]]) {
    let n = found.len() as f64;
    for (k, end) in ["front", "rear"].into_iter().enumerate() {
        let mean = |f: &dyn Fn(&[f64; 3]) -> f64| found.iter().map(|r| f(&r[k])).sum::<f64>() / n;
        let error = mean(&|[truth, value, _]| (value - truth).powi(2)).sqrt();
        let inside = found.iter().filter(|r| (r[k][1] - r[k][0]).abs() < 1.96 * r[k][2]).count();
        println!(
            "| {name} | {end} | {} | {error:.4} | {:.4} | {inside} |",
            found.len(),
            mean(&|r| r[2])
        );
    }
}

fn main() {
    let Arguments { only, machines, seed } = Arguments::parse();
    let wanted = |part: &str| only.as_deref().is_none_or(|o| o == part);
    if wanted("information") {
        information(seed);
    }
    if wanted("assumed") {
        println!();
        if let Err(why) = assumed::print(10 * machines, seed) {
            eprintln!("{why}");
        }
    }
    if wanted("verify") {
        println!();
        verify(machines, seed);
    }
    if wanted("fleet") {
        println!();
        fleet::print(machines, seed, false);
    }
    if wanted("multibody") {
        println!();
        fleet::print(machines.min(8), seed, true);
    }
}
