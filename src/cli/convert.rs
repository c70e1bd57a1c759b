//! `roadbench convert`.

use crate::contract::schema;
use std::fmt::Write as _;
use std::path::PathBuf;

use clap::ValueHint;

use crate::cli::bike::bad_name;
use crate::cli::failure::Failure;
use crate::cli::location::location;
use crate::cli::log::{self, rejected};
use crate::cli::say::{note, put, tell};
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::ingest::checks::aids::Aids;
use crate::ingest::maps::file::with_aids;
use crate::ingest::maps::{ChannelMap, TimeSource};
use crate::ingest::{self, Raw};
use crate::store::objects::Location;
use crate::store::tables::output;
use crate::store::tables::output::Outputs;

/// Turn any supported log into a session.v1 Parquet file
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The log.
    #[arg(value_parser = location(), value_hint = ValueHint::AnyPath)]
    log: Location,
    /// Channel map to use; may be repeated. Without it the shipped maps are tried.
    #[arg(long, value_name = "FILE")]
    map: Vec<PathBuf>,
    /// CAN database that the log's frames are read by; may be repeated.
    #[arg(long, value_name = "FILE")]
    dbc: Vec<PathBuf>,
    /// Bike id that the written log carries, whatever the log says.
    #[arg(long, value_name = "ID")]
    bike: Option<String>,
    /// The Parquet file to write.
    #[arg(short, long, value_name = "FILE", required_unless_present = "dry_run")]
    #[arg(value_parser = location(), value_hint = ValueHint::AnyPath)]
    out: Option<Location>,
    /// Rate of the common clock; without it the fastest channel's own.
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Longest gap that is interpolated over, s.
    #[arg(long, value_name = "S")]
    max_gap: Option<f64>,
    /// Write samples as float32: half the size, 7 digits.
    #[arg(long)]
    float32: bool,
    /// Show which source column feeds which column and write nothing.
    #[arg(long)]
    dry_run: bool,
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: Arguments) -> Result<(), Failure> {
    if let (Some(out), false) = (&arguments.out, arguments.dry_run) {
        let mut outputs = Outputs::default();
        outputs.file("--out", out)?;
        outputs.apart_from([&arguments.log])?;
        outputs.apart_from_files(arguments.map.iter().chain(&arguments.dbc))?;
    }
    log::require(&arguments.log)?;
    let aids = Aids::read(&arguments.dbc).map_err(Failure::usage)?;
    let maps = ChannelMap::read_all(&arguments.map).map_err(Failure::usage)?;
    let maps = with_aids(maps, &aids);
    let mut config = ingest::Config::default();
    for (name, given, slot) in [
        ("--rate", arguments.rate, &mut config.rate),
        ("--max-gap", arguments.max_gap, &mut config.max_gap),
    ] {
        let Some(value) = given else { continue };
        if !(value > 0.0 && value.is_finite()) {
            return Err(Failure::Usage(format!("{name} {value} must be positive")));
        }
        *slot = value;
    }
    if let Some(message) = arguments.bike.as_deref().and_then(bad_name) {
        return Err(Failure::Usage(format!("--bike: {message}")));
    }
    let mut raw = ingest::read(&arguments.log, &maps).map_err(rejected)?;
    if let Some(bike) = arguments.bike {
        raw.meta.bike_id = bike;
    }
    if arguments.dry_run {
        let map = ingest::map_for(&arguments.log, &maps).map_err(rejected)?;
        for warning in &raw.warnings {
            tell!("warning: {}: {}\n", warning.code, warning.message);
        }
        put!("{}", mapping(&raw, map.as_ref()));
        return Ok(());
    }
    let (mut session, mut warnings) = ingest::run(raw, &config).map_err(rejected)?;
    // what a run would refuse or leave out is said here already; the file has what the log has
    let mut seen = ingest::look(&session, None, &config);
    // but for gravity under the name of an acceleration of the level frame
    for warning in seen.iter_mut().filter(|w| w.code == "gravity_in_acceleration") {
        if let Some(channel) = warning.channel {
            session.remove(channel);
            warning.message += &format!("; {channel} is left out");
        }
    }
    warnings.extend(seen);
    for warning in &warnings {
        tell!("warning: {}: {}\n", warning.code, warning.message);
    }
    let Some(out) = arguments.out else { return Ok(()) };
    ingest::session_bytes(&session, arguments.float32)
        .and_then(|bytes| output::write(&out, &bytes))
        .map_err(|e| Failure::Output(e.to_string()))?;
    note!("{}", summary(&session, &warnings).trim_end_matches('\n'));
    note!("written to {}", out);
    Ok(())
}

/// Which source column feeds which column, and how.
fn mapping(raw: &Raw, map: Option<&ChannelMap>) -> String {
    let mut text = format!("session {:?}, bike {:?}\n", raw.meta.session_id, raw.meta.bike_id);
    let Some(map) = map else {
        text.push_str("session.v1 already: every column feeds the one of its name\n");
        for track in &raw.tracks {
            let _ = writeln!(text, "  {:26} {} rows", track.channel.name(), track.values.len());
        }
        return text;
    };
    let clock = match &map.time {
        TimeSource::Column { name, factor, .. } => format!("`{name}`, {factor} s per unit"),
        TimeSource::Rate(rate) => format!("none, {rate} Hz assumed"),
        TimeSource::Own => "the format's own".to_owned(),
    };
    let _ = writeln!(text, "channel map {} ({}); clock: {clock}", map.name, map.format);
    let _ = writeln!(
        text,
        "{:24} {:32} {:8} {:>4} {:>12} {:>10} {:>8} {:>7}",
        "column", "from", "unit", "sign", "to SI: x *", "+", "delay s", "rows"
    );
    for entry in &map.entries {
        let Some(track) = raw.tracks.iter().find(|t| t.channel == entry.channel) else { continue };
        let _ = writeln!(
            text,
            "{:24} {:32} {:8} {:>4} {:>12.6} {:>10.4} {:>8.3} {:>7}",
            entry.channel.name(),
            entry.from.join(" + "),
            entry.unit,
            entry.sign,
            entry.to_si.factor,
            entry.to_si.offset,
            entry.delay,
            track.values.len()
        );
    }
    text
}

/// What the session holds, a line per channel.
fn summary(session: &Session, warnings: &[Warning]) -> String {
    let table = schema::session();
    let mut text = format!(
        "session {:?}, bike {:?}: {:.1} s at {} Hz, {} samples, {} warning(s)\n",
        session.meta.session_id,
        session.meta.bike_id,
        session.duration(),
        session.rate,
        session.len,
        warnings.len()
    );
    let _ = writeln!(
        text,
        "{:26} {:8} {:>10} {:>10} {:>10} {:>9}",
        "column", "unit", "min", "median", "max", "missing"
    );
    for channel in session.channels() {
        let unit = table.column(channel.name()).and_then(|c| c.unit.as_deref()).unwrap_or("");
        let [low, middle, high, missing] = extent(session, channel);
        let name = channel.name();
        let _ = writeln!(
            text,
            "{name:26} {unit:8} {low:>10.4} {middle:>10.4} {high:>10.4} {missing:>8.2}%"
        );
    }
    text
}

/// Least, middle and largest sample, and the share of missing ones in percent.
fn extent(session: &Session, channel: Channel) -> [f64; 4] {
    let all = session.get(channel).unwrap_or_default();
    let ([low, middle, high], count) = ingest::extent(all).unwrap_or(([f64::NAN; 3], 0));
    let missing = 100.0 * (all.len() - count) as f64 / all.len().max(1) as f64;
    [low, middle, high, missing]
}
