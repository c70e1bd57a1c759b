//! Channel maps: which channel of a source feeds which column of `session.v1`.
//!
//! One small TOML file per source; `schemas/channel_map.v1.toml` describes every key. The
//! value of a column is
//!
//! ```text
//! sign * SI(scale * x + offset) / (radius * ratio)
//! ```
//!
//! where `x` is the source's number (the mean of several columns if several are given) and
//! `SI` converts from `unit`. `radius` turns a wheel's surface speed into spin, `ratio` a
//! motor's spin into the wheel's.

use std::sync::Arc;

use serde::Deserialize;

use crate::contract::channel::Channel;
use crate::contract::key_error::KeyError;
use crate::contract::rejection::RejectionCode;
use crate::contract::schema;
use crate::contract::session::Meta;
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::maps::units::Conversion;
use crate::ingest::raw::{Column, Imu, Track};
use crate::ingest::session_schema::si_unit;

pub(crate) mod bind;
pub(crate) mod file;
pub(crate) mod propose;
pub(crate) mod units;

/// A checked channel map.
#[derive(Debug, Clone)]
pub struct ChannelMap {
    /// Its name, unique among maps.
    pub name: String,
    /// Name of the reader it belongs to: `csv`, `parquet`, `mdf4`, ...
    pub format: String,
    /// How the text is laid out, for `csv`.
    pub csv: CsvLayout,
    /// Source columns that must be there for the map to be chosen by itself.
    pub detect: Vec<String>,
    /// Metadata for what neither the log nor its path gives.
    pub meta: Meta,
    /// Clock of the log: a column with its unit, or a rate.
    pub time: TimeSource,
    /// Whether the source's velocity is along the Euler yaw.
    pub euler_yaw: bool,
    /// Known properties of an inertial unit that is fixed to the frame.
    pub imu: Imu,
    /// Whether entries whose columns are not in the log are left out instead of an error.
    pub optional: bool,
    /// Sources of the channels, in schema order.
    pub entries: Vec<Entry>,
    /// Paths of CAN databases, as the map has them: relative to its own file.
    pub dbc: Vec<String>,
    /// Files that are needed to read the log, such as a DBC.
    pub aids: Aids,
    /// The file's text: part of what a result was made from.
    pub text: String,
}

/// Layout of a delimited text file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CsvLayout {
    /// Between cells.
    pub delimiter: char,
    /// `.` or `,`.
    pub decimal: char,
    /// In front of the header line, taken off.
    pub header_prefix: String,
    /// Lines before the header.
    pub skip_rows: usize,
    /// Lines between header and data (units, say).
    pub rows_after_header: usize,
    /// Which of them holds the units, from 1; 0 if none does.
    pub units_row: usize,
    /// Cells that mean "no sample", besides empty ones and `nan`.
    pub missing: Vec<String>,
}

impl Default for CsvLayout {
    fn default() -> Self {
        CsvLayout {
            delimiter: ',',
            decimal: '.',
            header_prefix: "#".into(),
            skip_rows: 0,
            rows_after_header: 0,
            units_row: 0,
            missing: Vec::new(),
        }
    }
}

/// Where the stamps come from.
#[derive(Debug, Clone)]
pub enum TimeSource {
    /// A column of the source.
    Column {
        /// The column's name in the source.
        name: String,
        /// Seconds per unit of the column.
        factor: f64,
        /// Whether it counts from 1970 (UTC) and so also gives the start time.
        epoch: bool,
    },
    /// No column: one row every `1 / rate` seconds.
    Rate(f64),
    /// The format brings its own clocks.
    Own,
}

