//! Text exports of racing loggers: a block of `key, value`, a row of names, rows of units and
//! sources, then the numbers.
//!
//! Each source is a [`Dialect`], a set of header keys and no code; what they have in common is
//! here and in `csv::table`. Inertial units ([`xsens`]) bring more and have a file of their own.
//!
//! | dialect | known by | clock | units |
//! |---|---|---|---|
//! | [`Motec`]: MoTeC i2, Export Data | `Format, MoTeC CSV File` | `Time`, or `Sample Rate` | second row |
//! | [`Aim`]: AiM Race Studio 2 and 3 | `Format, AiM CSV File` | `Time`, or `Sample Rate` | second row |
//! | [`RaceChrono`]: CSV v2 and v3 | its first line | `timestamp` or `Time (s)`, since 1970 | second row, v2: in the
//! name |

use std::collections::{HashMap, HashSet};

use crate::contract::rejection::RejectionCode;
use crate::contract::session::Markers;
use crate::contract::warning::Warning;
use crate::ingest::checks::aids::Aids;
use crate::ingest::clock::stamps::text::Kind;
use crate::ingest::error::Error;
use crate::ingest::formats::csv::table::{self, Table};
use crate::ingest::formats::csv::{cells, clocks, start_time, text};
use crate::ingest::formats::format::Format;
use crate::ingest::formats::format::Head;
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::ident;
use crate::ingest::maps::units;
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::ingest::warning::warning;
use crate::store::objects::Location;

pub(crate) mod facts;
mod level;
pub(super) mod racebox;
pub(super) mod xsens;

use facts::{Facts, HeaderKeys, wall_clock};

/// One source's way of writing a table.
#[derive(Debug)]
struct Dialect {
    /// Start of the text, in lower case and without quotes.
    begins: &'static str,
    /// First names of the row of names: the clock's.
    clock: &'static [&'static str],
    /// Whether the clock counts from 1970.
    epoch: bool,
    /// Rows of units (and sources) between names and numbers.
    notes: usize,
    /// Names of the column that counts laps, by which its readers find them.
    laps: &'static [&'static str],
    /// The keys that matter.
    keys: HeaderKeys,
}

const MOTEC: Dialect = Dialect {
    begins: "format,motec csv file",
    clock: &["Time"],
    epoch: false,
    notes: 1,
    laps: &[],
    keys: HeaderKeys {
        vehicle: "Vehicle",
        driver: &["Driver"],
        venue: "Venue",
        start: &["Log Date", "Log Time"],
        rate: "Sample Rate",
    },
};

const AIM: Dialect = Dialect {
    begins: "format,aim csv file",
    clock: &["Time"],
    epoch: false,
    notes: 1,
    laps: &[],
    keys: HeaderKeys {
        vehicle: "Vehicle",
        driver: &["Racer", "User"],
        venue: "Venue",
        start: &["Date", "Time"],
        rate: "Sample Rate",
    },
};

const RACECHRONO: Dialect = Dialect {
    begins: "this file is created using racechrono",
    clock: &["timestamp", "Time (s)"],
    epoch: true,
    notes: 2,
    laps: &["lap_number", "Lap #"],
    keys: HeaderKeys {
        vehicle: "",
        driver: &["Driver name"],
        venue: "Track name",
        start: &[],
        rate: "",
    },
};

macro_rules! text_format {
    ($(#[$doc:meta])* $name:ident, $dialect:expr, $text:literal, $description:literal,
     $channel_names:literal, [$($map:literal),*]) => {
        $(#[$doc])*
        #[derive(Debug)]
        pub(super) struct $name;

        impl Format for $name {
            const NAME: &'static str = $text;
            const DESCRIPTION: &'static str = $description;
            const CHANNEL_NAMES: &'static str = $channel_names;
            const EXTENSIONS: &'static [&'static str] = &["csv"];
            const MAPS: &'static [ShippedMap] = &[$(shipped_map!($map)),*];

            fn sniff(head: &Head<'_>) -> bool {
                $dialect.sniff(head)
            }

            fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
                $dialect.list(log)
            }

            fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
                $dialect.decode(log, wanted)
            }
        }
    };
}

text_format!(
    /// CSV exports of MoTeC i2.
    Motec, MOTEC, "motec_csv", "CSV exports of MoTeC i2", "channel", ["motec_csv"]
);
text_format!(
    /// CSV exports of AiM Race Studio.
    Aim, AIM, "aim_csv", "CSV exports of AiM Race Studio 2 and 3", "channel", ["aim_csv"]
);
text_format!(
    /// CSV exports of RaceChrono.
    RaceChrono, RACECHRONO, "racechrono", "CSV exports of RaceChrono, v2 and v3",
    "`gps/speed`, `canbus/gear`", ["racechrono_v3", "racechrono_v2"]
);

