//! Garmin FIT, as watches, navigation devices, bicycle computers and action cameras of many makers record.
//!
//! ```text
//! header: size u8 | version u8 | profile u16 | bytes of messages u32 | ".FIT" | checksum u16      then messages, then a checksum
//! record:       timestamp, position_lat, position_long, enhanced_altitude, enhanced_speed, heart_rate, ...      1 Hz
//! gps_metadata: timestamp + timestamp_ms, the same and heading, utc_timestamp                                   10 Hz (cameras)
//! lap:          start_time, lap_trigger (manual, position_lap, distance, time, session_end), ...
//! ```
//!
//! `fitparser` reads the messages and knows Garmin's names, scales and units. Every number of the messages in [`READ`] is
//! a channel `message/field`, fields of Connect IQ apps ("developer fields") too. Positions are given in degrees, not in
//! semicircles (2^31 to half a turn). Fields whose meaning Garmin does not publish are left out.
//!
//! `record/lap` is the number of the lap, from 1, where the rider or a line on the track began the laps; its steps are as
//! fine as the device's stamps, 1 s. Laps that the device cuts by way or time are none.

use fitparser::de::{DecodeOption, FitObject, FitStreamProcessor};
use fitparser::profile::MesgNum;
use fitparser::{ErrorKind, FitDataRecord, Value};

use crate::contract::rejection::RejectionCode;
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::csv::start_time;
use crate::ingest::formats::format::{Format, Head, guarded};
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::formats::streams::Streams;
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::store::objects::{Location, source};

#[derive(Debug)]
pub(super) struct Fit;

/// Behind the first eight bytes of a header.
const MAGIC: &[u8] = b".FIT";
/// Degrees of a semicircle.
const SEMICIRCLE: f64 = 180.0 / 2_147_483_648.0;
/// Stamps below this, s since 1970, count from when the device was switched on (2^28 s from its epoch, 1989-12-31).
const OF_A_DATE: f64 = 631_065_600.0 + 268_435_456.0;
/// Messages that are samples.
const READ: [MesgNum; 2] = [MesgNum::Record, MesgNum::GpsMetadata];
/// Triggers of laps that the rider or a line began, and that the end of the recording ended.
const BY_LINE: [&str; 7] = [
    "manual",
    "position_start",
    "position_lap",
    "position_waypoint",
    "position_marked",
    "fitness_equipment",
    "session_end",
];

impl Format for Fit {
    const NAME: &'static str = "fit";
    const DESCRIPTION: &'static str = "Garmin FIT, of watches, navigation devices and cameras";
    const CHANNEL_NAMES: &'static str = "`record/enhanced_speed`";
    const EXTENSIONS: &'static [&'static str] = &["fit"];
    const MAPS: &'static [ShippedMap] = &[shipped_map!("fit")];

    fn sniff(head: &Head<'_>) -> bool {
        head.bytes.get(8..12) == Some(MAGIC)
    }

    fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
        Ok(read(log)?.listing())
    }

    fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        Ok(read(log)?.decoded(wanted))
    }
}

/// Contents of a file.
#[derive(Default)]
struct File {
    streams: Streams,
    /// Start and trigger of each lap.
    laps: Vec<(f64, String)>,
    /// Messages with stamps that are no channels: names and counts.
    others: Vec<(String, usize)>,
    /// `type` of the file.
    kind: Option<String>,
    /// Samples without a time.
    without_time: usize,
    /// From a clock that counts from when the device was switched on to s since 1970.
    to_date: Option<f64>,
    /// Messages that make no sense.
    bad: usize,
    /// Parts whose checksum is wrong.
    bad_sums: usize,
}

fn read(log: &Location) -> Result<Streams, Error> {
    let mut bytes = source::read(log).map_err(|e| Error::unreadable(log, &e))?;
    let unfinished = finish(&mut bytes);
    let mut file = File::default();
    let mut at = 0;
    let end = guarded(log, || file.scan(&bytes, &mut at));
    let mut streams = std::mem::take(&mut file.streams);
    if unfinished {
        let message =
            "the device did not finish the file: its header says that it is empty; read to its end";
        streams.warn("unfinalised", 1, message.to_owned());
    } else if let Err(e) = end {
        let left = bytes.len() - at;
        let message =
            format!("{}; read up to there, {left} bytes after it are left out", e.message);
        streams.warn("truncated", 1, message);
    }
    streams.warn(
        "damaged",
        file.bad_sums,
        "the file's checksum is wrong, so some of its numbers may be wrong too".to_owned(),
    );
    streams.warn(
        "bad_frame",
        file.bad,
        format!("{} messages cannot be decoded and are left out", file.bad),
    );
    let message = format!("{} samples have no time and are left out", file.without_time);
    streams.warn("time_missing", file.without_time, message);
    if streams.is_empty() {
        return Err(Error::new(RejectionCode::NoSamples, no_samples(log, &file, &streams)));
    }
    streams.facts.extend(
        file.others
            .iter()
            .map(|(name, count)| (format!("not read: {name}"), format!("{count} messages"))),
    );
    file.count_laps(&mut streams);
    for stream in &mut streams.all {
        stream.add_speed(["position_lat", "position_long"], &["enhanced_speed", "speed"]);
    }
    file.start(&mut streams);
    Ok(streams)
}

