//! Limits that `plan` promises, and those that a diagnosis keeps: on machines of the population, and on rides whose
//! truth is known but that this project did not simulate.
//!
//! ```text
//! cargo run --release --example promised -- --machines 3 --plant ../shared/data/independent_plant
//! ```

use std::path::{Path, PathBuf};

use clap::Parser;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::verdict::Verdict;
use roadbench::internals::diagnose::Settings;
use roadbench::internals::diagnose::road::{Prepared, fitted};
use roadbench::internals::diagnose::tuning::RoadTuning;
use roadbench::internals::pipeline::{self, Pipeline};
use roadbench::internals::simulate::effects::physics::Multibody;
use roadbench::internals::simulate::effects::{ALL, Effect};
use roadbench::internals::simulate::hidden::{Case, Kind, plan_named};
use roadbench::internals::simulate::population::ride;
use serde_json::Value;

#[derive(Parser)]
struct Arguments {
    /// Machines of the population.
    #[arg(long, default_value_t = 3)]
    machines: usize,
    /// Rides of the scenario's own simulator instead.
    #[arg(long)]
    reduced: bool,
    /// Seed of the draw.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Ride plan.
    #[arg(long, default_value = "naturalistic")]
    plan: String,
    /// Only these effects.
    #[arg(long, value_delimiter = ',')]
    effects: Vec<String>,
    /// Hidden size, in what the plan promises.
    #[arg(long, default_value_t = 1.0)]
    times: f64,
    /// Folder of rides with `sessions/`, `bikes/` and `truth.json` each.
    #[arg(long)]
    plant: Option<PathBuf>,
}

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// What the diagnosis of a ride says of each effect, in usual sizes and in the order of [`ALL`].
struct Said {
    /// Size to first order.
    delta: Vec<f64>,
    /// Score of a usual size.
    score: Vec<f64>,
    /// Size that is identified half of the time; NaN where the ride does not show the effect.
    limit: Vec<f64>,
    causes: Vec<&'static str>,
}

fn said((log, bike): &(PathBuf, PathBuf)) -> Result<Said, Failure> {
    let (bike, pipeline) = (Bike::read(bike)?, Pipeline::onroad());
    let (session, _) =
        pipeline::prepare(log.clone(), &[], &bike, &pipeline).map_err(|e| e.message)?;
    let (fit, settings) =
        (fitted(&session, &bike, &pipeline).map_err(|e| e.message)?, Settings::default());
    let prepared = Prepared::new(&fit, &settings);
    let (calibration, scores) = (prepared.calibration(), prepared.scores());
    let places = 0..ALL.len();
    let limit = |j: usize| match calibration.is_identifiable(j) {
        true => calibration.identified_half(j),
        false => f64::NAN,
    };
    let is_cause = |v: Verdict| matches!(v, Verdict::Named | Verdict::Ambiguous);
    let identification = prepared.identification(&RoadTuning::default());
    let scale = &calibration.scale;
    eprintln!("  thresholds {:.2?}", scale.threshold);
    for j in places.clone() {
        eprintln!(
            "    {:24} size {:7.3} own error {:6.3} usual {:6.3} spread {:6.3} bias {:6.3} others {:6.3} response {:5.3} \
             half {:7.3} old limit {:7.3}",
            ALL[j].name,
            scores[j].delta,
            scores[j].std_error,
            scale.scatter[j],
            scale.spread[j],
            calibration.bias[j],
            scale.unmodelled[j],
            scale.response[j],
            calibration.identified_half(j),
            calibration.limit(j)
        );
    }
    Ok(Said {
        delta: scores.iter().map(|s| s.delta).collect(),
        score: places.clone().map(|j| calibration.score_of(j, 1.0, scores[j].std_error)).collect(),
        limit: places.map(limit).collect(),
        causes: identification
            .causes
            .iter()
            .filter(|c| is_cause(c.verdict))
            .map(|c| c.candidate.name)
            .collect(),
    })
}

