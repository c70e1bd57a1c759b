//! How the sessions of a motorcycle share files: one per table and month of their start.
//!
//! `<table>/bike=<id>/2026-05.parquet`, `undated.parquet` for sessions that do not say when they were. A table that is
//! written on request has a file per session still: time series are large, and are read one by one.

use crate::contract::instant;
use crate::store::tables::registry::{Presence, TableSpec};

/// The part of sessions without a start time.
pub(crate) const UNDATED: &str = "undated";

/// The part of a session that began then.
pub(crate) fn of(start: Option<&str>) -> String {
    start.and_then(instant::month).unwrap_or_else(|| UNDATED.to_owned())
}

/// Whether a file of that name, without extension, has the sessions of a month; outputs of earlier versions had a file
/// per session.
pub(crate) fn is_part(name: &str) -> bool {
    let digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
    let month = |(year, month): (&str, &str)| {
        year.len() == 4 && month.len() == 2 && digits(year) && digits(month)
    };
    name == UNDATED || name.split_once('-').is_some_and(month)
}

/// Whether sessions share the files of a table.
pub(crate) fn shares(spec: &TableSpec) -> bool {
    spec.presence != Presence::OnRequest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_months() {
        assert_eq!(of(Some("2026-05-31T23:30:00-02:00")), "2026-06");
        assert_eq!((of(Some("yesterday")).as_str(), of(None).as_str()), (UNDATED, UNDATED));
        assert!(is_part("2026-05") && is_part(UNDATED));
        assert!(!is_part("2026-5") && !is_part("ride_2026-05") && !is_part("2026-05-01"));
        assert!(is_part(&of(Some("9999-12-31"))) && is_part(&of(Some("-000044-03-15T00:00:00Z"))));
    }
}
