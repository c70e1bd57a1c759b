//! Delimited text, through a channel map.

use std::io::{BufRead, BufReader, Read};

use crate::contract::rejection::RejectionCode;
use crate::ingest::clock::stamps::check::in_seconds;
use crate::ingest::clock::stamps::text::Kind;
use crate::ingest::clock::stamps::unit::calendar_of;
use crate::ingest::error::Error;
use crate::ingest::formats::format::{HEAD_LEN, Head, LogFormat};
use crate::ingest::formats::listing::{Listing, SourceChannel};
use crate::ingest::ident;
use crate::ingest::maps::bind::fit;
use crate::ingest::maps::units;
use crate::ingest::maps::{ChannelMap, CsvLayout, Maps, TimeSource, shipped_map};
use crate::ingest::raw::{Identified, Raw};
use crate::ingest::warning::warning;
use crate::store::objects::Location;
use crate::store::objects::source;
use crate::store::objects::source::Source;

pub(crate) mod cells;
pub(crate) mod clocks;
mod layout;
mod plain;
mod sentinels;
pub(crate) mod table;
pub(crate) mod text;

use layout::Squeezed;
use text::{Text, decoded};

/// Rows that are read to know when a log began: enough to see the rate of its clock.
const FIRST: usize = 20;

/// The format.
pub(super) const FORMAT: LogFormat = LogFormat {
    name: "csv",
    description: "Delimited text",
    channel_names: "column",
    extensions: &["csv", "tsv", "txt"],
    maps: &[
        shipped_map!("session_csv"),
        shipped_map!("indy_av21_car"),
        shipped_map!("tudelft_bicycle"),
    ],
    own_clock: false,
    sniff,
    identify,
    read,
    map,
    decoder: Some(plain::DECODER),
};

/// Text of any encoding.
fn sniff(head: &Head<'_>) -> bool {
    text::is_text(head.bytes)
}

fn identify(log: &Location, maps: Maps<'_>) -> Result<Identified, Error> {
    let (map, header) = choose(log, maps)?;
    let mut meta = ident::or(ident::from_path(log), map.meta.clone());
    if let TimeSource::Column { name, epoch: true, .. } = &map.time {
        let mut rows = open(log, &map.csv)?;
        let at = header.names.iter().position(|c| c == name);
        if let Some(at) = at {
            let writing = header.writing(map, Some(0));
            let first = cells::read(log, &mut rows.reader, &[(name, at)], writing, FIRST);
            let unix = first.ok().and_then(|r| unix_of(&map.time, r.columns.first()?, r.kind));
            meta.start_time = unix.and_then(start_time).or(meta.start_time);
        }
    }
    Ok(Identified { meta, map: Some(map.name.clone()) })
}

/// Unix time of the first of some stamps on a clock that counts from a day.
fn unix_of(clock: &TimeSource, stamps: &[f64], kind: Kind) -> Option<f64> {
    let first = *stamps.first()?;
    match (clock, kind) {
        (TimeSource::Column { .. }, Kind::Dated) => Some(first),
        (TimeSource::Column { factor, .. }, Kind::Numbers) => {
            let zero = calendar_of(stamps).filter(|c| c.factor == *factor).map_or(0.0, |c| c.zero);
            Some(first * factor + zero)
        }
        _ => None,
    }
}

/// Unix seconds as RFC 3339, to the millisecond.
pub(crate) fn start_time(seconds: f64) -> Option<String> {
    let ms = (seconds * 1e3).round();
    if !(0.0..4e12).contains(&ms) {
        return None;
    }
    jiff::Timestamp::from_millisecond(ms as i64).ok().map(|t| t.to_string())
}

fn map(log: &Location, maps: Maps<'_>) -> Result<Option<ChannelMap>, Error> {
    let (map, header) = choose(log, maps)?;
    fitted(map, &header).map(Some)
}

/// The map as it is for this log; where the log gives units, in a row or in brackets behind the names, they are
/// checked.
fn fitted(map: &ChannelMap, header: &Header) -> Result<ChannelMap, Error> {
    if header.units.iter().all(String::is_empty) {
        return Ok(map.fitted(&header.names));
    }
    let channel = |(place, name): (usize, &String)| SourceChannel {
        name: name.clone(),
        unit: header.units.get(place).cloned().filter(|u| !u.is_empty()),
        place: [place, 0, 0],
        ..SourceChannel::default()
    };
    let channels: Vec<SourceChannel> = header.names.iter().enumerate().map(channel).collect();
    let mut map = map.clone();
    if map.csv.units_row == 0 {
        // units behind some names say nothing of the others: those are the contract's, as without any
        let bare = |name: &String| channels.iter().any(|c| c.name == *name && c.unit.is_none());
        for entry in &mut map.entries {
            entry.unit_given |= entry.from.iter().any(bare);
        }
    }
    fit(&map, &Listing { channels, ..Listing::default() })
}

