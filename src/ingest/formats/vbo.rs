//! Racelogic VBOX `.vbo` texts, which many lap timers write too: sections in square brackets, then rows between spaces.
//!
//! ```text
//! File created on 01/07/2026 at 09:00:00
//! [header]            titles, some with a unit at the end: "velocity kmh", "Long accel g"
//! [channel units]     units of further channels
//! [column names]      sats time lat long velocity heading height ...
//! [laptiming]         Start +00058.49277 +03119.09973 +00058.51000 +03119.09973: the start line, end to end
//! [data]              011 090000.10 +03119.099730 -00058.492770 082.140 321.85 +0152.58 ...
//! ```
//!
//! `time` is the time of day (UTC) as hhmmss.ss, `lat` and `long` are minutes of arc, of which **west is positive**
//! (Racelogic, "VBO file format"). Here both are degrees, north and east positive, and of `sats` the flags for brake
//! trigger and differential correction are taken off.
//!
//! Apps that write such texts differ: in names ([`ROLES`]), in what is between cells, some in degrees with east positive,
//! some without the section of names. What the text does not say is found from speed and heading.

use std::sync::Arc;

use crate::contract::rejection::RejectionCode;
use crate::contract::session::{Markers, Meta};
use crate::contract::warning::Warning;
use crate::ingest::checks::aids::Aids;
use crate::ingest::clock::stamps;
use crate::ingest::clock::stamps::names::folded;
use crate::ingest::error::Error;
use crate::ingest::formats::csv::{cells, text};
use crate::ingest::formats::format::{Format, Head};
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::maps::units::{conversion, dimension};
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::ingest::motion::track;
use crate::ingest::raw::Column;
use crate::ingest::warning::warning;
use crate::store::objects::{Location, source};

#[derive(Debug)]
pub(super) struct Vbo;

/// Bits of `sats` that count satellites; above them are flags.
const SATELLITES: u32 = 0x3f;
const DAY: f64 = 86_400.0;

/// Names of the usual columns, without case, accents and unit; the first is the format's own name.
const ROLES: [&[&str]; 7] = [
    &["time", "utc", "utc time", "time utc", "utctime", "gps time"],
    &["lat", "latitude", "gps latitude", "gps lat"],
    &["long", "lng", "lon", "longitude", "gps longitude", "gps long", "gps lon"],
    &["velocity", "speed", "vel", "gps speed", "gps velocity"],
    &["heading", "course", "bearing", "gps heading"],
    &["height", "altitude", "alt", "gps altitude"],
    &["sats", "satellites", "satcount", "num sats"],
];

/// The format's own name of a usual column.
fn role(name: &str) -> Option<&'static str> {
    let plain = folded(name.split(['(', '[']).next().unwrap_or(name));
    let ends = [
        " kmh", " km h", " kph", " mph", " knots", " kts", " m s", " deg", " degrees", " m",
        " minutes", " min",
    ];
    let bare = ends.iter().find_map(|e| plain.strip_suffix(e)).unwrap_or(&plain);
    ROLES.iter().find(|r| r.contains(&bare) || r.contains(&plain.as_str())).map(|r| r[0])
}

impl Format for Vbo {
    const NAME: &'static str = "vbo";
    const DESCRIPTION: &'static str = "Racelogic VBOX and lap timers that write `.vbo`";
    const CHANNEL_NAMES: &'static str = "column";
    const EXTENSIONS: &'static [&'static str] = &["vbo"];
    const MAPS: &'static [ShippedMap] = &[shipped_map!("vbo")];

    fn sniff(head: &Head<'_>) -> bool {
        let Some(text) = text::beginning(head.bytes) else { return false };
        let text = text.to_lowercase();
        let section = |name: &str| text.lines().any(|line| line.trim() == name);
        let own = head.has_extension("vbo") && (section("[header]") || section("[data]"));
        own || section("[column names]")
    }

    fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
        let text = whole(log)?;
        let file = File::of(log, &text)?;
        let table = file.table(log)?;
        let speed = file.at("velocity");
        let channel = |(place, name): (usize, &String)| SourceChannel {
            name: name.clone(),
            unit: table
                .speed
                .filter(|_| speed == Some(place))
                .map(str::to_owned)
                .or_else(|| file.units[place].clone()),
            samples: Some(table.time.len() as u64),
            place: [place, 0, 0],
            ..SourceChannel::default()
        };
        let listed =
            file.names.iter().enumerate().filter(|(place, _)| Some(*place) != file.at("time"));
        let facts = file.comments.iter().chain(&table.facts).cloned().collect();
        Ok(Listing {
            channels: listed.map(channel).collect(),
            meta: Meta { start_time: file.start(&table.time), ..Meta::default() },
            facts,
            warnings: table.warnings.clone(),
            ..Listing::default()
        })
    }

    fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        let text = whole(log)?;
        let file = File::of(log, &text)?;
        let table = file.table(log)?;
        let time = Arc::new(table.time.clone());
        let column = |c: &&SourceChannel| {
            let values = table.columns.get(c.place[0])?.clone();
            Some(Column { name: c.full(), time: Arc::clone(&time), values })
        };
        let columns = wanted.iter().filter_map(column).collect();
        let (line, warnings) = file.start_line(&table);
        Ok(Decoded { columns, warnings, markers: Markers { times: Vec::new(), line } })
    }
}

