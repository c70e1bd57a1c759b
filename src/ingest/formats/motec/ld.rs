//! The bytes of a MoTeC `.ld` file.
//!
//! MoTeC publishes no description; this is what others found out by looking at files (ldparser
//! by gotzl, motec-i2 by A. Bordado), all of it little-endian:
//!
//! ```text
//! header     0x00 64u32   0x08 first channel   0x24 event   0x5e date[16]   0x7e time[16]
//!            0x9e driver[64]   0xde vehicle[64]   0x15e venue[64]
//!            0x5e4 session[64]   0x624 comment[64]
//! event      name[64] session[64] comment[1024]
//! channel    previous u32, next u32, data u32, samples u32, _ u16, kind u16, bytes u16, rate u16,
//!            shift i16, multiplier i16, scale i16, decimals i16, name[32], short name[8], unit[12]
//! ```
//!
//! A sample `x` means `(x / scale / 10^decimals + shift) * multiplier`; sample `i` was taken
//! `i / rate` seconds after the start. The channels are a list: each names the place of the next.

use std::io::{Read, Result, Seek, SeekFrom};

/// Where the header's text ends: as much as must be there.
const HEADER: usize = 0x664;
/// Bytes of a channel's description that are read.
const CHANNEL: usize = 84;
/// Bytes of an event's description.
const EVENT: usize = 1152;
/// More channels than any logger has; a longer list is damage.
const MOST_CHANNELS: usize = 10_000;
/// Samples that are read at a time, bytes.
const BLOCK: usize = 1 << 16;

/// Header and channels of a file.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Log {
    /// Day, as written: day/month/year.
    pub date: String,
    /// Time of day, as written.
    pub time: String,
    pub driver: String,
    /// On what.
    pub vehicle: String,
    pub venue: String,
    /// The channels, in the file's order.
    pub channels: Vec<Channel>,
    /// Faults of the list of channels, one sentence each.
    pub faults: Vec<String>,
}

/// How a sample is stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum SampleType {
    /// Whole number of 2 bytes.
    I16,
    /// Whole number of 4 bytes.
    I32,
    /// Half precision.
    F16,
    /// Single precision.
    F32,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Channel {
    pub name: String,
    /// Its unit, as written.
    pub unit: String,
    /// Samples per second.
    pub rate: u16,
    /// Number of samples by its header.
    pub samples: u32,
    place: u64,
    kind: SampleType,
    factor: f64,
    offset: f64,
}

impl Channel {
    /// Number of the header's samples in a file of that size.
    pub(super) fn there(&self, size: u64) -> u64 {
        let room = size.saturating_sub(self.place) / self.kind.bytes() as u64;
        u64::from(self.samples).min(room)
    }
}

impl SampleType {
    fn bytes(self) -> usize {
        match self {
            SampleType::I16 | SampleType::F16 => 2,
            SampleType::I32 | SampleType::F32 => 4,
        }
    }

    /// 0 is a beacon's, 3 and 5 are whole numbers, 7 is floating point.
    fn of(kind: u16, bytes: u16) -> Option<SampleType> {
        match (kind, bytes) {
            (0 | 3 | 5, 2) => Some(SampleType::I16),
            (0 | 3 | 5, 4) => Some(SampleType::I32),
            (7, 2) => Some(SampleType::F16),
            (7, 4) => Some(SampleType::F32),
            _ => None,
        }
    }
}

/// Whether a file begins as one.
pub(super) fn is(head: &[u8]) -> bool {
    head.starts_with(&[64, 0, 0, 0]) && head.len() >= HEADER
}

