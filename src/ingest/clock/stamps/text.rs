//! Stamps that are written as dates and times of day.
//!
//! | part | forms |
//! |---|---|
//! | time | `h:mm:ss`, `h:mm:ss.sss`, `h:mm:ss,sss`, `h:mm:ss:mmm`, `mm:ss.s`; `AM` or `PM` after it |
//! | date | year first with `-`, `/`, `.`; day first with `.` or `-`; with `/` day or month first; `25 Oct 2026` |
//! | together | date, then time or the other way round, between them blanks, `T`, `_` or a comma; `20261025T100000.5` |
//! | digits | `20261025100000`, `20261025100000.5`, `20261025100000500`, `20261025 100000.5` |
//! | zone | `Z`, `UTC`, `+02:00`, `+0200`, `+02`, `CEST`; without one the clock is taken for that of UTC |
//! | span | `0 days 00:01:02.5` |
//!
//! Without a date a clock starts again at midnight (`mm:ss` at the full hour): [`Clock::finish`] lets it go on. Of
//! `10/11/2026` nobody knows which is the day: such dates are left out, and the time of day goes on over midnight too.

use super::dates::{
    Date, WEEKDAYS, ZONES, all_digits, date_of, days_from, month_of, of_digits, whole_year, zone,
};

/// Kind of a column of stamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Kind {
    /// Numbers in some unit.
    #[default]
    Numbers,
    /// Dates with times of day: s since 1970.
    Dated,
    /// Times of day: s since the midnight before the first.
    OfDay,
    /// Minutes and seconds: s since the full hour before the first.
    OfHour,
}

/// A stamp as it is written.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stamp {
    /// Days since 1970, where there is a date.
    days: Option<i64>,
    /// s since midnight, less the offset of the zone.
    seconds: f64,
    /// Whether there are no hours.
    of_hour: bool,
}

/// Reads a column of stamps, one after the other.
#[derive(Debug, Default)]
pub(crate) struct Clock {
    kind: Option<Kind>,
    /// Whether numbers were among the stamps: then what looks like a date of digits is one, too.
    counts: bool,
}

const MINUTE: f64 = 60.0;
const HOUR: f64 = 3600.0;
const DAY: f64 = 86_400.0;

impl Clock {
    /// s of a stamp; `None` if it is none, or of another kind than the ones in front of it.
    pub(crate) fn read(&mut self, text: &str) -> Option<f64> {
        let digits = || {
            of_digits(text).map(|(days, seconds)| Stamp {
                days: Some(days),
                seconds,
                of_hour: false,
            })
        };
        let stamp = stamp(text).or_else(digits)?;
        let own = match (stamp.days, stamp.of_hour) {
            (Some(_), _) => Kind::Dated,
            (None, true) => Kind::OfHour,
            (None, false) => Kind::OfDay,
        };
        let kind = *self.kind.get_or_insert(own);
        match (kind, stamp.days) {
            (Kind::Dated, Some(days)) => Some(days as f64 * DAY + stamp.seconds),
            (Kind::Dated, None) => None,
            // a date that was unclear at first stays out
            (Kind::OfDay, _) if !stamp.of_hour => Some(stamp.seconds),
            (Kind::OfHour, None) => Some(stamp.seconds),
            _ => None,
        }
    }

    /// s of a number that is a date of digits; `None` of one that counts.
    pub(crate) fn read_number(&mut self, text: &str) -> Option<f64> {
        if self.counts {
            return None;
        }
        let stamp = of_digits(text);
        // before the first fix there is nothing but zeros
        self.counts = stamp.is_none() && text.bytes().any(|b| (b'1'..=b'9').contains(&b));
        let (days, seconds) = stamp.filter(|_| matches!(self.kind, None | Some(Kind::Dated)))?;
        self.kind = Some(Kind::Dated);
        Some(days as f64 * DAY + seconds)
    }

    /// The kind of the stamps that were read; [`Kind::Numbers`] of none.
    pub(crate) fn kind(&self) -> Kind {
        self.kind.unwrap_or_default()
    }

