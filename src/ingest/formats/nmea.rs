//! NMEA 0183: the sentences of satellite receivers, as loggers and apps keep them.
//!
//! ```text
//! $GPRMC,120204.20,A,4500.00000,N,01113.50000,E,38.876,271.3,010526,,,A*6B
//!        hhmmss.ss  ddmm.mmmmm    dddmm.mmmmm   knots  deg   ddmmyy
//! $GPGGA time, position, quality, satellites, HDOP, altitude, M, geoid, M      $GPGNS  the same with a mode
//! $GPVTG course, T, course, M, knots, N, km/h, K: without a time               $GPZDA  time, day, month, year
//! ```
//!
//! Whatever stands in front of `$` (many loggers put their own time there) is passed by: the receiver's time of day counts,
//! with the date of RMC or ZDA, and goes on over midnight. A sentence counts only if its checksum is right; sentences
//! without one count where the log has none at all. What a receiver writes without a fix, or estimates, is left out.

use std::collections::BTreeMap;

use crate::contract::rejection::RejectionCode;
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::csv::text;
use crate::ingest::formats::format::{Format, Head};
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::formats::streams::{Stream, Streams};
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::store::objects::{Location, source};

/// Sentences of a receiver.
#[derive(Debug)]
pub(super) struct Nmea;

const DAY: f64 = 86_400.0;
/// Kinds of sentences that hold what is read.
const READ: [&str; 6] = ["RMC", "GGA", "GNS", "VTG", "GLL", "ZDA"];
/// Kinds that receivers write besides.
const OTHERS: [&str; 8] = ["GSA", "GSV", "GST", "TXT", "HDT", "DTM", "GBS", "GRS"];
/// Longest line that is looked at: a sentence has 82 characters, and a logger's time in front of it some more.
const LONGEST: usize = 400;
/// Lines that are looked at to recognise a log.
const LOOKED_AT: usize = 40;

impl Format for Nmea {
    const NAME: &'static str = "nmea";
    const DESCRIPTION: &'static str = "NMEA 0183 sentences of a satellite receiver";
    const CHANNEL_NAMES: &'static str = "`speed`, `lat`";
    const EXTENSIONS: &'static [&'static str] = &["nmea"];
    const MAPS: &'static [ShippedMap] = &[shipped_map!("nmea")];

    fn sniff(head: &Head<'_>) -> bool {
        let Some(text) = text::beginning(head.bytes) else { return false };
        let lines: Vec<&str> =
            text.lines().filter(|l| !l.trim().is_empty()).take(LOOKED_AT).collect();
        let sentences = lines.iter().filter(|l| Sentence::of(l).is_some()).count();
        sentences > 0 && 2 * sentences >= lines.len()
    }

    fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
        Ok(read(log)?.listing())
    }

    fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        Ok(read(log)?.decoded(wanted))
    }
}

/// A sentence, its fields without the kind and the checksum.
#[derive(Debug)]
struct Sentence<'a> {
    /// Three letters after the two of the talker.
    kind: &'a str,
    fields: Vec<&'a str>,
    /// Whether the checksum is right; `None` where there is none.
    sum: Option<bool>,
}

impl<'a> Sentence<'a> {
    /// The sentence in a line; `None` of other lines and of sentences of other devices.
    fn of(line: &'a str) -> Option<Self> {
        if line.len() > LONGEST {
            return None;
        }
        let body = line.rsplit_once('$')?.1.trim_end();
        let (body, sum) = match body.rsplit_once('*') {
            Some((body, sum)) => {
                let own = body.bytes().fold(0, |sum, b| sum ^ b);
                let told = u8::from_str_radix(sum.get(..2).unwrap_or(""), 16);
                (body, Some(told == Ok(own)))
            }
            None => (body, None),
        };
        let (name, fields) = body.split_once(',')?;
        let kind = name.get(2..)?;
        let known = name.len() == 5 && (READ.contains(&kind) || OTHERS.contains(&kind));
        let talker = name.bytes().all(|b| b.is_ascii_uppercase() || b.is_ascii_digit());
        (known && talker).then(|| Sentence { kind, fields: fields.split(',').collect(), sum })
    }

