//! The TOML form of a channel map, checked key by key.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{ChannelMap, CsvLayout, Entry, TimeSource, si_unit};
use crate::contract::channel::Channel;
use crate::contract::schema;
use crate::contract::session::Meta;
use crate::ingest::foreign::Aids;
use crate::ingest::units::{self, Conversion};
use crate::ingest::{READERS, Reader};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    format: String,
    #[serde(default)]
    #[allow(dead_code)] // for people
    description: String,
    #[serde(default)]
    optional: bool,
    #[serde(default)]
    yaw_convention: YawConvention,
    #[serde(default)]
    csv: CsvLayout,
    #[serde(default)]
    dbc: OneOrMore,
    /// Not for people: the databases' texts, once they were read.
    #[serde(default)]
    dbc_text: Vec<String>,
    #[serde(default)]
    detect: FileDetect,
    #[serde(default)]
    meta: FileMeta,
    time: Option<FileTime>,
    channel: BTreeMap<String, FileEntry>,
}

/// A text or a list of texts.
#[derive(Deserialize)]
#[serde(untagged)]
enum OneOrMore {
    One(String),
    More(Vec<String>),
}

impl OneOrMore {
    fn all(self) -> Vec<String> {
        match self {
            OneOrMore::One(text) => vec![text],
            OneOrMore::More(texts) => texts,
        }
    }
}

impl Default for OneOrMore {
    fn default() -> Self {
        OneOrMore::More(Vec::new())
    }
}

