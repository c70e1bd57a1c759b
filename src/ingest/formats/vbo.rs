//! Racelogic VBOX `.vbo` texts, which many lap timers write too: sections in square brackets, then rows between spaces.
//!
//! ```text
//! File created on 01/07/2026 at 09:00:00
//! [header]            titles, some with a unit at the end: "velocity kmh", "Long accel g"
//! [channel units]     units of further channels
//! [column names]      sats time lat long velocity heading height ...
//! [data]              011 090000.10 +03119.099730 -00058.492770 082.140 321.85 +0152.58 ...
//! ```
//!
//! `time` is the time of day (UTC) as hhmmss.ss, `lat` and `long` are minutes of arc, of which **west is positive**
//! (Racelogic, "VBO file format"). Here both are degrees, north and east positive, and of `sats` the flags for brake
//! trigger and differential correction are taken off.

use std::sync::Arc;

use crate::contract::session::Meta;
use crate::contract::warning::Warning;
use crate::ingest::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::format::{Format, Head};
use crate::ingest::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::map::{ShippedMap, shipped_map};
use crate::ingest::raw::Column;
use crate::ingest::units::dimension;
use crate::ingest::warning::warning;
use crate::objects::{Location, source};

/// A VBOX text.
#[derive(Debug)]
pub struct Vbo;

/// Bits of `sats` that count satellites; above them are flags.
const SATELLITES: u32 = 0x3f;
const DAY: f64 = 86_400.0;

impl Format for Vbo {
    const NAME: &'static str = "vbo";
    const DESCRIPTION: &'static str = "Racelogic VBOX and lap timers that write `.vbo`";
    const CHANNEL_NAMES: &'static str = "column";
    const EXTENSIONS: &'static [&'static str] = &["vbo"];
    const MAPS: &'static [ShippedMap] = &[shipped_map!("vbo")];

    fn sniff(head: &Head<'_>) -> bool {
        let text = String::from_utf8_lossy(head.bytes).to_lowercase();
        let section = |name: &str| text.lines().any(|line| line.trim() == name);
        section("[column names]") || head.has_extension("vbo") && section("[header]")
    }

    fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
        let text = text(log)?;
        let file = File::of(log, &text)?;
        let table = file.table(log)?;
        let channel = |(name, unit): (&&str, &Option<String>)| SourceChannel {
            name: (*name).to_owned(),
            unit: unit.clone(),
            samples: Some(table.time.len() as u64),
            ..SourceChannel::default()
        };
        let known = file.names.iter().zip(&file.units).filter(|(name, _)| **name != "time");
        Ok(Listing {
            channels: known.map(channel).collect(),
            meta: Meta { start_time: file.start(&table.time), ..Meta::default() },
            facts: file.comments.clone(),
            warnings: table.warnings(),
            layout: String::new(),
        })
    }

    fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        let text = text(log)?;
        let file = File::of(log, &text)?;
        let table = file.table(log)?;
        let time = Arc::new(table.time.clone());
        let column = |c: &&SourceChannel| {
            let place = file.names.iter().position(|name| *name == c.name)?;
            let values = table.columns[place].clone();
            Some(Column { name: c.full(), time: Arc::clone(&time), values })
        };
        Ok(Decoded { columns: wanted.iter().filter_map(column).collect(), warnings: Vec::new() })
    }
}

/// Old ones are not UTF-8; their names and numbers are plain ASCII.
fn text(log: &Location) -> Result<String, Error> {
    let bytes = source::read(log).map_err(|e| Error::unreadable(log, &e))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// The sections of a text.
struct File<'a> {
    /// Day, month, year of "File created on".
    created: Option<(i8, i8, i16)>,
    comments: Vec<(String, String)>,
    names: Vec<&'a str>,
    units: Vec<Option<String>>,
    rows: Vec<&'a str>,
}

/// Rows as columns, in the order of the names.
struct Rows {
    /// Seconds of the day of the first row; beyond midnight it goes on.
    time: Vec<f64>,
    columns: Vec<Vec<f64>>,
    broken: usize,
}