fn no_samples(log: &Location, file: &File, streams: &Streams) -> String {
    let kind = file.kind.as_deref().unwrap_or("unknown");
    let why: Vec<&str> = streams.warnings.iter().map(|w| w.message.as_str()).collect();
    let why = if why.is_empty() { String::new() } else { format!(" ({})", why.join("; ")) };
    format!(
        "{log} is a FIT file of the type `{kind}` without records of a ride{why}; export the recorded activity as FIT"
    )
}

/// A header that says there are no messages is of a file that was never closed: it says what there is then. Whether it
/// was.
fn finish(bytes: &mut [u8]) -> bool {
    let Some(&size) = bytes.first() else { return false };
    let messages = bytes.len().saturating_sub(usize::from(size));
    let is_header = bytes.get(8..12) == Some(MAGIC) && bytes.get(4..8) == Some(&[0; 4]);
    // 2: a file without messages has its checksum
    let (true, Ok(count)) = (is_header && messages > 2, u32::try_from(messages)) else {
        return false;
    };
    bytes[4..8].copy_from_slice(&count.to_le_bytes());
    true
}

impl File {
    /// Reads all messages; `at` is how far it came.
    ///
    /// # Errors
    /// A sentence about the place where it went on no further.
    fn scan(&mut self, bytes: &[u8], at: &mut usize) -> Result<(), String> {
        let mut processor = FitStreamProcessor::new();
        processor.add_option(DecodeOption::SkipHeaderCrcValidation);
        processor.add_option(DecodeOption::DropUnknownFields);
        let mut headers = 0;
        while *at < bytes.len() {
            let rest = &bytes[*at..];
            match processor.deserialize_next(rest) {
                Ok((left, object)) => {
                    *at = bytes.len() - left.len();
                    match object {
                        FitObject::DataMessage(message) => {
                            match processor.decode_message(message) {
                                Ok(record) => self.take(record),
                                Err(_) => self.bad += 1,
                            }
                        }
                        // a file may be several, one after the other
                        FitObject::Crc(_) => processor.reset(),
                        FitObject::Header(_) => headers += 1,
                        FitObject::DefinitionMessage(_) => {}
                    }
                }
                Err(e) => match *e {
                    ErrorKind::InvalidCrc((left, ..)) => {
                        self.bad_sums += 1;
                        *at = bytes.len() - left.len();
                        processor.reset();
                    }
                    ErrorKind::UnexpectedEof(_) => {
                        return Err(format!("the file is cut off at byte {}", *at));
                    }
                    _ if headers == 0 => return Err("the header is damaged".to_owned()),
                    other => {
                        let other = other.to_string();
                        return Err(format!("there is no message at byte {} ({other})", *at));
                    }
                },
            }
        }
        Ok(())
    }

    fn take(&mut self, record: FitDataRecord) {
        let kind = record.kind();
        match kind {
            MesgNum::FileId => self.about(&record),
            MesgNum::Lap => {
                let start = number(&record, "start_time");
                let trigger = text(&record, "lap_trigger").unwrap_or_default();
                self.laps.extend(start.map(|start| (start, trigger)));
            }
            MesgNum::TimestampCorrelation => {
                let [date, own] =
                    ["timestamp", "system_timestamp"].map(|name| number(&record, name));
                self.to_date = self.to_date.or_else(|| Some(date? - own?));
            }
            _ if READ.contains(&kind) => self.sample(&record),
            MesgNum::AccelerometerData | MesgNum::GyroscopeData | MesgNum::BarometerData => {
                let name = kind.to_string();
                match self.others.iter_mut().find(|o| o.0 == name) {
                    Some(other) => other.1 += 1,
                    None => self.others.push((name, 1)),
                }
            }
            _ => {}
        }
    }

