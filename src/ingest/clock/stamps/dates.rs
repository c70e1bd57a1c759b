//! Parts of stamps that are dates: three numbers, names of months, digits alone; and zones.

use super::names::folded;
use crate::contract::instant;

const MINUTE: f64 = 60.0;
const HOUR: f64 = 3600.0;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Date {
    /// Days since 1970.
    Known(i64),
    /// Which is the day and which the month is unknown.
    Unclear,
}

/// How the months begin, in English, German, French, Spanish, Italian, Portuguese, Dutch and Polish, without accents.
const MONTHS: [&[&str]; 12] = [
    &["jan", "ene", "gen", "sty"],
    &["feb", "fev", "lut"],
    &["mar", "mrz", "mrt", "maerz"],
    &["apr", "avr", "abr", "kwi"],
    &["may", "mai", "mag", "mei", "maj"],
    &["jun", "juin", "giu", "cze"],
    &["jul", "juil", "lug", "lip"],
    &["aug", "aou", "ago", "sie"],
    &["sep", "set", "wrz"],
    &["oct", "okt", "ott", "out", "paz"],
    &["nov", "lis"],
    &["dec", "dez", "dic", "gru"],
];
/// Words of zones, and h by which they are ahead of UTC. What means several is none.
pub(super) const ZONES: [(&str, f64); 22] = [
    ("cest", 2.0),
    ("mesz", 2.0),
    ("cet", 1.0),
    ("mez", 1.0),
    ("bst", 1.0),
    ("west", 1.0),
    ("wet", 0.0),
    ("eest", 3.0),
    ("eet", 2.0),
    ("msk", 3.0),
    ("jst", 9.0),
    ("kst", 9.0),
    ("aest", 10.0),
    ("aedt", 11.0),
    ("est", -5.0),
    ("edt", -4.0),
    ("cdt", -5.0),
    ("mst", -7.0),
    ("mdt", -6.0),
    ("pst", -8.0),
    ("pdt", -7.0),
    ("nzst", 12.0),
];
pub(super) const WEEKDAYS: [&str; 7] = ["mon", "tue", "wed", "thu", "fri", "sat", "sun"];

/// The number of a month by its name, from 1.
pub(super) fn month_of(text: &str) -> Option<i64> {
    if !text.starts_with(char::is_alphabetic) {
        return None;
    }
    let plain = folded(text);
    let begins = |names: &&[&str]| names.iter().any(|m| plain.starts_with(m));
    MONTHS.iter().position(begins).map(|m| m as i64 + 1)
}

/// A date of three numbers.
pub(super) fn date_of(text: &str) -> Option<Date> {
    let text = text.trim_end_matches(',');
    let sign = text.chars().find(|c| matches!(c, '-' | '/' | '.'))?;
    let mut numbers = text.split(sign);
    let (a, b, c) = (numbers.next()?, numbers.next()?, numbers.next()?);
    if numbers.next().is_some() || !all_digits(a) || !all_digits(c) || c.len() > 4 {
        return None;
    }
    let month = month_of(b);
    let number = |text: &str| text.parse::<i64>().ok();
    let (first, last) = (number(a)?, number(c)?);
    let known =
        |year: i64, month: i64, day: i64| days_from(whole_year(year), month, day).map(Date::Known);
    if let Some(month) = month {
        return if first > 31 { known(first, month, last) } else { known(last, month, first) };
    }
    let middle = all_digits(b).then(|| number(b))??;
    if a.len() == 4 {
        return known(first, middle, last);
    }
    match (sign, first > 12, middle > 12) {
        ('/', false, true) => known(last, first, middle),
        ('/', false, false) if first != middle => Some(Date::Unclear),
        _ => known(last, middle, first),
    }
}

pub(super) fn all_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

/// Two digits are of this century.
pub(super) fn whole_year(year: i64) -> i64 {
    if year < 100 { 2000 + year } else { year }
}

