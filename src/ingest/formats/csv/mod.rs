//! Delimited text, through a channel map.

use std::io::{BufRead, BufReader};

use crate::contract::rejection::RejectionCode;
use crate::contract::warning::Warning;
use crate::ingest::clock::stamps::check::in_seconds;
use crate::ingest::clock::stamps::text::Kind;
use crate::ingest::clock::wraps;
use crate::ingest::error::Error;
use crate::ingest::formats::format::{HEAD_LEN, Head, LogFormat};
use crate::ingest::formats::listing::{Listing, SourceChannel, number_twins};
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
mod coordinate;
mod day;
mod layout;
mod notation;
mod plain;
mod positions;
mod sentinels;
pub(crate) mod table;
pub(crate) mod text;

use coordinate::Coordinate;
pub(crate) use day::start_time;
use day::unix_of;
use layout::Squeezed;
use positions::Positions;
use text::{Text, decoded};

/// Rows that are read to know when a log began: enough to see the rate of its clock.
const FIRST: usize = 20;

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
    if let TimeSource::Column { name, epoch, .. } = &map.time
        && let Ok(at) = header.place(map, name)
    {
        let mut unix = None;
        if *epoch {
            let mut rows = open(log, &map.csv)?;
            let writing = header.writing(map, Some(0), &[]);
            let first = cells::read(log, &mut rows.reader, &[(name, at)], writing, FIRST);
            unix = first.ok().and_then(|r| unix_of(&map.time, r.columns.first()?, r.kind));
        }
        let unix = unix.or_else(|| day::start(&header.names, &header.first, at));
        meta.start_time = unix.and_then(start_time).or(meta.start_time);
    }
    Ok(Identified { meta, map: Some(map.name.clone()) })
}

fn map(log: &Location, maps: Maps<'_>) -> Result<Option<ChannelMap>, Error> {
    let (map, header) = choose(log, maps)?;
    fitted(map, &header).map(Some)
}

/// The map as it is for this log; where the log gives units, in a row or in brackets after the names, they are
/// checked.
fn fitted(map: &ChannelMap, header: &Header) -> Result<ChannelMap, Error> {
    let channels = &header.listing.channels;
    if channels.iter().all(|c| c.unit.is_none()) {
        return Ok(map.fitted(&header.known()));
    }
    let mut map = map.clone();
    if map.csv.units_row == 0 {
        // units after some names say nothing of the others: those are the contract's, as without any
        let bare = |name: &String| channels.iter().any(|c| c.is_called(name) && c.unit.is_none());
        for entry in &mut map.entries {
            entry.unit_given |= entry.from.iter().any(bare);
        }
    }
    fit(&map, &header.listing)
}

