//! `roadbench simulate`.

use clap::ValueHint;
use clap::builder::NonEmptyStringValueParser;
use indicatif::ProgressBar;
use rayon::prelude::*;

use crate::cli::failure::Failure;
use crate::cli::location::location;
use crate::cli::say::{note, say};
use crate::cli::steps::Steps;
use crate::contract::session::Meta;
use crate::ingest::write_session;
use crate::report::static_figures::panels::{Panel, Series, Style, panels};
use crate::simulate::builtin;
use crate::simulate::compare::Quantity;
use crate::simulate::effects::tyre_file;
use crate::simulate::motocross::{self, scenario::Motocross};
use crate::simulate::pilot::Skill;
use crate::simulate::ride::{MultibodyRide, Sample};
use crate::simulate::scenario::{BUILTIN, Scenario};
use crate::simulate::tables::{self, SimulatedSession, folder_of};
use crate::simulate::tour::Tour;
use crate::simulate::track::{self, Track, TrackRide};
use crate::simulate::{compare, loggers, ride, session, tyre_truth};
use crate::store::objects::Location;
use crate::store::tables::file;
use crate::store::tables::output::{Outputs, is_output};

/// Write a synthetic archive with known truth beside it
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    #[arg(help = help(), value_parser = NonEmptyStringValueParser::new())]
    scenario: String,
    /// Folder of the archive: sessions/, bikes/ and truth/ are made in it.
    #[arg(short, long, value_parser = location(), value_hint = ValueHint::AnyPath)]
    out: Location,
    /// Bikes, instead of the scenario's number.
    #[arg(long)]
    bikes: Option<usize>,
    /// Front tyre instead of the scenario's, with the nonlinear motorcycle: a published set or a
    /// .tir or .toml file.
    #[arg(long, value_name = "TYRE", value_parser = NonEmptyStringValueParser::new())]
    front_tyre: Option<String>,
    /// Rear tyre instead of the scenario's.
    #[arg(long, value_name = "TYRE", value_parser = NonEmptyStringValueParser::new())]
    rear_tyre: Option<String>,
    /// Ride with the scenario's own tyres too, and compare the peaks: table and figure.
    #[arg(long)]
    compare: bool,
}

/// What is said of the scenario.
fn help() -> String {
    format!("A scenario file, or a built-in scenario: {}", builtin::listed())
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: Arguments, bar: ProgressBar) -> Result<(), Failure> {
    check_archive(&arguments.out)?;
    if let Some(motocross) = Motocross::load(&arguments.scenario).map_err(Failure::usage)? {
        refuse_tyres(&arguments)?;
        return run_motocross(&motocross, &arguments, bar);
    }
    if let Some(track) = Track::load(&arguments.scenario).map_err(Failure::usage)? {
        refuse_tyres(&arguments)?;
        return run_track(track, &arguments, bar);
    }
    if let Some(tour) = Tour::load(&arguments.scenario).map_err(Failure::usage)? {
        return run_tour(tour, &arguments, bar);
    }
    refuse_tyres(&arguments)?;
    let mut scenario = Scenario::load(&arguments.scenario).map_err(Failure::usage)?;
    if let Some(bikes) = arguments.bikes {
        scenario.fleet.bikes = bikes;
    }
    let out = &arguments.out;
    begin_archive(out)?;
    let many = scenario.fleet.bikes * scenario.fleet.sessions_per_bike;
    let steps = Steps::begin(bar, many, "sessions to simulate");
    let written = (0..scenario.fleet.bikes)
        .into_par_iter()
        .map(|bike| write_bike(&scenario, bike, out, &|| steps.done()))
        .collect::<Result<Vec<usize>, file::Error>>();
    drop(steps);
    let sessions: usize = written.map_err(|e| Failure::Output(e.to_string()))?.iter().sum();
    if let Some((_, text)) = BUILTIN.iter().find(|(name, _)| *name == arguments.scenario) {
        file::write_bytes(out.join("scenario.toml"), text.as_bytes())
            .map_err(|e| Failure::Output(e.to_string()))?;
    }
    note!(
        "{}: {} sessions of {} bikes, with their truth, in {}",
        scenario.name,
        sessions,
        scenario.fleet.bikes,
        out
    );
    Ok(())
}

