//! `roadbench demo`: a ride on which something is wrong, and what comes out of it.

use std::path::{Path, PathBuf};
use std::time::Instant;

use indicatif::ProgressBar;

use crate::batch::discover::refuse_others_sessions;
use crate::cli::failure::Failure;
use crate::cli::say::say;
use crate::cli::{browser, colour, diagnose, run, simulate};
use crate::contract::coefficient::{Coefficient as C, Id, Part};
use crate::estimate;
use crate::report::diagnosis::tables as diagnosis;
use crate::report::labels;
use crate::report::tables;
use crate::simulate::effects::Effect;
use crate::simulate::scenario::{BUILTIN, Scenario};
use crate::simulate::{session, truth};
use crate::store::tables::file;
use crate::store::tables::output::Outputs;
use crate::store::tables::rows::{CauseRow, Coefficient, Status};

/// Simulate two rides with a hidden fault, find it, open the report
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Folder for the rides and the results.
    #[arg(short, long, value_name = "DIR", default_value = "roadbench-demo")]
    out: PathBuf,
    /// Do not open the report.
    #[arg(long)]
    no_open: bool,
}

/// Coefficients that the story shows, with their decimals.
const SHOWN: [(Part, C, usize); 8] = [
    (Part::Front, C::MfD, 3),
    (Part::Front, C::CorneringStiffness0, 1),
    (Part::Front, C::CamberStiffness0, 2),
    (Part::Rear, C::MfD, 3),
    (Part::Rear, C::CorneringStiffness0, 1),
    (Part::Rear, C::CamberStiffness0, 2),
    (Part::Vehicle, C::Drag, 3),
    (Part::Vehicle, C::OverturningStiffness, 4),
];

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: &Arguments, bar: ProgressBar) -> Result<(), Failure> {
    let scenario = Scenario::builtin("demo").map_err(Failure::usage)?;
    let (archive, out) = (arguments.out.join("archive"), arguments.out.join("tables"));
    Outputs::default().folder("--out", &(&arguments.out).into())?;
    simulate::check_archive(&(&archive).into())?;
    refuse_others_sessions(&(&out).into())?;
    simulate::begin_archive(&(&archive).into())?;
    let begin = Instant::now();
    let step = |what: &str, from: Instant| {
        say!("{what:<62} {:5.1} s", from.elapsed().as_secs_f64());
        Instant::now()
    };
    let colours = colour::on_stdout();
    say!("{}\n", colour::bold("Two simulated rides with a fault hidden in the sensors", colours));
    let rides = simulate::write_bike(&scenario, 0, &(&archive).into(), &|| ())
        .map_err(|e| Failure::Output(e.to_string()))?;
    let text = BUILTIN.iter().find(|(name, _)| *name == "demo").map_or("", |(_, text)| text);
    file::write_bytes(archive.join("scenario.toml"), text.as_bytes())
        .map_err(|e| Failure::Output(e.to_string()))?;
    let at = step(&format!("simulate: {rides} rides with the sensors of a real one"), begin);
    run::run(run::Arguments::quietly(archive.clone(), out.clone()), bar.clone())?;
    let at = step("run: the coefficients of both tyres, with intervals", at);
    diagnose::run(diagnose::Arguments::quietly(archive.clone(), out.clone()), bar)?;
    step("diagnose: is anything wrong with these rides?", at);

    tyres(&scenario, &out, colours)?;
    causes(text, &out, colours)?;
    let report = out.join("report/index.html");
    say!("\nRides in {}, tables in {}", archive.display(), out.display());
    say!("{} {}", colour::bold("Report:", colours), report.display());
    if !arguments.no_open {
        browser::open(&report);
    }
    say!("{:.1} s in all", begin.elapsed().as_secs_f64());
    Ok(())
}

