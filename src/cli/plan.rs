//! `roadbench plan`.

use clap::builder::NonEmptyStringValueParser;
use indicatif::ProgressBar;

use crate::cli::failure::Failure;
use crate::cli::say::say;
use crate::cli::steps::Steps;
use crate::diagnose::road::advice::ALIKE;
use crate::diagnose::road::null_calibration::LARGEST_LIMIT;
use crate::diagnose::road::ride_plan::{self, EffectLimit, RidePlan};
use crate::pipeline::Pipeline;
use crate::simulate::scenario::BUILTIN;

/// Predict which faults a planned ride could reveal
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    #[arg(help = help(), value_parser = NonEmptyStringValueParser::new())]
    scenario: String,
    /// Settings of the stages; a file or onroad (the default).
    #[arg(long, value_name = "FILE")]
    pipeline: Option<std::path::PathBuf>,
    /// Print effects and pairs as JSON, one object a line, instead of tables.
    #[arg(long)]
    json: bool,
}

/// What is said of the scenario.
fn help() -> String {
    let names: Vec<&str> = BUILTIN.iter().map(|(name, _)| *name).collect();
    let names = names.join(", ");
    format!("A built-in scenario ({names}) or a scenario file: its first session is ridden")
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: &Arguments, bar: ProgressBar) -> Result<(), Failure> {
    let pipeline = match &arguments.pipeline {
        Some(path) => Pipeline::read(path).map_err(Failure::usage)?,
        None => Pipeline::onroad(),
    };
    let scenario = ride_plan::scenario(&arguments.scenario).map_err(Failure::usage)?;
    let steps =
        Steps::begin(bar, crate::simulate::effects::ALL.len(), "effects on a simulated ride");
    let planned = ride_plan::plan(scenario, &pipeline);
    drop(steps);
    let RidePlan { scenario, duration, effects, pairs } = planned.map_err(Failure::usage)?;
    if arguments.json {
        let lines = effects.iter().map(serde_json::to_string);
        for line in lines.chain(pairs.iter().map(serde_json::to_string)) {
            say!("{}", line.map_err(|e| Failure::Output(e.to_string()))?);
        }
        return Ok(());
    }
    say!("{scenario}: smallest effects that a ride of {duration:.0} s can reveal, at best\n");
    say!(
        "{:24} {:>10} {:8} {:>7}  {}",
        "effect",
        "limit",
        "",
        "typical",
        "what would show it, where the limit is above 4 typical sizes"
    );
    for row in &effects {
        let figure = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2e}"));
        let usual = row.limit_usual.map_or("-".to_owned(), |x| format!("{x:.1}"));
        say!(
            "{:24} {:>10} {:8} {usual:>7}  {}",
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
fn hidden(row: &EffectLimit) -> String {
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
