//! `roadbench compare`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::ValueHint;
use clap::builder::NonEmptyStringValueParser;

use crate::batch::error::Error;
use crate::batch::fleet::compare::words::{noun, percent};
use crate::batch::fleet::compare::{Chosen, Comparison, compare};
use crate::cli::failure::Failure;
use crate::cli::location::location;
use crate::cli::say::{note, say};
use crate::contract::coefficient::Coefficient as C;
use crate::contract::error_source::{MODEL, RIDES};
use crate::fleet::compare::Verdict;
use crate::report::labels;
use crate::report::terminal::wrap;
use crate::statistics::number_format::{count, decimals_of, fixed};
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
    /// File for the table `comparison` (Parquet).
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    #[arg(value_parser = location(), value_hint = ValueHint::FilePath)]
    file: Option<Location>,
}

/// Columns of the terminal.
const WIDTH: usize = 80;
/// Sentences of differences before the table.
const SENTENCES: usize = 3;

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { out, a, b, same_tyres, load, json, file } = arguments;
    if !(10.0..=20_000.0).contains(load) {
        return Err(Failure::Usage(format!("--load {load} N must be between 10 and 20000")));
    }
    if let Some(file) = file {
        let mut outputs = Outputs::default();
        outputs.tables(&out.into());
        outputs.file("--out", file)?;
    }
    let found = compare(out, a, b.as_deref(), *same_tyres).map_err(|e| match e {
        Error::Usage(message) => Failure::Usage(message),
        other => Failure::Output(other.to_string()),
    })?;
    if let Some(file) = file {
        output::write_rows(file, &found.rows).map_err(|e| Failure::Output(e.to_string()))?;
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
    undecided(&compared);
    let others: Vec<&ComparisonRow> =
        found.rows.iter().filter(|row| row.difference.is_none()).collect();
    not_comparable(&others);
}

/// A side in a line.
fn about(side: &Chosen) -> String {
    let mut text = format!("{}, {}", side.text, count(side.sessions.len(), "session"));
    let bikes: Vec<&str> = side.bikes().into_iter().collect();
    match bikes.as_slice() {
        [bike] => text += &format!(" of {bike}"),
        all => text += &format!(" of {}", count(all.len(), "motorcycle")),
    }
    match &side.days {
        Some([first, last]) if first == last => text += &format!(", {first}"),
        Some([first, last]) => text += &format!(", {first} to {last}"),
        None => {}
    }
    text
}

/// What everybody wants to know first, in sentences.
fn answer(found: &Comparison, same_tyres: bool) -> Vec<String> {
    let is = |row: &ComparisonRow, verdict: Verdict| row.verdict == verdict.name();
    let mut differ: Vec<&ComparisonRow> = found
        .rows
        .iter()
        .filter(|row| is(row, Verdict::Larger) || is(row, Verdict::Smaller))
        .collect();
    let none = found.rows.iter().filter(|row| is(row, Verdict::NoDifference)).count();
    differ.sort_by_key(|row| {
        // who fits other tyres knows that their radius is another
        let last = FIRST.len() + usize::from(row.coefficient == C::EffectiveRollingRadius.name());
        FIRST.iter().position(|c| c.name() == row.coefficient).unwrap_or(last)
    });
    let friction: Vec<&ComparisonRow> = found
        .rows
        .iter()
        .filter(|row| row.coefficient == C::MfD.name() && is(row, Verdict::NoDifference))
        .collect();
    let mut out: Vec<String> =
        differ.iter().take(SENTENCES).map(|row| row.sentence.clone()).collect();
    if !friction.is_empty() {
        let ends = |row: &&ComparisonRow| {
            let [low, high] = [row.relative_low, row.relative_high].map(Option::unwrap_or_default);
            format!("{} {} to {} %", row.tyre, percent(low), percent(high))
        };
        let ends: Vec<String> = friction.iter().map(ends).collect();
        out.push(format!("No difference in peak friction is seen (95 %: {}).", ends.join(", ")));
    }
    if differ.is_empty() && none == 0 {
        return vec![
            "Nothing can be compared: no coefficient is determined on both sides.".to_owned(),
        ];
    }
    let what = if out.is_empty() { "coefficient" } else { "other coefficient" };
    let rest = none - friction.len();
    let unseen = count(rest, what);
    match (differ.len().saturating_sub(SENTENCES), rest) {
        (0, 0) => {}
        (0, _) => out.push(format!("No difference is seen in {unseen}.")),
        (more, 0) => out.push(format!("{more} more differ.")),
        (more, _) => out.push(format!("{more} more differ; no difference is seen in {unseen}.")),
    }
    let [a, b] = &found.sides;
    let both: Vec<&str> = a.bikes().intersection(&b.bikes()).copied().collect();
    out.push(
        match (both.is_empty(), a.bikes() == b.bikes()) {
            (true, _) => {
                "A and B are different motorcycles: the errors of their bike files do not cancel."
            }
            (_, true) => "Both are the same motorcycle: errors that its sessions share cancel.",
            _ => "Some motorcycles are on both sides: errors that their sessions share cancel.",
        }
        .to_owned(),
    );
    let unnamed = |side: &Chosen| side.tyres.iter().any(|t| t.iter().any(Option::is_none));
    if !both.is_empty() && !same_tyres && (unnamed(a) || unnamed(b)) {
        out.push(
            "The logs do not say which tyres were on: they count as two sets (--same-tyres: one)."
                .to_owned(),
        );
    }
    let tested = found.rows.iter().filter(|row| row.difference.is_some()).count();
    let doubtful =
        differ.iter().filter(|row| row.false_discovery_rate.is_some_and(|q| q > 0.1)).count();
    if doubtful > 0 {
        out.push(format!(
            "Of {tested} comparisons about one in twenty differs by chance: {doubtful} of those that differ may."
        ));
    }
    let few = found.rows.iter().filter(|row| row.between_assumed == Some(true)).count();
    if few * 2 > tested {
        out.push(
            "There are too few sessions to see their spread: 2 % are assumed (`between_sd` of the table)."
                .to_owned(),
        );
    }
    out
}

