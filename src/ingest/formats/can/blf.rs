//! Vector's binary logging format: objects, most of them within compressed containers.
//!
//! ```text
//! "LOGG" header | object | object ...        container = zlib of further objects, whose ends do
//! object = "LOBJ" sizes type | body          not keep to the containers' ends
//! ```
//!
//! A container that does not unpack, by its checksum, is left out; after what makes no sense the
//! next object is looked for.

use std::io::{BufRead, Read, Result};

use flate2::read::ZlibDecoder;

use super::frame::{Frame, Scan};

/// Length of an object's first part.
const BASE: usize = 16;
/// Largest object that is accepted, bytes; a larger length is damage.
const LARGEST: usize = 64 << 20;
/// Largest container after unpacking.
const LARGEST_UNPACKED: u64 = 256 << 20;

const CAN_MESSAGE: u32 = 1;
const LOG_CONTAINER: u32 = 10;
const CAN_MESSAGE2: u32 = 86;
const CAN_FD_MESSAGE: u32 = 100;
const CAN_FD_MESSAGE_64: u32 = 101;

/// Stamps in units of 10 us instead of 1 ns.
const TEN_MICROSECONDS: u32 = 1;
const REMOTE: u8 = 0x80;
const REMOTE_64: u32 = 0x10;

pub(super) fn each(log: &mut dyn BufRead, take: &mut dyn FnMut(&Frame<'_>)) -> Result<Scan> {
    let mut scan = Scan::default();
    let mut header = vec![0; 144];
    if !fill(log, &mut header)? {
        scan.cut = true;
        return Ok(scan);
    }
    let length = u32_at(&header, 4).unwrap_or(0) as u64;
    std::io::copy(&mut log.take(length.clamp(144, 4096) - 144), &mut std::io::sink())?;
    scan.start = start(&header[40..56]);
    let mut inner = Vec::new();
    let mut base = [0; BASE];
    let mut at = length;
    while next_object(log, &mut base, &mut at, &mut scan)? {
        let size = u32_at(&base, 8).unwrap_or(0) as usize;
        let kind = u32_at(&base, 12).unwrap_or(0);
        if !(BASE..=LARGEST).contains(&size) {
            scan.bad(|| format!("at byte {at}"));
            continue;
        }
        let mut body = Vec::new();
        // objects are padded, as Vector does it, by the remainder of four
        log.take((size - BASE) as u64).read_to_end(&mut body)?;
        if body.len() < size - BASE {
            scan.cut = true;
        }
        at += size as u64;
        let padding = size % 4;
        std::io::copy(&mut log.take(padding as u64), &mut std::io::sink())?;
        at += padding as u64;
        if kind == LOG_CONTAINER {
            let before = inner.len();
            // of one that is cut off what is there is right; of a damaged one nothing is sure
            if !unpack(&body, &mut inner) && !scan.cut {
                scan.bad(|| format!("in a container before byte {at}"));
                inner.truncate(before);
                objects(&inner, &mut scan, take);
                // the rest of its last object is lost
                inner.clear();
                continue;
            }
        } else {
            // an object that stands by itself
            inner.extend_from_slice(&base);
            inner.extend_from_slice(&body);
            inner.resize(inner.len() + padding, 0);
        }
        let used = objects(&inner, &mut scan, take);
        inner.drain(..used);
    }
    scan.cut |= inner.len() > BASE;
    Ok(scan)
}

/// The next object's first part, if there is one; what is none is passed over and counted once.
fn next_object(
    log: &mut dyn BufRead,
    base: &mut [u8; BASE],
    at: &mut u64,
    scan: &mut Scan,
) -> Result<bool> {
    if !fill(log, base)? {
        return Ok(false);
    }
    if base.starts_with(b"LOBJ") {
        return Ok(true);
    }
    scan.bad(|| format!("at byte {at}"));
    while !base.starts_with(b"LOBJ") {
        let mut byte = [0];
        if !fill(log, &mut byte)? {
            return Ok(false);
        }
        base.rotate_left(1);
        base[BASE - 1] = byte[0];
        *at += 1;
    }
    Ok(true)
}

/// Whether there was enough to fill it; a rest at the end is none.
fn fill(log: &mut dyn BufRead, out: &mut [u8]) -> Result<bool> {
    match log.read_exact(out) {
        Ok(()) => Ok(true),
        Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Ok(false),
        Err(e) => Err(e),
    }
}

/// Adds a container's content, as far as it can be unpacked; whether it is whole.
fn unpack(body: &[u8], out: &mut Vec<u8>) -> bool {
    let Some((head, packed)) = body.split_at_checked(16) else { return false };
    match u16_at(head, 0) {
        Some(0) => {
            out.extend_from_slice(packed);
            true
        }
        Some(2) => ZlibDecoder::new(packed).take(LARGEST_UNPACKED).read_to_end(out).is_ok(),
        _ => false,
    }
}

/// The frames of the whole objects in a buffer; how many bytes are done with.
fn objects(buffer: &[u8], scan: &mut Scan, take: &mut dyn FnMut(&Frame<'_>)) -> usize {
    let mut at = 0;
    while let Some(rest) = buffer.get(at..).filter(|r| r.len() >= BASE) {
        if !rest.starts_with(b"LOBJ") {
            // padding, mostly; otherwise the next object is looked for
            match rest.windows(4).position(|w| w == b"LOBJ") {
                Some(gap) => {
                    if gap > 8 {
                        scan.bad(|| "within a container".to_owned());
                    }
                    at += gap;
                    continue;
                }
                None => return at + rest.len() - 3,
            }
        }
        let size = u32_at(rest, 8).unwrap_or(0) as usize;
        if !(BASE..=LARGEST).contains(&size) {
            scan.bad(|| "within a container".to_owned());
            at += 4;
            continue;
        }
        let Some(object) = rest.get(..size) else { break };
        match frame(object) {
            Object::Frame(frame) => take(&frame),
            Object::Other => {}
            Object::Bad => scan.bad(|| "within a container".to_owned()),
        }
        at += size;
    }
    at
}

enum Object<'a> {
    Frame(Frame<'a>),
    Other,
    Bad,
}

fn frame(object: &[u8]) -> Object<'_> {
    let kind = u32_at(object, 12).unwrap_or(0);
    if !matches!(kind, CAN_MESSAGE | CAN_MESSAGE2 | CAN_FD_MESSAGE | CAN_FD_MESSAGE_64) {
        return Object::Other;
    }
    can_frame(object, kind).unwrap_or(Object::Bad)
}

fn can_frame(object: &[u8], kind: u32) -> Option<Object<'_>> {
    // after the first part: flags and stamp
    let length = match u16_at(object, 6)? {
        1 => 16,
        2 => 24,
        _ => return None,
    };
    let unit = if u32_at(object, BASE)? == TEN_MICROSECONDS { 1e-5 } else { 1e-9 };
    let stamp = object.get(BASE + 8..BASE + 16)?.try_into().map(u64::from_le_bytes).ok()?;
    let time = stamp as f64 * unit;
    let body = object.get(BASE + length..)?;
    let id = u32_at(body, 4)?;
    let (bus, remote, data) = match kind {
        CAN_MESSAGE | CAN_MESSAGE2 => {
            let count = usize::from(*body.get(3)?).min(8);
            (u16_at(body, 0)?, body.get(2)? & REMOTE != 0, body.get(8..8 + count)?)
        }
        CAN_FD_MESSAGE => {
            let count = usize::from(*body.get(14)?).min(64);
            (u16_at(body, 0)?, body.get(2)? & REMOTE != 0, there(body, 20, count)?)
        }
        _ => {
            let count = usize::from(*body.get(2)?).min(64);
            let remote = u32_at(body, 12)? & REMOTE_64 != 0;
            (u16::from(*body.first()?), remote, there(body, 40, count)?)
        }
    };
    if remote {
        return Some(Object::Other);
    }
    let extended = id & 0x8000_0000 != 0;
    Some(Object::Frame(Frame { time, bus, id: id & 0x1FFF_FFFF, extended, data }))
}

