//! u-blox UBX: the binary messages of u-blox receivers, as u-center, OpenLog and many boxes keep them.
//!
//! ```text
//! 0xb5 0x62 | class u8 | id u8 | bytes of the payload u16 | payload | two sums over all from the class on    little-endian
//! NAV-PVT (1, 7): year.. month.. second | valid | nano | fix | satellites | lon lat 1e-7 deg | hMSL mm | speeds mm/s | heading 1e-5 deg
//! ```
//!
//! One NAV-PVT is one sample; by its own message the speed is the receiver's (Doppler), not a difference of positions. Other
//! messages, and sentences between them, are counted and passed by. Of a receiver without a fix nothing is taken. A log
//! without NAV-PVT, as u-center writes it of a receiver that was never set up, is read by its NMEA sentences ([`nmea`]).
//! (u-blox 8 / u-blox M8 receiver description, UBX-13003221, 32.17.15.)

use std::collections::BTreeMap;

use crate::contract::rejection::RejectionCode;
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::format::{Format, Head};
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::formats::nmea;
use crate::ingest::formats::streams::{Stream, Streams};
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::store::objects::{Location, source};

/// A log of UBX messages.
#[derive(Debug)]
pub(super) struct Ubx;

const SYNC: [u8; 2] = [0xb5, 0x62];
/// Class and number of the message that is read.
const NAV_PVT: (u8, u8) = (1, 7);
/// Bytes of its payload at least; later receivers append to it.
const PVT: usize = 84;
/// Bytes of a message around its payload.
const AROUND: usize = 8;
const DAY: f64 = 86_400.0;

impl Format for Ubx {
    const NAME: &'static str = "ubx";
    const DESCRIPTION: &'static str = "u-blox UBX with NAV-PVT messages";
    const CHANNEL_NAMES: &'static str = "`gSpeed`, `lat`";
    const EXTENSIONS: &'static [&'static str] = &["ubx"];
    const MAPS: &'static [ShippedMap] = &[shipped_map!("ubx")];

    fn sniff(head: &Head<'_>) -> bool {
        let within = || head.bytes.windows(2).any(|w| w == SYNC);
        head.bytes.starts_with(&SYNC) || (head.has_extension("ubx") && within())
    }

    fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
        Ok(read(log)?.listing())
    }

    fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        Ok(read(log)?.decoded(wanted))
    }
}

fn read(log: &Location) -> Result<Streams, Error> {
    let bytes = source::read(log).map_err(|e| Error::unreadable(log, &e))?;
    let file = File::of(&bytes);
    let streams = if file.stream.time.is_empty() {
        let sentences = nmea::within(&bytes);
        sentences.ok_or_else(|| Error::new(RejectionCode::NoSamples, file.nothing(log)))?
    } else {
        let mut streams = file.streams();
        streams.start_by_stamps();
        streams
    };
    Ok(streams)
}

/// Contents of a log.
#[derive(Debug, Default)]
struct File {
    stream: Stream,
    /// Other messages, by class and number.
    others: BTreeMap<(u8, u8), usize>,
    bad_sums: usize,
    without_fix: usize,
    without_time: usize,
    /// Bytes of the last message that are missing.
    cut: bool,
}

impl File {
    fn of(bytes: &[u8]) -> Self {
        let mut file = File::default();
        let mut at = 0;
        while let Some(step) = bytes.get(at..).and_then(|b| b.windows(2).position(|w| w == SYNC)) {
            at += step;
            match message(&bytes[at..]) {
                Message::Right(kind, payload) => {
                    file.take(kind, payload);
                    at += payload.len() + AROUND;
                }
                Message::Wrong => {
                    file.bad_sums += 1;
                    at += SYNC.len();
                }
                // what claims to go on beyond the end may be a damaged length
                Message::Cut => {
                    file.cut = true;
                    at += SYNC.len();
                }
            }
        }
        file
    }

