//! Text logs: Vector ASC and candump.

use std::io::{BufRead, Read, Result};

use super::frame::{Frame, Scan};

/// Longest line that is read, bytes.
const LONGEST: u64 = 4096;

/// More buses than any logger has; the name of a further one is damage.
const MOST_BUSES: usize = 256;

/// The second line of an ASC log: base of numbers and kind of stamps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Base {
    radix: u32,
    /// Whether each stamp counts from the one before.
    relative: bool,
}

impl Base {
    /// Of a line like `base hex  timestamps absolute`.
    pub(super) fn parse(line: &str) -> Option<Self> {
        let mut words = line.split_whitespace();
        if words.next()? != "base" {
            return None;
        }
        let radix = match words.next()? {
            "hex" => 16,
            "dec" => 10,
            _ => return None,
        };
        Some(Base { radix, relative: words.any(|w| w == "relative") })
    }
}

/// Every line with its number; without its end, and cut at [`LONGEST`].
pub(super) fn lines(log: &mut dyn BufRead, mut each: impl FnMut(usize, &str)) -> Result<()> {
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        if log.take(LONGEST).read_until(b'\n', &mut line)? == 0 {
            break;
        }
        each(number, String::from_utf8_lossy(&line).trim());
    }
    Ok(())
}

pub(super) fn each_asc(log: &mut dyn BufRead, take: &mut dyn FnMut(&Frame<'_>)) -> Result<Scan> {
    let mut scan = Scan::default();
    let mut base = Base { radix: 16, relative: false };
    let mut clock = 0.0;
    let mut data = Vec::new();
    lines(log, |number, line| {
        if let Some(said) = Base::parse(line) {
            base = said;
            return;
        }
        // the first is when the file was begun, the second when the measurement was
        if let Some(date) =
            ["date ", "Begin Triggerblock "].iter().find_map(|p| line.strip_prefix(p))
        {
            scan.start = start(date).or_else(|| scan.start.take());
            return;
        }
        let mut words = line.split_whitespace();
        // all else that has no stamp in front is a comment or a heading
        let Some(stamp) = words.next().and_then(|w| w.parse::<f64>().ok()) else { return };
        clock = if base.relative { clock + stamp } else { stamp };
        match asc_frame(words, base.radix, &mut data) {
            Line::Frame { bus, id, extended } => {
                take(&Frame { time: clock, bus, id, extended, data: &data });
            }
            Line::Other => {}
            Line::Bad => scan.bad(|| format!("in line {number}")),
        }
    })?;
    Ok(scan)
}

enum Line {
    Frame { bus: u16, id: u32, extended: bool },
    Other,
    Bad,
}

/// Frame after a line's stamp: `1 123x Rx d 8 00 01 ...` or
/// `CANFD 1 Rx 123 [name] 1 0 d 12 00 01 ...`.
fn asc_frame<'a>(mut words: impl Iterator<Item = &'a str>, radix: u32, data: &mut Vec<u8>) -> Line {
    data.clear();
    let Some(first) = words.next() else { return Line::Bad };
    let flexible = first == "CANFD";
    let bus = if flexible { words.next() } else { Some(first) };
    // `Start of measurement`, statistics, other buses
    let Some(bus) = bus.and_then(|w| w.parse().ok()) else { return Line::Other };
    let frame = |words: &mut dyn Iterator<Item = &'a str>, data: &mut Vec<u8>| {
        let mut id = if flexible { words.nth(1)? } else { words.next()? };
        if id.eq_ignore_ascii_case("ErrorFrame") || id.starts_with("Statistic") {
            return Some(Line::Other);
        }
        let extended = id.ends_with(['x', 'X']);
        id = id.trim_end_matches(['x', 'X']);
        let id = u32::from_str_radix(id, radix).ok()?;
        let length = if flexible {
            let mut flag = words.next()?;
            // a message's name may stand before the flags
            if !matches!(flag, "0" | "1") {
                flag = words.next()?;
            }
            let _length_code = matches!(flag, "0" | "1").then(|| words.nth(1))??;
            words.next()?.parse::<usize>().ok()?
        } else {
            match words.nth(1)? {
                "d" => usize::from_str_radix(words.next()?, radix).ok()?.min(8),
                _ => return Some(Line::Other),
            }
        };
        for _ in 0..length.min(64) {
            data.push(u8::from_str_radix(words.next()?, radix).ok()?);
        }
        Some(Line::Frame { bus, id: id & 0x1FFF_FFFF, extended })
    };
    frame(&mut words, data).unwrap_or(Line::Bad)
}