/// Old ones are not UTF-8; their names and numbers are plain ASCII.
fn whole(log: &Location) -> Result<String, Error> {
    let bytes = source::read(log).map_err(|e| Error::unreadable(log, &e))?;
    Ok(text::whole(&bytes))
}

/// The sections of a text.
struct File<'a> {
    /// Day, month, year of "File created on".
    created: Option<(i8, i8, i16)>,
    comments: Vec<(String, String)>,
    names: Vec<String>,
    units: Vec<Option<String>>,
    /// The line `Start` of [laptiming].
    start: Option<&'a str>,
    /// With their lines in the file, from 1.
    rows: Vec<(u64, &'a str)>,
}

/// Rows as columns, in the order of the names.
#[derive(Default)]
struct Rows {
    /// Seconds of the day of the first row; beyond midnight it goes on.
    time: Vec<f64>,
    columns: Vec<Vec<f64>>,
    /// The unit of the speed by the positions, where it is not what the header says.
    speed: Option<&'static str>,
    facts: Vec<(String, String)>,
    warnings: Vec<Warning>,
}

/// The cells of a line: between blanks, or where there are none between commas or semicolons.
fn split(line: &str) -> Vec<&str> {
    let cells: Vec<&str> = line.split_whitespace().collect();
    match line.contains(';') || (cells.len() == 1 && line.contains(',')) {
        true => line.split([';', ',']).map(str::trim).collect(),
        false => cells,
    }
}

