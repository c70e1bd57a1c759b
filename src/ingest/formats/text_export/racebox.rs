//! CSV exports of RaceBox (Mini, Mini S, Micro, Pro) from its app and its web site.
//!
//! ```text
//! Format,RaceBox CSV            a block of `key,value`, which may be missing
//! Date UTC,2026-08-10T17:16:45+00:00
//! Lap 1, 33.821, sectors, ...
//!
//! Record,Time,Latitude,Longitude,Altitude,Speed,GForceX,GForceY,GForceZ,Lap,GyroX,GyroY,GyroZ
//! 1,2026-08-10T17:16:45.040Z,50.51,13.62,240.1,36.1,0.12,-0.03,1.01,0,0.4,-0.9,-0.3
//! ```
//!
//! Which columns there are depends on the preset of the export; some write units after the names. Without them `Speed`
//! is in whatever the rider chose and the file does not say it: the unit is found from the positions. `Altitude`
//! may be in feet, which nothing in the file tells: without a unit after its name it has none.

use super::facts::{Facts, HeaderKeys, wall_clock};
use super::rows;
use crate::contract::rejection::RejectionCode;
use crate::contract::warning::Warning;
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::csv::table::{self, Table};
use crate::ingest::formats::csv::{clocks, start_time, text};
use crate::ingest::formats::format::{Format, Head};
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::maps::units;
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::ingest::motion::track;
use crate::ingest::warning::warning;
use crate::store::objects::Location;

#[derive(Debug)]
pub(crate) struct RaceBox;

/// First names of the row of names.
const BEGIN: [&str; 2] = ["Record", "Time"];

/// The header's block tells no vehicle and no rider.
const KEYS: HeaderKeys =
    HeaderKeys { vehicle: "", driver: &[], venue: "Track", start: &[], rate: "" };

/// Stamps from here on count from 1970, s.
const EPOCH: f64 = 1e9;

impl Format for RaceBox {
    const NAME: &'static str = "racebox";
    const DESCRIPTION: &'static str = "CSV exports of RaceBox";
    const CHANNEL_NAMES: &'static str = "column";
    const EXTENSIONS: &'static [&'static str] = &["csv"];
    const MAPS: &'static [ShippedMap] = &[shipped_map!("racebox")];

    fn sniff(head: &Head<'_>) -> bool {
        let Some(text) = text::beginning(head.bytes) else { return false };
        let mut lines = text.lines().map(|line| line.trim().replace('"', ""));
        let names = |line: &String| {
            let cells: Vec<&str> = line.split(',').map(|c| units::of_name(c).0).collect();
            ["Time", "Latitude", "Longitude", "GForceX", "Lap"].iter().all(|n| cells.contains(n))
        };
        lines.next().is_some_and(|l| l.starts_with("Format,RaceBox") || names(&l))
    }

    fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
        let log_rows = Rows::open(log)?;
        let mut warnings = log_rows.warnings.clone();
        let mut facts = Facts::of_cells(&log_rows.table.above);
        let mut meta = facts.meta(&KEYS);
        let told = facts.get("Date UTC").and_then(|d| d.parse::<jiff::Timestamp>().ok());
        meta.start_time = told.map(|t| t.to_string());
        let first = log_rows.time.first().copied().filter(|t| *t > EPOCH);
        if let (None, Some(first)) = (&meta.start_time, first) {
            meta.start_time = start_time(first);
            if let Some(start) = meta.start_time.as_ref().filter(|_| !log_rows.zone) {
                warnings.push(wall_clock(start));
            }
        }
        let speed = log_rows.speed_unit();
        let bare = log_rows.table.names.iter().any(|name| name == "Speed");
        match speed {
            _ if !bare => {}
            Some((unit, ratio)) => facts.0.push((
                "unit of `Speed`".to_owned(),
                format!("{unit}: it is {ratio:.3} times the speed of the positions in m/s"),
            )),
            None => {
                let message = "the file does not give the unit of `Speed`, and its positions do \
                               not show it (too little riding, or none of m/s, km/h and mph); give \
                               it with `unit` in a map"
                    .to_owned();
                warnings.push(warning("speed_unit", None, 1, None, message));
            }
        }
        let channel = |(place, name): (usize, &String)| SourceChannel {
            name: name.clone(),
            unit: unit_of(name, speed.map(|s| s.0)).map(str::to_owned),
            samples: Some(log_rows.time.len() as u64),
            place: [place, 0, 0],
            ..SourceChannel::default()
        };
        let named = log_rows.table.names.iter().enumerate();
        let named = named.filter(|(_, name)| !name.is_empty() && *name != "Time");
        Ok(Listing {
            channels: named.map(channel).collect(),
            meta,
            facts: facts.0,
            warnings,
            ..Listing::default()
        })
    }

    fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        let mut read = Rows::open(log)?;
        let columns: Vec<(String, Vec<f64>)> = wanted
            .iter()
            .map(|c| (c.full(), std::mem::take(&mut read.columns[c.place[0]])))
            .collect();
        let columns = clocks::separate(read.time, columns, |_, _| false);
        Ok(Decoded { columns, ..Decoded::default() })
    }
}