/// `Fri May 01 12:02:04.123 2026`, `Fri May 01 12:02:04.123 pm 2026`: taken as UTC, which is not
/// said.
fn start(date: &str) -> Option<String> {
    let words: Vec<&str> = date.split_whitespace().collect();
    let (half, year) = match words[..] {
        [_, _, _, _, half, year] => (Some(half.to_lowercase()), year),
        [_, _, _, _, year] => (None, year),
        _ => return None,
    };
    let months =
        ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"];
    let name = words[1].to_lowercase();
    let month = months.iter().position(|m| name.starts_with(m))? + 1;
    let (hour, rest) = words[3].split_once(':')?;
    let hour: i8 = hour.parse().ok()?;
    let hour = match half.as_deref() {
        Some("pm") if hour < 12 => hour + 12,
        Some("am") if hour == 12 => 0,
        _ => hour,
    };
    let text = format!("{year}-{month:02}-{:0>2}T{hour:02}:{rest}Z", words[2]);
    Some(text.parse::<jiff::Timestamp>().ok()?.to_string())
}

pub(super) fn each_candump(
    log: &mut dyn BufRead,
    take: &mut dyn FnMut(&Frame<'_>),
) -> Result<Scan> {
    let mut scan = Scan::default();
    let mut buses: Vec<String> = Vec::new();
    let mut first = None;
    let mut data = Vec::new();
    lines(log, |number, line| {
        if line.is_empty() {
            return;
        }
        let Some(dumped) = candump(line) else { return scan.bad(|| format!("in line {number}")) };
        let bus = match buses.iter().position(|b| b == dumped.bus) {
            Some(bus) => bus,
            None if buses.len() == MOST_BUSES => return scan.bad(|| format!("in line {number}")),
            None => {
                buses.push(dumped.bus.to_owned());
                buses.len() - 1
            }
        };
        match dumped.data(&mut data) {
            Some(true) => {
                // the start is taken off: a stamp of today leaves a double 0.2 us only
                let begin = *first.get_or_insert(dumped.seconds);
                let time = (dumped.seconds - begin) as f64 + dumped.fraction;
                let (id, extended) = (dumped.id, dumped.extended);
                take(&Frame { time, bus: bus as u16 + 1, id, extended, data: &data });
            }
            Some(false) => {}
            None => scan.bad(|| format!("in line {number}")),
        }
    })?;
    // stamps may count from 1970 or from the start of the machine
    let start = first.filter(|s| *s > 1_000_000_000);
    let start = start.and_then(|s| jiff::Timestamp::from_second(s).ok());
    scan.start = start.map(|t| t.to_string());
    Ok(scan)
}

/// The parts of a candump line.
#[derive(Debug, PartialEq)]
pub(super) struct Dumped<'a> {
    seconds: i64,
    fraction: f64,
    bus: &'a str,
    id: u32,
    extended: bool,
    rest: &'a str,
    /// Whether the bytes are separated by spaces with their number in front, as on the screen.
    screen: bool,
}

/// `(1609459200.123456) can0 123#DEADBEEF`, `... 123##1DEADBEEF`, or
/// `(0.012) can0 123 [4] DE AD BE EF`.
pub(super) fn candump(line: &str) -> Option<Dumped<'_>> {
    let (stamp, rest) = line.strip_prefix('(')?.split_once(')')?;
    let (seconds, fraction) = stamp.trim().split_once('.')?;
    let seconds = seconds.parse().ok().filter(|s| (0..=1 << 40).contains(s))?;
    let fraction = format!("0.{fraction}").parse().ok()?;
    let (bus, rest) = rest.trim_start().split_once(char::is_whitespace)?;
    let rest = rest.trim_start();
    let (id, rest, screen) = match rest.split_once('#') {
        Some((id, rest)) => (id, rest, false),
        None => {
            let (id, rest) = rest.split_once(char::is_whitespace)?;
            (id, rest.trim_start(), true)
        }
    };
    let number = u32::from_str_radix(id, 16).ok()?;
    // three digits are a standard identifier, eight an extended one
    let extended = id.len() > 3;
    Some(Dumped { seconds, fraction, bus, id: number & 0x1FFF_FFFF, extended, rest, screen })
}

