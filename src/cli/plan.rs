//! `roadbench plan`.

use serde::Serialize;

use crate::cli::failure::Failure;
use crate::cli::say::say;
use crate::diagnose::road;
use crate::diagnose::road::advice::{ALIKE, Advice};
use crate::diagnose::road::null_calibration::LARGEST_LIMIT;
use crate::effects::ALL;
use crate::pipeline::Pipeline;
use crate::simulate;
use crate::simulate::scenario::Scenario;

/// What a ride would and would not tell of the causes that `diagnose` looks for, before it is ridden
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// A built-in scenario (archive, perfect, paper, naturalistic) or a scenario file: its first
    /// session is ridden.
    scenario: String,
    /// Settings of the stages; a file or onroad (the default).
    #[arg(long, value_name = "FILE")]
    pipeline: Option<std::path::PathBuf>,
    /// Print effects and pairs as JSON, one object a line, instead of tables.
    #[arg(long)]
    json: bool,
}

/// What the ride tells of one effect.
#[derive(Debug, Serialize)]
struct Seen {
    effect: &'static str,
    /// Smallest size that is named half of the time, in `unit`; none where the ride says nothing.
    limit: Option<f64>,
    unit: &'static str,
    /// The same in the effect's usual size.
    limit_usual: Option<f64>,
    /// The parameter of the base model most like it, and the cosine of their responses.
    base: Option<&'static str>,
    base_cosine: Option<f64>,
    /// What more riding would lower the limit most, and to what.
    set: Option<&'static str>,
    limit_after: Option<f64>,
}

/// Two effects of which the ride shows nearly the same.
#[derive(Debug, Serialize)]
struct Pair {
    pair: [&'static str; 2],
    cosine: f64,
    /// Standard deviations of a usual size of the first from the second, of whatever size.
    separation: f64,
    /// What more riding would take them apart best, and how far.
    set: Option<&'static str>,
    cosine_after: Option<f64>,
    separation_after: Option<f64>,
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scenario = Scenario::load(&arguments.scenario).map_err(Failure::Usage)?;
    let pipeline = match &arguments.pipeline {
        Some(path) => Pipeline::read(path).map_err(Failure::Usage)?,
        None => Pipeline::onroad(),
    };
    let machine = scenario.machine(0);
    let session = simulate::session(&scenario, &machine, 0).session;
    let fitted = road::fitted(&session, &machine.bike, &pipeline)
        .map_err(|why| Failure::Usage(format!("scenario {}: {}", scenario.name, why.message)))?;
    let road::Fitted { session, samples, base, .. } = &fitted;
    let advice = Advice::new(session, samples, base, ALL, &machine.bike, &pipeline);
    let (seen, pairs) = (seen(&advice), pairs(&advice));
    if arguments.json {
        let lines = seen.iter().map(serde_json::to_string);
        for line in lines.chain(pairs.iter().map(serde_json::to_string)) {
            say!("{}", line.map_err(|e| Failure::Output(e.to_string()))?);
        }
        return Ok(());
    }
    let duration = session.duration();
    say!("{}: what a ride of {duration:.0} s would tell, at best\n", scenario.name);
    say!(
        "{:24} {:>10} {:8} {:>6}  {}",
        "effect",
        "limit",
        "",
        "usual",
        "what would show it, beyond 4 usual sizes"
    );
    for row in &seen {
        let figure = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2e}"));
        let usual = row.limit_usual.map_or("-".to_owned(), |x| format!("{x:.1}"));
        say!(
            "{:24} {:>10} {:8} {usual:>6}  {}",
            row.effect,
            figure(row.limit),
            row.unit,
            hidden(row)
        );
    }
    say!("\nAlike (cosine of the responses beyond {ALIKE}):");
    if pairs.is_empty() {
        say!("no two");
    }
    for row in &pairs {
        let [a, b] = row.pair;
        let after = match (row.set, row.cosine_after, row.separation_after) {
            (Some(set), Some(cosine), Some(separation)) => {
                format!("; with {set} {cosine:+.2}, {separation:.1}")
            }
            _ => String::new(),
        };
        say!(
            "{a} and {b}: {:+.2}, {:.1} standard deviations apart{after}",
            row.cosine,
            row.separation
        );
    }
    Ok(())
}

/// What is said of an effect that the ride does not show.
fn hidden(row: &Seen) -> String {
    if row.limit_usual.is_some_and(|x| x < LARGEST_LIMIT) {
        return String::new();
    }
    let base = match (row.base, row.base_cosine) {
        (Some(name), Some(cosine)) if cosine.abs() > ALIKE => {
            format!("like {name} ({cosine:+.2}); ")
        }
        _ => String::new(),
    };
    match (row.set, row.limit, row.limit_usual, row.limit_after) {
        (Some(set), Some(limit), Some(usual), Some(after))
            if after * usual / limit < LARGEST_LIMIT =>
        {
            format!("{base}{after:.2e} with {set}")
        }
        _ => format!("{base}no set does"),
    }
}

fn seen(advice: &Advice) -> Vec<Seen> {
    ALL.iter()
        .enumerate()
        .map(|(j, effect)| {
            let usual = Some(advice.own.limit(j)).filter(|x| x.is_finite());
            let size = effect.typical.abs();
            let change = advice.best_detection(effect.name);
            let with = change.and_then(|c| advice.with.iter().find(|(s, _)| s.words == c.set));
            let after = with.map(|(_, known)| known.limit(j) * size).filter(|x| x.is_finite());
            Seen {
                effect: effect.name,
                limit: usual.map(|x| x * size),
                unit: effect.unit,
                limit_usual: usual,
                base: advice.own.taken[j].map(|t| t.0),
                base_cosine: advice.own.taken[j].map(|t| t.1),
                set: change.map(|c| c.set),
                limit_after: after,
            }
        })
        .collect()
}

fn pairs(advice: &Advice) -> Vec<Pair> {
    let mut out = Vec::new();
    for i in 0..ALL.len() {
        for j in i + 1..ALL.len() {
            let cosine = advice.own.cosine(i, j);
            if cosine.abs() <= ALIKE {
                continue;
            }
            let pair = [ALL[i].name, ALL[j].name];
            let change = advice.best_separation(pair[0], &pair[1..]);
            let with = change.and_then(|c| advice.with.iter().find(|(s, _)| s.words == c.set));
            out.push(Pair {
                pair,
                cosine,
                separation: advice.own.separation(i, &[j]),
                set: change.map(|c| c.set),
                cosine_after: with.map(|(_, known)| known.cosine(i, j)),
                separation_after: change.map(|c| c.separation[1]),
            });
        }
    }
    out
}