    fn text(&self, at: usize) -> &'a str {
        self.fields.get(at).map_or("", |f| f.trim())
    }

    fn number(&self, at: usize) -> Option<f64> {
        self.text(at).parse().ok().filter(|x: &f64| x.is_finite())
    }

    /// s since midnight of `hhmmss.ss`.
    fn of_day(&self, at: usize) -> Option<f64> {
        let text = self.text(at);
        let two = |at: usize| text.get(at..at + 2)?.parse::<u32>().ok();
        let (hours, minutes) = (two(0)?, two(2)?);
        let seconds: f64 = text.get(4..)?.parse().ok()?;
        let right = hours < 24 && minutes < 60 && (0.0..61.0).contains(&seconds);
        right.then(|| f64::from(3600 * hours + 60 * minutes) + seconds)
    }

    /// Degrees, north and east positive, of `ddmm.mmmm` and the letter after it.
    fn degrees(&self, at: usize, [positive, negative]: [&str; 2], most: f64) -> Option<f64> {
        let number = self.number(at).filter(|x| *x >= 0.0)?;
        let whole = (number / 100.0).trunc();
        let minutes = number - 100.0 * whole;
        let size = whole + minutes / 60.0;
        let sign = match self.text(at + 1) {
            letter if letter == positive => 1.0,
            letter if letter == negative => -1.0,
            _ => return None,
        };
        (minutes < 60.0 && size <= most).then_some(sign * size)
    }

    fn position(&self, at: usize) -> Option<[f64; 2]> {
        let north = self.degrees(at, ["N", "S"], 90.0)?;
        Some([north, self.degrees(at + 2, ["E", "W"], 180.0)?])
    }

    /// Days since 1970 of `ddmmyy`: 1980 to 2079.
    fn date(&self, at: usize) -> Option<i64> {
        let text = self.text(at);
        let two = |at: usize| text.get(at..at + 2)?.parse::<i16>().ok();
        let year = two(4).filter(|_| text.len() == 6)?;
        days(if year < 80 { 2000 + year } else { 1900 + year }, two(2)?, two(0)?)
    }

    /// Whether a receiver with a fix wrote it, and did not estimate.
    fn has_fix(&self) -> bool {
        match self.kind {
            "RMC" => self.text(1) == "A" && !["N", "E"].contains(&self.text(11)),
            "GLL" => self.text(5) == "A" && !["N", "E"].contains(&self.text(6)),
            "GGA" => !["", "0", "6"].contains(&self.text(5)),
            // a letter for each satellite system
            "GNS" => self.text(5).chars().any(|c| !"NE".contains(c)),
            "VTG" => !["N", "E"].contains(&self.text(8)),
            _ => true,
        }
    }
}

fn days(year: i16, month: i16, day: i16) -> Option<i64> {
    let (month, day) = (i8::try_from(month).ok()?, i8::try_from(day).ok()?);
    let date = jiff::civil::Date::new(year, month, day).ok()?;
    let midnight = date.to_zoned(jiff::tz::TimeZone::UTC).ok()?;
    Some(midnight.timestamp().as_second().div_euclid(DAY as i64))
}

fn read(log: &Location) -> Result<Streams, Error> {
    let bytes = source::read(log).map_err(|e| Error::unreadable(log, &e))?;
    let (mut streams, faults) = of_text(&text::whole(&bytes));
    if streams.is_empty() {
        return Err(Error::new(RejectionCode::NoSamples, faults.nothing(log)));
    }
    streams.all[0].add_speed(["lat", "lon"], &["speed"]);
    Ok(streams)
}

/// The samples of the sentences between other bytes; `None` where there are none.
pub(super) fn within(bytes: &[u8]) -> Option<Streams> {
    let line = |line: &[u8]| {
        let at = line.iter().rposition(|b| *b == b'$')?;
        std::str::from_utf8(&line[at..]).ok().map(|l| format!("{l}\n"))
    };
    let text: String = bytes.split(|b| *b == b'\n').filter_map(line).collect();
    let (mut streams, _) = of_text(&text);
    streams.all[0].add_speed(["lat", "lon"], &["speed"]);
    (!streams.is_empty()).then_some(streams)
}

