//! Any log to one [`Session`] on one clean clock.
//!
//! ```text
//! file -> reader (READERS) -> Raw: SI tracks, each on its source's own clock
//!      -> run: clocks repaired, faults taken out, one common clock -> Session
//!      -> check: channels against physics, given the bike
//! ```
//!
//! A new format is one file (mostly a [`foreign::Format`]: what is in the log, and the wanted
//! channels of it) and one line in [`READERS`]. A new source of a known format is one channel map
//! ([`map`]), no code; [`propose`] drafts one.

use std::io::Read as _;
use std::sync::{Arc, OnceLock};

use serde::{Deserialize, Serialize};

use crate::contract::channel::Channel;
use crate::contract::schema::Table;
use crate::contract::session::{Meta, Session};
use crate::contract::warning::Warning;
use crate::objects::{Location, source};

mod can;
mod check;
mod clean;
mod clock;
mod csv;
mod ctrk;
mod dialect;
pub mod foreign;
pub(crate) mod gaps;
mod ident;
mod kiro;
mod low_pass;
pub mod map;
mod mcap;
mod mdf;
mod middle;
mod motec;
mod parquet;
pub mod propose;
pub(crate) mod resample;
pub mod survey;
mod table;
pub mod units;
mod write;
pub mod yaw;

pub use check::check;
pub use middle::extent;
pub use table::read_table;
pub use write::{session_batch, write_session};

use map::ChannelMap;

/// Settings of the stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Rate of the common clock, Hz; 0 takes the fastest channel's own.
    pub rate: f64,
    /// Longest gap that is interpolated over, s. A channel that is slower than that by nature
    /// (GPS at 1 Hz) is interpolated between its own samples, never over a lost one.
    pub max_gap: f64,
    /// A single sample is a spike when it stands out of its neighbourhood by this many times
    /// what the signal does there otherwise; 0 looks for none.
    pub spike_threshold: f64,
    /// A channel that does not change at all for this long while the bike moves is stuck, s;
    /// 0 looks for none.
    pub stuck_time: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config { rate: 0.0, max_gap: 0.25, spike_threshold: 8.0, stuck_time: 2.0 }
    }
}

/// One channel as recorded, on its own clock.
#[derive(Debug, Clone)]
pub struct Track {
    /// Which.
    pub channel: Channel,
    /// Stamps as recorded, s: may repeat, jump back or jitter. Channels that were logged
    /// together share one clock.
    pub time: Arc<Vec<f64>>,
    /// SI values, NaN where there is none; as many as stamps.
    pub values: Vec<f64>,
}

/// A log as read: units are SI, the clocks are still the source's.
#[derive(Debug, Clone, Default)]
pub struct Raw {
    /// Who, when, on what.
    pub meta: Meta,
    /// The channels.
    pub tracks: Vec<Track>,
    /// What the reader noticed.
    pub warnings: Vec<Warning>,
    /// Whether velocities, accelerations and yaw are along the Euler yaw instead of the
    /// frame's trace on the road.
    pub euler_yaw: bool,
}

/// Why a log cannot be used; `code` is the `rejected` table's.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{message}")]
pub struct Error {
    /// Short stable name, snake case.
    pub code: &'static str,
    /// What was wrong, in which column and row, and what to do.
    pub message: String,
}

/// Code of what could not be fetched from an object store: it may be in order.
pub const UNREACHABLE: &str = "unreachable";

impl Error {
    fn new(code: &'static str, message: impl Into<String>) -> Self {
        Error { code, message: message.into() }
    }

    fn unreadable(log: &Location, error: &std::io::Error) -> Self {
        // a store that does not answer says nothing of the log
        let code = if log.is_remote() { UNREACHABLE } else { "unreadable" };
        Error::new(code, format!("cannot read {log}: {error}"))
    }
}

/// A format that can be read.
#[derive(Debug)]
pub struct Reader {
    /// Its name, as in `format` of a channel map.
    pub name: &'static str,
    /// Whether a file is of this format, from its path and first bytes.
    pub sniff: fn(&Head<'_>) -> bool,
    /// Who and when, without decoding samples.
    pub identify: fn(&Location, &[ChannelMap]) -> Result<Meta, Error>,
    /// The whole log.
    pub read: fn(&Location, &[ChannelMap]) -> Result<Raw, Error>,
    /// The channel map that `read` goes through, if it needs one.
    pub map: fn(&Location, &[ChannelMap]) -> Result<Option<ChannelMap>, Error>,
    /// Whether its logs bring their own clocks, so that its maps need no `[time]`.
    pub own_clock: bool,
    /// How a log is looked at without a map, if that is possible.
    pub look: Option<foreign::Look>,
}

/// Every format, the most particular first.
pub const READERS: &[Reader] = &[
    parquet::READER,
    foreign::reader::<mdf::Mdf>(),
    foreign::reader::<mcap::Mcap>(),
    foreign::reader::<can::Can>(),
    foreign::reader::<motec::Ld>(),
    foreign::reader::<ctrk::Ctrk>(),
    foreign::reader::<dialect::Motec>(),
    foreign::reader::<dialect::Aim>(),
    foreign::reader::<dialect::RaceChrono>(),
    foreign::reader::<dialect::xsens::Xsens>(),
    kiro::READER,
    csv::READER,
];

/// What a format is recognised by.
#[derive(Debug)]
pub struct Head<'a> {
    /// The file.
    pub log: &'a Location,
    /// Its first bytes, at most [`HEAD_LEN`].
    pub bytes: &'a [u8],
}

