//! `roadbench replay`.

use std::path::PathBuf;

use clap::ValueHint;
use clap::builder::NonEmptyStringValueParser;
use indicatif::ProgressBar;

use crate::cli::batch::BIKES;
use crate::cli::failure::Failure;
use crate::cli::location::{location, require_folder};
use crate::cli::log::{self, rejected};
use crate::cli::modes;
use crate::cli::say::{note, say};
use crate::cli::steps::Steps;
use crate::contract::bike::Bike;
use crate::contract::session::Session;
use crate::ingest;
use crate::ingest::maps::ChannelMap;
use crate::pipeline::{self, Pipeline};
use crate::report::static_figures::panels::{Panel, Series, Style, panels};
use crate::segment::Segment;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::simulate::effects::tyre_file;
use crate::simulate::multibody::{Model, Motorcycle, Road};
use crate::simulate::replay::{self, Braking, Replay};
use crate::store::objects::Location;
use crate::store::tables::file;
use crate::store::tables::output;
use crate::store::tables::output::Outputs;

/// Simulate a log's stops again from its measured brake pressures
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// A log.
    #[arg(value_parser = location(), value_hint = ValueHint::AnyPath)]
    log: Location,
    #[arg(long, help = motorcycle_help(), value_parser = NonEmptyStringValueParser::new())]
    motorcycle: String,
    /// Its front tyre instead of its own: a published set or a .tir or .toml file.
    #[arg(long, value_name = "TYRE", value_parser = NonEmptyStringValueParser::new())]
    front_tyre: Option<String>,
    /// Its rear tyre instead of its own.
    #[arg(long, value_name = "TYRE", value_parser = NonEmptyStringValueParser::new())]
    rear_tyre: Option<String>,
    /// Friction of the road.
    #[arg(long, default_value_t = 1.0)]
    friction: f64,
    /// Folder of bike files.
    #[arg(long, value_name = "DIR", env = BIKES, hide_env_values = true)]
    bikes: PathBuf,
    /// Channel map of a log that is not session.v1; may be repeated.
    #[arg(long, value_name = "FILE")]
    map: Vec<PathBuf>,
    /// Folder for the table (replay.parquet) and the figure (replay.svg).
    #[arg(short, long, value_parser = location(), value_hint = ValueHint::AnyPath)]
    out: Option<Location>,
}

/// What is said of the motorcycle.
fn motorcycle_help() -> String {
    format!("The motorcycle that brakes. {}", modes::help())
}

/// What is written into the folder.
const FILES: [&str; 2] = ["replay.parquet", "replay.svg"];

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: &Arguments, bar: ProgressBar) -> Result<(), Failure> {
    if let Some(out) = &arguments.out {
        let mut outputs = Outputs::default();
        outputs.folder("--out", out)?;
        FILES.iter().try_for_each(|name| outputs.file("--out", &out.join(name)))?;
        outputs.apart_from([&arguments.log])?;
        outputs.apart_from_files(arguments.map.iter().chain([&arguments.bikes]))?;
        outputs.apart_from_files(
            [&arguments.motorcycle]
                .into_iter()
                .chain(&arguments.front_tyre)
                .chain(&arguments.rear_tyre),
        )?;
    }
    log::require(&arguments.log)?;
    require_folder(&arguments.bikes)?;
    let model = model(arguments)?;
    let (session, segments) = session(arguments)?;
    let brakings: Vec<&Segment> =
        segments.iter().filter(|s| s.used && s.kind.is_braking()).collect();
    if brakings.is_empty() {
        return Err(Failure::Rejected(format!("{}: no usable braking in the log", arguments.log)));
    }
    let steering = replay::steering(&model, session.rate).map_err(Failure::usage)?;
    say!(
        "{:16} {:>8} {:>17} {:>8} {:>17} {:>8} {:>8}",
        "braking",
        "at, s",
        "peak m/s2",
        "error",
        "peak slip",
        "error",
        "delay, s"
    );
    say!("{:25} {:>17} {:>8} {:>17}", "", "measured / sim", "", "measured / sim");
    let mut rows = Vec::new();
    let mut drawn: Option<Replay> = None;
    let steps = Steps::begin(bar, brakings.len(), "braking manoeuvres of the log");
    let braked = replay::brakings(&model, &steering, &session, &brakings);
    drop(steps);
    for braking in braked {
        print(&braking);
        rows.extend(braking.row(&session.meta));
        if drawn.is_none() && braking.kind == ManoeuvreKind::FrontBraking {
            drawn = braking.replay.ok();
        }
    }
    let Some(out) = &arguments.out else { return Ok(()) };
    let fail = |e: file::Error| Failure::Output(e.to_string());
    let [table, path] = FILES.map(|name| out.join(name));
    output::write_rows(table, &rows).map_err(fail)?;
    if let Some(replay) = drawn {
        output::write(&path, figure(&replay).as_bytes()).map_err(fail)?;
        note!("figure: {path}");
    }
    Ok(())
}