/// Whether an archive may be simulated into a folder: one that holds sessions, bike files or a scenario must have been
/// simulated itself, or somebody's own would be replaced.
///
/// # Errors
/// It may not.
pub(super) fn check_archive(out: &Location) -> Result<(), Failure> {
    Outputs::default().folder("--out", out)?;
    if out.as_path().is_some_and(is_output) {
        let message = format!("--out {out} holds tables of a run; choose another folder");
        return Err(Failure::Usage(message));
    }
    let is_there = |name: &str| match out.join(name) {
        // a folder without anything in it is nobody's
        Location::Local(path) if path.is_dir() => {
            Ok(name == TRUTH || path.read_dir()?.next().is_some())
        }
        Location::Local(path) => Ok(path.exists()),
        at @ Location::Remote(_) => Ok(at.exists()? || at.is_folder()?),
    };
    let fail = |e: std::io::Error| Failure::Output(format!("--out {out}: {e}"));
    if is_there(TRUTH).map_err(fail)? {
        return Ok(());
    }
    for name in ["sessions", "bikes", "loggers", "scenario.toml"] {
        if is_there(name).map_err(fail)? {
            return Err(Failure::Usage(format!(
                "--out {out} holds {name}, but no truth beside it: it was not simulated; choose another folder"
            )));
        }
    }
    Ok(())
}

/// Folder of what is known of a simulated archive.
const TRUTH: &str = "truth";

/// Makes the folder by which an archive is known as a simulated one, also where the simulation is killed.
pub(super) fn begin_archive(out: &Location) -> Result<(), Failure> {
    let Location::Local(path) = out.join(TRUTH) else { return Ok(()) };
    let fail = |e| Failure::Output(format!("cannot write to --out {out}: {e}"));
    std::fs::create_dir_all(path).map_err(fail)
}

/// Tyres can be changed where the motorcycle rides on files of them.
fn refuse_tyres(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.compare || arguments.front_tyre.is_some() || arguments.rear_tyre.is_some() {
        return Err(Failure::Usage(format!(
            "scenario {}: --compare, --front-tyre and --rear-tyre are for scenarios of the nonlinear \
             motorcycle",
            arguments.scenario
        )));
    }
    Ok(())
}

/// Rides motocross: sessions, bike file, true forces.
fn run_motocross(
    scenario: &Motocross,
    arguments: &Arguments,
    bar: ProgressBar,
) -> Result<(), Failure> {
    let out = &arguments.out;
    begin_archive(out)?;
    let output = |e: file::Error| Failure::Output(e.to_string());
    let bike_id = &scenario.bike.bike_id;
    let file = out.join("bikes").join(format!("{bike_id}.toml"));
    file::write_bytes(&file, scenario.bike.to_toml().as_bytes()).map_err(output)?;
    let steps = Steps::begin(bar, scenario.sessions, "sessions to simulate");
    let ridden = (0..scenario.sessions)
        .into_par_iter()
        .map(|number| {
            let begin = std::time::Instant::now();
            let ridden = motocross::ride(scenario, number);
            let spent = begin.elapsed().as_secs_f64();
            let known = tables::of_motocross(scenario, ridden)?;
            write(&known, scenario.float32, out)?;
            let SimulatedSession { session, fall, .. } = known;
            let duration = session.duration();
            let fall = fall.map(|f| format!("{}: {f}", session.meta.session_id));
            steps.done();
            Ok((duration, spent, fall))
        })
        .collect::<Result<Vec<_>, file::Error>>();
    drop(steps);
    let ridden = ridden.map_err(output)?;
    let simulated: f64 = ridden.iter().map(|r| r.0).sum();
    let spent: f64 = ridden.iter().map(|r| r.1).sum();
    note!(
        "{}: {} sessions of {bike_id}, {simulated:.0} s simulated, {:.0} x real time per core, with \
         their truth, in {}",
        scenario.name,
        ridden.len(),
        simulated / spent,
        out
    );
    let falls: Vec<String> =
        ridden.into_iter().filter_map(|r| r.2).map(|why| why.to_string()).collect();
    if falls.is_empty() { Ok(()) } else { Err(Failure::Rejected(falls.join("\n"))) }
}

