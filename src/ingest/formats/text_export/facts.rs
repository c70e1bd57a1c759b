//! The header of a text export: keys and values above the table.

use crate::contract::session::Meta;
use crate::contract::warning::Warning;
use crate::ingest::warning::warning;

/// The header keys of one source.
#[derive(Debug)]
pub(crate) struct HeaderKeys {
    /// The vehicle: the bike.
    pub vehicle: &'static str,
    /// Who rode; the first that is there.
    pub driver: &'static [&'static str],
    pub venue: &'static str,
    /// Day and time of day; together they are the start.
    pub start: &'static [&'static str],
    /// Rows per second.
    pub rate: &'static str,
}

/// Key and value, in the order of the text.
#[derive(Debug, Default, Clone, PartialEq)]
pub(crate) struct Facts(pub Vec<(String, String)>);

impl Facts {
    /// From lines split into cells: a key and its values, then after an empty cell perhaps another.
    pub(crate) fn of_cells(lines: &[Vec<String>]) -> Self {
        let mut facts = Vec::new();
        for line in lines {
            for group in line.split(|cell| cell.is_empty()) {
                if let [key, values @ ..] = group
                    && !values.is_empty()
                {
                    facts.push((key.clone(), values.join(" ")));
                }
            }
        }
        Facts(facts)
    }

    /// Of lines of comment: `// key: value`.
    pub(crate) fn of_comments<'a>(lines: impl Iterator<Item = &'a str>) -> Self {
        let pair = |line: &str| {
            let (key, value) = line.trim_start_matches('/').split_once(':')?;
            let (key, value) = (key.trim(), value.trim());
            (!key.is_empty() && !value.is_empty()).then(|| (key.to_owned(), value.to_owned()))
        };
        Facts(lines.filter_map(pair).collect())
    }

    /// The value of a key, whatever its case.
    pub(crate) fn get(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(k, _)| k.eq_ignore_ascii_case(key)).map(|(_, v)| v.as_str())
    }

    /// A number that a value begins with: `100.000 Hz`, `40.0Hz`.
    pub(crate) fn number(&self, key: &str) -> Option<f64> {
        let value = self.get(key)?.trim();
        let end = value.find(|c: char| !(c.is_ascii_digit() || ".,-".contains(c)));
        let number: f64 = value[..end.unwrap_or(value.len())].replace(',', ".").parse().ok()?;
        (number > 0.0 && number.is_finite()).then_some(number)
    }

    /// When the logger passed its start line, s since its start, as `Beacon Markers` lists it: cells of their own or one
    /// cell with blanks between. A logger may list splits and the end of the log, too.
    pub(crate) fn beacons(&self) -> Vec<f64> {
        let words = self.get("Beacon Markers").unwrap_or_default().split([' ', ';']);
        let number = |word: &str| word.trim_end_matches(',').replace(',', ".").parse().ok();
        words.filter_map(number).filter(|t: &f64| t.is_finite()).collect()
    }

    /// Session metadata.
    pub(crate) fn meta(&self, keys: &HeaderKeys) -> Meta {
        let text = |key: &str| self.get(key).map(str::to_owned);
        let start: Option<Vec<&str>> = keys.start.iter().map(|key| self.get(key)).collect();
        Meta {
            bike_id: self.get(keys.vehicle).map(name).unwrap_or_default(),
            rider_id: keys.driver.iter().find_map(|key| text(key)),
            site: text(keys.venue),
            start_time: start.filter(|s| !s.is_empty()).and_then(|s| moment(&s.join(" "))),
            ..Meta::default()
        }
    }
}

/// A vehicle's name as that of a file: `BMW M4 #7` becomes `BMW_M4_7`.
pub(crate) fn name(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-');
    let words: Vec<&str> = text.split(|c| !plain(c)).filter(|w| !w.is_empty()).collect();
    words.join("_").trim_start_matches(['.', '_', '-']).to_owned()
}