/// Sentences that are not taken, and why.
#[derive(Debug, Default, PartialEq)]
struct Faults {
    sentences: usize,
    bad_sum: usize,
    without_sum: usize,
    without_fix: usize,
    without_time: usize,
    bad_lines: usize,
    first_bad: Option<usize>,
}

impl Faults {
    fn nothing(&self, log: &Location) -> String {
        let all = self.sentences;
        let why = match self {
            f if f.bad_sum == all && all > 0 => {
                "every checksum is wrong: the log was damaged on its way".to_owned()
            }
            f if f.without_fix > 0 => {
                format!("the receiver had no fix in {} of them", f.without_fix)
            }
            _ => "none of them has a time and a position (RMC, GGA or GNS)".to_owned(),
        };
        format!(
            "{log} has no sample in its {all} NMEA sentences: {why}; have the receiver write RMC and GGA"
        )
    }

    fn warn(&self, streams: &mut Streams) {
        let place =
            self.first_bad.map(|line| format!(", the first in line {line}")).unwrap_or_default();
        streams.warn(
            "bad_line",
            self.bad_sum + self.bad_lines,
            format!(
                "{} sentences with a wrong checksum and {} lines that are no sentence are left out{place}",
                self.bad_sum, self.bad_lines
            ),
        );
        streams.warn(
            "no_checksum",
            self.without_sum,
            "the sentences have no checksum: damaged ones cannot be recognised".to_owned(),
        );
        streams.warn(
            "no_fix",
            self.without_fix,
            format!(
                "{} sentences were written without a fix, or estimated: left out",
                self.without_fix
            ),
        );
        streams.warn(
            "time_missing",
            self.without_time,
            format!("{} sentences have no time of day and are left out", self.without_time),
        );
    }
}

/// The samples of a text: a row for each time of day.
fn of_text(text: &str) -> (Streams, Faults) {
    let mut faults = Faults::default();
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    let mut rows = Rows::default();
    let summed = text.lines().any(|l| Sentence::of(l).is_some_and(|s| s.sum.is_some()));
    for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
        let Some(sentence) = Sentence::of(line) else {
            // sentences of other devices (`$PUBX`, `!AIVDM`) and comments are none of ours
            if !line.contains(['$', '!', '#']) {
                faults.bad_lines += 1;
                faults.first_bad.get_or_insert(i + 1);
            }
            continue;
        };
        faults.sentences += 1;
        if sentence.sum.map_or(summed, |right| !right) {
            faults.bad_sum += 1;
            faults.first_bad.get_or_insert(i + 1);
            continue;
        }
        faults.without_sum += usize::from(sentence.sum.is_none());
        *kinds.entry(sentence.kind).or_default() += 1;
        if READ.contains(&sentence.kind) {
            rows.take(&sentence, &mut faults);
        }
    }
    let without_date = rows.date.is_none();
    let mut streams = Streams { all: vec![rows.stream], ..Streams::default() };
    faults.warn(&mut streams);
    let kinds: Vec<String> = kinds.iter().map(|(kind, n)| format!("{kind} {n}")).collect();
    streams.facts.push(("sentences".to_owned(), kinds.join(", ")));
    if !without_date {
        streams.start_by_stamps();
    } else if !streams.all[0].time.is_empty() {
        let told = "none in the log (RMC and ZDA have it): the times are those of a day";
        streams.facts.push(("date".to_owned(), told.to_owned()));
    }
    let speed = rows_of(&streams.all[0], "speed");
    if kinds.iter().all(|k| !k.starts_with("RMC")) && speed > 0 {
        let told = "of VTG, which has no time: taken for that of the sentence in front of it";
        streams.facts.push(("speed".to_owned(), told.to_owned()));
    }
    (streams, faults)
}

fn rows_of(stream: &Stream, name: &str) -> usize {
    stream.get(name).map_or(0, |v| v.iter().filter(|x| x.is_finite()).count())
}

/// Rows that are being made.
#[derive(Default)]
struct Rows {
    stream: Stream,
    /// Time of day of the last row, s.
    last: Option<f64>,
    /// Midnights that were passed.
    midnights: f64,
    /// From the stamps to s since 1970, by the last date.
    date: Option<f64>,
    /// Rows before the first date.
    undated: usize,
}

