//! `roadbench compare`.

use std::path::PathBuf;

use clap::ValueHint;
use clap::builder::NonEmptyStringValueParser;

use crate::batch::error::Error;
use crate::batch::fleet::compare::answer::{about, answer, not_comparable, undecided};
use crate::batch::fleet::compare::numbers::{AtLoad, Change, at_load, change, value};
use crate::batch::fleet::compare::page::html;
use crate::batch::fleet::compare::words::noun;
use crate::batch::fleet::compare::{Comparison, compare};
use crate::cli::failure::Failure;
use crate::cli::location::location;
use crate::cli::say::{note, say};
use crate::report::labels;
use crate::report::terminal::wrap;
use crate::store::objects::Location;
use crate::store::tables::output;
use crate::store::tables::output::Outputs;
use crate::store::tables::rows::ComparisonRow;

/// Compare two sets of sessions: how much their tyres differ
///
/// Errors that both sides share (bike file, sensors, model of one motorcycle) cancel; the spread between sessions
/// does not. A coefficient has a verdict where the 95 % interval of its difference excludes zero.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The folder that `roadbench run --out` wrote.
    out: PathBuf,
    /// Sessions of side A; without B, a second output to compare OUT with.
    ///
    /// A set is one or more of these, parted by commas: a session id, tyre=, front=, rear=, bike=, rider=, site= with a name,
    /// days such as 2026-05-01..2026-05-03. Terms of one kind add up, those of different kinds narrow each other; `*` stands
    /// for any letters. `others` is every session that the other side has not.
    #[arg(value_name = "A", value_parser = NonEmptyStringValueParser::new())]
    a: String,
    /// Sessions of side B.
    #[arg(value_name = "B", value_parser = NonEmptyStringValueParser::new())]
    b: Option<String>,
    /// Tyres whose model no log gives were the same on both sides; else they count as two.
    #[arg(long)]
    same_tyres: bool,
    /// Load at which forces and stiffnesses are given, N.
    #[arg(long, default_value_t = 1300.0)]
    load: f64,
    /// Print the rows of the table as JSON, one object a line.
    #[arg(long)]
    json: bool,
    /// File for the comparison as a page (HTML).
    #[arg(long, value_name = "FILE")]
    #[arg(value_parser = location(), value_hint = ValueHint::FilePath)]
    page: Option<Location>,
    /// File for the table `comparison` (Parquet).
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    #[arg(value_parser = location(), value_hint = ValueHint::FilePath)]
    file: Option<Location>,
}

/// Columns of the terminal.
const WIDTH: usize = 80;

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { out, a, b, same_tyres, load, json, page, file } = arguments;
    if !(10.0..=20_000.0).contains(load) {
        return Err(Failure::Usage(format!("--load {load} N must be between 10 and 20000")));
    }
    let mut outputs = Outputs::default();
    outputs.tables(&out.into());
    for (option, file) in [("--out", file), ("--page", page)] {
        if let Some(file) = file {
            outputs.file(option, file)?;
        }
    }
    let found = compare(out, a, b.as_deref(), *same_tyres).map_err(|e| match e {
        Error::Usage(message) => Failure::Usage(message),
        other => Failure::Output(other.to_string()),
    })?;
    if let Some(file) = file {
        output::write_rows(file, &found.rows).map_err(|e| Failure::Output(e.to_string()))?;
    }
    if let Some(page) = page {
        let html = html(&found, *load, *same_tyres).map_err(|e| Failure::Output(e.to_string()))?;
        output::write(page, html.as_bytes()).map_err(|e| Failure::Output(e.to_string()))?;
    }
    if *json {
        for row in &found.rows {
            let line = serde_json::to_string(row).map_err(|e| Failure::Output(e.to_string()))?;
            say!("{line}");
        }
        return Ok(());
    }
    print(&found, *load, *same_tyres);
    if let Some(file) = file {
        note!("\ntable: {file}");
    }
    if let Some(page) = page {
        note!("\npage: {page}");
    }
    Ok(())
}

fn print(found: &Comparison, load: f64, same_tyres: bool) {
    for (name, side) in ["A", "B"].into_iter().zip(&found.sides) {
        wrapped(&format!("{name}: {}", about(side)), "   ");
    }
    say!();
    answer(found, same_tyres).iter().for_each(|sentence| wrapped(sentence, ""));
    let compared: Vec<&ComparisonRow> =
        found.rows.iter().filter(|row| row.difference.is_some()).collect();
    if !compared.is_empty() {
        table(&compared);
        curves(&compared, load);
    }
    for paragraph in undecided(&compared) {
        say!();
        for line in paragraph {
            wrapped(&line, if line.starts_with(' ') { "    " } else { "  " });
        }
    }
    let others: Vec<&ComparisonRow> =
        found.rows.iter().filter(|row| row.difference.is_none()).collect();
    let missing = not_comparable(&others);
    if !missing.is_empty() {
        say!("\nNot comparable");
        missing.iter().for_each(|line| wrapped(&format!("  {line}"), "    "));
    }
}

fn table(rows: &[&ComparisonRow]) {
    say!();
    say!(
        "{:20}{:>13}{:>13}{:>8}{:>13}{:>5} {}",
        "",
        "A ±95 %",
        "B ±95 %",
        "B - A",
        "95 %",
        "P",
        "B is"
    );
    let mut tyre = "";
    for row in rows {
        if row.tyre != tyre {
            tyre = &row.tyre;
            say!("{}", labels::tyre(tyre));
        }
        let a = value(row.value_a, row.ci95_low_a, row.ci95_high_a);
        let b = value(row.value_b, row.ci95_low_b, row.ci95_high_b);
        let line = format!(" {:19}{a:>13}{b:>13}{}", noun(&row.coefficient), columns(row));
        say!("{}", line.trim_end());
    }
    say!("A, B: with all errors and the spread between sessions, unlike one session.");
    say!("P: probability that B is larger. Of values below zero the sizes are compared.");
}

/// Difference, interval, probability and verdict.
fn columns(row: &ComparisonRow) -> String {
    let Change { size, ends, chance, verdict } = change(row);
    format!("{size:>8}{ends:>13}{chance:>5} {verdict}")
}

/// The curves of both tyres at a load: their height and their slope.
fn curves(rows: &[&ComparisonRow], load: f64) {
    let lines = at_load(rows, load);
    if !lines.is_empty() {
        say!("\nCurves at {load:.0} N (force per load as at the load of the rides)");
    }
    for AtLoad { row, name, a, b } in lines {
        let line = format!(" {:5} {name:19}{a:>10}{b:>10}{}", row.tyre, columns(row));
        say!("{}", line.trim_end());
    }
}

/// A text on lines that fit; those after the first begin with `indent`.
fn wrapped(text: &str, indent: &str) {
    let first: String = text.chars().take_while(|c| *c == ' ').collect();
    let clean: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let room = WIDTH - first.len().max(indent.len());
    for (i, line) in wrap(&clean, room).iter().enumerate() {
        let before = if i == 0 { first.as_str() } else { indent };
        say!("{before}{line}");
    }
}