/// What is said first.
const FIRST: [C; 9] = [
    C::MfD,
    C::CorneringStiffness0,
    C::LateralFrictionCt,
    C::SlipStiffness,
    C::CamberStiffness0,
    C::PeakSlip,
    C::Drag,
    C::RollingResistance,
    C::OverturningStiffness,
];

/// Width of a value with half of its interval.
const VALUE: usize = 12;
/// Width of an interval.
const INTERVAL: usize = 12;

/// The text of numbers with as many decimals as there is room for.
fn fitted(places: usize, width: usize, text: impl Fn(usize) -> String) -> String {
    let all = (0..=places).rev().map(&text);
    all.into_iter().find(|t| t.chars().count() <= width).unwrap_or_else(|| text(0))
}

/// A value with half of its interval.
fn value(value: Option<f64>, low: Option<f64>, high: Option<f64>) -> String {
    let (Some(value), Some(low), Some(high)) = (value, low, high) else { return "-".to_owned() };
    let half = 0.5 * (high - low);
    let bare = |x: f64, places| match fixed(x, places) {
        text if text.starts_with("0.") => text[1..].to_owned(),
        text => text,
    };
    let text = |places| format!("{}±{}", fixed(value, places), bare(half, places));
    fitted(decimals_of(value, Some(half)).min(6), VALUE, text)
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
        let line = format!(" {:19}{a:>13}{b:>13}{}", noun(&row.coefficient), change(row));
        say!("{}", line.trim_end());
    }
    say!("P: probability that B is larger. Of values below zero the sizes are compared.");
}

/// Difference, interval, probability and verdict.
fn change(row: &ComparisonRow) -> String {
    let (size, ends) = match (row.relative, row.relative_low, row.relative_high) {
        (Some(size), Some(low), Some(high)) => (
            format!("{} %", signed(percent(size))),
            format!("{} to {}", percent(low), percent(high)),
        ),
        _ => {
            let [low, high] = [row.ci95_low, row.ci95_high].map(|x| x.unwrap_or(f64::NAN));
            let half = 0.5 * (high - low);
            let places = decimals_of(half, Some(half)).min(6);
            let size = row.difference.unwrap_or(f64::NAN);
            (
                fitted(places, 7, |n| signed(fixed(size, n))),
                fitted(places, INTERVAL, |n| format!("±{}", fixed(half, n))),
            )
        }
    };
    let chance = row.probability_larger.map_or("-".to_owned(), |p| match p {
        p if p >= 0.995 => ">99%".to_owned(),
        p if p < 0.005 => "<1%".to_owned(),
        p => format!("{:.0}%", 100.0 * p),
    });
    let verdict = match row.verdict.as_str() {
        v if v == Verdict::NoDifference.name() => "unclear",
        v => v,
    };
    format!("{size:>8}{ends:>13}{chance:>5} {verdict}")
}