    /// Lets a time of day go on over midnight, over noon on a clock of twelve hours, and `mm:ss` over the full hour.
    pub(crate) fn finish(&self, stamps: &mut [f64]) {
        let turn = match self.kind() {
            Kind::Numbers | Kind::Dated => return,
            Kind::OfDay => DAY,
            Kind::OfHour => HOUR,
        };
        let (mut added, mut last) = (0.0, f64::NAN);
        for stamp in stamps.iter_mut().filter(|t| t.is_finite()) {
            let fall = last - *stamp;
            if fall > 0.75 * turn {
                added += turn;
            } else if turn == DAY && fall > 0.45 * DAY && fall <= 0.5 * DAY && last >= 0.5 * DAY {
                added += 0.5 * DAY; // 12:59:59 is followed by 1:00:00
            }
            last = *stamp;
            *stamp += added;
        }
    }
}

/// s of one stamp alone: since 1970 where it has a date; `None` if it is none.
pub(crate) fn seconds(text: &str) -> Option<f64> {
    Clock::default().read(text)
}

/// s since 1970 of one stamp with a date and a time of day.
pub(crate) fn unix(text: &str) -> Option<f64> {
    let mut clock = Clock::default();
    clock.read(text).filter(|_| clock.kind() == Kind::Dated)
}

/// The day of a date alone, in days since 1970: as in front of a time of day, or six digits, day or year first. `None` of
/// one that is not clear.
pub(crate) fn day(text: &str) -> Option<i64> {
    let text = text.trim();
    if text.len() == 6 && all_digits(text) {
        let of = |range: std::ops::Range<usize>| text.get(range)?.parse::<i64>().ok();
        let [a, b, c] = [of(0..2)?, of(2..4)?, of(4..6)?];
        // a receiver's: day, month, year
        return days_from(2000 + c, b, a).or_else(|| days_from(2000 + a, b, c));
    }
    stamp(&format!("{text} 00:00:00"))?.days
}

fn stamp(text: &str) -> Option<Stamp> {
    let text = text.trim();
    let bytes = text.as_bytes();
    // most cells are none: that is seen at once
    let digits = bytes.iter().filter(|b| b.is_ascii_digit()).count();
    let dotted = || bytes.iter().filter(|b| **b == b'.').count() > 1;
    if digits < 3
        || bytes.len() > 48
        || !(bytes.contains(&b':') || bytes.contains(&b'T') || dotted())
    {
        return None;
    }
    let plain = (!text.is_ascii()).then(|| text.replace(['\u{a0}', '\u{202f}'], " "));
    let text = plain.as_deref().unwrap_or(text);
    let mut parts = Parts::default();
    let mut rest = text;
    while !rest.is_empty() {
        let (part, more) = next_part(rest);
        if !part.is_empty() {
            parts.take(part)?;
        }
        rest = more;
    }
    parts.stamp()
}

/// The part up to the next border, and what is after it. Borders are blanks, `_`, a comma with a blank after it, and
/// `T` between digits.
fn next_part(text: &str) -> (&str, &str) {
    let bytes = text.as_bytes();
    for (i, &b) in bytes.iter().enumerate() {
        let digit =
            |at: Option<usize>| at.and_then(|k| bytes.get(k)).is_some_and(u8::is_ascii_digit);
        let border = match b {
            b' ' | b'\t' | b'_' => true,
            b',' | b';' => bytes.get(i + 1) == Some(&b' '),
            b'T' | b't' => digit(i.checked_sub(1)) && digit(Some(i + 1)),
            _ => false,
        };
        if border {
            return (&text[..i], &text[i + 1..]);
        }
    }
    (text, "")
}

/// Findings in the parts of a stamp.
#[derive(Default)]
struct Parts {
    date: Option<Date>,
    /// s, and whether hours were among them.
    time: Option<(f64, bool)>,
    afternoon: Option<bool>,
    /// Of the zone, s.
    offset: f64,
    days: Option<i64>,
    /// Day and year around a month's name.
    numbers: [Option<i64>; 2],
    month: Option<i64>,
}

