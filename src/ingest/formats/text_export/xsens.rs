//! Text exports of XSens MT Manager.
//!
//! Lines of comments (`// key: value`), a row of names, then tab, comma or semicolon between
//! numbers; the cells of slower outputs are empty. Units are not written; they are the manual's:
//!
//! | columns | unit |
//! |---|---|
//! | `SampleTimeFine` | 0.1 ms, begins anew at 2^32 |
//! | `PacketCounter` | 1, begins anew at 2^16 |
//! | `Acc_*`, `FreeAcc_*` | m/s² |
//! | `Gyr_*` | rad/s |
//! | `Roll`, `Pitch`, `Yaw`, `Latitude`, `Longitude` | deg |
//! | `Vel_*`, `Velocity_*` | m/s |
//! | `Altitude` | m |
//! | `UTC_Year` to `UTC_Second`, `UTC_Nano` | the moment |
//!
//! Wireless sensors leave `SampleTimeFine` empty; then the packets are counted at the header's
//! `Update Rate`. The channels of the group `level` are computed ([`super::level`]): what the unit
//! measures in its own leaning frame and over the ground, in the frame that turns with the yaw.

use super::facts::{Facts, HeaderKeys};
use super::level::{self, Derived};
use super::{header_rate_warning, rows};
use crate::contract::rejection::RejectionCode;
use crate::contract::session::Meta;
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::csv::table::{self, Table};
use crate::ingest::formats::csv::{cells, clocks, start_time, text};
use crate::ingest::formats::format::Format;
use crate::ingest::formats::format::Head;
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::store::objects::Location;

/// Exports of MT Manager.
#[derive(Debug)]
pub(crate) struct Xsens;

const COUNTER: &str = "PacketCounter";
const TICKS: &str = "SampleTimeFine";
/// Seconds per tick.
const TICK: f64 = 1e-4;
/// The ticks and the packets begin anew after so many.
const TICKS_WRAP: f64 = 4_294_967_296.0;
const PACKETS_WRAP: f64 = 65_536.0;
/// The group of what is computed.
const LEVEL: &str = "level";
/// Rows in which the first moment is looked for.
const MOMENT_ROWS: usize = 5000;
const MOMENT: [&str; 7] =
    ["UTC_Year", "UTC_Month", "UTC_Day", "UTC_Hour", "UTC_Minute", "UTC_Second", "UTC_Nano"];
const HEADER_KEYS: HeaderKeys =
    HeaderKeys { vehicle: "", driver: &[], venue: "", start: &[], rate: "Update Rate" };

impl Format for Xsens {
    const NAME: &'static str = "xsens";
    const DESCRIPTION: &'static str =
        "XSens MT Manager's text; rates, accelerations and velocity are rotated upright";
    const CHANNEL_NAMES: &'static str = "column, `level/yaw_rate`";
    const EXTENSIONS: &'static [&'static str] = &["txt", "csv"];
    const MAPS: &'static [ShippedMap] = &[shipped_map!("xsens_mt_manager")];

    fn sniff(head: &Head<'_>) -> bool {
        text::beginning(head.bytes).is_some_and(|text| {
            text.trim_start().starts_with("//")
                && text.lines().any(|l| l.trim_start_matches('"').starts_with(COUNTER))
        })
    }

    fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
        let (mut table, facts) = open(log)?;
        let mut listing = Listing { channels: channels(&table), ..Listing::default() };
        listing.meta =
            Meta { start_time: first_moment(log, &mut table, &facts)?, ..Meta::default() };
        listing.facts = facts.0;
        Ok(listing)
    }

    fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        let (mut table, facts) = open(log)?;
        // what is asked for, what that is computed from, and the clock, each once
        let mut names: Vec<&str> = Vec::new();
        let inputs = wanted.iter().flat_map(|c| match derived(c) {
            Some(derived) => derived.of.to_vec(),
            None => vec![c.name.as_str()],
        });
        for name in inputs.chain([TICKS, COUNTER]) {
            if !names.contains(&name) && place(&table, name).is_some() {
                names.push(name);
            }
        }
        let places: Vec<cells::Wanted<'_>> =
            names.iter().filter_map(|n| Some((*n, place(&table, n)?))).collect();
        let read = rows(log, &mut table, &places, None, usize::MAX)?;
        let column = |name: &str| {
            names
                .iter()
                .position(|n| *n == name)
                .and_then(|i| read.columns.get(i))
                .map(Vec::as_slice)
        };
        let time = stamps(log, column(TICKS), column(COUNTER), &facts)?;
        let mut warnings = read.warnings.clone();
        warnings.extend(header_rate_warning(&time, facts.number(HEADER_KEYS.rate)));
        let values = |channel: &&SourceChannel| {
            let values = match derived(channel) {
                Some(derived) => computed(derived, &column, time.len()),
                None => column(&channel.name).unwrap_or_default().to_vec(),
            };
            (channel.full(), values)
        };
        let columns = wanted.iter().map(values).collect();
        let columns = clocks::separate(time.clone(), columns, |_, _| false);
        Ok(Decoded { columns, warnings, ..Decoded::default() })
    }
}