/// Days as loggers write them; the day stands before the month where both could be meant.
const DAYS: &[&str] = &[
    "%d/%m/%Y",
    "%m/%d/%Y",
    "%Y-%m-%d",
    "%Y/%m/%d",
    "%d.%m.%Y",
    "%d-%b-%y",
    "%d-%b-%Y",
    "%A, %B %d, %Y",
    "%A %B %d %Y",
    "%B %d, %Y",
    "%A, %d %B %Y",
    "%d %B %Y",
];

/// Times of day likewise.
const HOURS: &[&str] = &["%H:%M:%S", "%H:%M:%S%.f", "%H:%M", "%H.%M.%S", "%I:%M:%S %p", "%I:%M %p"];

/// A day and a time of day as RFC 3339. No logger tells its time zone here: the clock on the wall
/// is written as if it were UTC.
pub(crate) fn moment(text: &str) -> Option<String> {
    let text = text.trim();
    for day in DAYS {
        for hour in HOURS {
            if let Ok(civil) = jiff::civil::DateTime::strptime(format!("{day} {hour}"), text) {
                return Some(format!("{}Z", civil.strftime("%Y-%m-%dT%H:%M:%S")));
            }
        }
        if let Ok(date) = jiff::civil::Date::strptime(day, text) {
            return Some(format!("{}T00:00:00Z", date.strftime("%Y-%m-%d")));
        }
    }
    None
}

/// The warning that goes with such a start.
pub(crate) fn wall_clock(start: &str) -> Warning {
    let message = format!(
        "the start {} is the logger's own clock, whose time zone is unknown; it is kept as if it \
         were UTC",
        start.trim_end_matches('Z')
    );
    warning("local_time", None, 1, None, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_and_what_stands_beside_them() {
        let line = |cells: &[&str]| cells.iter().map(|c| (*c).to_owned()).collect::<Vec<_>>();
        let facts = Facts::of_cells(&[
            line(&["Driver", "", "", "", "Engine ID", ""]),
            line(&["Comment", "wet", "", "", "Session", "FP1"]),
            line(&["Sample Rate", "100.000", "Hz", "", "End Time", "2.5", "s"]),
            line(&["", "", ""]),
        ]);
        assert_eq!(facts.get("session"), Some("FP1"));
        assert_eq!(facts.get("Driver"), None);
        assert_eq!(facts.number("Sample Rate"), Some(100.0));
        assert!(facts.beacons().is_empty());
        for cells in [
            &["Beacon Markers", "82.915", "164.3"][..],
            &["Beacon Markers", "82.915 164.3 ", ""],
            &["Beacon Markers", "82.915, 164.3"],
            &["Beacon markers", "82,915", "164,3"],
        ] {
            assert_eq!(Facts::of_cells(&[line(cells)]).beacons(), [82.915, 164.3], "{cells:?}");
        }
        let comments =
            ["// General information:", "//  Update Rate: 40.0Hz", "// Start Time: Unknown"];
        let facts = Facts::of_comments(comments.into_iter());
        assert_eq!(facts.0.len(), 2);
        assert_eq!(facts.number("Update Rate"), Some(40.0));
        assert_eq!(facts.number("Start Time"), None);
    }

    #[test]
    fn moments_of_many_countries() {
        for (text, rfc) in [
            ("23/11/2005 09:53:00", "2005-11-23T09:53:00Z"),
            ("05.12.2018 17:42:00", "2018-12-05T17:42:00Z"),
            ("Sunday, June 19, 2022 3:42 PM", "2022-06-19T15:42:00Z"),
            ("01/01/2023 12:00:00 AM", "2023-01-01T00:00:00Z"),
            ("4/19/2025 7:08:18 PM", "2025-04-19T19:08:18Z"),
            ("2026/06/03 10:30:00", "2026-06-03T10:30:00Z"),
            ("3-Sep-25 11:54:02", "2025-09-03T11:54:02Z"),
            ("21/02/2026 22:12", "2026-02-21T22:12:00Z"),
            ("19/06/2022", "2022-06-19T00:00:00Z"),
        ] {
            assert_eq!(moment(text).as_deref(), Some(rfc), "{text}");
        }
        assert_eq!(moment("yesterday"), None);
        assert_eq!(name("BMW M4 #7"), "BMW_M4_7");
        assert_eq!(name("../../évil"), "vil");
    }
}