/// Source of one channel.
#[derive(Debug, Clone)]
pub struct Entry {
    pub channel: Channel,
    /// Source columns; more than one are averaged.
    pub from: Vec<String>,
    /// Names to look for where that is not in the log, the first first.
    pub or: Vec<String>,
    /// Unit of the source, after `scale` and `offset`; the contract's if the map gives none.
    pub unit: String,
    /// Whether the map gives it.
    pub unit_given: bool,
    /// A unit that the log itself gives wrongly.
    pub file_unit: Option<String>,
    /// Factor on the source's number.
    pub scale: f64,
    /// Added after `scale`, in the source's unit.
    pub offset: f64,
    /// 1 or -1, last of all.
    pub sign: f64,
    /// Wheel radius that turns surface speed into spin, m.
    pub radius: Option<f64>,
    /// Its standard deviation where the source does not say it, m.
    pub radius_sd: Option<f64>,
    /// Turns of the source per turn of the wheel.
    pub ratio: Option<f64>,
    /// How late the source's stamps are, s; they are shifted earlier by it.
    pub delay: f64,
    /// All of the above in one: `value = x * factor + offset`.
    pub to_si: Conversion,
}

impl ChannelMap {
    /// How far the scales of the wheel speeds, front and rear, may be off: a share, one standard deviation.
    pub fn wheel_scale_sd(&self) -> [f64; 2] {
        [Channel::WheelSpeedFront, Channel::WheelSpeedRear].map(|wheel| {
            let entry = self.entries.iter().find(|e| e.channel == wheel);
            let share = entry.and_then(|e| Some(e.radius_sd? / e.radius?));
            share.unwrap_or(0.0)
        })
    }

    /// Whether a source with these columns is what the map was written for.
    pub fn detects(&self, columns: &[String]) -> bool {
        !self.detect.is_empty() && self.detect.iter().all(|d| columns.contains(d))
    }

    /// The map for a log with these columns: if it is `optional`, without the entries that
    /// read others.
    pub fn fitted(&self, columns: &[String]) -> ChannelMap {
        let mut map = self.clone();
        for entry in &mut map.entries {
            if entry.from.iter().any(|name| !columns.contains(name))
                && let Some(other) = entry.or.iter().find(|name| columns.contains(name))
            {
                entry.from = vec![other.clone()];
            }
        }
        if map.optional {
            map.entries.retain(|e| e.from.iter().all(|name| columns.contains(name)));
        }
        map
    }

    /// The source columns that the map reads, each once, the time column first.
    pub fn needed(&self) -> Vec<&str> {
        let time = match &self.time {
            TimeSource::Column { name, .. } => Some(name.as_str()),
            _ => None,
        };
        let mut needed: Vec<&str> = time.into_iter().collect();
        for name in self.entries.iter().flat_map(|e| &e.from) {
            if !needed.contains(&name.as_str()) {
                needed.push(name);
            }
        }
        needed
    }

    /// Source columns to tracks. Every column that [`Self::needed`] names must be there.
    ///
    /// # Errors
    /// `missing_column`.
    pub fn apply(&self, mut columns: Vec<Column>) -> Result<Vec<Track>, Error> {
        let mut clocks = Vec::new();
        let mut tracks = Vec::with_capacity(self.entries.len());
        for (i, entry) in self.entries.iter().enumerate() {
            let place = |name: &String| {
                columns.iter().position(|c| &c.name == name).ok_or_else(|| {
                    let names: Vec<String> = columns.iter().map(|c| c.name.clone()).collect();
                    self.missing(name, &names)
                })
            };
            let sources: Vec<usize> = entry.from.iter().map(place).collect::<Result<_, Error>>()?;
            let Some((&first, others)) = sources.split_first() else { continue };
            let time = Arc::clone(&columns[first].time);
            let mut later = self.entries[i + 1..].iter().flat_map(|e| &e.from);
            let needed = others.contains(&first) || later.any(|n| *n == columns[first].name);
            let mut values = match needed {
                true => columns[first].values.clone(),
                false => std::mem::take(&mut columns[first].values),
            };
            for source in others.iter().map(|other| &columns[*other]) {
                if !Arc::ptr_eq(&source.time, &time) {
                    return Err(Error::new(
                        RejectionCode::MixedClocks,
                        format!(
                            "channel map {}: {} is the mean of columns with different clocks",
                            self.name, entry.channel
                        ),
                    ));
                }
                values.iter_mut().zip(&source.values).for_each(|(a, b)| *a += b);
            }
            let Conversion { factor, offset } = entry.to_si;
            let factor = factor / sources.len() as f64;
            if (factor, offset) != (1.0, 0.0) {
                values.iter_mut().for_each(|x| *x = *x * factor + offset);
            }
            tracks.push(Track {
                channel: entry.channel,
                time: shifted(&time, entry.delay, &mut clocks),
                values,
            });
        }
        Ok(tracks)
    }

