//! Channel maps as TOML files, checked key by key, and those that come with the program.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde::Deserialize;

use crate::contract::channel::Channel;
use crate::contract::file_error::{FileError, FileName};
use crate::contract::file_kind::FileKind;
use crate::contract::key_error::KeyError;
use crate::contract::schema;
use crate::contract::session::Meta;
use crate::ingest::checks::aids::{Aids, read_dbc};
use crate::ingest::formats::FORMATS;
use crate::ingest::formats::format::LogFormat;
use crate::ingest::maps::units;
use crate::ingest::maps::units::Conversion;
use crate::ingest::maps::{ChannelMap, CsvLayout, Entry, Maps, ShippedMap, TimeSource};
use crate::ingest::raw::Imu;
use crate::ingest::session_schema::si_unit;
use crate::store::objects::files::read_text;

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
    imu: Imu,
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
    radius_sd: Option<f64>,
    ratio: Option<f64>,
    delay: Option<f64>,
}

/// Checks a map's text; `name` is for messages.
fn parse(text: &str, name: &str) -> Result<ChannelMap, FileError> {
    let file = FileName::new("channel map", name);
    FileKind::ChannelMap.expect(text).map_err(|e| file.wrong(e))?;
    schema::refuse_infinite_in(text).map_err(|e| file.wrong(e))?;
    let given: File = toml::from_str(text).map_err(|e| file.wrong(e.to_string()))?;
    let Some(log_format) = FORMATS.iter().find(|r| r.name == given.format) else {
        let formats: Vec<&str> = FORMATS.iter().map(|r| r.name).collect();
        let message =
            format!("unknown format `{}`; known are {}", given.format, formats.join(", "));
        return Err(file.wrong(message));
    };
    if !(given.csv.delimiter.is_ascii() && matches!(given.csv.decimal, '.' | ',')) {
        return Err(file.wrong("`csv.delimiter` must be ASCII and `csv.decimal` `.` or `,`"));
    }
    if given.csv.units_row > given.csv.rows_after_header {
        return Err(file.wrong("`csv.units_row` must be one of the `csv.rows_after_header`"));
    }
    let time = time_source(given.time, log_format).map_err(|e| file.wrong(e))?;
    let mut entries = Vec::new();
    for (column, entry) in given.channel {
        let channel = channel_named(&column).map_err(|e| file.wrong(e))?;
        let entry =
            entry_of(channel, entry).map_err(|e| file.wrong(format!("[channel.{column}]: {e}")))?;
        entries.push(entry);
    }
    entries.sort_by_key(|e| e.channel);
    let dbc = given.dbc.all();
    Ok(ChannelMap {
        name: given.name,
        format: given.format,
        csv: given.csv,
        detect: given.detect.columns,
        meta: Meta {
            session_id: String::new(),
            bike_id: given.meta.bike_id.unwrap_or_default(),
            start_time: None,
            tyre_front: given.meta.tyre_front,
            tyre_rear: given.meta.tyre_rear,
            site: given.meta.site,
            rider_id: given.meta.rider_id,
        },
        time,
        euler_yaw: given.yaw_convention == YawConvention::Euler,
        imu: checked_imu(given.imu).map_err(|e| file.wrong(e))?,
        optional: given.optional,
        entries,
        aids: Aids { dbc: given.dbc_text, names: dbc.clone() },
        dbc,
        text: text.to_owned(),
    })
}

fn checked_imu(imu: Imu) -> Result<Imu, KeyError> {
    let far = imu.arm.is_some_and(|arm| arm.iter().any(|x| x.is_nan() || x.abs() > 3.0));
    if far {
        return Err("`imu.arm` must be three lengths of at most 3 m".into());
    }
    if imu.arm_sd.is_some_and(|sd| !(0.0..=1.0).contains(&sd)) {
        return Err("`imu.arm_sd` must be between 0 and 1 m".into());
    }
    if imu.delay.is_some_and(|delay| delay.is_nan() || delay.abs() > 5.0) {
        return Err("`imu.delay` must be within 5 s".into());
    }
    Ok(imu)
}

fn channel_named(column: &str) -> Result<Channel, KeyError> {
    Channel::from_name(column).ok_or_else(|| {
        let names = Channel::ALL.iter().map(|c| c.name());
        match schema::closest(column, names) {
            Some(near) => format!("unknown column `{column}`; did you mean `{near}`?").into(),
            None => {
                format!("unknown column `{column}`; `roadbench schema session` lists them").into()
            }
        }
    })
}