    /// The message at a file's beginning.
    fn about(&mut self, record: &FitDataRecord) {
        for (field, fact) in [
            ("manufacturer", "made by"),
            ("garmin_product", "product"),
            ("product_name", "product"),
        ] {
            let value = text(record, field);
            self.streams.facts.extend(value.map(|value| (fact.to_owned(), value)));
        }
        self.kind = self.kind.take().or_else(|| text(record, "type"));
    }

    fn sample(&mut self, record: &FitDataRecord) {
        let Some(time) = number(record, "timestamp") else {
            self.without_time += 1;
            return;
        };
        let ms = number(record, "timestamp_ms").unwrap_or(0.0);
        let stream = self.streams.group(&record.kind().to_string());
        stream.begin(time + 1e-3 * ms);
        let mut seen: Vec<(&str, f64)> = Vec::with_capacity(record.fields().len());
        for field in record.fields() {
            let name = field.name();
            if ["timestamp", "timestamp_ms", "utc_timestamp"].contains(&name) {
                continue;
            }
            let Some(mut value) = of(field.value()) else { continue };
            let mut unit = Some(field.units()).filter(|u| !u.is_empty());
            if unit == Some("semicircles") {
                (value, unit) = (value * SEMICIRCLE, Some("deg"));
            }
            // fields of apps may be called as Garmin's, which come first
            let before = seen.iter().filter(|s| s.0 == name).count();
            if seen.contains(&(name, value)) {
                continue;
            }
            seen.push((name, value));
            match before {
                0 => stream.set(name, unit, value),
                more => stream.set(&format!("{name} #{}", more + 1), unit, value),
            }
        }
    }

    /// When the recording began, if its clock tells a date.
    fn start(&self, streams: &mut Streams) {
        let stamps = streams.all.iter().flat_map(|s| s.time.iter().copied());
        let first = stamps.fold(f64::INFINITY, f64::min);
        let date = if first < OF_A_DATE { self.to_date.map(|by| first + by) } else { Some(first) };
        match date {
            Some(date) => streams.meta.start_time = start_time(date),
            None => {
                let fact = "unknown: the device's clock was not set";
                streams.facts.push(("start".to_owned(), fact.to_owned()));
            }
        }
    }

    /// The number of the lap of each record, if laps were begun by the rider or at a line.
    fn count_laps(&mut self, streams: &mut Streams) {
        self.laps.sort_by(|a, b| a.0.total_cmp(&b.0));
        let others = self.laps.iter().filter(|l| !BY_LINE.contains(&l.1.as_str())).count();
        if others > 0 {
            let fact = format!("{others} of {} by distance or time: not counted", self.laps.len());
            streams.facts.push(("laps".to_owned(), fact));
            return;
        }
        let records = streams.all.iter_mut().find(|s| s.group == MesgNum::Record.to_string());
        // of sessions that ended nobody began a lap
        let begun = self.laps.iter().any(|l| l.1 != "session_end");
        let (Some(records), true) = (records, begun && self.laps.len() > 1) else { return };
        let starts: Vec<f64> = self.laps.iter().map(|l| l.0).collect();
        let lap = |time: &f64| starts.partition_point(|start| start <= time).max(1) as f64;
        let values: Vec<f64> = records.time.iter().map(lap).collect();
        if let Some(last) = values.last() {
            records.set("lap", None, *last);
        }
        if let Some(line) = records.lines.iter_mut().find(|l| l.name == "lap") {
            line.values = values;
        }
    }
}

/// A finite number; `None` of words and lists.
fn of(value: &Value) -> Option<f64> {
    let number: Option<f64> = match value {
        Value::Timestamp(_) | Value::String(_) | Value::Array(_) => None,
        other => other.clone().try_into().ok(),
    };
    number.filter(|x| x.is_finite())
}

/// A field's number, times as s since 1970.
fn number(record: &FitDataRecord, name: &str) -> Option<f64> {
    let field = record.fields().iter().find(|f| f.name() == name)?;
    match field.value() {
        Value::Timestamp(time) => Some(time.timestamp() as f64),
        other => of(other),
    }
}

