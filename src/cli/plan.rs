//! `roadbench plan`.

use clap::builder::NonEmptyStringValueParser;
use indicatif::ProgressBar;

use crate::cli::failure::Failure;
use crate::cli::say::{self, put, say};
use crate::cli::steps::Steps;
use crate::contract::coefficient::{Coefficient as C, SLALOM};
use crate::contract::status::Status;
use crate::diagnose::road::advice::ALIKE;
use crate::diagnose::road::ride_plan::{EffectLimit, RidePlan, plan, scenario};
use crate::pipeline::Pipeline;
use crate::pipeline::predicted::{Expected, Predicted};
use crate::report::next_ride::{self, Want};
use crate::report::readable::size;
use crate::report::terminal;
use crate::simulate::scenario::BUILTIN;
use crate::simulate::tour::{BUILTIN as TOURS, Tour};

/// Predict what a planned ride shows: side forces and faults
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    #[arg(help = help(), value_parser = NonEmptyStringValueParser::new())]
    scenario: String,
    /// Settings of the stages; a file or onroad (the default).
    #[arg(long, value_name = "FILE")]
    pipeline: Option<std::path::PathBuf>,
    /// Print side forces, effects and pairs as JSON, one object a line, instead of tables.
    #[arg(long)]
    json: bool,
}

/// What is said of the scenario.
fn help() -> String {
    let names: Vec<&str> = BUILTIN.iter().map(|(name, _)| *name).collect();
    let names = names.join(", ");
    let tours: Vec<&str> = TOURS.iter().map(|(name, _)| *name).collect();
    let tours = tours.join(", ");
    format!(
        "A built-in scenario ({names}; {tours}: side forces only) or a scenario file: its first session is ridden"
    )
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
    let steps = match Tour::load(&arguments.scenario).map_err(Failure::usage)? {
        Some(_) => None,
        None => {
            // what is wrong is said before anything begins
            scenario(&arguments.scenario).map_err(Failure::usage)?;
            let effects = crate::simulate::effects::ALL.len();
            Some(Steps::begin(bar, effects, "effects on a simulated ride"))
        }
    };
    let planned = plan(&arguments.scenario, &pipeline);
    drop(steps);
    let RidePlan { scenario, duration, side_forces, effects, pairs } =
        planned.map_err(Failure::usage)?;
    if arguments.json {
        print_lines(&side_forces)?;
        print_lines(&effects)?;
        return print_lines(&pairs);
    }
    let Some(duration) = duration else {
        say!("{scenario}: its ride by the nonlinear motorcycle, simulated and fitted\n");
        print_side_forces(&side_forces);
        return Ok(());
    };
    say!("{scenario}: a ride of {duration:.0} s, simulated and fitted\n");
    print_side_forces(&side_forces);
    say!("Smallest effects that diagnose identifies half of the time\n");
    say!("{:<24}{:>14}  in usual sizes", "effect", "size");
    for row in &effects {
        let limit = row.limit.map_or("none".to_owned(), |x| size(x, row.effect, row.unit));
        let usual = row.limit_usual.map_or("-".to_owned(), |x| format!("{x:.1}"));
        say!("{:<24}{limit:>14}{usual:>8}", row.effect);
        let hidden = hidden(row);
        if !hidden.is_empty() {
            put!("{}", terminal::wrapped(&format!("    {hidden}"), say::line_width()));
        }
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
        let text = format!(
            "{a} and {b}: {:+.2}, {:.1} standard deviations apart{after}",
            row.cosine, row.separation
        );
        put!("{}", terminal::wrapped(&text, say::line_width()));
    }
    Ok(())
}

/// JSON, one object a line.
fn print_lines<T: serde::Serialize>(rows: &[T]) -> Result<(), Failure> {
    for row in rows {
        let line = serde_json::to_string(row).map_err(|e| Failure::Output(e.to_string()))?;
        say!("{line}");
    }
    Ok(())
}

/// How people read the coefficients of the side forces.
fn words(coefficient: &str) -> &str {
    match C::from_name(coefficient) {
        Some(C::CorneringStiffness0) => "cornering stiffness",
        Some(C::CamberStiffness0) => "camber stiffness",
        Some(C::SideForceRatio) => "camber over cornering (C)",
        _ => coefficient,
    }
}

/// An interval, and where it is not the ride's.
fn interval(expected: &Expected) -> String {
    let width = expected.half_width.map(|x| format!("±{:.0} %", 100.0 * x));
    match (width, expected.status) {
        (None, Status::NotAvailable) => "not available".to_owned(),
        (None, _) => "unbounded".to_owned(),
        (Some(width), Status::Assumed) => format!("{width} assumed"),
        (Some(width), _) => width,
    }
}

/// Less than this share of the planned interval is worth a slalom.
const WORTH: f64 = 0.9;

/// The side forces as planned and with a slalom, and what to ride.
fn print_side_forces(found: &[Predicted]) {
    let is_given = found.iter().any(|p| p.ratio_given);
    say!("{:34} {:>15} {:>15}", "side forces, 95 % interval", "as planned", "with a slalom");
    for given in [true, false] {
        let mut rows = found.iter().filter(|p| p.ratio_given == given).peekable();
        if is_given && rows.peek().is_some() {
            let whose = if given { "bike file that gives C" } else { "bike file that does not" };
            say!("  {whose}");
        }
        for p in rows {
            let name = format!("{} {}", p.tyre, words(p.coefficient));
            say!("{name:34} {:>15} {:>15}", interval(&p.planned), interval(&p.with_slalom));
        }
    }
    let gains: Vec<String> = found
        .iter()
        .filter(|p| !p.ratio_given && p.coefficient == C::CorneringStiffness0.name())
        .filter(|p| {
            let of = |e: Expected| e.half_width.unwrap_or(f64::INFINITY);
            of(p.with_slalom) < WORTH * of(p.planned)
        })
        .map(|p| {
            let (before, after) = (interval(&p.planned), interval(&p.with_slalom));
            format!("{} {} {before} -> {after}", p.tyre, words(p.coefficient))
        })
        .collect();
    match gains.is_empty() {
        true => say!("\nFour more slalom passes would narrow no cornering stiffness by a tenth.\n"),
        false => {
            let riding =
                next_ride::sentence(Want::Value, words(C::CorneringStiffness0.name()), SLALOM);
            let text = format!("\n{riding}.\n  {}\n\n", gains.join(", "));
            put!("{}", terminal::wrapped(&text, say::line_width()));
        }
    }
}

/// What is said of an effect that the ride does not show.
fn hidden(row: &EffectLimit) -> String {
    if row.limit.is_some() {
        return String::new();
    }
    let base = match (row.base, row.base_cosine) {
        (Some(name), Some(cosine)) if cosine.abs() > ALIKE => {
            format!("like {name} ({cosine:+.2}); ")
        }
        _ => String::new(),
    };
    match (row.set, row.limit_after) {
        (Some(set), Some(after)) => {
            format!("{base}{} with {set}", size(after, row.effect, row.unit))
        }
        _ => format!("{base}no manoeuvre that was tried shows it"),
    }
}