fn read(log: &Location, maps: Maps<'_>) -> Result<Raw, Error> {
    let (map, header) = choose(log, maps)?;
    let map = fitted(map, &header)?;
    let needed = map.needed();
    let place = |name: &str| header.names.iter().position(|h| h == name);
    let places = needed
        .iter()
        .map(|name| place(name).map(|p| (*name, p)).ok_or_else(|| map.missing(name, &header.names)))
        .collect::<Result<Vec<cells::Wanted<'_>>, Error>>()?;
    let mut rows = open(log, &map.csv)?;
    let own_clock = matches!(map.time, TimeSource::Column { .. });
    let writing = header.writing(&map, own_clock.then_some(0));
    let cells::Cells { columns: mut decoded, kind, mut warnings } =
        cells::read(log, &mut rows.reader, &places, writing, usize::MAX)?;
    let rows = decoded.first().map_or(0, Vec::len);
    let time = match &map.time {
        TimeSource::Rate(rate) => (0..rows).map(|i| i as f64 / rate).collect(),
        TimeSource::Column { name, factor, .. } => {
            let mut stamps = decoded.remove(0);
            if kind == Kind::Numbers {
                in_seconds(&mut stamps, *factor).map_err(|e| {
                    let of = format!("channel map {}, [time], column `{name}`: {e}", map.name);
                    Error::new(RejectionCode::ImplausibleClock, of)
                })?;
            }
            stamps
        }
        TimeSource::Own => {
            return Err(Error::new(
                RejectionCode::NoTime,
                format!("channel map {}: no `[time]`", map.name),
            ));
        }
    };
    let names = if matches!(map.time, TimeSource::Rate(_)) { &needed[..] } else { &needed[1..] };
    sentinels::take_out(names, &mut decoded, &mut warnings);
    let columns = names.iter().map(|n| (*n).to_owned()).zip(decoded).collect();
    // what is averaged shares a clock
    let together = |a: usize, b: usize| {
        let both = |from: &[String]| [a, b].iter().all(|&i| from.iter().any(|f| *f == names[i]));
        a != b && map.entries.iter().any(|e| both(&e.from))
    };
    let columns = clocks::separate(time, columns, together);
    let unread: Vec<&str> =
        header.names.iter().map(String::as_str).filter(|h| !needed.contains(h)).collect();
    if !unread.is_empty() {
        warnings.push(warning(
            "unknown_column",
            None,
            unread.len(),
            None,
            format!("not read by channel map {}: {}", map.name, unread.join(", ")),
        ));
    }
    Ok(Raw {
        meta: identify(log, maps)?.meta,
        tracks: map.apply(columns)?,
        warnings,
        euler_yaw: map.euler_yaw,
        wheel_scale_sd: map.wheel_scale_sd(),
        imu: map.imu,
        map: Some(map.name),
        ..Raw::default()
    })
}

/// The map for a file and the file's header under that map's layout.
fn choose<'a>(log: &Location, maps: Maps<'a>) -> Result<(&'a ChannelMap, Header), Error> {
    let candidates = maps.of_format("csv");
    let mut seen = Header::default();
    for &map in &candidates {
        let header = open(log, &map.csv)?.header;
        if map.detects(&header.names) {
            return Ok((map, header));
        }
        seen = header;
    }
    // a single map that was asked for is used even if it does not claim the file
    if let ([map], true) = (&candidates[..], maps.given) {
        return Ok((map, seen));
    }
    let tried: Vec<&str> = candidates.iter().map(|m| m.name.as_str()).collect();
    Err(Error::new(
        RejectionCode::NoChannelMap,
        format!(
            "no channel map fits {} (tried {}); its header is `{}`; `roadbench inspect` proposes a \
             map for it, `roadbench schema channel_map` lists every key{}",
            log,
            tried.join(", "),
            seen.names.join(", ").chars().take(300).collect::<String>(),
            of_a_phone(&seen.names)
        ),
    ))
}

/// What to do with a text of one sensor of a phone.
fn of_a_phone(names: &[String]) -> &'static str {
    match names {
        [time, elapsed, ..] if time == "time" && elapsed == "seconds_elapsed" => {
            "; it is one sensor of a recording of Sensor Logger: the ZIP that the app exports is one log with all of them"
        }
        _ => "",
    }
}

/// The names and the units of a file's columns.
#[derive(Debug, Default)]
struct Header {
    names: Vec<String>,
    /// Of the layout's row of units or in brackets behind the names; empty where there is none.
    units: Vec<String>,
}

/// A file that is open at its first row of data.
struct Rows {
    header: Header,
    reader: ::csv::Reader<Squeezed<BufReader<Text<Source>>>>,
}

impl Header {
    fn writing<'a>(&'a self, map: &'a ChannelMap, clock: Option<usize>) -> cells::Writing<'a> {
        cells::Writing {
            decimal: map.csv.decimal,
            missing: &map.csv.missing,
            first_line: (map.csv.skip_rows + map.csv.rows_after_header + 2) as u64,
            width: self.names.len(),
            clock,
            units: &self.units,
        }
    }
}