impl<'a> File<'a> {
    fn of(log: &Location, text: &'a str) -> Result<Self, Error> {
        let (mut titles, mut further, mut names, mut rows) = (vec![], vec![], vec![], vec![]);
        let (mut created, mut comments) = (None, Vec::new());
        let mut section = String::new();
        for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
            if let Some(name) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
                section = name.to_lowercase();
                continue;
            }
            match section.as_str() {
                "" => created = created.or_else(|| date(line)),
                "header" => titles.push(line),
                "channel units" => further.extend(line.split_whitespace()),
                "column names" => names.extend(line.split_whitespace()),
                "data" => rows.push(line),
                "comments" => comments.push(fact(line)),
                _ => {}
            }
        }
        let time = names.contains(&"time");
        if names.is_empty() || !time {
            let message = format!(
                "{log} has no section [column names] with `time`: it is cut off, or no VBOX text"
            );
            return Err(Error::new("no_channels", message));
        }
        let units = units(&names, &titles, &further);
        Ok(File { created, comments, names, units, rows })
    }

    fn table(&self, log: &Location) -> Result<Rows, Error> {
        let at = |name: &str| self.names.iter().position(|n| *n == name);
        let (clock, count) = (at("time"), self.names.len());
        let mut table = Rows { time: Vec::new(), columns: vec![Vec::new(); count], broken: 0 };
        let mut days = 0.0;
        for row in &self.rows {
            let cells: Vec<&str> = row.split_whitespace().collect();
            let Some(time) = clock.and_then(|k| cells.get(k)).and_then(|text| of_day(text)) else {
                table.broken += 1;
                continue;
            };
            table.broken += usize::from(cells.len() != count);
            if table.time.last().is_some_and(|last| last - (time + days) > 0.5 * DAY) {
                days += DAY;
            }
            table.time.push(time + days);
            for (k, column) in table.columns.iter_mut().enumerate() {
                // a decimal comma is written by programs of some countries
                let number = |text: &&str| text.replace(',', ".").parse().ok();
                column.push(cells.get(k).and_then(number).unwrap_or(f64::NAN));
            }
        }
        if table.time.is_empty() {
            let message = format!("{log} has no row with a time of day in its section [data]");
            return Err(Error::new("no_samples", message));
        }
        let each = |name: &str, f: &dyn Fn(f64) -> f64, table: &mut Rows| {
            if let Some(k) = at(name) {
                table.columns[k].iter_mut().for_each(|x| *x = f(*x));
            }
        };
        each("lat", &|minutes| minutes / 60.0, &mut table);
        each("long", &|minutes| -minutes / 60.0, &mut table);
        each(
            "sats",
            &|x| if x >= 0.0 { f64::from(x as u32 & SATELLITES) } else { f64::NAN },
            &mut table,
        );
        Ok(table)
    }

    /// The day on which it was created at the first row's time of day.
    fn start(&self, time: &[f64]) -> Option<String> {
        let (day, month, year) = self.created?;
        let date = jiff::civil::Date::new(year, month, day).ok()?;
        let midnight = date.to_zoned(jiff::tz::TimeZone::UTC).ok()?.timestamp();
        let ms = midnight.as_millisecond() + (1e3 * time.first()?).round() as i64;
        jiff::Timestamp::from_millisecond(ms).ok().map(|t| t.to_string())
    }
}

impl Rows {
    fn warnings(&self) -> Vec<Warning> {
        if self.broken == 0 {
            return Vec::new();
        }
        let message = format!(
            "{} rows of [data] have cells too few or too many, or no time of day; what is missing is taken as such",
            self.broken
        );
        vec![warning("bad_line", None, self.broken, None, message)]
    }
}

/// Unit of each column: of the usual ones the format's own, else what a title ends with, else those of
/// [channel units], which are for the last columns.
fn units(names: &[&str], titles: &[&str], further: &[&str]) -> Vec<Option<String>> {
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
    let usual = |name: &str| match name {
        "lat" | "long" | "heading" => Some("deg".to_owned()),
        "height" => Some("m".to_owned()),
        "velocity" => Some(speed("velocity").unwrap_or_else(|| "km/h".to_owned())),
        "vert-vel" | "vertvel" => Some(speed("vertical").unwrap_or_else(|| "km/h".to_owned())),
        _ => None,
    };
    let first_further = names.len().saturating_sub(further.len());
    names
        .iter()
        .enumerate()
        .map(|(k, name)| {
            let own = usual(name).or_else(|| said(titles[k..].first().filter(|_| titled)?));
            own.or_else(|| further.get(k.checked_sub(first_further)?).map(|u| (*u).to_owned()))
        })
        .collect()
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
        009 000000.10 +03119.50000\r\n009 0000xx\r\n";

    fn log() -> Location {
        Location::from(PathBuf::from("lap.vbo"))
    }

    #[test]
    fn rows_become_columns_with_units() {
        let file = File::of(&log(), LOG).expect("a VBOX text");
        let table = file.table(&log()).expect("rows");
        let of = |name: &str| {
            let k = file.names.iter().position(|n| *n == name).expect(name);
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
        assert!(along[2].is_nan(), "the row is cut off");
        assert_eq!(of("Water").1.as_deref(), Some("degC"));
        assert_eq!(table.broken, 2);
        assert_eq!(file.start(&table.time).as_deref(), Some("2006-07-31T23:59:59.9Z"));
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
