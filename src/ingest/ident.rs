//! Session, bike and start time from a log's path, and the check of ids.

use crate::contract::instant;
use crate::contract::rejection::RejectionCode;
use crate::contract::session::Meta;
use crate::ingest::error::Error;
use crate::store::objects::Location;

/// Metadata from a path of the form `bike=<id>/date=<yyyy-mm-dd>/<session_id>.<ext>`.
pub(super) fn from_path(log: &Location) -> Meta {
    let mut meta = Meta::default();
    for part in log.folders() {
        if let Some(bike) = part.strip_prefix("bike=") {
            meta.bike_id = bike.to_owned();
        } else if let Some(date) = part.strip_prefix("date=")
            && date.parse::<jiff::civil::Date>().is_ok()
        {
            meta.start_time = Some(format!("{date}T00:00:00Z"));
        }
    }
    meta.session_id = log.file_stem().into_owned();
    meta
}

/// Fills what `meta` lacks from `other`.
pub(super) fn or(mut meta: Meta, other: Meta) -> Meta {
    if meta.session_id.is_empty() {
        meta.session_id = other.session_id;
    }
    if meta.bike_id.is_empty() {
        meta.bike_id = other.bike_id;
    }
    meta.start_time = meta.start_time.or(other.start_time);
    meta.tyre_front = meta.tyre_front.or(other.tyre_front);
    meta.tyre_rear = meta.tyre_rear.or(other.tyre_rear);
    meta.site = meta.site.or(other.site);
    meta.rider_id = meta.rider_id.or(other.rider_id);
    meta
}

/// Ids become file names: refuses those that could lead elsewhere. A start time at which nothing was recorded is none.
///
/// # Errors
/// `bad_bike_id`, `bad_session_id`. An empty bike id passes: the batch rejects it.
pub(super) fn checked(mut meta: Meta) -> Result<Meta, Error> {
    meta.start_time = meta.start_time.filter(|text| instant::is_plausible(text));
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-');
    if meta.bike_id.starts_with('.') || !meta.bike_id.chars().all(plain) {
        return Err(Error::new(
            RejectionCode::BadBikeId,
            format!(
                "bike_id {:?} cannot name a file; use letters, digits, `.`, `_` and `-`, \
                 and no `.` in front",
                meta.bike_id
            ),
        ));
    }
    let id = &meta.session_id;
    let elsewhere = |c: char| c == '/' || c == '\\' || c.is_control();
    if id.is_empty() || id.starts_with('.') || id.len() > 200 || id.contains(elsewhere) {
        return Err(Error::new(
            RejectionCode::BadSessionId,
            format!(
                "session_id {id:?} cannot name a file; it must not be empty, start with `.`, \
                 contain a slash or be longer than 200 bytes"
            ),
        ));
    }
    Ok(meta)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(path: &str) -> Location {
        Location::Local(path.into())
    }

    #[test]
    fn the_path_says_bike_date_and_session() {
        let meta = from_path(&at("a/bike=b-1/date=2025-06-01/s 7.parquet"));
        assert_eq!(meta.bike_id, "b-1");
        assert_eq!(meta.session_id, "s 7");
        assert_eq!(meta.start_time.as_deref(), Some("2025-06-01T00:00:00Z"));
        assert_eq!(from_path(&at("x/date=soon/y.csv")).start_time, None);
    }

    #[test]
    fn ids_that_lead_elsewhere_are_refused() {
        let meta = |session: &str, bike: &str| Meta {
            session_id: session.into(),
            bike_id: bike.into(),
            ..Meta::default()
        };
        for bad in ["../evil", "a/b", "a\\b", "", "..", "a\nb"] {
            assert_eq!(checked(meta(bad, "b")).expect_err(bad).code.as_str(), "bad_session_id");
        }
        for bad in ["../evil", "a/b", "a b", ".b", "ä"] {
            assert_eq!(checked(meta("s", bad)).expect_err(bad).code.as_str(), "bad_bike_id");
        }
        assert!(checked(meta("KIRO 4", "")).is_ok());
    }
}