/// Rides on the track: sessions, bike files, truth, foreign logs.
fn run_track(mut track: Track, arguments: &Arguments, bar: ProgressBar) -> Result<(), Failure> {
    if let Some(bikes) = arguments.bikes {
        track.sessions = bikes;
    }
    let (track, out) = (&track, &arguments.out);
    begin_archive(out)?;
    let steps = Steps::begin(bar, track.sessions, "sessions to simulate");
    let ridden = (0..track.sessions)
        .into_par_iter()
        .map(|number| {
            let begin = std::time::Instant::now();
            // a machine that cannot be ridden round does not stop the others
            let ridden = match track::ride(track, number) {
                Ok(ridden) => ridden,
                Err(why) => return Ok((0.0, 0.0, Some(why))),
            };
            let spent = begin.elapsed().as_secs_f64();
            write_track(track, &ridden, out)?;
            steps.done();
            Ok((ridden.ride.session.duration(), spent, None))
        })
        .collect::<Result<Vec<_>, file::Error>>();
    drop(steps);
    let ridden = ridden.map_err(|e| Failure::Output(e.to_string()))?;
    let simulated: f64 = ridden.iter().map(|r| r.0).sum();
    let spent: f64 = ridden.iter().map(|r| r.1).sum();
    let failed: Vec<String> =
        ridden.into_iter().filter_map(|r| r.2).map(|why| why.to_string()).collect();
    note!(
        "{}: {} sessions of {} laps, {simulated:.0} s simulated, {:.0} x real time per core, with their \
         truth, in {}",
        track.name,
        track.sessions - failed.len(),
        track.laps,
        simulated / spent,
        out
    );
    if failed.is_empty() { Ok(()) } else { Err(Failure::Rejected(failed.join("\n"))) }
}

/// A session on the track: log, bike file, truth, and what the foreign loggers on board wrote.
fn write_track(track: &Track, ridden: &TrackRide, out: &Location) -> Result<(), file::Error> {
    let (id, bike) = (&ridden.ride.session.meta.session_id, &ridden.entry.bike);
    let coefficients = tyre_truth::coefficients(&ridden.entry.model);
    let bikes = out.join("bikes").join(format!("{}.toml", bike.bike_id));
    file::write_bytes(&bikes, bike.to_toml().as_bytes())?;
    write(&tables::of_tour(&coefficients, ridden.ride.clone())?, track.float32, out)?;
    let notes = out.join("truth/track").join(format!("{id}.toml"));
    file::write_bytes(&notes, track::notes(ridden).as_bytes())?;
    for profile in &track.loggers {
        let foreign = loggers::write(*profile, ridden, track.seed);
        let folder =
            out.join("loggers").join(profile.name()).join(format!("bike={}", bike.bike_id));
        let name = format!("{id}_{}", foreign.file);
        file::write_bytes(folder.join(&name), foreign.text.as_bytes())?;
        let truth = out.join("truth/loggers").join(format!("{name}.toml"));
        file::write_bytes(&truth, foreign.truth.as_bytes())?;
    }
    Ok(())
}

/// Where a session's files go.
struct Place {
    log: Location,
    truth: Location,
    below: String,
}

impl Place {
    fn of(meta: &Meta, out: &Location) -> Self {
        let date = meta.start_time.as_deref().and_then(|t| t.get(..10)).unwrap_or("2026-01-01");
        let part = format!("bike={}", meta.bike_id);
        let name = format!("{}.parquet", meta.session_id);
        let log = out.join("sessions").join(&part).join(format!("date={date}")).join(&name);
        Place { log, truth: out.join(TRUTH), below: format!("{part}/{name}") }
    }

    fn truth(&self, kind: &str) -> Location {
        self.truth.join(kind).join(&self.below)
    }
}

/// Rides a tour of the nonlinear motorcycle: sessions, bike file, truth.
fn run_tour(mut tour: Tour, arguments: &Arguments, bar: ProgressBar) -> Result<(), Failure> {
    let out = &arguments.out;
    let output = |e: file::Error| Failure::Output(e.to_string());
    let own = tour.clone();
    let tyre = |name: &Option<String>| match name {
        None => Ok(None),
        Some(name) => tyre_file::load(name).map(Some).map_err(Failure::usage),
    };
    tour.fit(tyre(&arguments.front_tyre)?, tyre(&arguments.rear_tyre)?);
    // a rider who knows the scenario's own tyres rides both: what differs is the tyre
    let tour = &tour;
    let skill = Skill::learn(&own.model, ride::period(tour.rate))
        .map_err(|e| Failure::Usage(format!("scenario {}: {e}", tour.name)))?;
    begin_archive(out)?;
    let file = out.join("bikes").join(format!("{}.toml", tour.bike.bike_id));
    file::write_bytes(&file, tour.bike.to_toml().as_bytes()).map_err(output)?;
    let coefficients = tyre_truth::coefficients(&tour.model);
    let steps = Steps::begin(bar, tour.sessions, "sessions to simulate");
    let ridden = (0..tour.sessions)
        .into_par_iter()
        .map(|number| {
            let begin = std::time::Instant::now();
            let ridden = ride::ride(tour, &skill, number);
            let spent = begin.elapsed().as_secs_f64();
            let known = tables::of_tour(&coefficients, ridden)?;
            write(&known, tour.float32, out)?;
            steps.done();
            let SimulatedSession { session, fall, .. } = known;
            Ok((session.meta.session_id.clone(), session.duration(), spent, fall))
        })
        .collect::<Result<Vec<_>, file::Error>>();
    drop(steps);
    let ridden = ridden.map_err(output)?;
    let (mut simulated, mut spent, mut falls) = (0.0, 0.0, Vec::new());
    for (id, duration, seconds, fall) in &ridden {
        simulated += duration;
        spent += seconds;
        if let Some(fall) = fall {
            falls.push(format!("{id}: {fall}; its log ends there"));
        }
    }
    note!(
        "{}: {} sessions of {}, {simulated:.0} s simulated, {:.0} x real time per core, with their \
         truth, in {}",
        tour.name,
        ridden.len(),
        tour.model.motorcycle.name,
        simulated / spent,
        out
    );
    if arguments.compare {
        compare(&own, tour, &skill, out)?;
    }
    if falls.is_empty() { Ok(()) } else { Err(Failure::Rejected(falls.join("\n"))) }
}

