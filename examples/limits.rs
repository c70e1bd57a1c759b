//! Detection limits over the size of what is hidden: an effect that hides itself raises its own limit. Latency
//! is also asked of `run`, which finds it from the accelerations alone.
//!
//! ```text
//! cargo run --release --example limits -- --archives 6
//! ```

use clap::Parser;
use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::verdict::Verdict;
use roadbench::internals::diagnose::{Settings, road};
use roadbench::internals::pipeline::{self, Pipeline};
use roadbench::internals::simulate::effects::ALL;
use roadbench::internals::simulate::hidden::{Case, Kind};
use roadbench::internals::tyre::formulation::Formulation;

#[derive(Parser)]
struct Arguments {
    /// Archives of each effect and size.
    #[arg(long, default_value_t = 6)]
    archives: usize,
    /// Seed of the draw.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Simulated nulls of each ride.
    #[arg(long, default_value_t = 24)]
    nulls: usize,
    /// Effects that are hidden.
    #[arg(long, value_delimiter = ',', default_value = "wind,road_grade,latency")]
    effects: Vec<String>,
    /// Hidden sizes, in usual ones.
    #[arg(long, num_args = 1.., default_values_t = [1.0, 2.0, 3.0, 4.0])]
    sizes: Vec<f64>,
}

/// What one ride says of the hidden effect, in its unit.
struct Answer {
    limit: f64,
    /// Standard deviation of the fault-free simulations, and their bias.
    spread: f64,
    bias: f64,
    named: Option<f64>,
    of_run: Option<f64>,
}

fn main() {
    let arguments = Arguments::parse();
    println!("median of {} rides each; sizes in the effect's unit\n", arguments.archives);
    println!(
        "| effect | hidden | detection limit | spread of nulls | their bias | named | size found | `run` finds |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|");
    for name in &arguments.effects {
        let Some(effect) = ALL.iter().find(|e| e.name == name) else {
            println!("there is no effect {name}");
            continue;
        };
        for size in &arguments.sizes {
            let value = size * effect.typical;
            let ask = |number: usize| {
                let kind = Kind::Null;
                let null = Case::draw(arguments.seed, number, kind, [1.0, 1.0]);
                ask(Case { hidden: vec![(effect, value)], ..null }, arguments.nulls)
            };
            let answers: Vec<Answer> =
                (0..arguments.archives).into_par_iter().filter_map(ask).collect();
            let of = |f: &dyn Fn(&Answer) -> f64| median(answers.iter().map(f).collect());
            let (limit, spread) = (of(&|a| a.limit), of(&|a| a.spread));
            let bias = of(&|a| a.bias.abs());
            let named: Vec<f64> = answers.iter().filter_map(|a| a.named).collect();
            let count = format!("{} of {}", named.len(), answers.len());
            let found = median(named);
            let of_run = match name.as_str() {
                "latency" => median(answers.iter().filter_map(|a| a.of_run).collect()),
                _ => "-".into(),
            };
            println!(
                "| {name} | {value:.4} | {limit} | {spread} | {bias} | {count} | {found} | {of_run} |"
            );
        }
    }
}

fn ask(case: Case, nulls: usize) -> Option<Answer> {
    let folder = tempfile::tempdir().expect("a folder for the archive");
    let (log, bike) = case.write(folder.path()).expect("archive");
    let bike = Bike::read(&bike).expect("bike");
    let pipeline = Pipeline::onroad();
    let (session, _) = pipeline::prepare(log, &[], &bike, &pipeline).ok()?;
    let settings = Settings { nulls, effects: ALL.to_vec(), advise: false };
    let found = road::diagnose(&session, &bike, &pipeline, &settings).ok()?;
    let (effect, _) = case.hidden.first()?;
    let place = settings.effects.iter().position(|e| e.name == effect.name)?;
    let is_named = |v: Verdict| matches!(v, Verdict::Named | Verdict::Ambiguous);
    let of_effect = |c: &&_| {
        let c: &roadbench::internals::diagnose::cause::Cause = c;
        c.candidate.name == effect.name && is_named(c.verdict)
    };
    let said = pipeline::characterise(session, &bike, &pipeline, Formulation::Corrected).warnings;
    // "the velocity lags the acceleration by 12.3 ms; corrected"
    let milliseconds = |text: &str| text.split(' ').find_map(|word| word.parse::<f64>().ok());
    let late = said.iter().find(|w| w.code == "velocity_latency");
    Some(Answer {
        limit: found.calibration.limit(place) * effect.typical.abs(),
        spread: found.calibration.scale.spread[place] * effect.typical.abs(),
        bias: found.calibration.bias[place] * effect.typical.abs(),
        named: found.identification.causes.iter().find(of_effect).map(|c| c.value()),
        of_run: late.and_then(|w| milliseconds(&w.message)).map(|ms| 1e-3 * ms),
    })
}

fn median(mut x: Vec<f64>) -> String {
    x.sort_by(f64::total_cmp);
    x.get(x.len() / 2).map_or("-".to_owned(), |x| format!("{x:.4}"))
}