impl Rows {
    fn take(&mut self, sentence: &Sentence<'_>, faults: &mut Faults) {
        if !sentence.has_fix() {
            faults.without_fix += 1;
            return;
        }
        if sentence.kind == "VTG" {
            self.of_motion(sentence);
            return;
        }
        let at = if sentence.kind == "GLL" { 4 } else { 0 };
        let Some(time) = sentence.of_day(at) else {
            faults.without_time += 1;
            return;
        };
        // a date alone is no sample
        if sentence.kind != "ZDA" {
            self.begin(time);
        }
        self.dated(sentence);
        let from = match sentence.kind {
            "RMC" => 2,
            "GGA" | "GNS" => 1,
            "GLL" => 0,
            _ => return,
        };
        if let Some([north, east]) = sentence.position(from) {
            self.set("lat", Some("deg"), Some(north));
            self.set("lon", Some("deg"), Some(east));
        }
        match sentence.kind {
            "RMC" => {
                self.set("speed", Some("knots"), sentence.number(6));
                self.set("course", Some("deg"), sentence.number(7));
            }
            "GGA" | "GNS" => {
                self.set("satellites", None, sentence.number(6));
                self.set("hdop", None, sentence.number(7));
                self.set("altitude", Some("m"), sentence.number(8));
            }
            _ => {}
        }
    }

    /// VTG: knots, or km/h as knots where only they are given.
    fn of_motion(&mut self, sentence: &Sentence<'_>) {
        if self.stream.time.is_empty() {
            return;
        }
        let knots = sentence.number(4).or_else(|| Some(sentence.number(6)? / 1.852));
        self.set("speed", Some("knots"), knots);
        self.set("course", Some("deg"), sentence.number(0));
    }

    /// A row of this time of day, if the last one is not.
    fn begin(&mut self, time: f64) {
        if self.last == Some(time) {
            return;
        }
        match self.last.map_or(0.0, |last| last - time) {
            fall if fall > 0.5 * DAY => self.midnights += 1.0,
            // of the day before, late
            fall if fall < -0.5 * DAY && self.midnights > 0.0 => self.midnights -= 1.0,
            _ => {}
        }
        self.last = Some(time);
        self.stream.begin(self.midnights * DAY + time + self.date.unwrap_or(0.0));
        self.undated += usize::from(self.date.is_none());
    }

    /// The day of the row, where the sentence tells it.
    fn dated(&mut self, sentence: &Sentence<'_>) {
        let date = match sentence.kind {
            "RMC" => sentence.date(8),
            "ZDA" => {
                let part = |at: usize| sentence.text(at).parse::<i16>().ok();
                part(3).and_then(|year| days(year, part(2)?, part(1)?))
            }
            _ => None,
        };
        // another sentence's time may be of another day
        let same = sentence.of_day(0) == self.last;
        let (Some(date), true) = (date, same) else { return };
        let date = date as f64 * DAY - self.midnights * DAY;
        let before = self.date.replace(date);
        if before != Some(date) {
            let rows = match before {
                None => self.undated,
                Some(_) => 1,
            };
            let by = date - before.unwrap_or(0.0);
            self.stream.time.iter_mut().rev().take(rows).for_each(|t| *t += by);
        }
    }