/// Header and channels, no samples.
///
/// # Errors
/// The file cannot be read; `None` when it is shorter than a header.
pub(super) fn list(file: &mut (impl Read + Seek), size: u64) -> Result<Option<Log>> {
    if size < HEADER as u64 {
        return Ok(None);
    }
    let mut head = vec![0; HEADER];
    file.seek(SeekFrom::Start(0))?;
    file.read_exact(&mut head)?;
    let mut log = Log {
        date: text(&head[0x5e..0x6e]),
        time: text(&head[0x7e..0x8e]),
        driver: text(&head[0x9e..0xde]),
        vehicle: text(&head[0xde..0x11e]),
        venue: text(&head[0x15e..0x19e]),
        ..Log::default()
    };
    let mut at = u64::from(u32_at(&head, 0x08));
    let mut seen = std::collections::HashSet::new();
    while at != 0 {
        if !seen.insert(at) || seen.len() > MOST_CHANNELS {
            log.faults
                .push("the list of channels runs in a circle; the channels before are read".into());
            break;
        }
        if at + CHANNEL as u64 > size {
            log.faults.push(format!(
                "the list of channels leads beyond the end of the file after {}; is it cut off?",
                log.channels.len()
            ));
            break;
        }
        let mut block = [0; CHANNEL];
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(&mut block)?;
        match channel(&block) {
            Ok(channel) => log.channels.push(channel),
            Err(fault) => log.faults.push(fault),
        }
        at = u64::from(u32_at(&block, 4));
    }
    Ok(Some(log))
}

/// Further entries of the header, for people.
///
/// # Errors
/// The file cannot be read.
pub(super) fn about(file: &mut (impl Read + Seek), size: u64) -> Result<Vec<(String, String)>> {
    let mut head = vec![0; HEADER];
    file.seek(SeekFrom::Start(0))?;
    file.read_exact(&mut head)?;
    let mut said = vec![
        ("device".to_owned(), text(&head[0x4a..0x52])),
        ("session".to_owned(), text(&head[0x5e4..0x624])),
        ("comment".to_owned(), text(&head[0x624..0x664])),
    ];
    let place = u64::from(u32_at(&head, 0x24));
    if place != 0 && place + EVENT as u64 <= size {
        let mut event = [0; EVENT];
        file.seek(SeekFrom::Start(place))?;
        file.read_exact(&mut event)?;
        said.push(("event".to_owned(), text(&event[..64])));
        said.push(("event comment".to_owned(), text(&event[128..])));
    }
    Ok(said)
}

/// A channel of its description; a sentence if it cannot be read.
fn channel(block: &[u8; CHANNEL]) -> std::result::Result<Channel, String> {
    let name = text(&block[32..64]);
    let (number, bytes, rate) = (u16_at(block, 18), u16_at(block, 20), u16_at(block, 22));
    let samples = u32_at(block, 12);
    let Some(kind) = SampleType::of(number, bytes) else {
        return Err(format!(
            "channel `{name}` is of unknown kind {number} with {bytes} bytes a sample; left out"
        ));
    };
    let [shift, multiplier, scale, decimals] = [24, 26, 28, 30].map(|i| u16_at(block, i) as i16);
    if rate == 0 || scale == 0 || !(-30..=30).contains(&decimals) {
        return Err(format!(
            "channel `{name}` says rate {rate} Hz, scale {scale}, {decimals} decimals, which is \
             impossible; the channel is left out"
        ));
    }
    // a multiplier of nought would say nothing: writers leave it out like that
    let multiplier = if multiplier == 0 { 1.0 } else { f64::from(multiplier) };
    Ok(Channel {
        name,
        unit: text(&block[72..84]),
        rate,
        samples,
        place: u64::from(u32_at(block, 8)),
        kind,
        factor: multiplier / (f64::from(scale) * 10_f64.powi(i32::from(decimals))),
        offset: f64::from(shift) * multiplier,
    })
}

