//! PEAK traces (`.trc`), versions 1.0 to 2.1.
//!
//! ```text
//! ;$FILEVERSION=2.1                         1.0 has no such line
//! ;$STARTTIME=46143.5013194444              days since 30 December 1899
//! ;$COLUMNS=N,O,T,B,I,d,R,L,D               2.x only; what a line's words are
//!   1   100.234 DT 1 0123 Rx - 8 01 02 ...  number, offset in ms, type, bus, identifier, ...
//! ```

use std::io::{BufRead, Result};

use super::frame::{Frame, Scan};
use super::text::lines;

/// Days from 30 December 1899 to 1 January 1970.
const EPOCH_DAYS: f64 = 25_569.0;

/// The words of a line, as [`COLUMNS`](https://www.peak-system.com) names them: what is asked for is `O` the offset,
/// `T` the type, `B` the bus, `I` the identifier, and `D` the bytes, the last.
fn columns(version: &str) -> &'static str {
    match version {
        "1.0" => "N,O,I,l,D",
        "1.1" => "N,O,T,I,l,D",
        "1.2" => "N,O,B,T,I,l,D",
        "1.3" => "N,O,B,T,I,R,l,D",
        _ => "N,O,T,I,d,l,D",
    }
}

/// Whether a file begins as a trace does.
pub(super) fn is_trace(start: &str) -> bool {
    let mut comments =
        start.lines().map(str::trim).take_while(|l| l.is_empty() || l.starts_with(';'));
    comments.any(|l| l.starts_with(";$FILEVERSION=") || l.to_lowercase().contains("time offset"))
}