fn read(log: &Location, maps: Maps<'_>) -> Result<Raw, Error> {
    let (map, header) = choose(log, maps)?;
    let map = fitted(map, &header)?;
    let needed = map.needed();
    let places = needed
        .iter()
        .map(|name| header.place(&map, name).map(|place| (*name, place)))
        .collect::<Result<Vec<cells::Wanted<'_>>, Error>>()?;
    let coordinates = header.coordinates(&map);
    let mut rows = open(log, &map.csv)?;
    let own_clock = matches!(map.time, TimeSource::Column { .. });
    let writing = header.writing(&map, own_clock.then_some(0), &coordinates);
    let cells::Cells { columns: mut decoded, kind, mut warnings } =
        cells::read(log, &mut rows.reader, &places, writing, usize::MAX)?;
    let rows = decoded.first().map_or(0, Vec::len);
    let mut time: Vec<f64> = match &map.time {
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
    // at which stamp the start time holds
    let zero = time.iter().copied().find(|t| t.is_finite()).filter(|_| own_clock);
    if let Some((count, what)) = wraps::unroll(&mut time) {
        warnings.push(warning("time_wrapped", None, count, None, what));
    }
    let names = if matches!(map.time, TimeSource::Rate(_)) { &needed[..] } else { &needed[1..] };
    sentinels::take_out(names, &mut decoded, &mut warnings);
    let columns = names.iter().map(|n| (*n).to_owned()).zip(decoded).collect();
    // what is averaged shares a clock
    let together = |a: usize, b: usize| {
        let both = |from: &[String]| [a, b].iter().all(|&i| from.iter().any(|f| *f == names[i]));
        a != b && map.entries.iter().any(|e| both(&e.from))
    };
    let columns = clocks::separate(time, columns, together);
    warnings.extend(header.said(&places, &coordinates));
    warnings.extend(text::encoding_warning(log)?);
    let unread = header.unread(&places);
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
        zero,
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

/// Advice with a text of one sensor of a phone, and with one that has no names.
fn of_a_phone(names: &[String]) -> &'static str {
    match names {
        [_, _, ..] if names.iter().all(|n| layout::is_number(n)) => {
            "; these are numbers: put a line with the names of the columns in front"
        }
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
    /// Of the layout's row of units or in brackets after the names; empty where there is none.
    units: Vec<String>,
    /// The columns, those of one name numbered; after them the two coordinates of cells that hold both.
    listing: Listing,
    positions: Positions,
    /// Line breaks in quotes above the rows.
    breaks: u64,
    /// Cells of the first rows.
    first: Vec<Vec<String>>,
}

/// A file that is open at its first row of data.
struct Rows {
    header: Header,
    reader: ::csv::Reader<Squeezed<BufReader<Text<Source>>>>,
}

impl Header {
    fn new(names: Vec<String>, units: Vec<String>, positions: Positions) -> Self {
        let own = |place: usize| units.get(place).cloned().filter(|u| !u.is_empty());
        let channel = |(place, name): (usize, &String)| SourceChannel {
            name: name.clone(),
            unit: positions.unit(place).map(str::to_owned).or_else(|| own(place)),
            place: [place, 0, 0],
            ..SourceChannel::default()
        };
        let mut channels: Vec<SourceChannel> = names.iter().enumerate().map(channel).collect();
        channels.extend(positions.parts_of(&names));
        number_twins(&mut channels);
        let listing = Listing { channels, ..Listing::default() };
        Header { names, units, listing, positions, ..Header::default() }
    }

    /// Every name by which a map may know a column.
    fn known(&self) -> Vec<String> {
        let channels = &self.listing.channels;
        channels.iter().map(|c| c.name.clone()).chain(channels.iter().map(|c| c.full())).collect()
    }

    /// Where a column of a map is.
    fn place(&self, map: &ChannelMap, name: &str) -> Result<usize, Error> {
        self.listing.find(name).map(|c| c.place[0]).map_err(|e| match e.code {
            RejectionCode::MissingColumn => map.missing(name, &self.known()),
            code => Error::new(code, format!("channel map {}: {}", map.name, e.message)),
        })
    }

    /// How the positions are read by a map. Where it gives a scale or a sign the numbers are what it expects.
    fn coordinates(&self, map: &ChannelMap) -> Vec<Option<Coordinate>> {
        let mut coordinates = self.positions.coordinates.clone();
        let own = map.entries.iter().filter(|e| (e.scale, e.offset, e.sign) != (1.0, 0.0, 1.0));
        for name in own.flat_map(|e| &e.from) {
            let place = self.listing.find(name).map(|c| c.place[0]);
            if let Some(coordinate) = place.ok().and_then(|place| coordinates.get_mut(place)) {
                coordinate.take_if(|c| !c.is_part());
            }
        }
        coordinates
    }

    /// Text about the positions that are read.
    fn said(&self, read: &[cells::Wanted<'_>], by: &[Option<Coordinate>]) -> Vec<Warning> {
        let mut said: Vec<Warning> = Vec::new();
        for &(_, place) in read {
            let Some(coordinate) = by.get(place) else { continue };
            let own = self.positions.coordinates[place].is_some() && coordinate.is_none();
            let cell = coordinate.as_ref().map_or(place, |c| c.cell);
            for message in self.positions.said(cell).filter(|_| !own) {
                let warning = warning(positions::CODE, None, 1, None, message.to_owned());
                if !said.contains(&warning) {
                    said.push(warning);
                }
            }
        }
        said
    }

    /// Columns that are not read.
    fn unread(&self, read: &[cells::Wanted<'_>]) -> Vec<String> {
        let own = &self.positions;
        let cell = |place: usize| match own.coordinates.get(place) {
            Some(Some(coordinate)) => coordinate.cell,
            _ => place,
        };
        let is_read = |place: usize| read.iter().any(|r| cell(r.1) == place);
        let unread = |c: &&SourceChannel| {
            let letters = own.letters.iter().find(|l| l.0 == c.place[0]).map(|l| l.1);
            !is_read(letters.unwrap_or(c.place[0]))
        };
        let columns = self.listing.channels.iter().filter(|c| c.place[0] < self.names.len());
        columns.filter(unread).map(SourceChannel::full).collect()
    }

    fn writing<'a>(
        &'a self,
        map: &'a ChannelMap,
        clock: Option<usize>,
        coordinates: &'a [Option<Coordinate>],
    ) -> cells::Writing<'a> {
        cells::Writing {
            decimal: map.csv.decimal,
            missing: &map.csv.missing,
            first_line: (map.csv.skip_rows + map.csv.rows_after_header + 2) as u64 + self.breaks,
            width: self.names.len(),
            clock,
            units: &self.units,
            coordinates,
        }
    }
}

fn open(log: &Location, map: &CsvLayout) -> Result<Rows, Error> {
    let fail = |e: std::io::Error| Error::unreadable(log, &e);
    let file = source::open(log).map_err(fail)?;
    let mut file = BufReader::with_capacity(table::SAMPLE, Text::new(file).map_err(fail)?);
    let mut line = Vec::new();
    let mut breaks = 0;
    let mut next = |line: &mut Vec<u8>| -> Result<(), Error> {
        breaks += layout::line(&mut file, HEAD_LEN, line).map_err(fail)?;
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
    // the first row says whether the names end with a delimiter too many, and units after its numbers
    let ahead = decoded(file.fill_buf().map_err(fail)?);
    let row = ahead.lines().find(|l| !l.trim().is_empty()).unwrap_or("");
    let header = header.trim_matches(|c: char| c.is_whitespace() && c != '\t');
    let header = header.strip_prefix(map.header_prefix.as_str()).unwrap_or(header);
    let names = layout::names(header, delimiter, row);
    let mut units = layout::cells(&decoded(&notes), delimiter);
    let cells = layout::cells(row, delimiter);
    for (place, name) in names.iter().enumerate() {
        let after = || layout::with_unit(cells.get(place)?).map(|w| w.1);
        if let Some(unit) = units::of_name(name).1.or_else(after) {
            units.resize(units.len().max(place + 1), String::new());
            if units[place].is_empty() {
                unit.clone_into(&mut units[place]);
            }
        }
    }
    let mut first = table::sample("", &ahead, delimiter);
    let positions = Positions::look(&names, &first, map.decimal);
    first.truncate(FIRST);
    let header = Header { breaks, first, ..Header::new(names, units, positions) };
    Ok(Rows { header, reader: layout::reader(delimiter, file) })
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
    fn columns_of_one_name_are_read_by_their_number() {
        let text = "l\nt;v;v\n;;\n0;36,0;72,0\n10;36,0;72,0\n20;36,0;72,0\n";
        let (_folder, path) = log(text);
        let error = read(&path, or_shipped(&maps())).expect_err("which of them?");
        assert_eq!(error.code.as_str(), "ambiguous_column");
        assert!(error.message.contains("v #1, v #2"), "{error}");
        for (name, wanted) in [("v #1", 10.0), ("v #2", 20.0)] {
            let map = MAP.replace("from = 'v'", &format!("from = '{name}'"));
            let map = vec![ChannelMap::parse(&map, "x.toml").expect("a map")];
            let raw = read(&path, or_shipped(&map)).expect(name);
            assert_eq!(raw.tracks[0].values, [wanted; 3], "{name}");
        }
    }

    #[test]
    fn a_position_is_read_with_its_letters_unless_the_map_says_its_sign() {
        let text = "t,lat,lon,N/S,E/W\n0,33.5,70.5,S,W\n1,33.5,70.5,S,W\n";
        let (_folder, path) = log(text);
        let map = |more: &str| {
            let text = format!(
                "name = 'x'\nformat = 'csv'\n[time]\ncolumn = 't'\n[channel.latitude]\nfrom = 'lat'\nunit = 'deg'\n\
                 [channel.longitude]\nfrom = 'lon'\nunit = 'deg'\n{more}"
            );
            vec![ChannelMap::parse(&text, "x.toml").expect("a map")]
        };
        let raw = read(&path, or_shipped(&map(""))).expect("read");
        assert_eq!([raw.tracks[0].values[0], raw.tracks[1].values[0]], [-33.5, -70.5]);
        assert!(raw.warnings.is_empty(), "the letters are read: {:?}", raw.warnings);
        let raw = read(&path, or_shipped(&map("sign = -1\n"))).expect("read");
        assert_eq!(raw.tracks[1].values[0], -70.5, "not turned twice");
    }
}