    fn take(&mut self, kind: (u8, u8), payload: &[u8]) {
        if kind != NAV_PVT || payload.len() < PVT {
            *self.others.entry(kind).or_default() += 1;
            return;
        }
        // a message after a broken one: that was no end
        self.cut = false;
        let fix_is_right = (2..=4).contains(&payload[20]) && payload[21] & 1 == 1;
        let time = stamp(payload);
        match (time, fix_is_right) {
            (_, false) => self.without_fix += 1,
            (None, true) => self.without_time += 1,
            (Some(time), true) => {
                let signed = |at: usize| f64::from(i32::from_le_bytes(four(payload, at)));
                let unsigned = |at: usize| f64::from(u32::from_le_bytes(four(payload, at)));
                let stream = &mut self.stream;
                stream.begin(time);
                for (name, unit, value) in [
                    ("lat", "deg", 1e-7 * signed(28)),
                    ("lon", "deg", 1e-7 * signed(24)),
                    ("hMSL", "m", 1e-3 * signed(36)),
                    ("gSpeed", "m/s", 1e-3 * signed(60)),
                    ("velN", "m/s", 1e-3 * signed(48)),
                    ("velE", "m/s", 1e-3 * signed(52)),
                    ("velD", "m/s", 1e-3 * signed(56)),
                    ("headMot", "deg", 1e-5 * signed(64)),
                    ("hAcc", "m", 1e-3 * unsigned(40)),
                    ("vAcc", "m", 1e-3 * unsigned(44)),
                    ("sAcc", "m/s", 1e-3 * unsigned(68)),
                    ("numSV", "", f64::from(payload[23])),
                ] {
                    stream.set(name, Some(unit).filter(|u| !u.is_empty()), value);
                }
            }
        }
    }

    fn streams(self) -> Streams {
        let mut streams = Streams { all: vec![self.stream], ..Streams::default() };
        let message = format!("{} messages have a wrong checksum and are left out", self.bad_sums);
        streams.warn("bad_frame", self.bad_sums, message);
        let message = "the log is cut off within a message; read up to there";
        streams.warn("truncated", usize::from(self.cut), message.to_owned());
        let message = format!("{} samples were written without a fix: left out", self.without_fix);
        streams.warn("no_fix", self.without_fix, message);
        let message = format!("{} samples have no valid time and are left out", self.without_time);
        streams.warn("time_missing", self.without_time, message);
        let others = self.others.iter().map(|((class, id), n)| format!("{class:02x}-{id:02x} {n}"));
        let others: Vec<String> = others.take(40).collect();
        if !others.is_empty() {
            streams.facts.push(("other messages".to_owned(), others.join(", ")));
        }
        streams
    }

    fn nothing(&self, log: &Location) -> String {
        let why = if self.without_fix > 0 {
            format!("the receiver had no fix in all of its {} NAV-PVT messages", self.without_fix)
        } else if self.without_time > 0 {
            format!("none of its {} NAV-PVT messages has a valid time", self.without_time)
        } else {
            let others: usize = self.others.values().sum();
            format!("it has no NAV-PVT message, {others} others and {} damaged", self.bad_sums)
        };
        format!(
            "{log} is a u-blox log without a sample: {why}; have the receiver write NAV-PVT, or convert the log to NMEA \
             (RMC and GGA) with u-center"
        )
    }
}

/// Text after a pair of sync bytes.
enum Message<'a> {
    Right((u8, u8), &'a [u8]),
    Wrong,
    Cut,
}

fn message(bytes: &[u8]) -> Message<'_> {
    let Some(&[low, high]) = bytes.get(4..6) else { return Message::Cut };
    let length = usize::from(u16::from_le_bytes([low, high]));
    let Some(whole) = bytes.get(2..length + AROUND) else { return Message::Cut };
    let (summed, sums) = whole.split_at(length + 4);
    let add = |(a, b): (u8, u8), x: &u8| {
        let a = a.wrapping_add(*x);
        (a, b.wrapping_add(a))
    };
    let (a, b) = summed.iter().fold((0, 0), add);
    if sums != [a, b] {
        return Message::Wrong;
    }
    Message::Right((summed[0], summed[1]), &summed[4..])
}

fn four(payload: &[u8], at: usize) -> [u8; 4] {
    [payload[at], payload[at + 1], payload[at + 2], payload[at + 3]]
}

