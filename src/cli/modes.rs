//! `roadbench modes`.

use clap::ValueHint;
use clap::builder::NonEmptyStringValueParser;

use crate::cli::failure::Failure;
use crate::cli::location::location;
use crate::cli::say::{note, say};
use crate::report::static_figures::panels::{Panel, Series, Style, panels};
use crate::simulate::multibody::description::BUILTIN;
use crate::simulate::multibody::modes::{Mode, Name, over_speed};
use crate::simulate::multibody::{Model, Motorcycle, Road};
use crate::store::objects::Location;
use crate::store::tables::file;
use crate::store::tables::output;
use crate::store::tables::output::Outputs;
use crate::store::tables::rows::ModeRow;

/// Eigenvalues of a motorcycle over speed: weave, wobble, capsize
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    #[arg(help = help(), value_parser = NonEmptyStringValueParser::new())]
    motorcycle: String,
    /// Lowest speed, m/s.
    #[arg(long, default_value_t = 4.0, value_name = "SPEED")]
    from: f64,
    /// Highest speed, m/s.
    #[arg(long, default_value_t = 60.0, value_name = "SPEED")]
    to: f64,
    /// Step of the speed, m/s.
    #[arg(long, default_value_t = 1.0, value_name = "SPEED")]
    step: f64,
    /// Folder for the table (modes.parquet) and the figure (modes.svg).
    #[arg(short, long, value_parser = location(), value_hint = ValueHint::AnyPath)]
    out: Option<Location>,
}

/// What is written into the folder.
const FILES: [&str; 2] = ["modes.parquet", "modes.svg"];

/// What is said of a motorcycle.
pub(super) fn help() -> String {
    let names: Vec<&str> = BUILTIN.iter().map(|(name, _)| *name).collect();
    format!("A built-in motorcycle ({}) or a motorcycle file", names.join(", "))
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { from, to, step, .. } = *arguments;
    if !(from >= 0.0 && to > from && to <= 120.0 && step > 0.0 && (to - from) / step <= 2000.0) {
        return Err(Failure::Usage(format!(
            "--from {from} --to {to} --step {step}: give 0 <= from < to <= 120 m/s and at most \
             2000 steps"
        )));
    }
    if let Some(out) = &arguments.out {
        let mut outputs = Outputs::default();
        outputs.folder("--out", out)?;
        FILES.iter().try_for_each(|name| outputs.file("--out", &out.join(name)))?;
        outputs.apart_from_files([&arguments.motorcycle])?;
    }
    let motorcycle = Motorcycle::load(&arguments.motorcycle).map_err(Failure::usage)?;
    let (id, name) = (motorcycle.id.clone(), motorcycle.name.clone());
    let model = Model::new(motorcycle, Road::default());
    let count = ((to - from) / step).floor() as usize;
    let speeds: Vec<f64> = (0..=count).map(|i| from + i as f64 * step).collect();
    let modes =
        over_speed(&model, &speeds).map_err(|e| Failure::Usage(format!("motorcycle {id}: {e}")))?;
    print(&model, &name, &speeds, &modes);
    let Some(out) = &arguments.out else { return Ok(()) };
    let rows: Vec<ModeRow> = modes
        .iter()
        .map(|m| ModeRow {
            motorcycle: id.clone(),
            speed: m.speed,
            mode: m.name.name().to_owned(),
            real: m.eigenvalue.re,
            imaginary: m.eigenvalue.im,
            frequency: m.frequency(),
            damping_ratio: m.damping(),
        })
        .collect();
    let fail = |e: file::Error| Failure::Output(e.to_string());
    let [table, drawing] = FILES.map(|name| out.join(name));
    output::write_rows(&table, &rows).map_err(fail)?;
    output::write(&drawing, figure(&name, &modes).as_bytes()).map_err(fail)?;
    note!("table: {table}");
    note!("figure: {drawing}");
    Ok(())
}

const NAMED: [Name; 3] = [Name::Weave, Name::Wobble, Name::Capsize];

/// About a dozen speeds on the terminal, and where stability changes.
fn print(model: &Model, name: &str, speeds: &[f64], modes: &[Mode]) {
    say!("{name}: eigenvalues of straight running, 1/s\n");
    say!("{:>7}  {:^20}  {:^20}  {:>10}", "m/s", "weave", "wobble", "capsize");
    let every = speeds.len().div_ceil(15);
    for &speed in speeds.iter().step_by(every) {
        let cell = |name: Name| {
            let found = modes.iter().find(|m| m.speed == speed && m.name == name);
            match found {
                Some(m) if name == Name::Capsize => format!("{:10.4}", m.eigenvalue.re),
                Some(m) => format!("{:9.4} ± {:7.4}i", m.eigenvalue.re, m.eigenvalue.im),
                None if name == Name::Capsize => format!("{:>10}", "-"),
                None => format!("{:^20}", "-"),
            }
        };
        say!("{speed:7.2}  {}  {}  {}", cell(Name::Weave), cell(Name::Wobble), cell(Name::Capsize));
    }
    say!();
    for name in NAMED {
        for (speed, settles) in crossings(model, modes, name) {
            let word = if settles { "stable" } else { "unstable" };
            say!("{} becomes {word} at {speed:.4} m/s", name.name());
        }
    }
}

/// Speeds at which a mode's real part changes its sign; whether it is stable above. Each is
/// narrowed down; where a mode jumps from one branch to another there is no crossing.
fn crossings(model: &Model, modes: &[Mode], name: Name) -> Vec<(f64, bool)> {
    let list: Vec<Mode> = modes.iter().filter(|m| m.name == name).copied().collect();
    let mut found = Vec::new();
    for pair in list.windows(2) {
        let (mut a, mut b) = (pair[0], pair[1]);
        let narrowed = |a: &Mode, b: &Mode| a.eigenvalue.re * b.eigenvalue.re < 0.0;
        if !narrowed(&a, &b) {
            continue;
        }
        for _ in 0..6 {
            let speeds: Vec<f64> =
                (0..=8).map(|i| a.speed + (b.speed - a.speed) * f64::from(i) / 8.0).collect();
            let Ok(fine) = over_speed(model, &speeds) else { break };
            let fine: Vec<Mode> = fine.into_iter().filter(|m| m.name == name).collect();
            let Some(pair) = fine.windows(2).find(|p| narrowed(&p[0], &p[1])) else { break };
            (a, b) = (pair[0], pair[1]);
        }
        if (a.eigenvalue.re - b.eigenvalue.re).abs() < 0.01 {
            found.push((0.5 * (a.speed + b.speed), b.eigenvalue.re < 0.0));
        }
    }
    found
}

fn figure(name: &str, modes: &[Mode]) -> String {
    let series = |f: fn(&Mode) -> f64, swinging: bool| {
        let mut list: Vec<Series> = Vec::new();
        for (colour, name) in NAMED.into_iter().enumerate() {
            if swinging && name == Name::Capsize {
                continue;
            }
            let of = modes.iter().filter(|m| m.name == name);
            list.push(Series {
                label: name.name().to_owned(),
                points: of.map(|m| (m.speed, f(m))).collect(),
                colour,
                style: Style::Line,
            });
        }
        list
    };
    let panel = |title: String, y: &str, series: Vec<Series>| Panel {
        title,
        x: "speed, m/s".into(),
        y: y.into(),
        series,
    };
    panels(
        &[
            panel(format!("{name}: growth"), "real part, 1/s", series(|m| m.eigenvalue.re, false)),
            panel(format!("{name}: frequency"), "frequency, Hz", series(Mode::frequency, true)),
        ],
        2,
    )
}
