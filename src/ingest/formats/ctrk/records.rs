//! The bytes of a Yamaha Y-Trac `.CTRK` file.
//!
//! By the specification of ctrk-exporter (github.com/tex0l/ctrk-exporter,
//! `docs/CTRK_FORMAT_SPECIFICATION.md`, 2.2), which its authors found from files and from the
//! vendor's library:
//!
//! ```text
//! "HEAD", 48 bytes, then entries: size u32, name length u8, name, value
//! records: kind u16, size u16, ms u16, s, min, h, weekday, day, month u8, year u16, payload
//!   1 CAN: identifier u16, 0 u16, length u8, data (big-endian)    2 GPS: a $GPRMC sentence
//!   5 lap: its time in ms u32, 0 u32; stamped when the logger passed its line
//! {"Attribute": [{"Key": .., "Value": ..}, ..]}
//! ```

use std::collections::BTreeMap;

/// Where the entries of the header begin.
const ENTRIES: usize = 0x34;
/// Bytes of a record before its payload.
const RECORD: usize = 14;
/// Largest record there is.
const LARGEST: usize = 500;

/// One record with its stamp.
#[derive(Debug, PartialEq)]
pub(super) struct Record<'a> {
    /// ms since 1970, UTC as far as the logger's clock was set.
    pub stamp: i64,
    pub payload: Payload<'a>,
}

/// Contents of a record.
#[derive(Debug, PartialEq)]
pub(super) enum Payload<'a> {
    /// A CAN frame's identifier and data.
    Can(u16, &'a [u8]),
    /// A sentence of the GPS.
    Gps(&'a [u8]),
    /// The logger passed its start line.
    Lap,
    Other,
}

/// All that a file holds.
#[derive(Debug, Default)]
pub(super) struct Contents<'a> {
    /// In the file's order.
    pub records: Vec<Record<'a>>,
    /// Key and value of the footer.
    pub footer: BTreeMap<String, String>,
    /// Why reading stopped before the footer, if it did.
    pub broken: Option<String>,
}

/// Whether a file begins as one.
pub(super) fn is(head: &[u8]) -> bool {
    head.starts_with(b"HEAD") && head.len() > ENTRIES
}

/// Splits a file into records.
pub(super) fn split(bytes: &[u8]) -> Contents<'_> {
    let mut at = after_entries(bytes);
    let mut contents = Contents::default();
    let mut clock = Clock::default();
    loop {
        let rest = &bytes[at.min(bytes.len())..];
        if rest.is_empty() || rest.starts_with(b"{") {
            break;
        }
        let stop = |why: String| Some(format!("{why} at byte {at} of {}", bytes.len()));
        if rest.len() < RECORD {
            if rest.iter().any(|b| *b != 0) {
                contents.broken = stop("it breaks off within a record".into());
            }
            break;
        }
        let (kind, size) = (u16_at(rest, 0), usize::from(u16_at(rest, 2)));
        if kind == 0 && size == 0 {
            break;
        }
        if !(1..=5).contains(&kind) || !(RECORD..=LARGEST).contains(&size) {
            contents.broken =
                stop(format!("a record of unknown kind {kind} and {size} bytes stands"));
            break;
        }
        if size > rest.len() {
            contents.broken = stop("it breaks off within a record".into());
            break;
        }
        let payload = &rest[RECORD..size];
        if let Some(stamp) = clock.stamp(&rest[4..RECORD]) {
            let payload = match kind {
                1 if payload.len() >= 5 => Payload::Can(u16_at(payload, 0), &payload[5..]),
                2 => Payload::Gps(payload),
                5 => Payload::Lap,
                _ => Payload::Other,
            };
            contents.records.push(Record { stamp, payload });
        }
        at += size;
    }
    contents.footer = footer(bytes);
    contents
}

/// Where the records begin: after the last entry that can be one.
fn after_entries(bytes: &[u8]) -> usize {
    let mut at = ENTRIES;
    while bytes.len() >= at + 5 {
        let size = u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        let name = u32::from(bytes[at + 4]);
        if !(5..=200).contains(&size) || name < 1 || name > size - 5 {
            break;
        }
        at += size as usize;
    }
    at
}

/// The logger's clock. It is not read in one go: the milliseconds may have begun anew while the
/// second is still the old one.
#[derive(Default)]
struct Clock {
    /// The bytes after the milliseconds, and the milliseconds since 1970 at that second.
    second: Option<([u8; 8], i64)>,
    /// The milliseconds last seen in that second.
    last: u16,
    /// Whether they have begun anew in it.
    wrapped: bool,
}

impl Clock {
    /// ms since 1970 of a record's ten bytes; `None` if they are no time.
    fn stamp(&mut self, bytes: &[u8]) -> Option<i64> {
        let ms = u16_at(bytes, 0);
        let second: [u8; 8] = bytes.get(2..10)?.try_into().ok()?;
        let base = match self.second {
            Some((known, base)) if known == second => {
                self.wrapped |= ms < self.last;
                base
            }
            _ => {
                let base = unix_seconds(&second)? * 1000;
                self.second = Some((second, base));
                self.wrapped = false;
                base
            }
        };
        self.last = ms;
        Some(base + i64::from(ms) + if self.wrapped { 1000 } else { 0 })
    }
}