/// Days since 1970.
pub(super) fn days_from(year: i64, month: i64, day: i64) -> Option<i64> {
    let (year, month, day) =
        (i16::try_from(year).ok()?, i8::try_from(month).ok()?, i8::try_from(day).ok()?);
    let date = jiff::civil::Date::new(year, month, day).ok()?;
    let start = jiff::civil::date(1970, 1, 1);
    Some(i64::from((date - start).get_days()))
}

/// s of the offset `02:00`, `0200` or `02`.
pub(super) fn zone(text: &str) -> Option<f64> {
    let mut digits = [0.0; 4];
    let mut count = 0;
    for c in text.chars().filter(|c| *c != ':') {
        *digits.get_mut(count)? = f64::from(c.to_digit(10)?);
        count += 1;
    }
    let [a, b, c, d] = digits;
    match count {
        2 | 4 => Some(HOUR * (10.0 * a + b) + MINUTE * (10.0 * c + d)),
        _ => None,
    }
}

/// Days since 1970 of a year, month and day.
pub(crate) fn day_of(year: f64, month: f64, day: f64) -> Option<i64> {
    let whole = |x: f64| (x.fract() == 0.0 && (0.0..1e4).contains(&x)).then_some(x as i64);
    days_from(whole_year(whole(year)?), whole(month)?, whole(day)?)
}

/// A date with its time of day in digits alone, `20261025100000`, with parts of a second after it: days since 1970 and s of
/// the day.
pub(super) fn of_digits(text: &str) -> Option<(i64, f64)> {
    let text = text.trim();
    let len = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
    let first = len(text);
    let (date, time) = match (first, text.as_bytes().get(8)) {
        (14.., _) => text.split_at(8),
        (8, Some(b' ' | b'_' | b'-' | b'T')) => (&text[..8], &text[9..]),
        _ => return None,
    };
    let digits = len(time);
    let (whole, part) = time.split_at(digits);
    let part = match (digits, part.strip_prefix(['.', ','])) {
        (6, Some(part)) if part.is_empty() || all_digits(part) => part,
        (6..=9 | 12, None) if part.is_empty() => &whole[6..],
        _ => return None,
    };
    let of = |text: &str, range: std::ops::Range<usize>| text.get(range)?.parse::<i64>().ok();
    let (year, h) = (of(date, 0..4)?, of(whole, 0..2)?);
    let (m, s) = (of(whole, 2..4)?, of(whole, 4..6)?);
    let days = days_from(year, of(date, 4..6)?, of(date, 6..8)?)?;
    if !instant::YEARS.contains(&i16::try_from(year).ok()?) || h > 23 || m > 59 || s > 60 {
        return None;
    }
    let part = if part.is_empty() { 0.0 } else { format!("0.{part}").parse::<f64>().ok()? };
    Some((days, HOUR * h as f64 + MINUTE * m as f64 + s as f64 + part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn months_of_many_countries() {
        for (names, month) in [
            (["Oct", "Okt.", "octobre", "octubre", "ottobre", "outubro", "październik"], 10),
            (["Mar", "März", "mars", "marzo", "mrt", "Mrz", "marca"], 3),
            (["Dec", "Dez", "déc.", "dic", "dezembro", "dicembre", "grudnia"], 12),
        ] {
            names.iter().for_each(|name| assert_eq!(month_of(name), Some(month), "{name}"));
        }
        assert_eq!([month_of("km"), month_of("10"), month_of("é")], [None; 3]);
    }

    #[test]
    fn digits_alone_are_a_date_only_with_its_ranges() {
        let noon = Some((20_751, 36_000.5));
        for text in
            ["20261025100000.5", "202610251000005", "20261025100000500", "20261025-100000,5"]
        {
            assert_eq!(of_digits(text), noon, "{text}");
        }
        for none in [
            "1792922400500",       // Unix ms
            "1792922400500000",    // Unix us
            "1792922400500000000", // Unix ns
            "20261325100000",
            "20261025240000",
            "20261025106000",
            "2026102510000",
            "99991025100000",
            "639285192005000000", // ticks of .NET
        ] {
            assert_eq!(of_digits(none), None, "{none}");
        }
    }
}