/// The bytes of a flexible frame that were stored: some writers leave the last ones out and count them all the same.
fn there(body: &[u8], at: usize, count: usize) -> Option<&[u8]> {
    body.get(at..(at + count).min(body.len()))
}

/// A Windows SYSTEMTIME: year, month, day of the week, day, hour, minute, second, ms.
fn start(bytes: &[u8]) -> Option<String> {
    let part = |i: usize| u16_at(bytes, 2 * i).and_then(|v| i16::try_from(v).ok());
    let small = |i: usize| part(i).and_then(|v| i8::try_from(v).ok());
    let (year, ms) = (part(0)?, part(7)?);
    let time = jiff::civil::DateTime::new(
        year,
        small(1)?,
        small(3)?,
        small(4)?,
        small(5)?,
        small(6)?,
        i32::from(ms).checked_mul(1_000_000)?,
    );
    let zoned = time.ok()?.to_zoned(jiff::tz::TimeZone::UTC).ok()?;
    Some(zoned.timestamp().to_string())
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As a vendor writes it: 64 bytes by its count, 48 of them stored.
    #[test]
    fn flexible_frames_whose_last_bytes_were_not_stored() {
        let mut object = Vec::new();
        object.extend(b"LOBJ\x20\0\x01\0");
        object.extend([120_u32, CAN_FD_MESSAGE_64, 2, 0].map(u32::to_le_bytes).concat());
        object.extend(1_500_000_000_u64.to_le_bytes());
        object.extend([7, 15, 64, 0, 0xA9, 6, 0, 0]);
        object.resize(32 + 40, 0);
        object.extend(1..=48);
        let Object::Frame(frame) = frame(&object) else { panic!("a frame") };
        assert_eq!((frame.time, frame.bus, frame.id, frame.extended), (1.5, 7, 0x6A9, false));
        assert_eq!(frame.data, (1..=48).collect::<Vec<u8>>());
    }

    #[test]
    fn starts_that_are_no_time_are_none() {
        let told = |parts: [u16; 8]| start(&parts.map(u16::to_le_bytes).concat());
        let day = [2026, 5, 5, 1, 12, 2, 4, 500];
        assert_eq!(told(day).as_deref(), Some("2026-05-01T12:02:04.5Z"));
        for (part, values) in [(0, [0x8000, 10_000]), (1, [0, 300]), (7, [1000, 0x7FFF])] {
            for value in values {
                let mut odd = day;
                odd[part] = value;
                assert_eq!(told(odd), None, "{odd:?}");
            }
        }
    }
}
