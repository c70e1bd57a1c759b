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

use std::path::Path;
use std::sync::{Arc, OnceLock};

use serde::Deserialize;

use crate::contract::channel::Channel;
use crate::contract::schema;
use crate::contract::session::Meta;
use crate::ingest::foreign::Aids;
use crate::ingest::units::{self, Conversion};
use crate::ingest::{Error, Track, session_table};

mod form;

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
    /// What is used where neither the log nor its path says it.
    pub meta: Meta,
    /// The clock.
    pub time: TimeSource,
    /// Whether the source's velocity is along the Euler yaw.
    pub euler_yaw: bool,
    /// Whether entries whose columns are not in the log are left out instead of an error.
    pub optional: bool,
    /// What feeds which channel, in schema order.
    pub entries: Vec<Entry>,
    /// Paths of CAN databases, as the map has them: relative to its own file.
    pub dbc: Vec<String>,
    /// What is needed beside a log to understand it.
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
        /// Its name.
        name: String,
        /// Seconds per unit of the column.
        factor: f64,
        /// Whether it counts from 1970 (UTC) and so also tells the start time.
        epoch: bool,
    },
    /// No column: one row every `1 / rate` seconds.
    Rate(f64),
    /// The format brings its own clocks.
    Own,
}

/// What feeds one channel.
#[derive(Debug, Clone)]
pub struct Entry {
    /// The channel.
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
    /// Turns of the source per turn of the wheel.
    pub ratio: Option<f64>,
    /// How late the source's stamps are, s; they are shifted earlier by it.
    pub delay: f64,
    /// All of the above in one: `value = x * factor + offset`.
    pub to_si: Conversion,
}

/// A column of a source as decoded, before any map.
#[derive(Debug, Clone)]
pub struct Column {
    /// Its name in the source.
    pub name: String,
    /// Its stamps, s.
    pub time: Arc<Vec<f64>>,
    /// Its numbers, NaN where there is none.
    pub values: Vec<f64>,
}

impl ChannelMap {
    /// Reads and checks several maps.
    ///
    /// # Errors
    /// As [`ChannelMap::read`], for the first that cannot be read.
    pub fn read_all(paths: &[std::path::PathBuf]) -> Result<Vec<Self>, String> {
        paths.iter().map(|path| Self::read(path)).collect()
    }

    /// Reads and checks a map.
    ///
    /// # Errors
    /// A sentence that names the file and the key.
    pub fn read(path: &Path) -> Result<Self, String> {
        Self::parse(&Self::text_of(path)?, &path.display().to_string())
    }

    /// A map file's text with the CAN databases that it names in it (as `dbc_text`): all that
    /// the map means, wherever it is read.
    ///
    /// # Errors
    /// A sentence that names the file.
    pub fn text_of(path: &Path) -> Result<String, String> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path)
            .map_err(|e| format!("cannot read channel map {name}: {e}"))?;
        let map = Self::parse(&text, &name)?;
        if map.dbc.is_empty() {
            return Ok(text);
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let texts = map
            .dbc
            .iter()
            .map(|file| read_dbc(&folder.join(file)).map(toml::Value::String))
            .collect::<Result<Vec<_>, String>>()
            .map_err(|e| format!("channel map {name}: {e}"))?;
        // in front, where it belongs to no table
        Ok(format!("dbc_text = {}\n{text}", toml::Value::Array(texts)))
    }

    /// Checks a map's text; `name` is for messages.
    ///
    /// # Errors
    /// A sentence that names the file and the key.
    pub fn parse(text: &str, name: &str) -> Result<Self, String> {
        form::parse(text, name)
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
                        "mixed_clocks",
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
    pub(super) fn missing(&self, name: &str, there: &[String]) -> Error {
        let near = schema::nearest(name, there.iter().map(String::as_str));
        let near = near.map(|near| format!(" (did you mean `{near}`?)")).unwrap_or_default();
        let message = format!(
            "column `{name}`, which channel map {} reads, is not in the log{near}; correct the \
             map's `from` or take the entry out",
            self.name
        );
        Error::new("missing_column", message)
    }
}

impl Entry {
    /// The conversion of a source's numbers in `unit`, all in one.
    ///
    /// # Errors
    /// The unit is unknown or of another dimension.
    pub fn converted(&self, unit: &str) -> Result<Conversion, String> {
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
    pub(super) fn convert(&mut self) -> Result<(), String> {
        self.to_si = self.converted(&self.unit)?;
        Ok(())
    }
}

/// The contract's unit of a channel.
fn si_unit(channel: Channel) -> &'static str {
    session_table().column(channel.name()).and_then(|c| c.unit.as_deref()).unwrap_or("1")
}

/// The text of a CAN database. Old ones are not UTF-8; their names and numbers are plain ASCII.
///
/// # Errors
/// A sentence that names the file.
pub fn read_dbc(path: &Path) -> Result<String, String> {
    let bytes =
        std::fs::read(path).map_err(|e| format!("cannot read DBC {}: {e}", path.display()))?;
    Ok(match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(e) => e.into_bytes().into_iter().map(char::from).collect(),
    })
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

macro_rules! ship {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../pipelines/maps/", $name, ".toml")))),*]
    };
}