impl Dumped<'_> {
    /// Its bytes; `false` for frames without any by nature, `None` if they cannot be read.
    fn data(&self, out: &mut Vec<u8>) -> Option<bool> {
        out.clear();
        if self.screen {
            let (length, bytes) = self.rest.strip_prefix('[')?.split_once(']')?;
            let length: usize = length.trim().parse().ok()?;
            if bytes.contains("remote") {
                return Some(false);
            }
            for byte in bytes.split_whitespace().take(length.min(64)) {
                out.push(u8::from_str_radix(byte, 16).ok()?);
            }
            return (out.len() == length.min(64)).then_some(true);
        }
        if self.rest.starts_with(['R', 'r']) {
            return Some(false);
        }
        let digits = match self.rest.strip_prefix('#') {
            // flags of CAN FD
            Some(rest) => rest.get(1..)?,
            None => self.rest,
        };
        let digits = digits.split_whitespace().next().unwrap_or("");
        let (pairs, odd) = digits.as_bytes().as_chunks::<2>();
        if !odd.is_empty() || pairs.len() > 64 {
            return None;
        }
        for pair in pairs {
            out.push(u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()?);
        }
        Some(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Seen = (f64, u16, u32, bool, Vec<u8>);

    fn read(
        text: &str,
        each: impl Fn(&mut dyn BufRead, &mut dyn FnMut(&Frame<'_>)) -> Result<Scan>,
    ) -> (Vec<Seen>, Scan) {
        let mut seen = Vec::new();
        let scan = each(&mut text.as_bytes(), &mut |f| {
            seen.push((f.time, f.bus, f.id, f.extended, f.data.to_vec()));
        });
        (seen, scan.expect("read"))
    }

    #[test]
    fn asc_of_several_writers() {
        let text = "date Fri May 01 12:02:04.5 pm 2026\nbase hex  timestamps absolute\n\
            internal events logged\nBegin Triggerblock Fri May 01 12:02:03.25 2026\n 0.000000 Start of measurement\n\
            0.010000 1  1A3             Rx   d 3 01 02 FF\n\
            0.020000 2  18FF1234x       Tx   d 1 07  Length = 0 BitCount = 0\n\
            0.030000 CANFD   1 Rx        123  Name  1 0 9 12 00 01 02 03 04 05 06 07 08 09 0A 0B 0 0\n\
            0.040000 CANFD   1 Rx        123   0 0 4 4 00 01 02 03\n\
            0.050000 1  ErrorFrame\n0.060000 1  1A3  Rx   r\n0.070000 1  1A3 Rx d 3 01 zz\nEnd TriggerBlock\n";
        let (frames, scan) = read(text, |l, t| each_asc(l, t));
        assert_eq!(frames.len(), 4, "{frames:?}");
        assert_eq!(frames[0], (0.01, 1, 0x1A3, false, vec![1, 2, 255]));
        assert_eq!(frames[1], (0.02, 2, 0x18FF_1234, true, vec![7]));
        assert_eq!(frames[2].4, (0..12).collect::<Vec<u8>>());
        assert_eq!(frames[3].4, [0, 1, 2, 3]);
        assert_eq!((scan.bad, scan.first_bad.as_str()), (1, "in line 12"));
        assert_eq!(scan.start.as_deref(), Some("2026-05-01T12:02:03.25Z"));
        assert_eq!(
            start("Fri May 1 12:02:04.5 am 2026").as_deref(),
            Some("2026-05-01T00:02:04.5Z")
        );
    }

    #[test]
    fn relative_stamps_add_up_and_decimals_are_decimals() {
        let text = "base dec  timestamps relative\n1.5 1 100 Rx d 1 255\n0.5 1 100 Rx d 1 10\n";
        let (frames, _) = read(text, |l, t| each_asc(l, t));
        assert_eq!(frames[1], (2.0, 1, 100, false, vec![10]));
    }

    #[test]
    fn candump_of_both_kinds() {
        let text = "(1777636924.000100) can0 1A3#0102FF\n(1777636924.500000) can1 18FF1234#\n\
            (1777636925.000000) can0 123##1000102030405060708090A0B\n\
            (1777636925.1) can0 123#R\n(1777636925.2) can0 123#0\nnonsense\n\
            (1777636925.250000)  can0  1A3   [2]  DE AD\n(1777636926.000000) can0 1A3#01 R\n";
        let (frames, scan) = read(text, |l, t| each_candump(l, t));
        assert_eq!(frames.len(), 5, "{frames:?}");
        assert_eq!(frames[0], (0.0001, 1, 0x1A3, false, vec![1, 2, 255]));
        assert_eq!(frames[1], (0.5, 2, 0x18FF_1234, true, vec![]));
        assert_eq!(frames[2].4, (0..12).collect::<Vec<u8>>());
        assert_eq!(frames[3], (1.25, 1, 0x1A3, false, vec![0xDE, 0xAD]));
        assert_eq!(frames[4].4, [1]);
        assert_eq!((scan.bad, scan.first_bad.as_str()), (2, "in line 5"));
        assert_eq!(scan.start.as_deref(), Some("2026-05-01T12:02:04Z"));
    }

    #[test]
    fn buses_without_end_are_damage() {
        let line = |i: usize| format!("({i}.0) bus{i} 1A3#01\n");
        let text: String = (0..70_000).map(line).collect();
        let (frames, scan) = read(&text, |l, t| each_candump(l, t));
        assert_eq!((frames.len(), scan.bad), (MOST_BUSES, 70_000 - MOST_BUSES));
        assert_eq!(scan.first_bad, "in line 257");
    }
}