impl Parts {
    /// Sorts in one part; `None` where it is nothing of a stamp.
    fn take(&mut self, part: &str) -> Option<()> {
        let first = part.as_bytes()[0];
        if part.contains(':') && first.is_ascii_digit() {
            if self.time.is_some() {
                return None;
            }
            let end = part.find(['+', '-', 'Z', 'z', 'A', 'a', 'P', 'p']).unwrap_or(part.len());
            self.time = Some(time_of(&part[..end])?);
            return match &part[end..] {
                "" => Some(()),
                rest => self.after(rest),
            };
        }
        if part.starts_with(char::is_alphabetic)
            || matches!(first, b'+')
            || (first == b'-' && self.time.is_some())
        {
            return self.after(part);
        }
        if !first.is_ascii_digit() {
            return None;
        }
        if let Some(time) =
            time_of_dots(part).filter(|t| self.time.is_none() && (t.1 || self.date.is_some()))
        {
            self.time = Some((time.0, true));
            return Some(());
        }
        if let Some(date) = date_of(part) {
            self.date = Some(date);
            return Some(());
        }
        let number = part.trim_end_matches([',', '.']);
        match (number.len(), self.date.is_some()) {
            // the compact form of ISO 8601
            (8, false) => {
                let of = |range: std::ops::Range<usize>| number.get(range)?.parse::<i64>().ok();
                self.date = Some(Date::Known(days_from(of(0..4)?, of(4..6)?, of(6..8)?)?));
            }
            (6.., true) if self.time.is_none() => {
                let end = number.find(['+', '-', 'Z', 'z']).unwrap_or(number.len());
                let of = |range: std::ops::Range<usize>| number.get(range)?.parse::<f64>().ok();
                let (h, m, s) = (of(0..2)?, of(2..4)?, number.get(4..end)?.parse::<f64>().ok()?);
                self.time = Some((HOUR * h + MINUTE * m + s, true));
                if end < number.len() {
                    return self.after(&number[end..]);
                }
            }
            (1..=4, _) => {
                let slot = self.numbers.iter_mut().find(|n| n.is_none())?;
                *slot = number.parse().ok();
            }
            _ => return None,
        }
        Some(())
    }

    /// Text after a time: half of the day, zone; and words around a date.
    fn after(&mut self, text: &str) -> Option<()> {
        if let Some(offset) = text.strip_prefix('+') {
            self.offset = zone(offset)?;
            return Some(());
        }
        if let Some(offset) = text.strip_prefix('-') {
            self.offset = -zone(offset)?;
            return Some(());
        }
        let is = |word: &str| text.trim_end_matches([',', '.']).eq_ignore_ascii_case(word);
        if is("am") || is("a.m") || is("a") {
            self.afternoon = Some(false);
        } else if is("pm") || is("p.m") || is("p") {
            self.afternoon = Some(true);
        } else if is("m") && self.afternoon.is_some() {
            // `a. m.`
        } else if is("z") || is("utc") || is("gmt") {
        } else if let Some((_, hours)) = ZONES.iter().find(|z| is(z.0)) {
            self.offset = hours * HOUR;
        } else if is("days") || is("day") {
            self.days = self.numbers[0].take();
            self.days?;
        } else if let Some(month) = month_of(text) {
            self.month = Some(month);
        } else if !WEEKDAYS.iter().any(|d| text.get(..3).is_some_and(|t| t.eq_ignore_ascii_case(d)))
        {
            return None;
        }
        Some(())
    }

    fn stamp(self) -> Option<Stamp> {
        let (mut seconds, hours) = self.time?;
        if let Some(afternoon) = self.afternoon {
            if !hours || seconds >= 13.0 * HOUR {
                return None;
            }
            // 12 is the hour before 1
            seconds = seconds % (12.0 * HOUR) + if afternoon { 12.0 * HOUR } else { 0.0 };
        }
        if let Some(days) = self.days {
            return Some(Stamp {
                days: None,
                seconds: seconds + days as f64 * DAY,
                of_hour: false,
            });
        }
        let date = match (self.date, self.month, self.numbers) {
            (None, Some(month), [Some(a), Some(b)]) => {
                let (day, year) = if a > 31 { (b, a) } else { (a, b) };
                Some(Date::Known(days_from(whole_year(year), month, day)?))
            }
            (None, None, [None, None]) => None,
            (Some(date), None, [None, None]) => Some(date),
            _ => return None,
        };
        let days = match date {
            Some(Date::Known(days)) => Some(days),
            Some(Date::Unclear) | None => None,
        };
        Some(Stamp { days, seconds: seconds - self.offset, of_hour: !hours && days.is_none() })
    }
}