fn signed(text: String) -> String {
    let is_bare = text.starts_with('-') || text.chars().all(|c| c == '0' || c == '.');
    if is_bare { text } else { format!("+{text}") }
}

/// The curves of both tyres at a load: their height and their slope.
fn curves(rows: &[&ComparisonRow], load: f64) {
    const OF: [(C, &str); 4] = [
        (C::MfD, "peak brake force, N"),
        (C::SlipStiffness, "slip stiffness, N"),
        (C::CorneringStiffness0, "cornering, N/rad"),
        (C::CamberStiffness0, "camber, N/rad"),
    ];
    let mut lines = Vec::new();
    for row in rows {
        let Some((_, name)) = OF.iter().find(|(c, _)| c.name() == row.coefficient) else {
            continue;
        };
        let force = |v: Option<f64>| v.map_or("-".to_owned(), |v| fixed(v * load, 0));
        lines.push(format!(
            " {:5} {name:19}{:>10}{:>10}{}",
            row.tyre,
            force(row.value_a),
            force(row.value_b),
            change(row)
        ));
    }
    if !lines.is_empty() {
        say!("\nCurves at {load:.0} N (force per load as at the load of the rides)");
        lines.iter().for_each(|line| say!("{}", line.trim_end()));
    }
}

/// What riding would decide what is not decided, by the riding.
fn undecided(rows: &[&ComparisonRow]) {
    let open = rows.iter().filter(|row| row.verdict == Verdict::NoDifference.name());
    let (mut shown, mut limited) = (Vec::new(), Vec::new());
    let mut by_riding: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for row in open {
        let who = format!("{} {}", row.tyre, noun(&row.coefficient));
        let seen = row.more_sessions_for_seen;
        let text = match row.more_sessions_for_5_percent {
            Some(0) => {
                shown.push(who);
                continue;
            }
            Some(n) => format!("{who} {}", sessions(n)),
            // what has no per cent has no 5 of them either
            None if seen.is_some_and(|n| n <= SENSIBLE) => format!("{who} -"),
            None => {
                limited.push(format!("{who} ({})", row.limited_by.as_deref().unwrap_or("rides")));
                continue;
            }
        };
        let seen = seen.map_or("-".to_owned(), sessions);
        by_riding
            .entry(row.advice.as_deref().unwrap_or("any riding"))
            .or_default()
            .push(format!("{text} ({seen})"));
    }
    if !shown.is_empty() {
        say!();
        wrapped(&format!("A difference of 5 % would have shown: {}.", shown.join(", ")), "  ");
    }
    if !by_riding.is_empty() {
        say!();
        wrapped(
            "Sessions more on each side that would decide 5 % (in brackets: the difference seen), if they are such as these and have this riding:",
            "  ",
        );
        for (riding, all) in by_riding {
            wrapped(&format!("  {riding}: {}", all.join(", ")), "    ");
        }
    }
    if !limited.is_empty() {
        say!();
        let measurable = rows.iter().any(|row| {
            let by = row.limited_by.as_deref().unwrap_or_default();
            let is_open = row.verdict == Verdict::NoDifference.name();
            is_open && row.more_sessions_for_5_percent.is_none() && by != MODEL && by != RIDES
        });
        let hint =
            if measurable { " Numbers of the bike file can be measured better." } else { "" };
        let text = limited.join(", ");
        wrapped(
            &format!(
                "No number of such sessions decides, for what limits them (in brackets): {text}.{hint}"
            ),
            "  ",
        );
    }
}

/// More sessions than these are no plan.
const SENSIBLE: i64 = 99;

fn sessions(n: i64) -> String {
    if n > SENSIBLE { format!(">{SENSIBLE}") } else { n.to_string() }
}

/// What has no value on one side.
fn not_comparable(rows: &[&ComparisonRow]) {
    let mut by_reason: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for row in rows {
        let who = format!("{} {}", row.tyre, noun(&row.coefficient));
        by_reason.entry(row.sentence.trim_end_matches('.')).or_default().push(who);
    }
    if by_reason.is_empty() {
        return;
    }
    say!("\nNot comparable");
    for (reason, all) in by_reason {
        wrapped(&format!("  {} ({reason})", all.join(", ")), "    ");
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