impl Head<'_> {
    /// Whether the file's name has this extension, in whatever case.
    pub fn has_extension(&self, extension: &str) -> bool {
        self.log.has_extension(extension)
    }
}

/// How much of a file is looked at to recognise its format, bytes.
pub const HEAD_LEN: u64 = 64 * 1024;

/// Largest file that is read, bytes: a day of 100 Hz riding is a tenth of it.
const MAX_FILE: u64 = 4 << 30;

/// Who and when, without reading the samples.
///
/// `maps` are the channel maps to choose from; an empty slice means [`map::shipped`].
///
/// # Errors
/// The file cannot be read or is of no known kind, or it names itself in a way that cannot be
/// a file name (`bad_bike_id`, `bad_session_id`).
pub fn identify(log: impl Into<Location>, maps: &[ChannelMap]) -> Result<Meta, Error> {
    let log = &log.into();
    let meta = (reader(log)?.identify)(log, maps)?;
    ident::checked(meta)
}

/// Reads a log of any known format.
///
/// `maps` as in [`identify`].
///
/// # Errors
/// The file cannot be read, or lacks what every session needs.
pub fn read(log: impl Into<Location>, maps: &[ChannelMap]) -> Result<Raw, Error> {
    let log = &log.into();
    let mut raw = (reader(log)?.read)(log, maps)?;
    raw.meta = ident::checked(raw.meta)?;
    Ok(raw)
}

/// The channel map that [`read`] takes for a log; `None` if it is `session.v1` already.
///
/// # Errors
/// As [`identify`].
pub fn map_for(log: impl Into<Location>, maps: &[ChannelMap]) -> Result<Option<ChannelMap>, Error> {
    let log = &log.into();
    (reader(log)?.map)(log, maps)
}

/// The format of a log.
///
/// # Errors
/// The file cannot be read or is of no known kind.
pub fn reader(log: impl Into<Location>) -> Result<&'static Reader, Error> {
    let log = &log.into();
    let fail = |e: std::io::Error| Error::unreadable(log, &e);
    let mut file = source::open(log).map_err(fail)?;
    let size = file.size().map_err(fail)?;
    if size == 0 {
        return Err(Error::new("empty_file", format!("{log} is empty")));
    }
    if size > MAX_FILE {
        let message = format!("{log} is {} MB long; split the log", size >> 20);
        return Err(Error::new("file_too_large", message));
    }
    let mut bytes = Vec::new();
    let named = Head { log, bytes: &bytes };
    if let Some(reader) = READERS.first().filter(|r| (r.sniff)(&named)) {
        return Ok(reader); // its name settles it: its first bytes need not be fetched
    }
    file.by_ref().take(HEAD_LEN).read_to_end(&mut bytes).map_err(fail)?;
    let head = Head { log, bytes: &bytes };
    READERS.iter().find(|r| (r.sniff)(&head)).ok_or_else(|| {
        let names: Vec<&str> = READERS.iter().map(|r| r.name).collect();
        let message = format!("{log} is none of {}", names.join(", "));
        Error::new("unknown_format", message)
    })
}

/// Repairs the clocks, takes out what no sensor can have meant, and brings every channel onto
/// one clock.
///
/// In this order, each with its warning: stamps (`time_missing`, `time_duplicated`,
/// `time_backwards`, `time_jitter`), values out of the schema's range (`out_of_range`),
/// `spike`, `clipped`, `stuck`, `gap`, `empty_channel`, `down_sampled`.
///
/// # Errors
/// Nothing usable is left: `no_time`, `too_short`.
pub fn run(raw: Raw, config: &Config) -> Result<(Session, Vec<Warning>), Error> {
    let Raw { meta, tracks, mut warnings, euler_yaw } = raw;
    let mut tracks = clock::repair(tracks, &mut warnings)?;
    clean::clean(&mut tracks, config, &mut warnings);
    let mut session = resample::onto_one_clock(meta, tracks, config, &mut warnings)?;
    if euler_yaw {
        yaw::to_trace(&mut session, &mut warnings);
    }
    Ok((session, warnings))
}

/// The contract's input table, parsed once.
fn session_table() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(|| Table::embedded("session"))
}

/// Takes what a log says of who and when in the contract's words; whether it is one of them.
fn session_meta(meta: &mut Meta, key: &str, value: &str) -> bool {
    let value = || Some(value.trim().to_owned());
    match key.trim() {
        "session_id" => meta.session_id = value().unwrap_or_default(),
        "bike_id" => meta.bike_id = value().unwrap_or_default(),
        "start_time" => meta.start_time = value(),
        "tyre_front" => meta.tyre_front = value(),
        "tyre_rear" => meta.tyre_rear = value(),
        "site" => meta.site = value(),
        "rider_id" => meta.rider_id = value(),
        _ => return false,
    }
    true
}

/// A warning of this stage.
fn warning(
    code: &'static str,
    channel: Option<Channel>,
    count: usize,
    time: Option<f64>,
    message: String,
) -> Warning {
    Warning { stage: "ingest", code, channel, count, time, message }
}