/// s of a time of day between dots, `hh.mm.ss,s`, and whether it has parts of a second: a date has none.
fn time_of_dots(text: &str) -> Option<(f64, bool)> {
    let mut fields = text.splitn(3, '.');
    let (h, m, rest) = (fields.next()?, fields.next()?, fields.next()?);
    let (s, part) = rest.split_once([',', '.']).map_or((rest, ""), |(s, part)| (s, part));
    let two =
        |text: &str| (text.len() == 2 && all_digits(text)).then(|| text.parse::<f64>().ok())?;
    let (h, m, s) = (two(h)?, two(m)?, two(s)?);
    if !(part.is_empty() || all_digits(part)) || h > 23.0 || m > 59.0 || s > 60.0 {
        return None;
    }
    let share = if part.is_empty() { 0.0 } else { format!("0.{part}").parse::<f64>().ok()? };
    Some((HOUR * h + MINUTE * m + s + share, !part.is_empty()))
}

/// s of `h:mm:ss.s`, `h:mm:ss,s`, `h:mm:ss:mmm` or `mm:ss.s`, and whether there are hours.
fn time_of(text: &str) -> Option<(f64, bool)> {
    let mut fields = [0.0; 4];
    let (mut count, mut broken) = (0, false);
    for field in text.split(':') {
        let whole = field.split([',', '.']).next()?;
        // only the last may have a fraction
        if count == 4 || broken || whole.is_empty() || whole.len() > 3 || !all_digits(whole) {
            return None;
        }
        broken = field.len() > whole.len();
        fields[count] = match field[whole.len()..].get(1..) {
            None => whole.parse().ok()?,
            Some(part) if part.is_empty() || !all_digits(part) => return None,
            Some(part) => {
                let scale = 10_f64.powi(i32::try_from(part.len()).ok()?);
                whole.parse::<f64>().ok()? + part.parse::<f64>().ok()? / scale
            }
        };
        count += 1;
    }
    let (hours, seconds) = match count {
        2 => (false, MINUTE * fields[0] + fields[1]),
        3 => (true, HOUR * fields[0] + MINUTE * fields[1] + fields[2]),
        4 => (true, HOUR * fields[0] + MINUTE * fields[1] + fields[2] + 1e-3 * fields[3]),
        _ => return None,
    };
    let [.., last] = &fields[..count.min(3)] else { return None };
    let minutes = if hours { fields[1] } else { 0.0 };
    (*last < 61.0 && minutes < 60.0).then_some((seconds, hours))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2026-10-25 10:00:00 UTC.
    const NOON: f64 = 1_792_922_400.0;

    #[test]
    fn one_instant_in_every_form() {
        for text in [
            "2026-10-25T10:00:00.5Z",
            "2026-10-25 10:00:00.500",
            "2026-10-25T12:00:00.5+02:00",
            "2026-10-25T05:00:00.5-0500",
            "2026/10/25 10:00:00.5",
            "2026.10.25 10:00:00,5",
            "25.10.2026 10:00:00.5",
            "25.10.26 10:00:00.5",
            "25-10-2026 10:00:00.5",
            "25/10/2026 10:00:00.5",
            "10/25/2026 10:00:00.5 AM",
            "10/25/2026, 10:00:00.5 AM",
            "10/25/26 10:00:00.5",
            "25-Oct-2026 10:00:00.5",
            "25 Oct 2026 10:00:00.5",
            "Sun Oct 25 10:00:00.5 2026",
            "Oct 25, 2026 10:00:00.5 AM",
            "10:00:00.5 25.10.2026",
            "2026-10-25_10:00:00.5",
            "2026-10-25 10:00:00:500",
            "20261025T100000.5Z",
            "20261025T100000.5",
            "2026-10-25 10:00:00.5 UTC",
            "2026-10-25 10:00:00.500000000",
            "2026-10-25 12:00:00.5 CEST",
            "25/10/2026 10:00:00.5 a. m.",
            "25/10/2026 10:00:00.5\u{a0}a.\u{a0}m.",
            "25. Okt. 2026 10:00:00,5",
            "25 oct. 2026 10:00:00,5",
            "25/10/2026 10.00.00,5",
            "25-OKT-26 10:00:00.5",
            "20261025100000.5",
            "20261025100000500",
            "20261025 100000.5",
        ] {
            assert_eq!(unix(text), Some(NOON + 0.5), "{text}");
        }
    }

    #[test]
    fn times_of_day() {
        for (text, s) in [
            ("00:00:01.5", 1.5),
            ("1:02:03", 3723.0),
            ("12:00:01 AM", 1.0),
            ("12:00:01 pm", 43_201.0),
            ("1:00:00PM", 46_800.0),
            ("11:59:59.5 p.m.", 86_399.5),
            ("10:00:00,25", 36_000.25),
            ("10:00:00:250", 36_000.25),
            ("59:59.9", 3599.9),
            ("61:00.5", 3660.5),
            ("0 days 00:01:00.5", 60.5),
            ("1 days 00:00:00", 86_400.0),
            // which is the day?
            ("10/11/2026 00:00:01", 1.0),
        ] {
            let got = seconds(text).unwrap_or_else(|| panic!("{text}"));
            assert!((got - s).abs() < 1e-6, "{text}: {got}");
        }
        for text in [
            "",
            "12.5",
            "-1:00",
            "a:b",
            "10:60:00",
            "10:00:61.5",
            "1:2:3:4:5",
            "Time: 10",
            "lap 1:02.3",
            "10:0",
            "13:00:00 PM x",
            "2026-13-01 10:00:00",
            "2026-10-25",
            "1,2:3:4",
            "T10",
            "14:00:00 AM",
            "http://x:80",
        ] {
            assert_eq!(seconds(text), if text == "10:0" { Some(600.0) } else { None }, "{text}");
        }
    }

    #[test]
    fn numbers_are_dates_unless_one_of_them_counts() {
        let mut clock = Clock::default();
        assert_eq!(clock.read_number("0"), None, "before the first fix");
        assert_eq!(clock.read_number("20261025100000.5"), Some(NOON + 0.5));
        assert_eq!(clock.kind(), Kind::Dated);
        let mut clock = Clock::default();
        assert_eq!(clock.read_number("20261024999999"), None);
        assert_eq!(clock.read_number("20261025000000"), None, "a counter that passes by");
    }

    #[test]
    fn a_day_alone() {
        for text in ["25/10/2026", "2026-10-25", "25.10.26", "25-OCT-26", "20261025", "251026"] {
            assert_eq!(day(text).map(|d| d as f64 * DAY + 36_000.0), Some(NOON), "{text}");
        }
        assert_eq!([day("10/11/2026"), day("3"), day("")], [None; 3]);
        assert_eq!(seconds("09.59.45,5"), Some(35_985.5));
        assert_eq!(seconds("09.11.45"), None, "a date as well");
    }

    #[test]
    fn a_time_of_day_goes_on() {
        let through = |texts: &[&str]| {
            let mut clock = Clock::default();
            let mut all: Vec<f64> =
                texts.iter().map(|t| clock.read(t).unwrap_or(f64::NAN)).collect();
            clock.finish(&mut all);
            all.iter().map(|t| t - all[0]).collect::<Vec<f64>>()
        };
        assert_eq!(through(&["23:59:59.5", "00:00:00", "00:00:00.5"]), [0.0, 0.5, 1.0]);
        assert_eq!(through(&["12:59:59.5", "1:00:00", "1:00:00.5"]), [0.0, 0.5, 1.0]);
        assert_eq!(through(&["11:59:59 AM", "12:00:00 PM", "12:00:01 PM"]), [0.0, 1.0, 2.0]);
        assert_eq!(through(&["59:59.5", "00:00.0", "00:00.5"]), [0.0, 0.5, 1.0]);
        assert_eq!(through(&["10/11/2026 23:59:59", "11/11/2026 00:00:01"]), [0.0, 2.0]);
        assert_eq!(through(&["12/10/2026 23:59:59", "13/10/2026 00:00:01"]), [0.0, 2.0]);
        // a step back is none
        assert_eq!(through(&["10:00:00", "09:59:59"]), [0.0, -1.0]);
        // a date among times of day
        let mut clock = Clock::default();
        assert!(clock.read("2026-10-25 10:00:00").is_some() && clock.read("10:00:01").is_none());
    }
}