/// Where the stamps come from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Clock {
    /// A column, seconds per unit.
    Column(usize, f64),
    /// Rows per second.
    Rate(f64),
}

impl Dialect {
    fn sniff(&self, head: &Head<'_>) -> bool {
        let Some(text) = text::beginning(head.bytes) else { return false };
        let first = text.trim_start().lines().next().unwrap_or("");
        let plain: String = first.chars().filter(|c| *c != '"').collect();
        plain.to_lowercase().replace(';', ",").starts_with(self.begins)
    }

    fn list(&self, log: &Location) -> Result<Listing, Error> {
        let mut table = table::open(log, self.clock, self.notes)?;
        let facts = Facts::of_cells(&table.above);
        let clock = self.clock(log, &table, &facts)?;
        let mut meta = facts.meta(&self.keys);
        let mut warnings = Vec::new();
        if let (Clock::Column(place, factor), true) = (clock, self.epoch) {
            let first = rows(log, &mut table, &[("time", place)], Some(0), 1)?;
            let stamp = first.columns.first().and_then(|c| c.first()).copied();
            let factor = if first.kind == Kind::Numbers { factor } else { 1.0 };
            meta.start_time = stamp.and_then(|t| start_time(t * factor));
        } else if let Some(start) = &meta.start_time {
            warnings.push(wall_clock(start));
        }
        if !ident::from_path(log).bike_id.is_empty() {
            meta.bike_id.clear(); // the folder that the user chose is a better source than the header
        }
        Ok(Listing {
            channels: self.channels(&table, clock, &facts),
            meta,
            facts: facts.0,
            warnings,
            ..Listing::default()
        })
    }

    fn clock(&self, log: &Location, table: &Table, facts: &Facts) -> Result<Clock, Error> {
        let found = self.clock.iter().find_map(|name| table.names.iter().position(|n| n == name));
        if let Some(place) = found {
            let unit = table.notes.first().and_then(|u| u.get(place)).map_or("", |u| u.trim());
            let factor = match unit {
                "" | "unix time" | "sec" => 1.0,
                unit => units::conversion(unit, "s").map(|c| c.factor).map_err(|e| {
                    let name = &table.names[place];
                    Error::new(RejectionCode::UnknownUnit, format!("{log}: `{name}`: {e}"))
                })?,
            };
            return Ok(Clock::Column(place, factor));
        }
        facts.number(self.keys.rate).map(Clock::Rate).ok_or_else(|| {
            let message = format!(
                "{} has no column `{}` and its header gives no rate; export it again with time",
                log,
                self.clock.join("` or `")
            );
            Error::new(RejectionCode::NoTime, message)
        })
    }

    fn channels(&self, table: &Table, clock: Clock, facts: &Facts) -> Vec<SourceChannel> {
        let rate = match clock {
            Clock::Rate(rate) => Some(rate),
            Clock::Column(..) => facts.number(self.keys.rate),
        };
        let note = |row: usize, place: usize| {
            table.notes.get(row).and_then(|r| r.get(place)).map_or("", |c| c.trim())
        };
        let mut channels: Vec<SourceChannel> = Vec::new();
        let mut taken: HashSet<String> = HashSet::new();
        let mut twins: HashMap<String, usize> = HashMap::new();
        for (place, name) in table.names.iter().enumerate() {
            if name.is_empty() || matches!(clock, Clock::Column(at, _) if at == place) {
                continue;
            }
            let mut channel = SourceChannel {
                name: name.clone(),
                unit: Some(note(0, place).to_owned()),
                group: if self.notes > 1 {
                    device(note(1, place)).to_owned()
                } else {
                    String::new()
                },
                rate,
                place: [place, 0, 0],
                ..SourceChannel::default()
            };
            if table.notes.is_empty() {
                in_name(&mut channel);
            }
            channel.unit = channel.unit.map(|u| standard_unit(&u)).filter(|u| !u.is_empty());
            if taken.contains(&channel.full()) {
                // two receivers of one kind: the source with its number is unique
                channel.group = note(1, place).to_owned();
            }
            let full = channel.full();
            if taken.contains(&full) {
                let number = twins.entry(full.clone()).or_insert(1);
                *number += 1;
                while taken.contains(&format!("{full} #{number}")) {
                    *number += 1;
                }
                channel.name = format!("{} #{number}", channel.name);
            }
            taken.insert(channel.full());
            channels.push(channel);
        }
        channels
    }