fn open(log: &Location, map: &CsvLayout) -> Result<Rows, Error> {
    let fail = |e: std::io::Error| Error::unreadable(log, &e);
    let file = source::open(log).map_err(fail)?;
    let mut file = BufReader::new(Text::new(file).map_err(fail)?);
    let mut line = Vec::new();
    let mut next = |line: &mut Vec<u8>| -> Result<(), Error> {
        line.clear();
        (&mut file).take(HEAD_LEN).read_until(b'\n', line).map_err(fail)?;
        Ok(())
    };
    for _ in 0..=map.skip_rows {
        next(&mut line)?;
    }
    let header = decoded(&line);
    let mut notes = Vec::new();
    for row in 1..=map.rows_after_header {
        next(&mut line)?;
        if row == map.units_row {
            notes = decoded(&line).trim_end_matches(['\r', '\n']).to_owned().into_bytes();
        }
    }
    let delimiter = map.delimiter as u8;
    // the first row says whether the names end with a delimiter too many, and units behind its numbers
    let ahead = decoded(file.fill_buf().map_err(fail)?);
    let row = ahead.lines().find(|l| !l.trim().is_empty()).unwrap_or("");
    let header = header.trim_matches(|c: char| c.is_whitespace() && c != '\t');
    let header = header.strip_prefix(map.header_prefix.as_str()).unwrap_or(header);
    let names = layout::names(header, delimiter, row);
    let mut units = layout::cells(&decoded(&notes), delimiter);
    let cells = layout::cells(row, delimiter);
    for (place, name) in names.iter().enumerate() {
        let behind = || layout::with_unit(cells.get(place)?).map(|w| w.1);
        if let Some(unit) = units::of_name(name).1.or_else(behind) {
            units.resize(units.len().max(place + 1), String::new());
            if units[place].is_empty() {
                unit.clone_into(&mut units[place]);
            }
        }
    }
    Ok(Rows { header: Header { names, units }, reader: layout::reader(delimiter, file) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::channel::Channel;
    use crate::ingest::maps::file::or_shipped;

    const MAP: &str = "name = 'x'\nformat = 'csv'\n[csv]\ndelimiter = ';'\ndecimal = ','\n\
         skip_rows = 1\nrows_after_header = 1\nmissing = ['n/a']\n[detect]\ncolumns = ['v']\n\
         [time]\ncolumn = 't'\nunit = 'ms'\n[channel.velocity_x]\nfrom = 'v'\nunit = 'km/h'\n";

    fn log(text: &str) -> (tempfile::TempDir, Location) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("ride.csv");
        std::fs::write(&path, text).expect("written");
        (folder, path.into())
    }

    fn maps() -> Vec<ChannelMap> {
        vec![ChannelMap::parse(MAP, "x.toml").expect("a map")]
    }

    #[test]
    fn decimal_comma_units_row_prefix_and_missing_cells() {
        let (_folder, path) =
            log("logger 3\n# t;extra;v\nms;;km/h\n0;1;36,0\n10;;n/a\n20;2;\n30;2;\n40;1;7,2e1\n");
        let raw = read(&path, or_shipped(&maps())).expect("read");
        let track = &raw.tracks[0];
        assert_eq!(track.channel, Channel::VelocityX);
        assert_eq!(*track.time, [0.0, 0.01, 0.02, 0.03, 0.04]);
        assert_eq!(track.values[0], 10.0);
        assert!(track.values[1..4].iter().all(|v| v.is_nan()));
        assert_eq!(track.values[4], 20.0);
        assert_eq!(raw.warnings[0].code, "unknown_column");
        assert!(raw.warnings[0].message.contains("extra"));
    }

    #[test]
    fn unreadable_cells_name_column_and_line() {
        let (_folder, path) = log("l\nt;v\n;\n0;1\n10;oops\n20;3\n");
        let error = read(&path, or_shipped(&maps())).expect_err("a third is bad");
        assert_eq!(error.code.as_str(), "bad_cell");
        assert!(error.message.contains("`v`") && error.message.contains("line 5"), "{error}");
        let mut text = "l\nt;v\n;\n".to_owned();
        (0..500).for_each(|i| text += &format!("{i};{}\n", if i == 7 { "oops" } else { "1" }));
        let (_folder, path) = log(&text);
        let raw = read(&path, or_shipped(&maps())).expect("rare enough");
        assert!(raw.tracks[0].values[7].is_nan());
        assert!(raw.warnings.iter().any(|w| w.code == "bad_cell" && w.message.contains("line 11")));
    }

    #[test]
    fn an_unknown_header_says_what_was_tried() {
        let (_folder, path) = log("a,b\n1,2\n");
        let error = read(&path, or_shipped(&[])).expect_err("no map");
        assert_eq!(error.code.as_str(), "no_channel_map");
        assert!(error.message.contains("session_csv") && error.message.contains("a, b"), "{error}");
        let error = read(&path, or_shipped(&maps())).expect_err("forced map");
        assert_eq!(error.code.as_str(), "missing_column");
    }

    #[test]
    fn unix_stamps_give_the_start_time() {
        assert_eq!(start_time(1_692_117_187.464).as_deref(), Some("2023-08-15T16:33:07.464Z"));
        assert_eq!(start_time(f64::NAN), None);
    }
}