/// Seconds since 1970 of second, minute, hour, weekday, day, month, year.
fn unix_seconds(b: &[u8; 8]) -> Option<i64> {
    let year = i16::try_from(u16::from_le_bytes([b[6], b[7]])).ok()?;
    let [s, min, h, _, day, month] =
        [b[0], b[1], b[2], b[3], b[4], b[5]].map(|x| i8::try_from(x).unwrap_or(-1));
    let civil = jiff::civil::DateTime::new(year, month, day, h, min, s, 0).ok()?;
    Some(civil.to_zoned(jiff::tz::TimeZone::UTC).ok()?.timestamp().as_second())
}

/// The JSON object at the end, if there is one.
fn footer(bytes: &[u8]) -> BTreeMap<String, String> {
    const BEGIN: &[u8] = b"{\"Attribute\"";
    #[derive(serde::Deserialize)]
    #[serde(rename_all = "PascalCase")]
    struct Footer {
        attribute: Vec<Attribute>,
    }
    #[derive(serde::Deserialize)]
    #[serde(rename_all = "PascalCase")]
    struct Attribute {
        key: String,
        value: String,
    }
    let tail = &bytes[bytes.len().saturating_sub(1 << 16)..];
    let compact: Vec<usize> = (0..tail.len())
        .filter(|&i| tail[i] == b'{')
        .filter(|&i| {
            let mut rest = tail[i..].iter().filter(|b| !b.is_ascii_whitespace());
            BEGIN.iter().all(|b| rest.next() == Some(b))
        })
        .collect();
    let Some(&at) = compact.last() else { return BTreeMap::new() };
    let mut json = serde_json::Deserializer::from_slice(&tail[at..]).into_iter::<Footer>();
    let attributes = json.next().and_then(Result::ok).map(|f| f.attribute).unwrap_or_default();
    attributes.into_iter().map(|a| (a.key, a.value)).collect()
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The specification's example of a record: 2025-07-29 12:21:34.879, CAN 0x0511.
    const CAN: &[u8] = &[
        0x01, 0x00, 0x1b, 0x00, 0x6f, 0x03, 0x22, 0x15, 0x0c, 0x02, 0x1d, 0x07, 0xe9, 0x07, 0x11,
        0x05, 0x00, 0x00, 0x08, 0x55, 0xd1, 0xd0, 0xd1, 0xd0, 0x2c, 0x00, 0x28,
    ];

    fn header() -> Vec<u8> {
        let mut bytes = b"HEAD".to_vec();
        bytes.resize(ENTRIES, 0);
        // the specification's example of an entry
        bytes.extend([0x1f, 0, 0, 0, 0x11]);
        bytes.extend(b"RECORDLINE.P1.LAT(");
        bytes.extend([0xa1, 0xf2, 0xaf, 0xe5, 0x95, 0xf9, 0x47, 0x40]);
        bytes
    }

    #[test]
    fn the_published_examples() {
        let mut bytes = header();
        assert_eq!(after_entries(&bytes), ENTRIES + 0x1f);
        bytes.extend(CAN);
        let contents = split(&bytes);
        let when: jiff::Timestamp = "2025-07-29T12:21:34.879Z".parse().expect("a time");
        let data = &[0x55, 0xd1, 0xd0, 0xd1, 0xd0, 0x2c, 0x00, 0x28][..];
        assert_eq!(
            contents.records,
            [Record { stamp: when.as_millisecond(), payload: Payload::Can(0x0511, data) }]
        );
        assert_eq!(contents.broken, None);
    }

    #[test]
    fn milliseconds_that_begin_anew_before_the_second_does() {
        let mut bytes = header();
        // the specification's edge case: 999 then 8 in the same second, then the next second
        for (ms, second) in [(990_u16, 47_u8), (999, 47), (8, 47), (15, 47), (30, 48)] {
            let mut record = CAN.to_vec();
            record[4..6].copy_from_slice(&ms.to_le_bytes());
            record[6] = second;
            bytes.extend(record);
        }
        let stamps: Vec<i64> = split(&bytes).records.iter().map(|r| r.stamp).collect();
        let since: Vec<i64> = stamps.iter().map(|s| s - stamps[0]).collect();
        assert_eq!(since, [0, 9, 18, 25, 40]);
    }

    #[test]
    fn the_end_is_known_and_damage_is_said() {
        let mut bytes = header();
        bytes.extend(CAN);
        bytes.extend(CAN);
        let whole = bytes.len();
        let footer = br#"{"Attribute": [{"Key": "CircuitName", "Value": "Calder"},
            {"Key": "User", "Value": "R122"}]}"#;
        bytes.extend(footer);
        let contents = split(&bytes);
        assert_eq!((contents.records.len(), &contents.broken), (2, &None));
        assert_eq!(contents.footer["CircuitName"], "Calder");
        // cut within the second record
        let cut = split(&bytes[..whole - 5]);
        assert_eq!(cut.records.len(), 1);
        assert!(cut.broken.expect("said").contains("breaks off"));
        // a record of an unknown kind
        let mut odd = bytes.clone();
        odd[whole - CAN.len()] = 9;
        let contents = split(&odd);
        assert_eq!(contents.records.len(), 1);
        assert!(contents.broken.expect("said").contains("unknown kind 9"));
        assert_eq!(contents.footer["User"], "R122");
        for n in 0..bytes.len() {
            assert!(split(&bytes[..n]).records.len() <= 2);
        }
    }
}