/// Name and text of the maps that come with the program.
pub const SHIPPED: &[(&str, &str)] = ship!(
    "session_csv",
    "session_mdf",
    "session_mcap",
    "session_can",
    "indy_av21_car",
    "tudelft_bicycle",
    "kiro",
    "motec_ld",
    "motec_csv",
    "aim_csv",
    "racechrono_v3",
    "racechrono_v2",
    "xsens_mt_manager",
    "ytrac_ctrk",
);

/// The maps that come with the program.
///
/// # Panics
/// If one is broken: they are the program's own, and a test loads them all.
pub fn shipped() -> &'static [ChannelMap] {
    static MAPS: OnceLock<Vec<ChannelMap>> = OnceLock::new();
    MAPS.get_or_init(|| {
        let parse = |(name, text): &(&str, &str)| {
            ChannelMap::parse(text, &format!("pipelines/maps/{name}.toml"))
                .unwrap_or_else(|e| panic!("{e}"))
        };
        SHIPPED.iter().map(parse).collect()
    })
}

/// Maps that bring these aids instead of their own, if any are given; of none, the shipped ones.
pub fn with_aids(maps: Vec<ChannelMap>, aids: &Aids) -> Vec<ChannelMap> {
    if *aids == Aids::default() {
        return maps;
    }
    let mut maps = if maps.is_empty() { shipped().to_vec() } else { maps };
    maps.iter_mut().for_each(|map| map.aids = aids.clone());
    maps
}

/// The maps of one format among those given, or among the shipped ones if none are given.
pub(super) fn of_format<'a>(maps: &'a [ChannelMap], format: &str) -> Vec<&'a ChannelMap> {
    let maps: &'a [ChannelMap] = if maps.is_empty() { shipped() } else { maps };
    maps.iter().filter(|m| m.format == format).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: &str = "name = 'm'\nformat = 'csv'\n[time]\ncolumn = 't'\nunit = 'ms'\n";

    fn parse(more: &str) -> Result<ChannelMap, String> {
        ChannelMap::parse(&format!("{BASE}{more}"), "m.toml")
    }

    fn column(name: &str, time: &Arc<Vec<f64>>, values: &[f64]) -> Column {
        Column { name: name.into(), time: Arc::clone(time), values: values.to_vec() }
    }

    #[test]
    fn the_shipped_maps_load() {
        let names: Vec<&str> = SHIPPED.iter().map(|(n, _)| *n).collect();
        let loaded: Vec<&str> = shipped().iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, loaded);
    }

    #[test]
    fn unit_sign_offset_scale_radius_ratio_and_mean() {
        let map = parse(
            "[channel.wheel_speed_front]\nfrom = ['l', 'r']\nunit = 'km/h'\nradius = 0.3\n\
             [channel.wheel_speed_rear]\nfrom = 'rpm'\nunit = 'rpm'\nratio = 5\n\
             [channel.roll]\nfrom = 'lean'\nunit = 'deg'\nsign = -1\noffset = 2\nscale = 0.1\n\
             delay = 0.5\n",
        )
        .expect("a map");
        assert_eq!(map.needed(), ["t", "lean", "l", "r", "rpm"]);
        let time = Arc::new(vec![1.0, 2.0]);
        let columns = [
            column("l", &time, &[35.0, f64::NAN]),
            column("r", &time, &[37.0, 37.0]),
            column("rpm", &time, &[3000.0, 0.0]),
            column("lean", &time, &[280.0, -20.0]),
        ];
        let tracks = map.apply(columns.to_vec()).expect("all there");
        let of = |c| tracks.iter().find(|t| t.channel == c).expect("mapped");
        let front = of(Channel::WheelSpeedFront);
        assert!((front.values[0] - 10.0 / 0.3).abs() < 1e-12 && front.values[1].is_nan());
        let rear = of(Channel::WheelSpeedRear);
        assert!((rear.values[0] - 600.0 * std::f64::consts::PI / 30.0).abs() < 1e-9);
        let roll = of(Channel::Roll);
        assert!((roll.values[0] + 30_f64.to_radians()).abs() < 1e-12);
        assert!(roll.values[1].abs() < 1e-12);
        assert_eq!(*roll.time, [0.5, 1.5]);
        assert!(Arc::ptr_eq(&front.time, &rear.time));
    }

    #[test]
    fn every_mistake_is_named() {
        let cases = [
            ("[channel.rol]\nfrom = 'x'\n", "did you mean `roll`"),
            ("[channel.roll]\nfrom = 'x'\nunit = 'furlong'\n", "unknown unit `furlong`"),
            ("[channel.roll]\nfrom = 'x'\nunit = 'm/s'\n", "not angle"),
            ("[channel.roll]\nfrom = 'x'\nsigne = 1\n", "signe"),
            ("[channel.roll]\nfrom = 'x'\nsign = 2\n", "`sign` = 2"),
            ("[channel.roll]\nfrom = 'x'\nratio = 2\n", "`ratio`"),
            ("[channel.roll]\nfrom = 3\n", "`from`"),
            ("[cvs]\n", "cvs"),
        ];
        for (text, wanted) in cases {
            let message = parse(text).expect_err(text);
            assert!(message.contains(wanted) && message.contains("m.toml"), "{message}");
        }
        let message = ChannelMap::parse("name='m'\nformat='xls'\nchannel={}", "m").expect_err("x");
        assert!(message.contains("`xls`") && message.contains("csv"), "{message}");
    }
}
