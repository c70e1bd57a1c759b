//! When a log began whose clock tells the time of day alone: the day stands in columns beside it.
//!
//! | columns | start |
//! |---|---|
//! | date, time of day | both |
//! | year, month, day, and hour, minute, second | all |
//! | week of GPS, time of week | both, in UTC |

use crate::ingest::clock::stamps::dates::day_of;
use crate::ingest::clock::stamps::names::folded;
use crate::ingest::clock::stamps::text::{self, Kind};
use crate::ingest::clock::stamps::unit::{calendar_of, of_digits};
use crate::ingest::maps::TimeSource;

const DAY: f64 = 86_400.0;
/// The zero of the weeks of GPS, s since 1970, and s by which its clock is ahead of UTC.
const GPS: (f64, f64) = (315_964_800.0, 18.0);

const DATES: [&str; 10] = [
    "date", "datum", "fecha", "data", "gps date", "utc date", "date utc", "log date", "tarih",
    "дата",
];
const WEEKS: [&str; 5] = ["gps week", "week", "week number", "wn", "gps wn"];
/// Words of a name that say the order of a date of six digits, and where year, month and day begin.
const ORDERS: [(&str, [usize; 3]); 6] = [
    ("ddmmyy", [4, 2, 0]),
    ("yymmdd", [0, 2, 4]),
    ("mmddyy", [4, 0, 2]),
    ("ttmmjj", [4, 2, 0]),
    ("jjmmtt", [0, 2, 4]),
    ("jjmmaa", [4, 2, 0]),
];
/// Names of year, month, day, hour, minute and second.
const PARTS: [&[&str]; 6] = [
    &["year", "yyyy", "jahr", "annee", "ano", "anno"],
    &["month", "mon", "mm", "monat", "mois", "mes", "mese"],
    &["day", "dd", "tag", "jour", "dia", "giorno"],
    &["hour", "hours", "hr", "hh", "h", "stunde", "heure", "hora", "ora"],
    &["minute", "minutes", "min", "mins"],
    &[
        "second", "seconds", "sec", "secs", "ss", "s", "sekunde", "sek", "seconde", "segundo",
        "secondo",
    ],
];

/// Unix time of the first of some stamps on a clock that counts from a day.
pub(super) fn unix_of(clock: &TimeSource, stamps: &[f64], kind: Kind) -> Option<f64> {
    let first = *stamps.iter().find(|t| t.is_finite())?;
    match (clock, kind) {
        (TimeSource::Column { .. }, Kind::Dated) => Some(first),
        (TimeSource::Column { factor, .. }, Kind::Numbers) => {
            let zero = calendar_of(stamps).filter(|c| c.factor == *factor).map_or(0.0, |c| c.zero);
            Some(first * factor + zero)
        }
        _ => None,
    }
}

/// Unix seconds as RFC 3339, to the millisecond.
pub(crate) fn start_time(seconds: f64) -> Option<String> {
    let ms = (seconds * 1e3).round();
    if !(0.0..4e12).contains(&ms) {
        return None;
    }
    jiff::Timestamp::from_millisecond(ms as i64).ok().map(|t| t.to_string())
}

/// s since 1970 at the first row whose stamp `clock` is a time of day; `None` where no column tells the day, or not clearly.
///
/// `rows` are the first rows by cells, in the order of `names`.
pub(super) fn start(names: &[String], rows: &[Vec<String>], clock: usize) -> Option<f64> {
    let row = rows.iter().find(|row| row.get(clock).is_some_and(|c| !c.trim().is_empty()))?;
    let place = |what: &[&str]| {
        let is = |(i, name): &(usize, &String)| *i != clock && what.contains(&plain(name).as_str());
        Some(names.iter().enumerate().find(is)?.0)
    };
    let called = |what: &[&str]| row.get(place(what)?).map(|cell| cell.trim());
    let number = |text: &str| text.replace(',', ".").parse::<f64>().ok();
    let cell = row[clock].trim();
    let name = plain(names.get(clock)?);
    if PARTS[5].contains(&name.as_str()) {
        let of = |part: usize| number(called(PARTS[part])?);
        let day = day_of(of(0)?, of(1)?, of(2)?)?;
        let (h, m, s) = (of(3)?, of(4)?, number(cell)?);
        let is_time =
            (0.0..24.0).contains(&h) && (0.0..60.0).contains(&m) && (0.0..61.0).contains(&s);
        return is_time.then_some(day as f64 * DAY + 3600.0 * h + 60.0 * m + s);
    }
    if let Some(week) = called(&WEEKS).and_then(number) {
        let factor = if name.contains("i tow") || name.ends_with("ms") { 1e-3 } else { 1.0 };
        let of_week = number(cell)? * factor;
        let is_week = week.fract() == 0.0 && (1000.0..10_000.0).contains(&week);
        let fits = is_week && name.contains("tow") && (0.0..7.0 * DAY).contains(&of_week);
        return fits.then_some(GPS.0 + 7.0 * DAY * week + of_week - GPS.1);
    }
    let day = day(&names[place(&DATES)?], called(&DATES)?)?;
    Some(day as f64 * DAY + of_day(cell)?)
}