impl<'a> File<'a> {
    fn of(log: &Location, text: &'a str) -> Result<Self, Error> {
        let (mut titles, mut further, mut names, mut rows) = (vec![], vec![], vec![], vec![]);
        let (mut created, mut comments, mut start) = (None, Vec::new(), None);
        let mut section = String::new();
        let lines = text.lines().enumerate().map(|(i, line)| (i as u64 + 1, line.trim()));
        for (number, line) in lines.filter(|(_, line)| !line.is_empty()) {
            if let Some(name) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
                section = name.trim().to_lowercase().replace(['_', '-'], " ");
                continue;
            }
            match section.as_str() {
                "" => created = created.or_else(|| date(line)),
                "header" => titles.push(line),
                "channel units" => further.extend(split(line)),
                "column names" | "columnnames" => {
                    names.extend(split(line).into_iter().map(str::to_owned))
                }
                "data" => rows.push((number, line)),
                "comments" => comments.push(fact(line)),
                "laptiming" | "lap timing" if line.to_lowercase().starts_with("start") => {
                    start = start.or(Some(line));
                }
                _ => {}
            }
        }
        // the section may be missing: the titles are as many as the cells
        if names.is_empty() && rows.first().is_some_and(|(_, row)| split(row).len() == titles.len())
        {
            names = titles.iter().map(|t| t.replace(' ', "_")).collect();
        }
        while names.last().is_some_and(String::is_empty) {
            names.pop();
        }
        let units = units(&names, &titles, &further);
        let mut file = File { created, comments, names, units, start, rows };
        file.own_names();
        if file.at("time").is_none() {
            let message = format!(
                "{log} has no section [column names] with `time`: it is cut off, or no VBOX text"
            );
            return Err(Error::new(RejectionCode::NoChannels, message));
        }
        Ok(file)
    }

    /// Names with a unit in them, and titles, become the format's own; others stay as maps know them.
    fn own_names(&mut self) {
        for place in 0..self.names.len() {
            let Some(own) = role(&self.names[place]) else { continue };
            let known =
                ROLES.iter().flat_map(|r| *r).any(|n| self.names[place].eq_ignore_ascii_case(n));
            if (!known || own == "long") && !self.names.iter().any(|n| n == own) {
                self.names[place] = own.to_owned();
            }
        }
    }

    /// The place of a usual column, by the format's own name.
    fn at(&self, own: &str) -> Option<usize> {
        let exact = self.names.iter().position(|n| n == own);
        exact.or_else(|| self.names.iter().position(|n| role(n) == Some(own)))
    }

    fn table(&self, log: &Location) -> Result<Rows, Error> {
        let (clock, count) = (self.at("time"), self.names.len());
        let mut table = Rows { columns: vec![Vec::new(); count], ..Rows::default() };
        let mut uneven = cells::Uneven::default();
        let (mut stamps, mut broken, mut short) = (Vec::new(), 0, 0);
        let mut whole: Vec<&str> = Vec::new();
        for (line, row) in &self.rows {
            let cells = split(row);
            // cells are printed in one width: so it is seen that a row breaks off and no cell within it is lost
            let alike = cells.iter().zip(&whole).all(|(a, b)| a.len() == b.len());
            let broken_off = cells.len() < count && !whole.is_empty() && alike;
            if cells.len() != count && !broken_off {
                uneven.note(*line, cells.len(), row);
                continue;
            }
            short += usize::from(broken_off);
            stamps.push(clock.and_then(|k| cells.get(k)).copied().unwrap_or_default());
            for (k, column) in table.columns.iter_mut().enumerate() {
                // a decimal comma is written by programs of some countries
                let number = |cell: &&str| match cell.contains(',') {
                    true => cell.replace(',', ".").parse().ok(),
                    false => cell.parse().ok(),
                };
                column.push(cells.get(k).and_then(number).unwrap_or(f64::NAN));
            }
            if !broken_off {
                whole = cells;
            }
        }
        if short > 0 {
            let message = format!(
                "{short} rows of [data] are incomplete; the cells that lack are taken as missing"
            );
            table.warnings.push(warning("bad_line", None, short, None, message));
        }
        table.warnings.extend(uneven.judged(log, self.rows.len(), count)?);
        table.time = times(&stamps);
        let there: Vec<bool> = table.time.iter().map(|t| t.is_finite()).collect();
        broken += there.iter().filter(|t| !**t).count();
        if broken > 0 {
            for column in table.columns.iter_mut().chain([&mut table.time]) {
                let mut kept = there.iter();
                column.retain(|_| kept.next().is_some_and(|k| *k));
            }
            let message = format!("{broken} rows of [data] have no time of day and are left out");
            table.warnings.push(warning("bad_line", None, broken, None, message));
        }
        if table.time.is_empty() {
            let message = format!("{log} has no row with a time of day in its section [data]");
            return Err(Error::new(RejectionCode::NoSamples, message));
        }
        if let Some(k) = self.at("sats") {
            let count = |x: f64| if x >= 0.0 { f64::from(x as u32 & SATELLITES) } else { f64::NAN };
            table.columns[k].iter_mut().for_each(|x| *x = count(*x));
        }
        self.positions(&mut table);
        Ok(table)
    }

    /// The start line, degrees. Programs write its ends as longitude and latitude or the other way round, in minutes of arc
    /// or degrees, and west or east positive: it is the one that the ride comes past.
    fn start_line(&self, table: &Rows) -> (Option<[[f64; 2]; 2]>, Vec<Warning>) {
        let Some(line) = self.start else { return (None, Vec::new()) };
        let number = |cell: &&str| cell.replace(',', ".").parse().ok();
        let numbers: Vec<f64> = split(line).iter().skip(1).map_while(number).collect();
        let place = |name: &str| self.at(name).and_then(|k| table.columns.get(k));
        let (Some(north), Some(east)) = (place("lat"), place("long")) else {
            return (None, Vec::new());
        };
        if let Some(line) = track::start_line(&numbers, [north, east]) {
            return (Some(line), Vec::new());
        }
        let message = format!(
            "the start line of [laptiming], `{line}`, is not crossed by the ride and is left out; \
             give one with the key laps.line of the pipeline"
        );
        (None, vec![warning("lap_markers", None, 1, None, message)])
    }

    /// Positions in degrees, north and east positive, and the unit of the speed by them.
    fn positions(&self, table: &mut Rows) {
        let (Some(lat), Some(lon)) = (self.at("lat"), self.at("long")) else { return };
        let (mut north, mut east) =
            (std::mem::take(&mut table.columns[lat]), std::mem::take(&mut table.columns[lon]));
        let v = self.at("velocity");
        let si = v
            .and_then(|v| Some(conversion(self.units[v].as_deref()?, "m/s").ok()?.factor))
            .unwrap_or(1.0);
        let speed: Option<Vec<f64>> = v.map(|v| table.columns[v].iter().map(|x| x * si).collect());
        let most =
            |x: &[f64]| x.iter().filter(|x| x.is_finite()).fold(0.0_f64, |m, x| m.max(x.abs()));
        let small = most(&north) <= 90.0 && most(&east) <= 180.0;
        let degrees = small
            && speed.as_ref().is_some_and(|speed| {
                let factor = track::clock_factor(&table.time, [&north, &east], speed);
                factor.is_some_and(|f| (0.2..5.0).contains(&f))
            });
        if degrees {
            table.facts.push((
                "positions".into(),
                "in degrees, as the speed says, not in minutes of arc".into(),
            ));
        } else {
            north.iter_mut().for_each(|x| *x /= 60.0);
            east.iter_mut().for_each(|x| *x /= -60.0);
        }
        let heading = self.at("heading").map(|k| table.columns[k].as_slice());
        if heading.is_some_and(|heading| mirrored(&north, &east, heading)) {
            east.iter_mut().for_each(|x| *x = -*x);
            let way = if degrees { "west" } else { "east" };
            table
                .facts
                .push(("positions".into(), format!("{way} is positive, as the heading says")));
        }
        if let Some(v) = v {
            let ratio = track::ratio(&table.time, [&north, &east], &table.columns[v]);
            let known =
                [("m/s", 1.0), ("km/h", 3.6), ("mph", 1.0 / 0.44704), ("knots", 3600.0 / 1852.0)];
            let near = |factor: f64| ratio.is_some_and(|r| (r / factor - 1.0).abs() < 0.06);
            let found =
                known.into_iter().find(|k| near(k.1)).filter(|k| (k.1 * si - 1.0).abs() > 0.08);
            if let Some((unit, _)) = found {
                let said = self.units[v].as_deref().unwrap_or("");
                let message = format!(
                    "`{}` is in {unit} by its positions, not in {said}; the positions decide",
                    self.names[v]
                );
                table.warnings.push(warning("speed_unit", None, 1, None, message));
                table.speed = Some(unit);
            }
        }
        (table.columns[lat], table.columns[lon]) = (north, east);
    }

    /// The day on which it was created at the first row's time of day.
    fn start(&self, time: &[f64]) -> Option<String> {
        if let Some(unix) = time.first().filter(|t| stamps::unit::in_years(**t)) {
            return jiff::Timestamp::from_millisecond((1e3 * unix).round() as i64)
                .ok()
                .map(|t| t.to_string());
        }
        let (day, month, year) = self.created?;
        let date = jiff::civil::Date::new(year, month, day).ok()?;
        let midnight = date.to_zoned(jiff::tz::TimeZone::UTC).ok()?.timestamp();
        let ms = midnight.as_millisecond() + (1e3 * time.first()?).round() as i64;
        jiff::Timestamp::from_millisecond(ms).ok().map(|t| t.to_string())
    }
}