/// Rides the first session on both pairs of tyres and shows the peaks.
fn compare(own: &Tour, tour: &Tour, skill: &Skill, out: &Location) -> Result<(), Failure> {
    let fail = |e: file::Error| Failure::Output(e.to_string());
    let (reference, other) = (ride::ride(own, skill, 0), ride::ride(tour, skill, 0));
    let falls = compare::falls(&reference, &other);
    // the peaks of a ride that fell over are those of its fall
    let rows = if falls.is_empty() { compare::peaks(&reference, &other) } else { Vec::new() };
    for fall in &falls {
        say!("\n{fall}; no peaks are compared");
    }
    if !rows.is_empty() {
        say!("\n{:26} {:>6} {:>12} {:>12} {:>9}", "peak", "unit", "own tyres", "given", "error");
    }
    for row in &rows {
        say!(
            "{:26} {:>6} {:12.5} {:12.5} {:8.1}%",
            row.channel,
            row.unit,
            row.reference,
            row.other,
            100.0 * row.error
        );
    }
    file::write(out.join("compare/peaks.parquet"), &rows).map_err(fail)?;
    let figure = figure(&reference, &other);
    let path = out.join("compare/compare.svg");
    file::write_bytes(&path, figure.as_bytes()).map_err(fail)?;
    note!("figure: {path}");
    Ok(())
}

/// Both rides over time.
fn figure(reference: &MultibodyRide, other: &MultibodyRide) -> String {
    let rate = reference.session.rate;
    let line =
        |ridden: &MultibodyRide, of: fn(&Sample) -> f64, label: &str, colour, style| Series {
            label: label.to_owned(),
            points: ridden
                .samples
                .iter()
                .enumerate()
                .map(|(i, s)| (i as f64 / rate, of(s)))
                .collect(),
            colour,
            style,
        };
    let both = |of, labels: [&str; 2], colours: [usize; 2]| {
        [
            line(reference, of, labels[0], colours[0], Style::Line),
            line(other, of, labels[1], colours[1], Style::Dashed),
        ]
    };
    let drawn: Vec<Panel> = compare::TRACES
        .iter()
        .map(|(title, unit, quantity)| Panel {
            title: (*title).to_owned(),
            x: "time, s".into(),
            y: (*unit).to_owned(),
            series: match *quantity {
                Quantity::Motorcycle(of) => both(of, ["own", "given"], [0, 1]).into(),
                Quantity::Wheels([front, rear]) => [
                    both(front, ["front, own", "front, given"], [0, 0]),
                    both(rear, ["rear, own", "rear, given"], [1, 1]),
                ]
                .concat(),
            },
        })
        .collect();
    panels(&drawn, 2)
}

/// A session and its truth.
fn write(known: &SimulatedSession, float32: bool, out: &Location) -> Result<(), file::Error> {
    let place = Place::of(&known.session.meta, out);
    write_session(&place.log, &known.session, float32)?;
    for (table, batch) in &known.truth {
        file::write_batch(place.truth(folder_of(table)), batch)?;
    }
    Ok(())
}

/// One bike: its file, its sessions, its truth. Returns the number of sessions.
pub(super) fn write_bike(
    scenario: &Scenario,
    bike: usize,
    out: &Location,
    done: &dyn Fn(),
) -> Result<usize, file::Error> {
    let machine = scenario.machine(bike);
    let id = &machine.bike.bike_id;
    let file = out.join("bikes").join(format!("{id}.toml"));
    file::write_bytes(&file, machine.bike.to_toml().as_bytes())?;
    let count = scenario.fleet.sessions_per_bike;
    for i in 0..count {
        let simulated = session(scenario, &machine, bike * count + i);
        write(&tables::of_fleet(&machine, simulated)?, scenario.float32, out)?;
        done();
    }
    Ok(count)
}
