//! Gain of an identified effect in the simulation: one ride with each effect hidden, on the reduced-order motorcycle
//! and on machines of the multibody population; errors on manoeuvres that the fit had not seen.
//!
//! ```text
//! cargo run --release --example gains -- --size 4 > gains.md
//! ```

use std::path::PathBuf;

use clap::Parser;
use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::verdict::Verdict;
use roadbench::internals::diagnose::road::oracle;
use roadbench::internals::diagnose::{Settings, road};
use roadbench::internals::pipeline::{self, Pipeline};
use roadbench::internals::simulate::effects::physics::Multibody;
use roadbench::internals::simulate::effects::{ALL, Effect};
use roadbench::internals::simulate::hidden::{Case, Kind};
use roadbench::internals::simulate::population::ride;
use roadbench::internals::store::tables::rows::SimulationError;

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

/// Least contribution of an effect, in multiples of the noise-only rms, whose error is asked to fall.
const ASKED: f64 = 2.0;
/// Rise that is one.
const WORSE: f64 = 1.1;

/// What a diagnosis says of a ride, and what one that knows what is hidden would.
struct Answer {
    named: Vec<&'static str>,
    errors: Vec<SimulationError>,
    truth: Vec<SimulationError>,
}

impl Answer {
    /// The error of a channel and kind with the true effect, in its unit.
    fn true_error(&self, of: &SimulationError) -> Option<f64> {
        let same = |e: &&SimulationError| e.channel == of.channel && e.kind == of.kind;
        self.truth.iter().find(same)?.rmse_extended
    }
}

fn written(case: &Case, suite: &str, folder: &std::path::Path) -> Option<(PathBuf, PathBuf)> {
    match suite {
        "reduced" => case.write(folder).ok(),
        _ => ride::write(case, folder).ok().map(|(paths, _)| paths),
    }
}

fn answer(case: &Case, suite: &str, nulls: usize) -> Option<Answer> {
    let truth: Vec<(&Effect, f64)> = case.hidden.clone();
    let folder = tempfile::tempdir().expect("a folder for the ride");
    let (log, bike) = written(case, suite, folder.path())?;
    let bike = Bike::read(&bike).expect("bike");
    let pipeline = Pipeline::onroad();
    let (session, _) = pipeline::prepare(log, &[], &bike, &pipeline).ok()?;
    let settings = Settings { nulls, effects: ALL.to_vec(), advise: false };
    let found = road::diagnose(&session, &bike, &pipeline, &settings).ok()?;
    let truth = oracle::errors_with_the_truth(&session, &bike, &pipeline, &truth).ok()?;
    let is_named = |v: Verdict| matches!(v, Verdict::Named | Verdict::Ambiguous);
    let named = found.identification.causes.iter().filter(|c| is_named(c.verdict));
    Some(Answer {
        named: named.map(|c| c.candidate.name).collect(),
        errors: found.simulation_errors,
        truth,
    })
}

fn main() {
    let arguments = Arguments::parse();
    println!(
        "| effect | ride | named | better | worse by a tenth | with the true effect | all, mean | largest fall: base, extended (noise) |"
    );
    println!("|---|---|---|---:|---:|---:|---:|---|");
    let mut sums = [[0; 5]; SUITES.len()];
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
        let Some(answer) = answer else {
            println!("| `{}` | {} | not ridden | | | | | |", effect.name, SUITES[*suite]);
            continue;
        };
        let Answer { named, errors, .. } = answer;
        let truth = |e: &SimulationError| answer.true_error(e).unwrap_or(f64::NAN);
        // what the effect itself does: errors that stay with the true effect are not its own
        let effect_of =
            |e: &SimulationError| (e.rmse_base * e.rmse_base - truth(e) * truth(e)).max(0.0).sqrt();
        let asked = |e: &&SimulationError| effect_of(e) > ASKED * e.noise_floor;
        let ratio = |e: &SimulationError| e.ratio.unwrap_or(1.0);
        let large: Vec<&SimulationError> = errors.iter().filter(asked).collect();
        let better = large.iter().filter(|e| ratio(e) < 1.0).count();
        let worse = errors.iter().filter(|e| ratio(e) > WORSE).count();
        let truth_worse = errors.iter().filter(|e| truth(e) > WORSE * e.rmse_base).count();
        if named.contains(&effect.name) {
            let one = [better, large.len(), worse, truth_worse, errors.len()];
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
            "| `{}` | {} | {named} | {better} of {} | {worse} of {} | {truth_worse} | {mean} | {best} |",
            effect.name,
            SUITES[*suite],
            large.len(),
            errors.len()
        );
    }
    for (s, (suite, [better, large, worse, truth, n])) in SUITES.into_iter().zip(sums).enumerate() {
        println!(
            "\n{suite}, where the hidden effect is named: where it does more than {ASKED} noise floors errors get \
             better in {better} of {large}; of all {worse} of {n} get worse by more than a tenth, with the true \
             effect {truth}\n"
        );
        let own = all.iter().filter(|(_, suite, _)| *suite == s);
        let answers: Vec<(&Effect, &Answer)> =
            own.filter_map(|(effect, _, answer)| Some((*effect, answer.as_ref()?))).collect();
        by_channel(&answers);
    }
}

/// Errors of every channel, in multiples of the noise-only rms: root mean squares over effects and kinds of manoeuvres.
fn by_channel(answers: &[(&Effect, &Answer)]) {
    println!(
        "| channel | kinds | base | extended | true effect | where named: kinds | base | extended | true effect | within a tenth of the true one's |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    let mut channels: Vec<&str> =
        answers.iter().flat_map(|(_, a)| &a.errors).map(|e| e.channel.as_str()).collect();
    channels.sort_unstable();
    channels.dedup();
    for channel in channels {
        let cells = |named_only: bool| {
            let wanted = move |(effect, a): &&(&Effect, &Answer)| {
                !named_only || a.named.contains(&effect.name)
            };
            let own = answers.iter().filter(wanted).flat_map(|(_, a)| {
                let of = |e: &SimulationError| {
                    let extended = e.rmse_extended.unwrap_or(e.rmse_base);
                    Some([e.rmse_base, extended, a.true_error(e)?].map(|x| x / e.noise_floor))
                };
                a.errors.iter().filter(|e| e.channel == channel).filter_map(of).collect::<Vec<_>>()
            });
            own.filter(|x| x.iter().all(|x| x.is_finite())).collect::<Vec<[f64; 3]>>()
        };
        let rms = |cells: &[[f64; 3]]| {
            let n = cells.len() as f64;
            let of = |k: usize| (cells.iter().map(|x| x[k] * x[k]).sum::<f64>() / n).sqrt();
            format!("{} | {:.2} | {:.2} | {:.2}", cells.len(), of(0), of(1), of(2))
        };
        let (every, named) = (cells(false), cells(true));
        let near = named.iter().filter(|[_, extended, truth]| *extended < 1.1 * truth).count();
        println!("| {channel} | {} | {} | {near} of {} |", rms(&every), rms(&named), named.len());
    }
}