fn text(record: &FitDataRecord, name: &str) -> Option<String> {
    let field = record.fields().iter().find(|f| f.name() == name)?;
    match field.value() {
        Value::String(text) => Some(text.clone()),
        other => of(other).map(|x| x.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two records of a definition with a timestamp, a position and a speed, by hand from Garmin's description.
    fn bytes() -> Vec<u8> {
        let mut data = vec![
            0x40, 0, 0, 20, 0,
            4, // definition of local message 0: little-endian, record, 4 fields
            253, 4, 0x86, 0, 4, 0x85, 1, 4, 0x85, 73, 4, 0x86,
        ];
        for (time, speed) in [(1_000_000_000_u32, 12_345_u32), (1_000_000_001, u32::MAX)] {
            data.push(0);
            data.extend(time.to_le_bytes());
            data.extend(0x2000_0000_i32.to_le_bytes());
            data.extend((-0x1000_0000_i32).to_le_bytes());
            data.extend(speed.to_le_bytes());
        }
        let mut file = vec![14, 0x20, 0, 0];
        file.extend((data.len() as u32).to_le_bytes());
        file.extend(MAGIC);
        file.extend([0, 0]);
        file.extend(data);
        file
    }

    fn scanned(mut bytes: Vec<u8>) -> (File, Result<(), String>, bool) {
        let unfinished = finish(&mut bytes);
        let (mut file, mut at) = (File::default(), 0);
        let end = file.scan(&bytes, &mut at);
        (file, end, unfinished)
    }

    #[test]
    fn positions_are_degrees_and_an_invalid_number_is_none() {
        let (file, end, unfinished) = scanned(bytes());
        assert!(end.is_ok() && !unfinished && file.bad == 0, "{end:?}");
        let records = &file.streams.all[0];
        assert_eq!(records.group, "record");
        // 631065600 s from 1970 to the epoch of FIT
        assert_eq!(records.time, [1_631_065_600.0, 1_631_065_601.0]);
        assert_eq!(records.get("position_lat"), Some(&[45.0, 45.0][..]));
        assert_eq!(records.get("position_long"), Some(&[-22.5, -22.5][..]));
        let speed = records.get("enhanced_speed").expect("there");
        assert!(speed[0] == 12.345 && speed[1].is_nan(), "{speed:?}");
        let unit = records.lines.iter().find(|l| l.name == "enhanced_speed").expect("there");
        assert_eq!(unit.unit.as_deref(), Some("m/s"));
    }

    #[test]
    fn what_breaks_off_or_was_never_closed_is_read_up_to_there() {
        let mut cut = bytes();
        cut.truncate(cut.len() - 5);
        let (file, end, _) = scanned(cut);
        assert_eq!(file.streams.all[0].time.len(), 1);
        assert!(end.expect_err("cut").contains("is cut off"));
        let mut open = bytes();
        open[4..8].fill(0);
        let (file, end, unfinished) = scanned(open);
        assert!(unfinished && end.is_ok());
        assert_eq!(file.streams.all[0].time.len(), 2);
        let mut wrong = bytes();
        wrong.extend([1, 2]);
        let (file, end, _) = scanned(wrong);
        assert_eq!((file.bad_sums, end), (1, Ok(())));
    }

    #[test]
    fn a_clock_that_was_not_set_gives_no_start() {
        let start = |to_date: Option<f64>| {
            let mut early = bytes();
            for record in [1_000_000_000_u32, 1_000_000_001] {
                let stamp = record.to_le_bytes();
                let at = early.windows(4).position(|w| w == stamp).expect("its stamp");
                early[at..at + 4].copy_from_slice(&(record - 999_999_990).to_le_bytes());
            }
            let (mut file, _, _) = scanned(early);
            file.to_date = to_date;
            let mut streams = std::mem::take(&mut file.streams);
            file.start(&mut streams);
            streams.meta.start_time
        };
        assert_eq!(start(None), None);
        assert_eq!(start(Some(1_000_000_000.0)).as_deref(), Some("2021-09-08T01:46:50Z"));
    }

    #[test]
    fn laps_count_where_the_rider_began_them() {
        let laps = |triggers: [&str; 3]| {
            let (mut file, _, _) = scanned(bytes());
            let start = |i: usize| 1_631_065_600.0 + i as f64;
            file.laps =
                triggers.iter().enumerate().map(|(i, t)| (start(i), (*t).to_owned())).collect();
            let mut streams = std::mem::take(&mut file.streams);
            file.count_laps(&mut streams);
            streams.all[0].get("lap").map(<[f64]>::to_vec)
        };
        assert_eq!(laps(["manual", "position_lap", "session_end"]), Some(vec![1.0, 2.0]));
        assert_eq!(laps(["manual", "distance", "session_end"]), None);
        assert_eq!(laps(["session_end"; 3]), None);
    }
}