    /// The error for a source column that is not among those that are there.
    pub(crate) fn missing(&self, name: &str, there: &[String]) -> Error {
        let near = schema::nearest(name, there.iter().map(String::as_str));
        let near = near.map(|near| format!(" (did you mean `{near}`?)")).unwrap_or_default();
        let message = format!(
            "column `{name}`, which channel map {} reads, is not in the log{near}; correct the \
             map's `from` or remove the entry",
            self.name
        );
        Error::new(RejectionCode::MissingColumn, message)
    }
}

impl Entry {
    /// The conversion of a source's numbers in `unit`, all in one.
    ///
    /// # Errors
    /// The unit is unknown or of another dimension.
    pub fn converted(&self, unit: &str) -> Result<Conversion, KeyError> {
        let si = si_unit(self.channel);
        // a surface speed in m/s over the radius is the spin in rad/s
        let target = if self.radius.is_some() { "m/s" } else { si };
        let divisor = self.radius.unwrap_or(1.0) * self.ratio.unwrap_or(1.0);
        let Conversion { factor, offset } = units::conversion(unit, target)?;
        Ok(Conversion {
            factor: self.sign * factor * self.scale / divisor,
            offset: self.sign * (factor * self.offset + offset) / divisor,
        })
    }

    /// Sets `to_si` from everything else.
    pub(crate) fn convert(&mut self) -> Result<(), KeyError> {
        self.to_si = self.converted(&self.unit)?;
        Ok(())
    }
}

/// A clock that was shifted.
struct Shifted {
    source: Arc<Vec<f64>>,
    delay: f64,
    made: Arc<Vec<f64>>,
}

/// The clock, `delay` earlier; equal ones stay shared.
fn shifted(time: &Arc<Vec<f64>>, delay: f64, known: &mut Vec<Shifted>) -> Arc<Vec<f64>> {
    if delay == 0.0 {
        return Arc::clone(time);
    }
    if let Some(k) = known.iter().find(|k| Arc::ptr_eq(&k.source, time) && k.delay == delay) {
        return Arc::clone(&k.made);
    }
    let made = Arc::new(time.iter().map(|t| t - delay).collect::<Vec<f64>>());
    known.push(Shifted { source: Arc::clone(time), delay, made: Arc::clone(&made) });
    made
}

/// Name and text of a channel map that comes with the program.
pub(crate) type ShippedMap = (&'static str, &'static str);

/// A map of `pipelines/maps/` by its name.
macro_rules! shipped_map {
    ($name:literal) => {
        (
            $name,
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/pipelines/maps/", $name, ".toml")),
        )
    };
}
pub(crate) use shipped_map;

/// The channel maps to choose from.
#[derive(Debug, Clone, Copy)]
pub struct Maps<'a> {
    /// The maps, in order of preference.
    pub list: &'a [ChannelMap],
    /// Whether the user gave them; else they are those that come with the program.
    pub given: bool,
}

impl<'a> Maps<'a> {
    /// The maps of one format.
    pub fn of_format(self, format: &str) -> Vec<&'a ChannelMap> {
        self.list.iter().filter(|m| m.format == format).collect()
    }
}