/// A channel's samples, as many of the header's number as the file holds.
///
/// # Errors
/// The file cannot be read.
pub(super) fn samples(
    file: &mut (impl Read + Seek),
    size: u64,
    channel: &Channel,
) -> Result<Vec<f64>> {
    let bytes = channel.kind.bytes();
    let mut left = channel.there(size) as usize;
    let mut out = Vec::with_capacity(left);
    file.seek(SeekFrom::Start(channel.place))?;
    let mut block = vec![0; BLOCK];
    while left > 0 {
        let n = left.min(BLOCK / bytes);
        let block = &mut block[..n * bytes];
        file.read_exact(block)?;
        out.extend(block.chunks_exact(bytes).map(|raw| {
            let x = match channel.kind {
                SampleType::I16 => f64::from(i16::from_le_bytes([raw[0], raw[1]])),
                SampleType::I32 => f64::from(i32::from_le_bytes([raw[0], raw[1], raw[2], raw[3]])),
                SampleType::F16 => half(u16::from_le_bytes([raw[0], raw[1]])),
                SampleType::F32 => f64::from(f32::from_le_bytes([raw[0], raw[1], raw[2], raw[3]])),
            };
            x * channel.factor + channel.offset
        }));
        left -= n;
    }
    Ok(out)
}

/// A number of half precision.
fn half(bits: u16) -> f64 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    sign * match exponent {
        0 => fraction * 2_f64.powi(-24),
        0x1f if fraction == 0.0 => f64::INFINITY,
        0x1f => f64::NAN,
        e => (1024.0 + fraction) * 2_f64.powi(e - 25),
    }
}

/// Text up to the first nought; bytes beyond ASCII are Latin-1 (a degree sign, say).
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    let text = match std::str::from_utf8(&bytes[..end]) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes[..end].iter().map(|b| char::from(*b)).collect(),
    };
    text.trim().to_owned()
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

#[cfg(test)]
pub(super) mod tests {
    use std::io::Cursor;

    use super::*;