    /// A number of the row, if it has none of that name yet.
    fn set(&mut self, name: &str, unit: Option<&str>, value: Option<f64>) {
        let there = self.stream.get(name).and_then(<[f64]>::last).is_some_and(|x| x.is_finite());
        if let (Some(value), false) = (value, there) {
            self.stream.set(name, unit, value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_sum(body: &str) -> String {
        format!("${body}*{:02X}\r\n", body.bytes().fold(0, |sum, b| sum ^ b))
    }

    #[test]
    fn sentences_of_one_time_are_a_row() {
        let text = [
            // of pynmea2's description of the sentences: 1994, Victoria
            "$GPRMC,184332.07,A,1929.459,S,02410.381,E,74.00,16.78,210410,0.0,E,A*2B\n".to_owned(),
            with_sum("GPVTG,16.78,T,,M,74.00,N,137.05,K,A"),
            with_sum("GNGGA,184332.07,1929.459,S,02410.381,E,1,04,2.6,100.00,M,-33.9,M,,0000"),
            format!(
                "1714564924123 {}",
                with_sum("GNGNS,184332.17,1929.460,S,02410.382,E,AN,05,2.5,101.0,,,")
            ),
        ];
        let (streams, faults) = of_text(&text.concat());
        let rows = &streams.all[0];
        // 2010-04-21T18:43:32.07Z
        assert_eq!(rows.time.len(), 2);
        assert!((rows.time[0] - 1_271_875_412.07).abs() < 1e-6, "{}", rows.time[0]);
        let of = |name: &str| rows.get(name).expect(name).to_vec();
        assert!((of("lat")[0] + (19.0 + 29.459 / 60.0)).abs() < 1e-12);
        assert!((of("lon")[1] - (24.0 + 10.382 / 60.0)).abs() < 1e-12);
        assert!(of("speed")[0] == 74.0 && of("speed")[1].is_nan());
        assert_eq!((of("altitude"), of("satellites")), (vec![100.0, 101.0], vec![4.0, 5.0]));
        assert_eq!((faults.bad_sum, faults.bad_lines), (0, 0), "{faults:?}");
    }

    fn rmc(time: &str, date: &str) -> String {
        with_sum(&format!("GPRMC,{time},A,4500.0,N,00900.0,W,10.0,90.0,{date},,,A"))
    }

    #[test]
    fn time_goes_on_over_midnight_with_and_without_a_date() {
        for (first, second) in [("300426", "010526"), ("", "")] {
            let text = [
                with_sum("GPGGA,235958.50,4500.0,N,00900.0,W,1,08,1.0,80.0,M,,M,,"),
                rmc("235959.00", first),
                with_sum("GPGGA,000000.00,4500.0,N,00900.0,W,1,08,1.0,80.0,M,,M,,"),
                rmc("000000.50", second),
            ];
            let (streams, _) = of_text(&text.concat());
            let time = &streams.all[0].time;
            let zero = if first.is_empty() { DAY } else { 1_777_593_600.0 };
            let since: Vec<f64> = time.iter().map(|t| t - zero).collect();
            assert_eq!(since, [-1.5, -1.0, 0.0, 0.5], "{first}");
            assert_eq!(streams.facts.iter().any(|f| f.0 == "date"), first.is_empty());
            assert_eq!(streams.meta.start_time.is_none(), first.is_empty(), "no day, no start");
        }
        // another day's ride after it
        let (streams, _) = of_text(&(rmc("120000.00", "010526") + &rmc("120001.00", "030526")));
        assert_eq!(streams.all[0].time[1] - streams.all[0].time[0], 2.0 * DAY + 1.0);
    }

    #[test]
    fn damaged_sentences_and_those_without_a_fix_are_left_out_and_counted() {
        let good = rmc("120000.00", "010526");
        let text = [
            good.clone(),
            good.replace("4500.0", "4600.0"),
            with_sum("GPRMC,120001.00,V,,,,,,,010526,,,N"),
            with_sum("GPGGA,120002.00,4500.0,N,00900.0,W,6,00,9.9,80.0,M,,M,,"),
            with_sum("GPGGA,,,,,,0,00,99.99,,,,,,"),
            "12:00:00 starting\n".to_owned(),
            "$GPRMC,120003.00,A,4500.0,N,00900.0,W,10".to_owned(),
        ];
        let (streams, faults) = of_text(&text.concat());
        assert_eq!(streams.all[0].time.len(), 1);
        assert_eq!((faults.bad_sum, faults.without_fix, faults.bad_lines), (2, 3, 1));
        assert_eq!(faults.first_bad, Some(2));
        let codes: Vec<&str> = streams.warnings.iter().map(|w| w.code).collect();
        assert_eq!(codes, ["bad_line", "no_fix"]);
        // a log that never had checksums
        let bare = good.split('*').next().expect("a sentence");
        let (streams, faults) = of_text(bare);
        assert_eq!((streams.all[0].time.len(), faults.without_sum), (1, 1));
    }

    #[test]
    fn what_is_no_receiver_is_none() {
        for line in ["$PUBX,00,1", "!AIVDM,1", "$GPRMC", "12,3.5,$5", "$WIMWV,045.0,R,10.8,N,A*1B"]
        {
            assert!(Sentence::of(line).is_none(), "{line}");
        }
    }
}
