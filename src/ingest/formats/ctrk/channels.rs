//! What the records of a `.CTRK` file mean.
//!
//! Identifiers, places and factors are those of the specification (sections 7 to 9). The columns
//! have the names of its authors' own CSV export, so that the two can be laid side by side; three
//! are ours: `gps_course_deg`, and `lean_raw_deg`, the lean before the dead band of 5 degrees and
//! the rounding to whole degrees that the vendor's program puts on it (`lean_deg`,
//! `lean_signed_deg`), and the engine speed `rpm` is not cut to whole turns.

use std::sync::Arc;

use super::records::{Contents, Payload};
use crate::ingest::raw::Column;

/// A channel's name, unit and how a frame's data gives its value; none where it is no sample.
type Field = (&'static str, &'static str, fn(&[u8]) -> Option<f64>);

/// Frames by identifier, their least length and their fields.
#[rustfmt::skip]
const FRAMES: &[(u16, usize, &[Field])] = &[
    (0x0209, 5, &[
        ("rpm", "rpm", |d| Some(be(d, 0) / 2.56)),
        // 7 while the gears change
        ("gear", "1", |d| Some(f64::from(d[4] & 7)).filter(|g| *g < 7.0)),
    ]),
    (0x0215, 8, &[
        ("throttle", "%", |d| Some(be(d, 0) / 8.192 * 100.0 / 84.96)),
        ("throttle_grip", "%", |d| Some(be(d, 2) / 8.192 * 100.0 / 84.96)),
        ("launch", "1", |d| Some(f64::from(u8::from(d[6] & 0x60 != 0)))),
        ("tcs", "1", |d| bit(d, 7, 5)),
        ("scs", "1", |d| bit(d, 7, 4)),
        ("lif", "1", |d| bit(d, 7, 3)),
    ]),
    (0x023e, 4, &[
        ("water_temp", "degC", |d| Some(f64::from(d[0]) / 1.6 - 30.0)),
        ("intake_temp", "degC", |d| Some(f64::from(d[1]) / 1.6 - 30.0)),
        ("fuel_cc", "cc", |d| Some(be(d, 2) / 100.0)),
    ]),
    (0x0250, 4, &[
        ("acc_x_g", "g", |d| Some(be(d, 0) / 1000.0 - 7.0)),
        ("acc_y_g", "g", |d| Some(be(d, 2) / 1000.0 - 7.0)),
    ]),
    (0x0258, 8, &[
        ("lean_deg", "deg", |d| Some(shown(lean(d)).abs())),
        ("lean_signed_deg", "deg", |d| Some(shown(lean(d)))),
        ("lean_raw_deg", "deg", |d| Some(f64::from(lean(d)) / 100.0 - 90.0)),
        ("pitch_deg_s", "deg/s", |d| Some(be(d, 6) / 100.0 - 300.0)),
    ]),
    (0x0260, 4, &[
        ("front_brake_bar", "bar", |d| Some(be(d, 0) / 32.0)),
        ("rear_brake_bar", "bar", |d| Some(be(d, 2) / 32.0)),
    ]),
    (0x0264, 4, &[
        ("front_speed_kmh", "km/h", |d| Some(be(d, 0) / 64.0 * 3.6)),
        ("rear_speed_kmh", "km/h", |d| Some(be(d, 2) / 64.0 * 3.6)),
    ]),
    (0x0268, 5, &[
        ("f_abs", "1", |d| bit(d, 4, 1)),
        ("r_abs", "1", |d| bit(d, 4, 0)),
    ]),
];

/// Channels of the GPS.
const GPS: [(&str, &str); 4] = [
    ("latitude", "deg"),
    ("longitude", "deg"),
    ("gps_speed_kmh", "km/h"),
    ("gps_course_deg", "deg"),
];

/// A counter: each frame holds the increment since the last one.
const COUNTED: &str = "fuel_cc";