fn open(log: &Location) -> Result<(Table, Facts), Error> {
    let mut table = table::open(log, &[COUNTER], 0)?;
    // older versions call them otherwise
    for name in &mut table.names {
        for (from, to) in
            [("Velocity_", "Vel_"), ("Vel_E", "Vel_X"), ("Vel_N", "Vel_Y"), ("Vel_U", "Vel_Z")]
        {
            if name.starts_with(from) {
                *name = name.replacen(from, to, 1);
            }
        }
    }
    // a comment may hold what elsewhere is between cells
    let lines: Vec<String> = table
        .above
        .iter()
        .map(|cells| cells.join(&char::from(table.delimiter).to_string()))
        .collect();
    let facts = Facts::of_comments(lines.iter().map(String::as_str));
    match facts.get("Coordinate system") {
        Some(system) if system.to_uppercase().contains("NED") => {
            let message = format!(
                "{} is in the coordinate system {system}, with z down; export it again in ENU",
                log
            );
            Err(Error::new(RejectionCode::CoordinateSystem, message))
        }
        _ => Ok((table, facts)),
    }
}

fn place(table: &Table, name: &str) -> Option<usize> {
    table.names.iter().position(|n| n == name)
}

fn channels(table: &Table) -> Vec<SourceChannel> {
    let mut channels: Vec<SourceChannel> = Vec::new();
    for (at, name) in table.names.iter().enumerate() {
        let known = channels.iter().any(|c| c.name == *name);
        if name.is_empty() || known || [COUNTER, TICKS].contains(&name.as_str()) {
            continue;
        }
        channels.push(SourceChannel {
            name: name.clone(),
            unit: unit(name).map(str::to_owned),
            place: [at, 0, 0],
            ..SourceChannel::default()
        });
    }
    for (i, derived) in level::ALL.iter().enumerate() {
        if derived.of.iter().all(|name| place(table, name).is_some()) {
            channels.push(SourceChannel {
                group: LEVEL.into(),
                name: derived.name.into(),
                unit: Some(derived.unit.into()),
                place: [i, 1, 0],
                ..SourceChannel::default()
            });
        }
    }
    channels
}

fn derived(channel: &SourceChannel) -> Option<&'static Derived> {
    if channel.place[1] == 1 { level::ALL.get(channel.place[0]) } else { None }
}

fn unit(name: &str) -> Option<&'static str> {
    const UNITS: [(&str, &str); 9] = [
        ("Acc_", "m/s2"),
        ("FreeAcc_", "m/s2"),
        ("Gyr_", "rad/s"),
        ("Vel_", "m/s"),
        ("Roll", "deg"),
        ("Pitch", "deg"),
        ("Yaw", "deg"),
        ("L", "deg"), // Latitude, Longitude
        ("Altitude", "m"),
    ];
    let angle = matches!(name, "Latitude" | "Longitude");
    UNITS.iter().find(|(n, _)| name.starts_with(n) && (*n != "L" || angle)).map(|(_, unit)| *unit)
}