/// What the first ride gives of the tyres, beside the truth.
fn tyres(scenario: &Scenario, out: &Path, colours: bool) -> Result<(), Failure> {
    let machine = scenario.machine(0);
    let ride = session(scenario, &machine, 0);
    let known = truth::coefficients(&machine.plant, &ride, &estimate::Config::default());
    let rows = tables::coefficients(out).map_err(|e| Failure::Output(e.to_string()))?;
    let Some(first) = rows.first().map(|r| r.ident.session_id.clone()) else { return Ok(()) };
    let of = |id: Id| {
        let own = |r: &&Coefficient| {
            r.ident.session_id == first && Id::from_names(&r.tyre, &r.coefficient) == Some(id)
        };
        rows.iter().find(own)
    };
    let (mut held, mut all) = (0, 0);
    for (id, value) in &known {
        if let Some(row) = of(*id).filter(|r| r.status == Status::Ok)
            && let (Some(low), Some(high)) = (row.ci95_low, row.ci95_high)
        {
            all += 1;
            held += usize::from((low..=high).contains(value));
        }
    }
    let title = format!("The tyres, from ride {first}");
    say!("\n{}", colour::bold(&title, colours));
    say!("{:55} {:>8} {:>8}   95 % interval", "", "true", "found");
    for (part, coefficient, decimals) in SHOWN {
        let id = Id { part, coefficient };
        let (Some(row), Some((_, truth))) = (of(id), known.iter().find(|k| k.0 == id)) else {
            continue;
        };
        let figure = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.decimals$}"));
        let unit = labels::unit(&row.unit);
        let of_unit = if unit.is_empty() { unit } else { format!(", {unit}") };
        let words = format!("{}{of_unit}", labels::coefficient(coefficient.name()));
        let interval = match (row.ci95_low, row.ci95_high) {
            (Some(low), Some(high)) => format!("{} to {}", figure(Some(low)), figure(Some(high))),
            _ => "-".to_owned(),
        };
        say!(
            "{part:8} {words:46} {:>8} {:>8}   {interval}",
            figure(Some(*truth)),
            figure(row.value)
        );
    }
    say!(
        "{held} of the {all} intervals of this ride contain the true value; of many rides, 95 % would."
    );
    Ok(())
}

/// The hidden faults, and the causes that `diagnose` identified.
fn causes(scenario: &str, out: &Path, colours: bool) -> Result<(), Failure> {
    let hidden = hidden(scenario);
    let rows = diagnosis::causes(out).map_err(|e| Failure::Output(e.to_string()))?;
    let named: Vec<&CauseRow> =
        rows.iter().filter(|r| matches!(r.verdict.as_str(), "named" | "ambiguous")).collect();
    say!("\n{}", colour::bold("Hidden in these rides, unknown to `diagnose`", colours));
    for (effect, value) in &hidden {
        say!("{:24} {value:8.4} {:4} {}", effect.name, effect.unit, effect.sentence_of(*value));
    }
    say!("\n{}", colour::bold("Identified by `diagnose`", colours));
    for row in &named {
        let (Some(value), Some(low), Some(high)) = (row.value, row.ci95_low, row.ci95_high) else {
            continue;
        };
        let right = match hidden.iter().find(|(e, _)| e.name == row.effect) {
            None => "not hidden: a false alarm",
            Some((_, truth)) if (low..=high).contains(truth) => "right, the interval contains it",
            Some(_) => "right, but the interval misses its size",
        };
        say!(
            "{:24} {value:8.4} {:4} 95 % interval {low:.4} to {high:.4}; ride {}: {right}",
            row.effect,
            row.unit,
            row.ident.session_id
        );
    }
    for (effect, _) in &hidden {
        if !named.iter().any(|r| r.effect == effect.name) {
            say!("{:24} was not found", effect.name);
        }
    }
    Ok(())
}

/// The effects of a scenario and, as one of them, the delay of its velocities.
fn hidden(scenario: &str) -> Vec<(Effect, f64)> {
    let table: toml::Table = scenario.parse().unwrap_or_default();
    let mut found = Vec::new();
    let effects = table.get("effects").and_then(toml::Value::as_table);
    for (name, value) in effects.into_iter().flatten() {
        if let (Ok(effect), Some(value)) = (Effect::named(name), value.as_float()) {
            found.push((*effect, value));
        }
    }
    let latency = || table.get("sensors")?.get("velocity_x")?.get("latency")?.as_float();
    if let (Some(value), Ok(effect)) = (latency(), Effect::named("latency")) {
        found.push((*effect, value));
    }
    found
}