/// Whether the way goes east where the heading (degrees) says west, and north where it says north.
fn mirrored(north: &[f64], east: &[f64], heading: &[f64]) -> bool {
    let (mut along, mut across) = ([0.0, 0.0], [0.0, 0.0]);
    for i in 1..heading.len() {
        let (n, e) =
            (north[i] - north[i - 1], (east[i] - east[i - 1]) * north[i].to_radians().cos());
        let (sin, cos) = heading[i].to_radians().sin_cos();
        let (a, b) = (n * cos, e * sin);
        // a jump of the position is no way
        if a.is_finite() && b.is_finite() && n.hypot(e) < 0.01 {
            along = [along[0] + a, along[1] + a.abs()];
            across = [across[0] + b, across[1] + b.abs()];
        }
    }
    across[1] > 1e-4 && across[0] < -0.7 * across[1] && along[0] >= -0.7 * along[1]
}

/// Seconds of the day; over midnight they go on. NaN where a text is no time.
fn times(texts: &[&str]) -> Vec<f64> {
    let share =
        |times: &[f64]| times.iter().filter(|t| t.is_finite()).count() * 10 >= times.len() * 9;
    let mut times: Vec<f64> = texts.iter().map(|t| of_day(t).unwrap_or(f64::NAN)).collect();
    if !share(&times) {
        let mut clock = stamps::text::Clock::default();
        let mut other: Vec<f64> = texts.iter().map(|t| clock.read(t).unwrap_or(f64::NAN)).collect();
        clock.finish(&mut other);
        if !share(&other) {
            // seconds of the day, or since 1970
            other = texts.iter().map(|t| t.replace(',', ".").parse().unwrap_or(f64::NAN)).collect();
            let calendar = stamps::unit::calendar_of(&other);
            let known = calendar.is_some() || other.iter().all(|t| !(*t < 0.0 || *t > 2.0 * DAY));
            let factor = calendar.map_or(1.0, |c| c.factor);
            other.iter_mut().for_each(|t| *t = if known { *t * factor } else { f64::NAN });
        }
        if share(&other) {
            return other;
        }
    }
    let (mut days, mut last) = (0.0, f64::NAN);
    for time in times.iter_mut().filter(|t| t.is_finite()) {
        if last - (*time + days) > 0.5 * DAY {
            days += DAY;
        }
        *time += days;
        last = *time;
    }
    times
}