fn time_source(time: Option<FileTime>, log_format: &LogFormat) -> Result<TimeSource, KeyError> {
    let time = match (time, log_format.own_clock) {
        (None, true) => return Ok(TimeSource::Own),
        (None, false) => return Err("missing `[time]`; give `column` and `unit`, or `rate`".into()),
        (Some(_), true) => {
            let format = log_format.name;
            return Err(KeyError::Values(format!(
                "a {format} log has its own clocks; remove `[time]`"
            )));
        }
        (Some(time), false) => time,
    };
    match (time.column, time.rate) {
        (Some(name), None) => {
            let (_, own) = units::of_name(&name);
            let own = own.filter(|unit| units::dimension(unit) == Some("time"));
            let unit = time.unit.as_deref().or(own).unwrap_or("s");
            let c = units::conversion(unit, "s")
                .map_err(|e| KeyError::Values(format!("[time]: {e}")))?;
            Ok(TimeSource::Column { name, factor: c.factor, epoch: time.epoch })
        }
        (None, Some(rate)) if rate > 0.0 && rate.is_finite() => Ok(TimeSource::Rate(rate)),
        (None, Some(rate)) => {
            Err(KeyError::Values(format!("`time.rate` = {rate} Hz must be positive")))
        }
        _ => Err("`[time]` needs either `column` or `rate`".into()),
    }
}

fn entry_of(channel: Channel, entry: FileEntry) -> Result<Entry, KeyError> {
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
        return Err(KeyError::Values(format!("`sign` = {sign} must be 1 or -1")));
    }
    for (key, value) in [("radius", entry.radius), ("ratio", entry.ratio)] {
        let Some(value) = value else { continue };
        if si != "rad/s" || !(value > 0.0 && value.is_finite()) {
            return Err(KeyError::Values(format!(
                "`{key}` must be positive, and is for wheel speeds only"
            )));
        }
    }
    if let Some(sd) = entry.radius_sd
        && (entry.radius.is_none() || !(0.0..=0.1).contains(&sd))
    {
        return Err("`radius_sd` goes with `radius` and is between 0 and 0.1 m".into());
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
        radius_sd: entry.radius_sd,
        ratio,
        delay,
        to_si,
    };
    entry.convert()?;
    Ok(entry)
}

impl ChannelMap {
    /// Reads and checks several maps.
    ///
    /// # Errors
    /// As [`ChannelMap::read`], for the first that cannot be read.
    pub fn read_all(paths: &[PathBuf]) -> Result<Vec<Self>, FileError> {
        paths.iter().map(|path| Self::read(path)).collect()
    }

    /// Reads and checks a map.
    ///
    /// # Errors
    /// Error text that names the file and the key.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(&Self::text_of(path)?, &path.display().to_string())
    }

    /// A map file's text with the CAN databases that it names in it (as `dbc_text`): all that
    /// the map means, wherever it is read.
    ///
    /// # Errors
    /// Error text that names the file.
    pub fn text_of(path: &Path) -> Result<String, FileError> {
        let name = path.display().to_string();
        let text = read_text(path).map_err(|e| FileName::new("channel map", &name).unread(e))?;
        let map = Self::parse(&text, &name)?;
        if map.dbc.is_empty() {
            return Ok(text);
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let texts = map
            .dbc
            .iter()
            .map(|file| read_dbc(&folder.join(file)).map(toml::Value::String))
            .collect::<Result<Vec<_>, FileError>>()
            .map_err(|e| FileName::new("channel map", &name).wrong(e))?;
        // in front, where it belongs to no table
        Ok(format!("dbc_text = {}\n{text}", toml::Value::Array(texts)))
    }

    /// Checks a map's text; `name` is for messages.
    ///
    /// # Errors
    /// Error text that names the file and the key.
    pub fn parse(text: &str, name: &str) -> Result<Self, FileError> {
        parse(text, name)
    }
}

/// Name and text of the maps that come with the program, format by format.
pub(crate) fn shipped_files() -> impl Iterator<Item = &'static ShippedMap> {
    FORMATS.iter().flat_map(|format| format.maps)
}

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
        shipped_files().map(parse).collect()
    })
}

/// The maps to choose from: those that were given, or of none the shipped ones.
pub(crate) fn or_shipped(maps: &[ChannelMap]) -> Maps<'_> {
    match maps {
        [] => Maps { list: shipped(), given: false },
        list => Maps { list, given: true },
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ingest::raw::Column;
    use std::sync::Arc;

    const BASE: &str = "name = 'm'\nformat = 'csv'\n[time]\ncolumn = 't'\nunit = 'ms'\n";

    fn parse(more: &str) -> Result<ChannelMap, String> {
        ChannelMap::parse(&format!("{BASE}{more}"), "m.toml").map_err(String::from)
    }

    fn column(name: &str, time: &Arc<Vec<f64>>, values: &[f64]) -> Column {
        Column { name: name.into(), time: Arc::clone(time), values: values.to_vec() }
    }

    #[test]
    fn the_shipped_maps_load() {
        let names: Vec<&str> = shipped_files().map(|(n, _)| *n).collect();
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
            let message = parse(text).expect_err(text).to_string();
            assert!(message.contains(wanted) && message.contains("m.toml"), "{message}");
        }
        let message = ChannelMap::parse("name='m'\nformat='xls'\nchannel={}", "m")
            .expect_err("x")
            .to_string();
        assert!(message.contains("`xls`") && message.contains("csv"), "{message}");
    }
}