/// The motorcycle on its tyres and road.
fn model(arguments: &Arguments) -> Result<Model, Failure> {
    let mut motorcycle = Motorcycle::load(&arguments.motorcycle).map_err(Failure::usage)?;
    let tyre = |name: &Option<String>| match name {
        None => Ok(None),
        Some(name) => tyre_file::load(name).map(Some).map_err(Failure::usage),
    };
    if let Some([front, rear]) = motorcycle.tyres.clone() {
        let (given_front, given_rear) = (tyre(&arguments.front_tyre)?, tyre(&arguments.rear_tyre)?);
        motorcycle =
            motorcycle.with_tyres(given_front.unwrap_or(front), given_rear.unwrap_or(rear));
    }
    let road = Road { friction: arguments.friction, ..Road::default() };
    road.check().map_err(Failure::usage)?;
    Ok(Model::new(motorcycle, road))
}

/// The log up to its manoeuvres.
fn session(arguments: &Arguments) -> Result<(Session, Vec<Segment>), Failure> {
    let maps = ChannelMap::read_all(&arguments.map).map_err(Failure::usage)?;
    let pipeline = Pipeline::onroad();
    let raw = ingest::read(&arguments.log, &maps).map_err(rejected)?;
    let file = arguments.bikes.join(format!("{}.toml", raw.meta.bike_id));
    let bike = Bike::read(&file).map_err(Failure::usage)?;
    let (mut session, _) = pipeline::prepare_raw(raw, &bike, &pipeline)
        .map_err(|e| Failure::Rejected(format!("{} ({})", e.message, e.code)))?;
    let (segments, _) = pipeline::segmented(&mut session, &bike, &pipeline);
    Ok((session, segments))
}

/// One line: peaks measured and simulated, their errors and the delay.
fn print(braking: &Braking) {
    let (kind, start) = (braking.kind.name(), braking.start);
    let p = match &braking.replay {
        Ok(replay) => replay.peaks(braking.wheel()),
        Err(e) => {
            say!("{kind:16} {start:8.2} {e}");
            return;
        }
    };
    // a log without a channel has no such peak
    let shown = |x: f64, digits: usize| match x.is_finite() {
        true => format!("{x:.digits$}"),
        false => "-".to_owned(),
    };
    let error = |x: [f64; 2]| match shown(100.0 * (x[1] / x[0] - 1.0), 1) {
        none if none == "-" => none,
        percent => format!("{percent}%"),
    };
    say!(
        "{kind:16} {start:8.2} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}",
        shown(p.deceleration[0], 2),
        shown(p.deceleration[1], 2),
        error(p.deceleration),
        shown(p.slip[0], 3),
        shown(p.slip[1], 3),
        error(p.slip),
        shown(p.delay, 3)
    );
}

fn figure(r: &Replay) -> String {
    let series = |label: &str, y: &[f64], colour, style| Series {
        label: label.to_owned(),
        points: r.time.iter().copied().zip(y.iter().copied()).collect(),
        colour,
        style,
    };
    let panel = |title: &str, y: &str, series| Panel {
        title: title.to_owned(),
        x: "time, s".into(),
        y: y.to_owned(),
        series,
    };
    let bar: Vec<f64> = r.pressure[0].iter().map(|p| p * 1e-5).collect();
    panels(
        &[
            panel("Front brake", "bar", vec![series("", &bar, 2, Style::Line)]),
            panel(
                "Acceleration",
                "m/s2",
                vec![
                    series("measured", &r.measured_acceleration, 0, Style::Line),
                    series("simulated", &r.acceleration, 1, Style::Dashed),
                ],
            ),
            panel(
                "Front slip ratio",
                "1",
                vec![
                    series("measured", &r.measured_slip[0], 0, Style::Line),
                    series("simulated", &r.slip[0], 1, Style::Dashed),
                ],
            ),
        ],
        3,
    )
}