/// The rows of a log as columns.
struct Rows {
    table: Table,
    time: Vec<f64>,
    /// In the order of the names.
    columns: Vec<Vec<f64>>,
    /// Whether the stamps tell their time zone.
    zone: bool,
    warnings: Vec<Warning>,
}

impl Rows {
    fn open(log: &Location) -> Result<Self, Error> {
        let mut table = table::open(log, &BEGIN, 0)?;
        let Some(clock) = table.names.iter().position(|name| name == "Time") else {
            let message =
                format!("{log} has no column `Time`; export it from RaceBox again, with time");
            return Err(Error::new(RejectionCode::NoTime, message));
        };
        let names = table.names.clone();
        let wanted: Vec<(&str, usize)> =
            names.iter().enumerate().map(|(place, name)| (name.as_str(), place)).collect();
        let zone = has_zone(&mut table::open(log, &BEGIN, 0)?, clock);
        let read = rows(log, &mut table, &wanted, Some(clock), usize::MAX)?;
        let (mut columns, mut warnings) = (read.columns, read.warnings);
        let time = columns[clock].clone();
        let lost = without_fix(&names, &mut columns);
        if lost > 0 {
            let message = format!(
                "{lost} rows have no position (0, 0): the receiver had no fix; position and speed are taken as missing"
            );
            warnings.push(warning("no_fix", None, lost, None, message));
        }
        Ok(Rows { table, time, columns, zone, warnings })
    }

    /// The unit of `Speed` by the positions, and how many times the speed in m/s it is.
    fn speed_unit(&self) -> Option<(&'static str, f64)> {
        let column = |name: &str| {
            let place = self.table.names.iter().position(|n| n == name)?;
            Some(self.columns[place].as_slice())
        };
        let position = [column("Latitude")?, column("Longitude")?];
        let ratio = track::ratio(&self.time, position, column("Speed")?)?;
        let known = [("m/s", 1.0), ("km/h", 3.6), ("mph", 1.0 / 0.44704)];
        let near = known.into_iter().find(|(_, factor)| (ratio / factor - 1.0).abs() < 0.06);
        near.map(|(unit, _)| (unit, ratio))
    }
}

/// Whether the first stamp says how far its clock is from UTC.
fn has_zone(table: &mut Table, clock: usize) -> bool {
    let first = table.rows.byte_records().next().and_then(Result::ok);
    let cell =
        first.and_then(|row| row.get(clock).map(|c| String::from_utf8_lossy(c).into_owned()));
    cell.is_some_and(|cell| {
        cell.split_once('T').is_some_and(|(_, time)| time.contains(['Z', 'z', '+', '-']))
    })
}

/// Takes positions and speeds out where the receiver had no fix; how many rows those are.
fn without_fix(names: &[String], columns: &mut [Vec<f64>]) -> usize {
    let place = |wanted: &str| names.iter().position(|n| units::of_name(n).0 == wanted);
    let (Some(north), Some(east)) = (place("Latitude"), place("Longitude")) else { return 0 };
    let speed = ["Speed", "KPH", "MPH"].into_iter().find_map(place);
    let lost: Vec<usize> = (0..columns[north].len())
        .filter(|&i| columns[north][i] == 0.0 && columns[east][i] == 0.0)
        .collect();
    for place in [Some(north), Some(east), speed].into_iter().flatten() {
        lost.iter().for_each(|&i| columns[place][i] = f64::NAN);
    }
    lost.len()
}

/// The unit of a column: after its name, or what the box measures in.
fn unit_of<'a>(name: &'a str, speed: Option<&'a str>) -> Option<&'a str> {
    match units::of_name(name) {
        (_, Some(unit)) => Some(unit),
        (base, None) => match base {
            "Speed" => speed,
            "KPH" => Some("km/h"),
            "MPH" => Some("mph"),
            "Latitude" | "Longitude" | "Heading" | "LeanAngle" => Some("deg"),
            "GForceX" | "GForceY" | "GForceZ" | "X" | "Y" | "Z" => Some("g"),
            "GyroX" | "GyroY" | "GyroZ" => Some("deg/s"),
            _ => None,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_behind_the_names_or_the_boxs_own() {
        for (name, unit) in [
            ("Speed", Some("km/h")),
            ("Speed (m/s)", Some("m/s")),
            ("GForceX (g)", Some("g")),
            ("GForceY", Some("g")),
            ("GyroZ (deg/s)", Some("deg/s")),
            ("KPH", Some("km/h")),
            ("Altitude", None),
            ("Altitude (m)", Some("m")),
            ("Lap", None),
        ] {
            assert_eq!(unit_of(name, Some("km/h")), unit, "{name}");
        }
    }
}