#[derive(Deserialize, Default, PartialEq)]
#[serde(rename_all = "snake_case")]
enum YawConvention {
    #[default]
    Trace,
    Euler,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct FileDetect {
    columns: Vec<String>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct FileMeta {
    bike_id: Option<String>,
    tyre_front: Option<String>,
    tyre_rear: Option<String>,
    site: Option<String>,
    rider_id: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileTime {
    column: Option<String>,
    unit: Option<String>,
    rate: Option<f64>,
    #[serde(default)]
    epoch: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileEntry {
    from: toml::Value,
    #[serde(default)]
    or: OneOrMore,
    unit: Option<String>,
    file_unit: Option<String>,
    scale: Option<f64>,
    offset: Option<f64>,
    sign: Option<f64>,
    radius: Option<f64>,
    ratio: Option<f64>,
    delay: Option<f64>,
}

/// Checks a map's text; `name` is for messages.
pub(super) fn parse(text: &str, name: &str) -> Result<ChannelMap, String> {
    let fail = |message: String| format!("channel map {name}: {message}");
    let file: File = toml::from_str(text).map_err(|e| fail(e.to_string()))?;
    let Some(reader) = READERS.iter().find(|r| r.name == file.format) else {
        let formats: Vec<&str> = READERS.iter().map(|r| r.name).collect();
        let message = format!("unknown format `{}`; known are {}", file.format, formats.join(", "));
        return Err(fail(message));
    };
    if !(file.csv.delimiter.is_ascii() && matches!(file.csv.decimal, '.' | ',')) {
        return Err(fail("`csv.delimiter` must be ASCII and `csv.decimal` `.` or `,`".into()));
    }
    if file.csv.units_row > file.csv.rows_after_header {
        return Err(fail("`csv.units_row` must be one of the `csv.rows_after_header`".into()));
    }
    let time = time_source(file.time, reader).map_err(fail)?;
    let mut entries = Vec::new();
    for (column, entry) in file.channel {
        let channel = channel_named(&column).map_err(fail)?;
        let entry =
            entry_of(channel, entry).map_err(|e| fail(format!("[channel.{column}]: {e}")))?;
        entries.push(entry);
    }
    entries.sort_by_key(|e| e.channel);
    let dbc = file.dbc.all();
    Ok(ChannelMap {
        name: file.name,
        format: file.format,
        csv: file.csv,
        detect: file.detect.columns,
        meta: Meta {
            session_id: String::new(),
            bike_id: file.meta.bike_id.unwrap_or_default(),
            start_time: None,
            tyre_front: file.meta.tyre_front,
            tyre_rear: file.meta.tyre_rear,
            site: file.meta.site,
            rider_id: file.meta.rider_id,
        },
        time,
        euler_yaw: file.yaw_convention == YawConvention::Euler,
        optional: file.optional,
        entries,
        aids: Aids { dbc: file.dbc_text, names: dbc.clone() },
        dbc,
        text: text.to_owned(),
    })
}

fn channel_named(column: &str) -> Result<Channel, String> {
    Channel::from_name(column).ok_or_else(|| {
        let names = Channel::ALL.iter().map(|c| c.name());
        match schema::closest(column, names) {
            Some(near) => format!("unknown column `{column}`; did you mean `{near}`?"),
            None => format!("unknown column `{column}`; `roadbench schema session` lists them"),
        }
    })
}

fn time_source(time: Option<FileTime>, reader: &Reader) -> Result<TimeSource, String> {
    let time = match (time, reader.own_clock) {
        (None, true) => return Ok(TimeSource::Own),
        (None, false) => return Err("missing `[time]`; give `column` and `unit`, or `rate`".into()),
        (Some(_), true) => {
            let format = reader.name;
            return Err(format!("a {format} log brings its own clocks; take `[time]` out"));
        }
        (Some(time), false) => time,
    };
    match (time.column, time.rate) {
        (Some(name), None) => {
            let unit = time.unit.as_deref().unwrap_or("s");
            let c = units::conversion(unit, "s").map_err(|e| format!("[time]: {e}"))?;
            Ok(TimeSource::Column { name, factor: c.factor, epoch: time.epoch })
        }
        (None, Some(rate)) if rate > 0.0 && rate.is_finite() => Ok(TimeSource::Rate(rate)),
        (None, Some(rate)) => Err(format!("`time.rate` = {rate} Hz must be positive")),
        _ => Err("`[time]` needs either `column` or `rate`".into()),
    }
}

fn entry_of(channel: Channel, entry: FileEntry) -> Result<Entry, String> {
    let from = match entry.from {
        toml::Value::String(name) => vec![name],
        toml::Value::Array(names) if !names.is_empty() => names
            .into_iter()
            .map(|n| n.as_str().map(str::to_owned).ok_or("`from` must list texts".to_owned()))
            .collect::<Result<Vec<_>, _>>()?,
        _ => return Err("`from` must be a column's name or a list of names".into()),
    };
    let si = si_unit(channel);
    let unit_given = entry.unit.is_some();
    // what is said with a radius is a surface speed
    let usual = if entry.radius.is_some() { "m/s" } else { si };
    let unit = entry.unit.unwrap_or_else(|| usual.to_owned());
    let (sign, delay) = (entry.sign.unwrap_or(1.0), entry.delay.unwrap_or(0.0));
    if sign.abs() != 1.0 {
        return Err(format!("`sign` = {sign} must be 1 or -1"));
    }
    for (key, value) in [("radius", entry.radius), ("ratio", entry.ratio)] {
        let Some(value) = value else { continue };
        if si != "rad/s" || !(value > 0.0 && value.is_finite()) {
            return Err(format!("`{key}` must be positive, and is for wheel speeds only"));
        }
    }
    let (scale, offset) = (entry.scale.unwrap_or(1.0), entry.offset.unwrap_or(0.0));
    if !(scale.is_finite() && scale != 0.0 && offset.is_finite() && delay.is_finite()) {
        return Err("`scale` must not be 0, and every number finite".into());
    }
    let (radius, ratio, file_unit) = (entry.radius, entry.ratio, entry.file_unit);
    let to_si = Conversion::IDENTITY;
    let mut entry = Entry {
        channel,
        from,
        or: entry.or.all(),
        unit,
        unit_given,
        file_unit,
        scale,
        offset,
        sign,
        radius,
        ratio,
        delay,
        to_si,
    };
    entry.convert()?;
    Ok(entry)
}