pub(super) fn each(log: &mut dyn BufRead, take: &mut dyn FnMut(&Frame<'_>)) -> Result<Scan> {
    let mut scan = Scan::default();
    let mut layout: Vec<String> = columns("1.0").split(',').map(str::to_owned).collect();
    let mut data = Vec::new();
    lines(log, |number, line| {
        if let Some(comment) = line.strip_prefix(';') {
            match comment.split_once('=').map(|(key, value)| (key.trim(), value.trim())) {
                Some(("$FILEVERSION", version)) => {
                    layout = columns(version).split(',').map(str::to_owned).collect();
                }
                Some(("$COLUMNS", named)) => {
                    layout = named.split(',').map(|c| c.trim().to_owned()).collect();
                }
                Some(("$STARTTIME", days)) => scan.start = start(days),
                _ => {}
            }
            // what 1.0 has instead
            if let Some(told) = comment.trim().strip_prefix("Start time:") {
                scan.start = scan.start.take().or_else(|| start_in_words(told));
            }
            return;
        }
        if line.is_empty() {
            return;
        }
        match frame(line, &layout, &mut data) {
            Some(Line::Frame { time, bus, id, extended }) => {
                take(&Frame { time, bus, id, extended, data: &data });
            }
            Some(Line::Other) => {}
            None => scan.bad(|| format!("in line {number}")),
        }
    })?;
    Ok(scan)
}

enum Line {
    Frame { time: f64, bus: u16, id: u32, extended: bool },
    Other,
}

/// A line; `None` if it cannot be read.
fn frame(line: &str, layout: &[String], data: &mut Vec<u8>) -> Option<Line> {
    data.clear();
    let mut words = line.split_whitespace();
    let (mut time, mut bus, mut id, mut extended, mut length) = (None, 1, None, false, None);
    for column in layout {
        match column.as_str() {
            "O" => time = Some(words.next()?.parse::<f64>().ok().filter(|t| t.is_finite())?),
            "T" => {
                // frames with data; the others are errors, states of the bus, remote frames and the trace's own events
                let data = ["Rx", "Tx", "DT", "FD", "FB", "FE", "BI"];
                if !data.contains(&words.next()?) {
                    return Some(Line::Other);
                }
            }
            "B" => bus = words.next()?.parse().ok()?,
            "I" => {
                let digits = words.next()?;
                // a state of the bus
                if digits == "FFFFFFFF" {
                    return Some(Line::Other);
                }
                id = Some(u32::from_str_radix(digits, 16).ok()?);
                // four digits are a standard identifier, eight an extended one
                extended = digits.len() > 4;
            }
            "l" | "L" => length = Some(words.next()?.parse::<usize>().ok()?),
            "D" => {
                for word in words.by_ref().take(64) {
                    if word == "RTR" {
                        return Some(Line::Other);
                    }
                    data.push(u8::from_str_radix(word, 16).ok()?);
                }
            }
            _ => _ = words.next()?,
        }
    }
    // eight bytes and fewer are their own number in a length and in a length code
    if length.is_some_and(|n| data.len() < n.min(8)) {
        return None;
    }
    Some(Line::Frame { time: time? * 1e-3, bus, id: id? & 0x1FFF_FFFF, extended })
}

/// Taken as UTC, which is not said.
fn start(days: &str) -> Option<String> {
    let days: f64 = days.parse().ok().filter(|d| (EPOCH_DAYS..1e5).contains(d))?;
    let ms = ((days - EPOCH_DAYS) * 86_400e3).round();
    jiff::Timestamp::from_millisecond(ms as i64).ok().map(|t| t.to_string())
}

/// `18.12.2021 14:28:07.062`, likewise.
fn start_in_words(text: &str) -> Option<String> {
    let civil = jiff::civil::DateTime::strptime("%d.%m.%Y %H:%M:%S%.f", text.trim()).ok()?;
    Some(civil.to_zoned(jiff::tz::TimeZone::UTC).ok()?.timestamp().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    type Seen = (f64, u16, u32, bool, Vec<u8>);

    fn read(text: &str) -> (Vec<Seen>, Scan) {
        assert!(is_trace(text), "{text}");
        let mut seen = Vec::new();
        let scan = each(&mut text.as_bytes(), &mut |f| {
            seen.push((f.time, f.bus, f.id, f.extended, f.data.to_vec()));
        });
        (seen, scan.expect("in memory"))
    }

    /// The same two frames as each version writes them, a remote frame or an error, and a line that is damaged.
    #[test]
    fn every_version() {
        let one = (1.841, 1, 0x1A3, false, vec![1, 2, 255]);
        let two = (2.0, 1, 0x18FF_1234, true, vec![7]);
        for (version, lines) in [
            (
                "1.0",
                "1)  1841  01A3  3  01 02 FF\n2)  2000  18FF1234  1  07\n3)  2001  01A3  3  RTR\n5)  17540  FFFFFFFF  4  00 00 00 08 -- -- -- -- BUSHEAVY\n4)  2002  01A3  3  01",
            ),
            (
                "1.1",
                "1)  1841.0  Rx  01A3  3  01 02 FF\n2)  2000.0  Tx  18FF1234  1  07\n\
                 3)  2001.0  Warng  FFFFFFFF  4  00 00 00 04\n4)  2002.0  Rx  01A3  3  01 zz",
            ),
            (
                "1.2",
                "1)  1841.0 1  Rx  01A3  3  01 02 FF\n2)  2000.0 1  Tx  18FF1234  1  07\n\
                 3)  2001.0 1  Rx  01A3  3  RTR\n4)  2002.0 1  Rx",
            ),
            (
                "1.3",
                "1)  1841.000 1  Rx  01A3 -  3  01 02 FF\n2)  2000.000 1  Tx  18FF1234 -  1  07\n\
                 3)  2001.000 1  Error  0001 -  5  00 00 00 00 00\n4)  nan 1  Rx  01A3 -  3  01 02 FF",
            ),
            (
                "2.0",
                "1  1841.000 DT  01A3 Rx 3  01 02 FF\n2  2000.000 DT  18FF1234 Tx 1  07\n\
                 3  2001.000 ST       Rx    00 00 00 08\n4  2002.000 DT  01A3 Rx 3  01 02",
            ),
            (
                "2.1\n;$COLUMNS=N,O,T,B,I,d,R,L,D",
                "1  1841.000 DT 1  01A3 Rx -  3  01 02 FF\n2  2000.000 DT 1  18FF1234 Tx -  1  07\n\
                 3  2001.000 RR 1  01A3 Rx -  8\n4  2002.000 DT 1  01G3 Rx -  1  01",
            ),
        ] {
            let head = match version {
                "1.0" => ";####\n;   Start time: 18.12.2021 14:28:07.062\n;    |       +time offset of message (ms)\n"
                    .to_owned(),
                version => format!(";$FILEVERSION={version}\n;$STARTTIME=46143.5013194444\n"),
            };
            let (frames, scan) = read(&format!("{head};---+--   ----+----\n{lines}\n"));
            assert_eq!(frames, [one.clone(), two.clone()], "{version}");
            assert_eq!(scan.bad, 1, "{version}");
            let wanted =
                if version == "1.0" { "2021-12-18T14:28:07.062Z" } else { "2026-05-01T12:01:54Z" };
            assert_eq!(scan.start.as_deref(), Some(wanted), "{version}");
        }
    }

    #[test]
    fn flexible_frames_have_length_codes() {
        let bytes: Vec<String> = (0..12).map(|b| format!("{b:02X}")).collect();
        let text = format!(
            ";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n 1 10.0 FB 2 0123 Rx - 9 {}\n",
            bytes.join(" ")
        );
        let (frames, scan) = read(&text);
        assert_eq!(frames, [(0.01, 2, 0x123, false, (0..12).collect())]);
        assert_eq!(scan.bad, 0);
    }
}