/// Unit of each column: of the usual ones the format's own, else what a title ends with, else those of
/// [channel units], which are for the last columns.
fn units(names: &[String], titles: &[&str], further: &[&str]) -> Vec<Option<String>> {
    let titled = titles.len() == names.len();
    let said = |title: &str| {
        let last = title.rsplit(' ').next()?.trim_matches(['(', ')', '[', ']']);
        dimension(last).filter(|_| title.contains(' ')).map(|_| last.to_owned())
    };
    // titles of speeds are found by their beginning, however many there are
    let speed = |beginning: &str| {
        let title = titles.iter().find(|t| t.to_lowercase().starts_with(beginning))?;
        said(title)
    };
    let usual = |name: &str| match role(name).unwrap_or(name) {
        "lat" | "long" | "heading" => Some("deg".to_owned()),
        "height" => Some("m".to_owned()),
        "velocity" => {
            let of_title = || speed("velocity").or_else(|| speed("speed"));
            Some(of_name(name).or_else(of_title).unwrap_or_else(|| "km/h".to_owned()))
        }
        "vert-vel" | "vertvel" => Some(speed("vertical").unwrap_or_else(|| "km/h".to_owned())),
        _ => None,
    };
    let first_further = names.len().saturating_sub(further.len());
    names
        .iter()
        .enumerate()
        .map(|(k, name)| {
            let name = name.as_str();
            let own = usual(name)
                .or_else(|| of_name(name))
                .or_else(|| said(titles.get(k).filter(|_| titled)?));
            own.or_else(|| further.get(k.checked_sub(first_further)?).map(|u| (*u).to_owned()))
        })
        .collect()
}

/// The unit in a column's own name.
fn of_name(name: &str) -> Option<String> {
    let unit = crate::ingest::maps::units::of_name(name)
        .1
        .or_else(|| crate::ingest::maps::units::behind_name(name));
    unit.map(str::to_owned)
}

/// `File created on 31/07/2006 at 09:55:20`: day, month, year.
fn date(line: &str) -> Option<(i8, i8, i16)> {
    let rest = line.strip_prefix("File created on")?;
    let mut parts = rest.split_whitespace().next()?.split('/');
    let (day, month, year) = (parts.next()?, parts.next()?, parts.next()?);
    Some((day.parse().ok()?, month.parse().ok()?, year.parse().ok()?))
}

/// `Serial Number : 005201`; a line without a colon is a comment.
fn fact(line: &str) -> (String, String) {
    match line.split_once(':') {
        Some((key, value)) => (key.trim().to_owned(), value.trim().to_owned()),
        None => ("comment".to_owned(), line.to_owned()),
    }
}

