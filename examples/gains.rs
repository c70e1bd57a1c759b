//! What naming an effect gains in the simulation: one ride with each effect hidden, on the reduced-order motorcycle
//! and on machines of the multibody population; errors on manoeuvres that the fit had not seen.
//!
//! ```text
//! cargo run --release --example gains -- --size 4 > gains.md
//! ```

use std::path::PathBuf;

use clap::Parser;
use rayon::prelude::*;
use roadbench::contract::bike::Bike;
use roadbench::contract::verdict::Verdict;
use roadbench::diagnose::{Settings, road};
use roadbench::effects::physics::Multibody;
use roadbench::effects::{ALL, Effect};
use roadbench::pipeline::{self, Pipeline};
use roadbench::simulate::hidden::{Case, Kind};
use roadbench::simulate::population::ride;
use roadbench::tables::rows::SimulationError;

#[derive(Parser)]
struct Arguments {
    /// Hidden size, in usual ones.
    #[arg(long, default_value_t = 4.0)]
    size: f64,
    /// Seed of the draw.
    #[arg(long, default_value_t = 5)]
    seed: u64,
    /// Simulated nulls of each ride.
    #[arg(long, default_value_t = 19)]
    nulls: usize,
    /// Effects that are hidden; all when left out.
    #[arg(long, value_delimiter = ',')]
    effects: Vec<String>,
    /// Only the rides of the population, or only those of the reduced-order motorcycle.
    #[arg(long)]
    only: Option<String>,
}

/// On which motorcycle.
const SUITES: [&str; 2] = ["reduced", "population"];

/// Noise floors from which an error of the base model is asked to fall.
const ASKED: f64 = 2.0;
/// Rise that is one.
const WORSE: f64 = 1.1;

/// What a diagnosis says of a ride.
struct Answer {
    named: Vec<&'static str>,
    errors: Vec<SimulationError>,
}

fn written(case: &Case, suite: &str, folder: &std::path::Path) -> Option<(PathBuf, PathBuf)> {
    match suite {
        "reduced" => case.write(folder).ok(),
        _ => ride::write(case, folder).ok().map(|(paths, _)| paths),
    }
}

fn answer(case: &Case, suite: &str, nulls: usize) -> Option<Answer> {
    let folder = tempfile::tempdir().expect("a folder for the ride");
    let (log, bike) = written(case, suite, folder.path())?;
    let bike = Bike::read(&bike).expect("bike");
    let pipeline = Pipeline::onroad();
    let (session, _) = pipeline::prepare(log, &[], &bike, &pipeline).ok()?;
    let settings = Settings { nulls, effects: ALL.to_vec(), advise: false };
    let found = road::diagnose(&session, &bike, &pipeline, &settings).ok()?;
    let is_named = |v: Verdict| matches!(v, Verdict::Named | Verdict::Ambiguous);
    let named = found.naming.causes.iter().filter(|c| is_named(c.verdict));
    Some(Answer {
        named: named.map(|c| c.candidate.name).collect(),
        errors: found.simulation_errors,
    })
}

fn main() {
    let arguments = Arguments::parse();
    println!(
        "| effect | ride | named | better | worse by a tenth | all, mean | largest fall: base, extended (noise) |"
    );
    println!("|---|---|---|---:|---:|---:|---|");
    let mut sums = [[0; 4]; SUITES.len()];
    let wanted =
        |e: &&Effect| arguments.effects.is_empty() || arguments.effects.iter().any(|n| n == e.name);
    let effects: Vec<&'static Effect> = ALL.iter().filter(wanted).collect();
    let all: Vec<(&Effect, usize, Option<Answer>)> = effects
        .par_iter()
        .flat_map_iter(|effect| {
            let own = (0..SUITES.len()).filter(|s| {
                arguments.only.as_deref().is_none_or(|only| only == SUITES[*s])
                    && (*s == 0 || matches!(effect.multibody, Multibody::Hooks))
            });
            own.map(|suite| {
                let (seed, kind) = (arguments.seed, Kind::Null);
                let drawn = match suite {
                    0 => Case::draw(seed, 0, kind, [1.0, 1.0]),
                    _ => ride::case(seed, 0, kind, [1.0, 1.0]),
                };
                let hidden = vec![(*effect, arguments.size * effect.typical)];
                let case = Case { hidden, ..drawn };
                (*effect, suite, answer(&case, SUITES[suite], arguments.nulls))
            })
            .collect::<Vec<_>>()
        })
        .collect();
    for (effect, suite, answer) in &all {
        let Some(Answer { named, errors }) = answer else {
            println!("| `{}` | {} | not ridden | | | | |", effect.name, SUITES[*suite]);
            continue;
        };
        let asked = |e: &&SimulationError| e.rmse_base > ASKED * e.noise_floor;
        let ratio = |e: &SimulationError| e.ratio.unwrap_or(1.0);
        let large: Vec<&SimulationError> = errors.iter().filter(asked).collect();
        let better = large.iter().filter(|e| ratio(e) < 1.0).count();
        let worse = errors.iter().filter(|e| ratio(e) > WORSE).count();
        if named.contains(&effect.name) {
            let one = [better, large.len(), worse, errors.len()];
            sums[*suite].iter_mut().zip(one).for_each(|(sum, n)| *sum += n);
        }
        let best = match SimulationError::gains(errors).first() {
            Some(e) => format!(
                "{} in {}: {:.3}, {:.3} ({:.3}) {}",
                e.channel,
                e.kind,
                e.rmse_base,
                e.rmse_extended.unwrap_or(f64::NAN),
                e.noise_floor,
                e.unit
            ),
            None => "-".into(),
        };
        let mean = SimulationError::change_of_all(errors);
        let mean = mean.map_or("-".into(), |m| format!("{:+.1} %", 100.0 * (m.exp() - 1.0)));
        let named = if named.is_empty() { "-".into() } else { named.join(", ") };
        println!(
            "| `{}` | {} | {named} | {better} of {} | {worse} of {} | {mean} | {best} |",
            effect.name,
            SUITES[*suite],
            large.len(),
            errors.len()
        );
    }
    for (suite, [better, large, worse, n]) in SUITES.into_iter().zip(sums) {
        println!(
            "\n{suite}, where the hidden effect is named: errors above {ASKED} noise floors get better in {better} \
             of {large}, of all {worse} of {n} get worse by more than a tenth"
        );
    }
}