fn median(mut x: Vec<f64>) -> f64 {
    x.sort_by(f64::total_cmp);
    x.get(x.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Median, or nothing where fewer than half have a number.
fn middle(x: &[f64]) -> Option<f64> {
    let known: Vec<f64> = x.iter().copied().filter(|x| x.is_finite()).collect();
    (2 * known.len() > x.len()).then(|| median(known))
}

fn main() -> Result<(), Failure> {
    let a = Arguments::parse();
    let plan = plan_named(&a.plan).ok_or("no such plan")?;
    let promised: Vec<Option<f64>> = roadbench::plan_ride(plan, &Pipeline::onroad())?
        .effects
        .iter()
        .map(|row| row.limit_usual)
        .collect();
    let is_wanted = |e: &Effect| a.effects.is_empty() || a.effects.iter().any(|n| n == e.name);
    let mut kept: Vec<Vec<f64>> = vec![Vec::new(); ALL.len()];
    let mut of_machines = kept.clone();
    let mut identified = vec![[0, 0]; ALL.len()];
    let work = tempfile::tempdir()?;
    for number in 0..a.machines {
        let ask = |hidden: Vec<(&'static Effect, f64)>| -> Result<Said, Failure> {
            let (kind, foreign, odd) = (Kind::Null, None, Vec::new());
            let case = Case { seed: a.seed, number, kind, plan, hidden, foreign, odd };
            let files = match a.reduced {
                true => case.write(work.path())?,
                false => ride::write(&case, work.path())?.0,
            };
            said(&files)
        };
        let none = ask(Vec::new())?;
        println!("machine {number}, nothing hidden: {:?}", none.causes);
        for (j, effect) in ALL.iter().enumerate() {
            of_machines[j].push(none.limit[j]);
            // some are in every machine by its construction
            let can_be = a.reduced || effect.multibody == Multibody::Hooks;
            let Some(size) = promised[j].filter(|_| can_be && is_wanted(effect)) else { continue };
            let usual = [a.times * size, -a.times * size]
                .into_iter()
                .find(|s| effect.in_bounds(s * effect.typical));
            let Some(usual) = usual else { continue };
            let planted = match ask(vec![(effect, usual * effect.typical)]) {
                Ok(planted) => planted,
                Err(why) => {
                    eprintln!("{}: {why}", effect.name);
                    continue;
                }
            };
            // the machine's own errors show in both
            let shown = (planted.delta[j] - none.delta[j]) / usual;
            let limit = RoadTuning::default().alarm / (shown.abs() * planted.score[j]);
            let limit = if planted.limit[j].is_finite() { limit } else { f64::NAN };
            kept[j].push(limit);
            identified[j][0] += usize::from(planted.causes.contains(&effect.name));
            identified[j][1] += 1;
            println!(
                "machine {number} {} {usual:.2}: shown {shown:.2}, kept {limit:.2}, {:?}",
                effect.name, planted.causes
            );
        }
    }
    let plant = a.plant.as_deref().map(of_plant).transpose()?.unwrap_or_default();
    println!(
        "\n| effect | promised | kept | kept / promised | identified | fault-free machines | plant |"
    );
    println!("|---|---|---|---|---|---|---|");
    let text = |x: Option<f64>| x.map_or("none".to_owned(), |x| format!("{x:.2}"));
    for (j, effect) in ALL.iter().enumerate() {
        let own = middle(&kept[j]);
        let ratio = own.zip(promised[j]).map_or("-".to_owned(), |(k, p)| format!("{:.2}", k / p));
        let of_plant: Vec<f64> = plant.iter().map(|said| said.limit[j]).collect();
        let [hits, of] = identified[j];
        println!(
            "| `{}` | {} | {} | {ratio} | {hits} of {of} | {} | {} |",
            effect.name,
            text(promised[j]),
            text(own),
            text(middle(&of_machines[j])),
            text(middle(&of_plant)),
        );
    }
    Ok(())
}

/// The rides of the independent simulator, each with what is hidden in it; those without anything are given back.
fn of_plant(rides: &Path) -> Result<Vec<Said>, Failure> {
    let mut folders: Vec<PathBuf> = std::fs::read_dir(rides)?
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|path| path.join("truth.json").is_file())
        .collect();
    folders.sort();
    let mut out = Vec::new();
    for folder in folders {
        let only = |part: &str| -> Result<PathBuf, Failure> {
            Ok(std::fs::read_dir(folder.join(part))?.next().ok_or("no file")??.path())
        };
        let own = said(&(only("sessions")?, only("bikes")?))?;
        let truth: Value = serde_json::from_slice(&std::fs::read(folder.join("truth.json"))?)?;
        let hidden = truth["hidden_effects"].to_string();
        println!("{}: {:?}; {hidden}", folder.display(), own.causes);
        for (j, effect) in ALL.iter().enumerate() {
            println!(
                "    {:24} size {:6.2} score {:6.2} limit {:6.2}",
                effect.name,
                own.delta[j],
                own.delta[j].abs() * own.score[j],
                own.limit[j]
            );
        }
        if truth["hidden_effects"][0]["name"] == "none" {
            out.push(own);
        }
    }
    Ok(out)
}