/// Seconds of the day of hhmmss.ss; leading zeros may be missing.
fn of_day(text: &str) -> Option<f64> {
    let number: f64 =
        text.replace(',', ".").parse().ok().filter(|x| (0.0..=240_000.0).contains(x))?;
    let whole = number.trunc() as u32;
    let (hours, minutes, seconds) = (whole / 10_000, whole / 100 % 100, whole % 100);
    let seconds = f64::from(seconds) + number.fract();
    (minutes < 60 && seconds < 61.0)
        .then(|| 3600.0 * f64::from(hours) + 60.0 * f64::from(minutes) + seconds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    // by the example of Racelogic's description, other numbers
    const LOG: &str = "File created on 31/07/2006 at 23:59:59\r\n\r\n[header]\r\nsatellites\r\ntime\r\n\
        latitude\r\nlongitude\r\nvelocity knots\r\nheading\r\nheight\r\nLong accel g\r\nWater temp\r\n\
        [channel units]\r\ndegC\r\n[comments]\r\n(c) 2001 2003\r\nSerial Number : 005201\r\n[column names]\r\n\
        sats time lat long velocity heading height Longacc Water\r\n[data]\r\n\
        137 235959.90 +03119.50000 +00058.50000 010.000 321.85 +00152.58 +000.250 8.0E+01\r\n\
        009 000000.00 +03119.50000 +00058.50000 010.000 321.85 +00152.58 +000.250 8.0E+01\r\n\
        009 000000.10 +03119.50000 +00058.50000 010.000 321.85 +00152.58 x 8.0E+01\r\n\
        009 0000xx +03119.50000 +00058.50000 010.000 321.85 +00152.58 +000.250 8.0E+01\r\n";

    fn log() -> Location {
        Location::from(PathBuf::from("lap.vbo"))
    }

    #[test]
    fn rows_become_columns_with_units() {
        let file = File::of(&log(), LOG).expect("a VBOX text");
        let table = file.table(&log()).expect("rows");
        let of = |name: &str| {
            let k =
                file.at(name).or_else(|| file.names.iter().position(|n| *n == name)).expect(name);
            (table.columns[k].clone(), file.units[k].clone())
        };
        let seconds: Vec<f64> = table.time.iter().map(|t| t - 86_399.0).collect();
        for (got, right) in seconds.iter().zip([0.9, 1.0, 1.1]) {
            assert!((got - right).abs() < 1e-6, "{got}: over midnight time goes on");
        }
        assert_eq!(of("sats").0, [9.0, 9.0, 9.0], "flags are off");
        assert!((of("lat").0[0] - 51.991_666_67).abs() < 1e-8);
        assert!((of("long").0[0] + 0.975).abs() < 1e-9, "west is positive there, negative here");
        assert_eq!(of("velocity").1.as_deref(), Some("knots"));
        let (along, unit) = of("Longacc");
        assert_eq!((&along[..2], unit.as_deref()), (&[0.25, 0.25][..], Some("g")));
        assert!(along[2].is_nan(), "no number");
        assert_eq!(of("Water").1.as_deref(), Some("degC"));
        assert_eq!((table.warnings.len(), table.warnings[0].count), (1, 1));
        assert_eq!(file.start(&table.time).as_deref(), Some("2006-07-31T23:59:59.9Z"));
    }

    #[test]
    fn the_start_line_is_the_one_that_the_ride_comes_past() {
        let line = |start: &str| {
            let text = LOG.replace(
                "[comments]",
                &format!("[laptiming]\r\n{start}\r\nSplit 1 2 3 4\r\n[comments]"),
            );
            let file = File::of(&log(), &text).expect("a VBOX text");
            file.start_line(&file.table(&log()).expect("rows"))
        };
        let right = [[51.991_666, -0.974_9], [51.991_667, -0.975_1]];
        for start in [
            "Start +00058.49400 +03119.49996 +00058.50600 +03119.50002 \u{ac} Start / Finish",
            "Start 3119.49996 58.49400 3119.50002 58.50600",
            "start -0.9749 51.991666 -0.9751 51.991667",
        ] {
            let (line, warnings) = line(start);
            let line = line.expect(start);
            let off = line.iter().flatten().zip(right.iter().flatten());
            assert!(off.into_iter().all(|(a, b)| (a - b).abs() < 2e-6), "{start}: {line:?}");
            assert!(warnings.is_empty());
        }
        let (none, warnings) = line("Start +00158.49400 +03119.49996 +00158.50600 +03119.50002");
        assert!(none.is_none() && warnings[0].message.contains("not crossed by the ride"));
        assert!(line("Start 1 2").0.is_none());
    }

    #[test]
    fn a_text_without_columns_is_told() {
        let error =
            File::of(&log(), "File created on 1/1/2020\n[header]\ntime\n").err().expect("told");
        assert!(error.to_string().contains("[column names]"), "{error}");
    }

    #[test]
    fn times_of_day() {
        let time = of_day("162235.40").expect("a time");
        assert!((time - (16.0 * 3600.0 + 22.0 * 60.0 + 35.4)).abs() < 1e-6, "{time}");
        assert_eq!(of_day("000000.00"), Some(0.0));
        assert_eq!(of_day("127560.00"), None);
        assert_eq!(of_day("nan"), None);
    }
}
