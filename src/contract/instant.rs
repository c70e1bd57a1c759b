//! Instants: RFC 3339 texts as logs give them, and microseconds since 1970 as the tables have them.

use jiff::Timestamp;
use jiff::civil::{Date, DateTime};
use jiff::tz::TimeZone;

/// An instant from a text: RFC 3339; without an offset, or without a time of day, UTC. `None` where it is no time.
pub fn parse(text: &str) -> Option<Timestamp> {
    text.parse().ok().or_else(|| {
        let civil =
            text.parse::<DateTime>().or_else(|_| text.parse::<Date>().map(|d| d.at(0, 0, 0, 0)));
        Some(civil.ok()?.to_zoned(TimeZone::UTC).ok()?.timestamp())
    })
}

/// Microseconds since 1970 of a text, as [`parse`].
pub(crate) fn microseconds(text: &str) -> Option<i64> {
    parse(text).map(Timestamp::as_microsecond)
}

/// RFC 3339 in UTC of microseconds since 1970; `None` where a calendar does not reach.
pub(crate) fn text(microseconds: i64) -> Option<String> {
    Timestamp::from_microsecond(microseconds).ok().map(|t| t.to_string())
}

/// Year and month in UTC, `2026-05`; `None` where the text is no time after Christ.
pub(crate) fn month(text: &str) -> Option<String> {
    let day = parse(text)?.to_zoned(TimeZone::UTC).date();
    (day.year() > 0).then(|| format!("{:04}-{:02}", day.year(), day.month()))
}

/// Years in which a ride may have been recorded: before them a clock was not set, and calendars of other programs that read
/// the tables end (pandas 2262, Python year 1).
pub(crate) const YEARS: std::ops::Range<i16> = 1980..2200;

/// Whether a text is a time at which a ride may have been recorded; a text that is no time is none.
pub(crate) fn is_plausible(text: &str) -> bool {
    parse(text).is_some_and(|at| YEARS.contains(&at.to_zoned(TimeZone::UTC).year()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn start_times_in_their_usual_forms() {
        let days = |text| Some(microseconds(text)? as f64 / 86_400e6);
        let day = |text| days(text).expect(text);
        assert_eq!(day("1970-01-02T12:00:00Z"), 1.5);
        assert_eq!(day("1970-01-02T14:00:00+02:00"), 1.5);
        assert_eq!(day("1970-01-02T12:00:00"), 1.5);
        assert_eq!(day("1970-01-02"), 1.0);
        assert_eq!(days("yesterday"), None);
        assert_eq!(month("2026-05-01T01:00:00+02:00").as_deref(), Some("2026-04"));
        assert!(is_plausible("2026-05-01") && is_plausible("1980-01-06T00:00:00Z"));
        for odd in ["0000-01-01T00:00:00Z", "-000044-03-15", "1970-01-01", "9999-12-31", "noon"] {
            assert!(!is_plausible(odd), "{odd}");
        }
        let at = microseconds("2026-05-01T10:00:00.25+02:00").expect("a time");
        assert_eq!(text(at).as_deref(), Some("2026-05-01T08:00:00.25Z"));
    }
}