/// All columns with their units, each on the clock of its frames, from the first record on.
pub(super) fn columns(contents: &Contents<'_>) -> Vec<(Column, &'static str)> {
    let Some(start) = contents.records.first().map(|r| r.stamp) else { return Vec::new() };
    let seconds = |stamp: i64| (stamp - start) as f64 * 1e-3;
    let mut out = Vec::new();
    let mut add = |time: Vec<f64>, named: Vec<((&str, &'static str), Vec<f64>)>| {
        let time = Arc::new(time);
        for ((name, unit), values) in named {
            out.push((Column { name: name.into(), time: Arc::clone(&time), values }, unit));
        }
    };
    let fixes = contents.records.iter().filter_map(|r| match r.payload {
        Payload::Gps(sentence) => Fix::of(sentence).map(|fix| (seconds(r.stamp), fix)),
        _ => None,
    });
    let (times, fixes): (Vec<f64>, Vec<Fix>) = fixes.unzip();
    if !times.is_empty() {
        let values = |k: usize| fixes.iter().map(|f| f.values[k]).collect();
        add(times, GPS.iter().enumerate().map(|(k, g)| (*g, values(k))).collect());
    }
    for &(identifier, least, fields) in FRAMES {
        let frames = contents.records.iter().filter_map(|r| match r.payload {
            Payload::Can(id, data) if id == identifier && data.len() >= least => {
                Some((seconds(r.stamp), data))
            }
            _ => None,
        });
        let (times, frames): (Vec<f64>, Vec<&[u8]>) = frames.unzip();
        if times.is_empty() {
            continue;
        }
        let values = |&(name, unit, of): &Field| {
            let mut sum = 0.0;
            let one = |d: &&[u8]| match of(d) {
                Some(x) if name == COUNTED => {
                    sum += x;
                    sum
                }
                Some(x) => x,
                None => f64::NAN,
            };
            ((name, unit), frames.iter().map(one).collect())
        };
        add(times, fields.iter().map(values).collect());
    }
    out
}

/// When the logger passed its start line, s since the first record.
pub(super) fn laps(contents: &Contents<'_>) -> Vec<f64> {
    let Some(start) = contents.records.first().map(|r| r.stamp) else { return Vec::new() };
    let laps = contents.records.iter().filter(|r| r.payload == Payload::Lap);
    laps.map(|r| (r.stamp - start) as f64 * 1e-3).collect()
}

/// The first GPS time, as ms since 1970 of the record that everything counts from.
pub(super) fn start_by_gps(contents: &Contents<'_>) -> Option<i64> {
    let start = contents.records.first()?.stamp;
    contents.records.iter().find_map(|r| match r.payload {
        Payload::Gps(sentence) => Some(Fix::of(sentence)?.when? - (r.stamp - start)),
        _ => None,
    })
}

/// Contents of a `$GPRMC` sentence.
struct Fix {
    /// ms since 1970.
    when: Option<i64>,
    /// Latitude, longitude, km/h, course; NaN without a fix.
    values: [f64; 4],
}

impl Fix {
    /// `None` where it is no such sentence or its checksum is wrong.
    fn of(payload: &[u8]) -> Option<Fix> {
        let text = std::str::from_utf8(payload).ok()?.trim_end_matches(['\0', '\r', '\n']);
        let (body, sum) = text.strip_prefix('$')?.rsplit_once('*')?;
        if u8::from_str_radix(sum.get(..2)?, 16).ok()? != body.bytes().fold(0, |a, b| a ^ b) {
            return None;
        }
        let cells: Vec<&str> = body.split(',').collect();
        let ["GPRMC", time, status, latitude, ns, longitude, ew, knots, course, date, ..] =
            cells[..]
        else {
            return None;
        };
        let number = |text: &str| text.parse().unwrap_or(f64::NAN);
        let values = match status {
            "A" => [
                degrees(latitude, 2, ns == "S"),
                degrees(longitude, 3, ew == "W"),
                number(knots) * 1.852,
                number(course),
            ],
            _ => [f64::NAN; 4],
        };
        let when = (status == "A").then(|| moment(date, time)).flatten();
        Some(Fix { when, values })
    }
}

/// `ddmmyy` and `hhmmss.sss` as ms since 1970.
fn moment(date: &str, time: &str) -> Option<i64> {
    let two = |text: &str, at: usize| text.get(at..at + 2)?.parse::<i8>().ok();
    let year = 2000 + i16::from(two(date, 4)?);
    let day = jiff::civil::Date::new(year, two(date, 2)?, two(date, 0)?).ok()?;
    let midnight = day.at(0, 0, 0, 0).to_zoned(jiff::tz::TimeZone::UTC).ok()?;
    let hours = f64::from(two(time, 0)?) * 3600.0 + f64::from(two(time, 2)?) * 60.0;
    let seconds = time.get(4..)?.parse::<f64>().ok().filter(|s| (0.0..62.0).contains(s))?;
    Some(midnight.timestamp().as_millisecond() + ((hours + seconds) * 1e3).round() as i64)
}

/// `ddmm.mmmm` or `dddmm.mmmm` in degrees.
fn degrees(text: &str, digits: usize, negative: bool) -> f64 {
    let whole = text.get(..digits).and_then(|t| t.parse::<u16>().ok());
    let minutes = text.get(digits..).and_then(|t| t.parse::<f64>().ok());
    let (Some(whole), Some(minutes)) = (whole, minutes) else { return f64::NAN };
    let angle = f64::from(whole) + minutes / 60.0;
    if negative { -angle } else { angle }
}

/// Two bytes, the higher one first; the callers' frames are long enough.
fn be(data: &[u8], at: usize) -> f64 {
    f64::from(u16::from_be_bytes([data[at], data[at + 1]]))
}

fn bit(data: &[u8], at: usize, bit: u8) -> Option<f64> {
    Some(f64::from(data[at] >> bit & 1))
}

/// The lean in hundredths of a degree, 9000 upright, from its scattered nibbles.
fn lean(d: &[u8]) -> u16 {
    let high = (u16::from(d[0]) << 4 | u16::from(d[2] & 0x0f)) << 8;
    high.wrapping_add(u16::from(d[1] & 0x0f) << 4 | u16::from(d[3] >> 4))
}

/// The lean as the vendor's program shows it, but with its direction: nothing under 5 degrees,
/// whole degrees above.
fn shown(lean: u16) -> f64 {
    let deviation = f64::from(lean) - 9000.0;
    if deviation.abs() < 500.0 { 0.0 } else { (deviation / 100.0).trunc() }
}

#[cfg(test)]
mod tests {
    use super::super::records::Record;
    use super::*;

    fn values(id: u16, data: &[u8]) -> Vec<(String, f64)> {
        let contents = Contents {
            records: vec![Record { stamp: 0, payload: Payload::Can(id, data) }],
            ..Contents::default()
        };
        columns(&contents).into_iter().map(|(c, _)| (c.name, c.values[0])).collect()
    }

    fn value(id: u16, data: &[u8], name: &str) -> f64 {
        values(id, data).into_iter().find(|v| v.0 == name).expect(name).1
    }

    /// The calibration table of the specification, section 9.
    #[test]
    fn the_published_calibrations() {
        assert_eq!(value(0x0209, &[0x64, 0, 0, 0, 3, 0], "rpm"), 10_000.0);
        assert_eq!(value(0x0209, &[0x64, 0, 0, 0, 3, 0], "gear"), 3.0);
        assert!(value(0x0209, &[0x64, 0, 0, 0, 7, 0], "gear").is_nan(), "changing gears");
        assert_eq!(value(0x023e, &[0xb0, 0x60, 0, 100], "water_temp"), 80.0);
        assert_eq!(value(0x023e, &[0xb0, 0x60, 0, 100], "fuel_cc"), 1.0);
        let level = &[0x1b, 0x58, 0x1f, 0x40, 0, 0, 0, 0];
        assert!(value(0x0250, level, "acc_x_g").abs() < 1e-12);
        assert!((value(0x0250, level, "acc_y_g") - 1.0).abs() < 1e-12);
        assert_eq!(value(0x0260, &[0x01, 0x40, 0, 0xa0], "front_brake_bar"), 10.0);
        assert_eq!(value(0x0260, &[0x01, 0x40, 0, 0xa0], "rear_brake_bar"), 5.0);
        assert_eq!(value(0x0264, &[0x19, 0, 0x18, 0], "front_speed_kmh"), 360.0);
        let all_flags = &[0, 0, 0, 0, 0, 0, 0x60, 0x08];
        let flags: Vec<f64> =
            ["launch", "tcs", "scs", "lif"].iter().map(|n| value(0x0215, all_flags, n)).collect();
        assert_eq!(flags, [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(value(0x0268, &[0, 0, 0, 0, 1, 0], "r_abs"), 1.0);
        assert_eq!(value(0x0268, &[0, 0, 0, 0, 1, 0], "f_abs"), 0.0);
        let full = 8.192 * 84.96;
        assert!(
            (value(0x0215, &(full as u16).to_be_bytes().repeat(4), "throttle") - 100.0).abs() < 0.2
        );
        assert!(values(0x0250, &[0x1b]).is_empty(), "too short");
        assert!(values(0x0999, &[1, 2, 3]).is_empty(), "unknown");
    }

    #[test]
    fn lean_from_its_nibbles() {
        // the specification's tests: 9100, within the dead band; pitch 30000 is none
        let little = &[0x02, 0x08, 0x03, 0xc0, 0, 0, 0x75, 0x30];
        assert_eq!(lean(little), 9100);
        assert_eq!(value(0x0258, little, "lean_deg"), 0.0);
        assert!((value(0x0258, little, "lean_raw_deg") - 1.0).abs() < 1e-12);
        assert_eq!(value(0x0258, little, "pitch_deg_s"), 0.0);
        for (raw, degrees) in
            [(12_000, 30.0), (6_000, -30.0), (9_499, 0.0), (9_599, 5.0), (8_401, -5.0)]
        {
            assert_eq!(shown(raw), degrees, "{raw}");
        }
    }

    #[test]
    fn the_published_sentence() {
        let text = b"$GPRMC,122135.000,A,4757.0410,N,00012.5240,E,5.14,334.60,290725,,,A*65\r\n\0";
        let fix = Fix::of(text).expect("its checksum is right");
        assert!((fix.values[0] - 47.950_683).abs() < 1e-6, "{:?}", fix.values);
        assert!((fix.values[1] - (12.524 / 60.0)).abs() < 1e-9);
        assert!((fix.values[2] - 5.14 * 1.852).abs() < 1e-9);
        let when: jiff::Timestamp = "2025-07-29T12:21:35Z".parse().expect("a time");
        assert_eq!(fix.when, Some(when.as_millisecond()));
        let wrong = String::from_utf8_lossy(text).replace("*65", "*66");
        assert!(Fix::of(wrong.as_bytes()).is_none());
        assert_eq!(moment("290725", "122135.000"), fix.when);
        for odd in ["1221", "12211e300", "1221NaN", "1221-1", "1221é", "12"] {
            assert_eq!(moment("290725", odd), None, "{odd}");
        }
        let body = "GPRMC,122135.000,V,,,,,,,290725,,,N";
        let sum = body.bytes().fold(0, |a, b| a ^ b);
        let fix = Fix::of(format!("${body}*{sum:02X}").as_bytes()).expect("no fix, but a sentence");
        assert!(fix.values.iter().all(|v| v.is_nan()) && fix.when.is_none());
    }
}