    /// Name, kind, bytes, shift, multiplier, scale and decimals, samples.
    pub(in crate::ingest::formats::motec) type Made<'a> = (&'a str, u16, u16, [i16; 4], Vec<u8>);

    /// A file with channels of every kind.
    pub(in crate::ingest::formats::motec) fn file(channels: &[Made<'_>]) -> Vec<u8> {
        let mut out = vec![0; HEADER];
        out[0] = 64;
        for (at, text) in
            [(0x5e, "23/11/2005"), (0x7e, "09:53:00"), (0xde, "11A"), (0x15e, "Calder")]
        {
            out[at..at + text.len()].copy_from_slice(text.as_bytes());
        }
        let first = out.len();
        out[8..12].copy_from_slice(&(first as u32).to_le_bytes());
        let size = 124;
        let mut data = first + size * channels.len();
        for (i, (name, kind, bytes, numbers, raw)) in channels.iter().enumerate() {
            let mut block = vec![0; size];
            let next = if i + 1 < channels.len() { first + size * (i + 1) } else { 0 };
            block[4..8].copy_from_slice(&(next as u32).to_le_bytes());
            block[8..12].copy_from_slice(&(data as u32).to_le_bytes());
            let samples = raw.len() as u32 / u32::from(*bytes).max(1);
            block[12..16].copy_from_slice(&samples.to_le_bytes());
            for (at, x) in [(18, *kind), (20, *bytes), (22, 20)] {
                block[at..at + 2].copy_from_slice(&x.to_le_bytes());
            }
            for (k, x) in numbers.iter().enumerate() {
                block[24 + 2 * k..26 + 2 * k].copy_from_slice(&x.to_le_bytes());
            }
            block[32..32 + name.len()].copy_from_slice(name.as_bytes());
            block[72..75].copy_from_slice(b"\xb0C\0");
            out.extend(block);
            data += raw.len();
        }
        channels.iter().for_each(|c| out.extend(&c.4));
        out
    }

    fn read(bytes: &[u8]) -> (Log, Vec<Vec<f64>>) {
        let size = bytes.len() as u64;
        let mut cursor = Cursor::new(bytes);
        let log = list(&mut cursor, size).expect("in memory").expect("a header");
        let values = log
            .channels
            .iter()
            .map(|c| samples(&mut cursor, size, c).expect("in memory"))
            .collect();
        (log, values)
    }

    #[test]
    fn every_kind_with_scale_shift_multiplier_and_decimals() {
        let i16s: Vec<u8> = [350_i16, -1].iter().flat_map(|x| x.to_le_bytes()).collect();
        let f32s: Vec<u8> = [1.5_f32, -0.25].iter().flat_map(|x| x.to_le_bytes()).collect();
        let bytes = file(&[
            ("rpm", 3, 2, [0, 6, 10, -1], i16s.clone()),
            ("shifted", 5, 2, [-40, 1, 1, 1], i16s),
            ("lat", 3, 4, [0, 1, 1, 7], 387_867_788_i32.to_le_bytes().to_vec()),
            ("half", 7, 2, [0, 1, 1, 0], vec![0x00, 0x3c, 0x00, 0xc0]),
            ("single", 7, 4, [0, 0, 1, 0], f32s),
            ("odd", 15, 5, [0, 1, 1, 0], Vec::new()),
        ]);
        let (log, values) = read(&bytes);
        assert_eq!(values[0], [2100.0, -6.0], "350 / 10 * 10 * 6");
        assert_eq!(values[1], [-5.0, -40.1]);
        assert!((values[2][0] - 38.786_778_8).abs() < 1e-12);
        assert_eq!(values[3], [1.0, -2.0]);
        assert_eq!(values[4], [1.5, -0.25], "a multiplier of nought is none");
        assert_eq!(log.faults.len(), 1, "{:?}", log.faults);
        assert!(log.faults[0].contains("`odd`"), "{:?}", log.faults);
        assert_eq!((log.vehicle.as_str(), log.venue.as_str()), ("11A", "Calder"));
        assert_eq!((log.date.as_str(), log.channels[0].unit.as_str()), ("23/11/2005", "°C"));
    }

    #[test]
    fn half_precision_by_the_book() {
        for (bits, x) in [
            (0x0000, 0.0),
            (0x0001, 5.960_464_477_539_063e-8),
            (0x03ff, 6.097_555_160_522_461e-5),
            (0x0400, 6.103_515_625e-5),
            (0x3555, 0.333_251_953_125),
            (0x7bff, 65504.0),
            (0xfc00, f64::NEG_INFINITY),
        ] {
            assert_eq!(half(bits), x, "{bits:#x}");
        }
        assert!(half(0x7e00).is_nan());
    }

    #[test]
    fn lists_that_lie_end() {
        let whole =
            file(&[("a", 3, 2, [0, 1, 1, 0], vec![1, 0]), ("a", 3, 2, [0, 1, 1, 0], vec![2, 0])]);
        let (log, values) = read(&whole);
        assert_eq!([log.channels[0].name.as_str(), log.channels[1].name.as_str()], ["a", "a"]);
        assert_eq!(values, [[1.0], [2.0]]);
        let second = HEADER + 124;
        // a circle
        let mut bytes = whole.clone();
        bytes[second + 4..second + 8].copy_from_slice(&(HEADER as u32).to_le_bytes());
        let (log, _) = read(&bytes);
        assert!(log.channels.len() == 2 && log.faults[0].contains("circle"), "{log:?}");
        // beyond the end
        let mut bytes = whole.clone();
        bytes[second + 4..second + 8].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(read(&bytes).0.faults[0].contains("beyond the end"));
        // more samples than there are, and cut off
        let mut bytes = whole.clone();
        bytes[second + 12..second + 16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(read(&bytes).1[1], [2.0]);
        let (log, values) = read(&whole[..whole.len() - 1]);
        assert!(log.faults.is_empty() && values[1].is_empty());
        for n in 0..whole.len() {
            let size = n as u64;
            let mut cursor = Cursor::new(&whole[..n]);
            let Some(log) = list(&mut cursor, size).expect("in memory") else { continue };
            for channel in &log.channels {
                assert!(samples(&mut cursor, size, channel).expect("in memory").len() <= 1);
            }
        }
    }
}