/// Days since 1970 of a date in a column of some name. Six digits are in the order that the name says, else day first, as
/// receivers write them; a spreadsheet has taken the nought in front of five.
fn day(name: &str, cell: &str) -> Option<i64> {
    let is_number = (5..=6).contains(&cell.len()) && cell.bytes().all(|b| b.is_ascii_digit());
    let digits = if is_number { format!("{cell:0>6}") } else { cell.to_owned() };
    let order = folded(name).split(' ').find_map(|word| ORDERS.iter().find(|o| o.0 == word));
    match order.filter(|_| is_number) {
        Some((_, places)) => {
            let [year, month, day] = places.map(|at| digits.get(at..at + 2)?.parse::<f64>().ok());
            day_of(year?, month?, day?)
        }
        None => text::day(&digits),
    }
}

/// s of a time of day: as it is written, or six digits with parts of a second after them.
fn of_day(cell: &str) -> Option<f64> {
    if cell.contains(':') || cell.matches('.').count() > 1 {
        return text::seconds(cell).filter(|s| (0.0..=DAY).contains(s));
    }
    let (whole, _) = cell.split_once([',', '.']).unwrap_or((cell, ""));
    if whole.len() != 6 || !whole.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    of_digits(&[cell.replace(',', ".").parse().ok()?], 1.0)?.first().copied()
}

/// A name without unit and order of the digits.
fn plain(name: &str) -> String {
    let whole = folded(crate::ingest::maps::units::of_name(name).0);
    let words = whole.split(' ').filter(|word| !ORDERS.iter().any(|o| o.0 == *word));
    words.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(names: &[&str], row: &[&str], clock: usize) -> Option<f64> {
        let words = |from: &[&str]| from.iter().map(|w| (*w).to_owned()).collect::<Vec<String>>();
        start(&words(names), &[words(row)], clock)
    }

    /// 2026-10-24 09:59:45 UTC.
    const START: f64 = 1_792_835_985.0;

    #[test]
    fn unix_stamps_give_the_start_time() {
        assert_eq!(start_time(1_692_117_187.464).as_deref(), Some("2023-08-15T16:33:07.464Z"));
        assert_eq!(start_time(f64::NAN), None);
    }

    #[test]
    fn the_day_stands_beside_the_time() {
        for (date, time) in [
            ("24/10/2026", "09:59:45.0"),
            ("2026-10-24", "09:59:45"),
            ("24.10.26", "09:59:45,000"),
            ("24-OCT-26", "9:59:45 AM"),
            ("241026", "095945.00"),
            ("20261024", "095945"),
            ("24. Okt. 2026", "09.59.45,0"),
        ] {
            assert_eq!(of(&["Date", "v", "Time"], &[date, "1", time], 2), Some(START), "{date}");
        }
        // six digits are as the name says, and may have lost their nought
        for (name, date) in [
            ("Date (yymmdd)", "261024"),
            ("date_yymmdd", "261024"),
            ("Date [mmddyy]", "102426"),
            ("Datum (TTMMJJ)", "241026"),
            ("GPS Date (ddmmyy)", "241026"),
        ] {
            assert_eq!(of(&[name, "Time"], &[date, "095945.00"], 1), Some(START), "{name}");
        }
        let early = Some(START - 20.0 * DAY);
        assert_eq!(of(&["Date", "Time"], &["41026", "095945.00"], 1), early, "4 October");
        assert_eq!(of(&["Date (yymmdd)", "Time"], &["321340", "095945"], 1), None);
        assert_eq!(
            of(&["Datum", "Uhrzeit"], &["10/11/2026", "09:59:45"], 1),
            None,
            "which is the day?"
        );
        assert_eq!(of(&["Date", "Time (s)"], &["24/10/2026", "12.5"], 1), None, "elapsed");
        assert_eq!(of(&["v", "Time"], &["1", "09:59:45"], 1), None);
    }

    #[test]
    fn parts_of_a_date_and_weeks_are_put_together() {
        let names = ["Year", "Month", "Day", "Hour", "Min", "Sec", "v"];
        assert_eq!(of(&names, &["2026", "10", "24", "9", "59", "45.0", "1"], 5), Some(START));
        assert_eq!(of(&names, &["2026", "13", "24", "9", "59", "45.0", "1"], 5), None);
        assert_eq!(of(&["Sec", "v"], &["45.0", "1"], 0), None);
        // Saturday, 18 s ahead of UTC
        let tow = 6.0 * DAY + 35_985.0 + 18.0;
        assert_eq!(of(&["GPS Week", "GPS TOW"], &["2441", &tow.to_string()], 1), Some(START));
        assert_eq!(of(&["GPS Week", "iTOW"], &["2441", &(1e3 * tow).to_string()], 1), Some(START));
        assert_eq!(of(&["Week", "Time"], &["2441", "5.0"], 1), None);
    }
}