fn computed<'a>(
    derived: &Derived,
    column: &impl Fn(&str) -> Option<&'a [f64]>,
    rows: usize,
) -> Vec<f64> {
    let Some(inputs) = derived.of.iter().map(|n| column(n)).collect::<Option<Vec<&[f64]>>>() else {
        return vec![f64::NAN; rows];
    };
    let row = |i: usize| (derived.how)(&inputs.iter().map(|c| c[i]).collect::<Vec<f64>>());
    (0..rows).map(row).collect()
}

/// Stamps in seconds, from the ticks, or else from the packets.
fn stamps(
    log: &Location,
    ticks: Option<&[f64]>,
    packets: Option<&[f64]>,
    facts: &Facts,
) -> Result<Vec<f64>, Error> {
    let filled =
        |column: &&[f64]| 2 * column.iter().filter(|x| x.is_finite()).count() > column.len();
    if let Some(ticks) = ticks.filter(filled) {
        return Ok(running_on(ticks, TICKS_WRAP).into_iter().map(|t| t * TICK).collect());
    }
    if let (Some(packets), Some(rate)) = (packets.filter(filled), facts.number(HEADER_KEYS.rate)) {
        return Ok(running_on(packets, PACKETS_WRAP).into_iter().map(|k| k / rate).collect());
    }
    let message = format!(
        "{}: `{TICKS}` is empty and no comment gives the `{}`; export it again with {TICKS}",
        log, HEADER_KEYS.rate
    );
    Err(Error::new(RejectionCode::NoTime, message))
}

/// A counter that begins anew after `wrap`, as one that does not.
fn running_on(counts: &[f64], wrap: f64) -> Vec<f64> {
    let (mut turns, mut last) = (0.0, f64::NAN);
    counts
        .iter()
        .map(|&count| {
            if last - count > 0.5 * wrap {
                turns += wrap;
            }
            if count.is_finite() {
                last = count;
            }
            count + turns
        })
        .collect()
}

/// The moment of the first row, from the first row that has one.
fn first_moment(log: &Location, table: &mut Table, facts: &Facts) -> Result<Option<String>, Error> {
    let wanted: Option<Vec<usize>> = MOMENT[..6].iter().map(|n| place(table, n)).collect();
    let Some(mut places) = wanted else { return Ok(None) };
    let more = [MOMENT[6], "UTC_Valid", TICKS, COUNTER];
    places.extend(more.iter().filter_map(|n| place(table, n)));
    let named: Vec<(String, usize)> = places.iter().map(|&p| (table.names[p].clone(), p)).collect();
    let named: Vec<cells::Wanted<'_>> = named.iter().map(|(n, p)| (n.as_str(), *p)).collect();
    let read = rows(log, table, &named, None, MOMENT_ROWS)?;
    let column =
        |name: &str| named.iter().position(|(n, _)| *n == name).map(|i| read.columns[i].as_slice());
    let Ok(time) = stamps(log, column(TICKS), column(COUNTER), facts) else { return Ok(None) };
    let moment = |row: usize| -> Option<f64> {
        if column("UTC_Valid").is_some_and(|v| v[row] == 0.0) {
            return None;
        }
        let field = |name: &str| column(name).map(|c| c[row]).filter(|x| x.is_finite());
        let [year, month, day, hour, minute] =
            [0, 1, 2, 3, 4].map(|i| field(MOMENT[i]).map_or(-1, |x| x as i16));
        let small = |x: i16| i8::try_from(x).unwrap_or(-1);
        let civil = jiff::civil::DateTime::new(
            year,
            small(month),
            small(day),
            small(hour),
            small(minute),
            0,
            0,
        )
        .ok()?;
        let begun = civil.to_zoned(jiff::tz::TimeZone::UTC).ok()?.timestamp().as_second();
        Some(begun as f64 + field(MOMENT[5])? + field(MOMENT[6]).unwrap_or(0.0) * 1e-9)
    };
    let first = (0..time.len()).find_map(|row| Some(moment(row)? - (time[row] - time[0])));
    Ok(first.and_then(start_time))
}