/// s since 1970; `None` while date or time are not valid.
fn stamp(payload: &[u8]) -> Option<f64> {
    if payload[11] & 3 != 3 {
        return None;
    }
    let year = i16::try_from(u16::from_le_bytes([payload[4], payload[5]])).ok()?;
    let (month, day) = (i8::try_from(payload[6]).ok()?, i8::try_from(payload[7]).ok()?);
    let date = jiff::civil::Date::new(year, month, day).ok()?;
    let midnight = date.to_zoned(jiff::tz::TimeZone::UTC).ok()?.timestamp().as_second() as f64;
    let [hour, minute, second] = [8, 9, 10].map(|at| f64::from(payload[at]));
    let of_day = 3600.0 * hour + 60.0 * minute + second;
    let nano = f64::from(i32::from_le_bytes(four(payload, 16)));
    (of_day <= DAY).then_some(midnight + of_day + 1e-9 * nano)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn framed(kind: (u8, u8), payload: &[u8]) -> Vec<u8> {
        let mut body = vec![kind.0, kind.1];
        body.extend((payload.len() as u16).to_le_bytes());
        body.extend(payload);
        let (mut a, mut b) = (0_u8, 0_u8);
        for x in &body {
            a = a.wrapping_add(*x);
            b = b.wrapping_add(a);
        }
        [&SYNC[..], &body, &[a, b]].concat()
    }

    fn pvt(second: u8, fix: u8) -> Vec<u8> {
        let mut payload = vec![0; 92];
        payload[4..6].copy_from_slice(&2026_u16.to_le_bytes());
        payload[6..12].copy_from_slice(&[5, 1, 12, 2, second, 7]);
        payload[16..20].copy_from_slice(&(-100_000_000_i32).to_le_bytes());
        payload[20..24].copy_from_slice(&[fix, 1, 0, 14]);
        payload[24..28].copy_from_slice(&(-112_250_000_i32).to_le_bytes());
        payload[28..32].copy_from_slice(&455_000_000_i32.to_le_bytes());
        payload[36..40].copy_from_slice(&80_500_i32.to_le_bytes());
        payload[60..64].copy_from_slice(&12_345_i32.to_le_bytes());
        payload[64..68].copy_from_slice(&27_130_000_i32.to_le_bytes());
        framed(NAV_PVT, &payload)
    }

    #[test]
    fn a_message_is_a_sample_in_si() {
        let file = File::of(
            &[pvt(4, 3), b"$GNTXT,hello\r\n".to_vec(), framed((1, 0x22), &[0; 20])].concat(),
        );
        let stream = &file.stream;
        assert_eq!(stream.time.len(), 1);
        // a negative part of a second belongs to the second before
        assert!((stream.time[0] - 1_777_636_923.9).abs() < 1e-6, "{}", stream.time[0]);
        let of = |name: &str| stream.get(name).expect(name)[0];
        for (name, value) in [
            ("lat", 45.5),
            ("lon", -11.225),
            ("hMSL", 80.5),
            ("gSpeed", 12.345),
            ("headMot", 271.3),
            ("numSV", 14.0),
        ] {
            assert!((of(name) - value).abs() < 1e-9, "{name}: {}", of(name));
        }
        assert_eq!(file.others, BTreeMap::from([((1, 0x22), 1)]));
    }

    #[test]
    fn a_log_without_nav_pvt_is_read_by_its_sentences() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log.ubx");
        let sentence =
            b"$GPRMC,184332.07,A,1929.459,S,02410.381,E,74.00,16.78,210410,0.0,E,A*2B\r\n";
        let other = framed((6, 0x8b), &[0; 12]);
        std::fs::write(&path, [&other[..], sentence, &other[..]].concat()).expect("written");
        let streams = read(&path.into()).expect("read");
        assert_eq!(streams.all[0].get("speed"), Some(&[74.0][..]));
    }

    #[test]
    fn damaged_messages_and_those_without_a_fix_are_left_out_and_counted() {
        let mut wrong = pvt(5, 3);
        wrong[40] ^= 1;
        let mut untimed = pvt(6, 3);
        untimed[6 + 11] = 1;
        let payload = untimed[6..98].to_vec();
        let mut cut = pvt(9, 3);
        cut.truncate(50);
        let all = [pvt(4, 3), wrong, pvt(5, 0), framed(NAV_PVT, &payload), pvt(8, 3), cut];
        let file = File::of(&all.concat());
        assert_eq!(file.stream.time.len(), 2);
        assert_eq!((file.bad_sums, file.without_fix, file.without_time, file.cut), (1, 1, 1, true));
        let codes: Vec<&str> = file.streams().warnings.iter().map(|w| w.code).collect();
        assert_eq!(codes, ["bad_frame", "truncated", "no_fix", "time_missing"]);
    }
}