    fn decode(&self, log: &Location, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        let mut table = table::open(log, self.clock, self.notes)?;
        let facts = Facts::of_cells(&table.above);
        let clock = self.clock(log, &table, &facts)?;
        let names: Vec<String> = wanted.iter().map(|c| c.full()).collect();
        let mut places: Vec<cells::Wanted<'_>> =
            names.iter().zip(wanted).map(|(name, c)| (name.as_str(), c.place[0])).collect();
        let counter = self.laps.iter().find_map(|name| table.names.iter().position(|n| n == name));
        places.extend(counter.map(|place| ("laps", place)));
        if let Clock::Column(place, _) = clock {
            places.push((&table.names[place], place));
        } else if places.is_empty() {
            return Ok(Decoded::default());
        }
        let places: Vec<(String, usize)> =
            places.into_iter().map(|(name, place)| (name.to_owned(), place)).collect();
        let places: Vec<cells::Wanted<'_>> = places.iter().map(|(n, p)| (n.as_str(), *p)).collect();
        let at = matches!(clock, Clock::Column(..)).then(|| places.len() - 1);
        let mut read = rows(log, &mut table, &places, at, usize::MAX)?;
        let time = match clock {
            Clock::Column(_, factor) => {
                let mut time = read.columns.pop().unwrap_or_default();
                // a time of day is in seconds already
                let factor = if read.kind == Kind::Numbers { factor } else { 1.0 };
                time.iter_mut().for_each(|t| *t *= factor);
                read.warnings.extend(header_rate_warning(&time, facts.number(self.keys.rate)));
                time
            }
            Clock::Rate(rate) => {
                let rows = read.columns.first().map_or(0, Vec::len);
                (0..rows).map(|i| i as f64 / rate).collect()
            }
        };
        let mut times = facts.beacons();
        if counter.is_some() {
            times.extend(rises(&time, &read.columns.pop().unwrap_or_default()));
        }
        let columns = names.into_iter().zip(read.columns).collect();
        Ok(Decoded {
            columns: clocks::separate(time, columns, |_, _| false),
            warnings: read.warnings,
            markers: Markers { times, line: None },
        })
    }
}

/// Stamps of the rows in which a counter of laps goes up by one, or begins after the first row. RaceChrono puts a row in
/// where its line was passed, between those of the receiver.
fn rises(time: &[f64], counter: &[f64]) -> Vec<f64> {
    let mut last: Option<f64> = None;
    let mut out = Vec::new();
    for (i, (time, count)) in
        time.iter().zip(counter).enumerate().filter(|(_, (_, c))| c.is_finite())
    {
        let rose = last.is_none_or(|last| count - last == 1.0);
        if rose && i > 0 {
            out.push(*time);
        }
        last = Some(*count);
    }
    out
}

/// Columns of a table's rows.
fn rows(
    log: &Location,
    table: &mut Table,
    places: &[cells::Wanted<'_>],
    clock: Option<usize>,
    most: usize,
) -> Result<cells::Cells, Error> {
    let writing = cells::Writing {
        decimal: table.decimal,
        missing: &[],
        first_line: table.first_line,
        width: table.names.len(),
        clock,
        units: &[],
        coordinates: &[],
    };
    cells::read(log, &mut table.rows, places, writing, most)
}

/// Device of a source row's cell: `100: gps` is `gps`.
fn device(text: &str) -> &str {
    match text.split_once(':') {
        Some((number, name)) if number.trim().parse::<u32>().is_ok() => name.trim(),
        _ => text,
    }
}

/// Takes unit and device out of a name: `Speed (m/s) *gps`.
fn in_name(channel: &mut SourceChannel) {
    let (name, device) = channel.name.rsplit_once(" *").unwrap_or((&channel.name, ""));
    let with_unit = name.trim_end().strip_suffix(')').and_then(|n| n.rsplit_once('('));
    let (name, unit) = with_unit.unwrap_or((name, ""));
    let (name, unit, device) = (name.trim().to_owned(), unit.to_owned(), device.trim().to_owned());
    (channel.name, channel.unit, channel.group) = (name, Some(unit), device);
}

/// Units that a source spells in its own way.
fn standard_unit(unit: &str) -> String {
    match unit.trim() {
        // RaceChrono has no degree sign, AiM writes a number's name
        ".C" => "degC".to_owned(),
        ".F" => "degF".to_owned(),
        "#" => String::new(),
        unit => unit.to_owned(),
    }
}

/// A warning where the stamps' rate is not the header's.
fn header_rate_warning(time: &[f64], told: Option<f64>) -> Option<Warning> {
    let rate = 1.0 / clocks::median_step(time.iter().copied())?;
    let told = told?;
    // stamps are rounded: only what no rounding explains
    if (0.8..1.25).contains(&(rate / told)) {
        return None;
    }
    let message =
        format!("the header says {told} Hz, the stamps say {rate:.4} Hz; the stamps decide");
    Some(warning("rate_mismatch", None, 1, None, message))
}
