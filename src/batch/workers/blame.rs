//! Whose fault it is that a log was not used.
//!
//! The log's own: its bytes are bad, or end the worker that reads them. Then it has no session any more, and the rows that it
//! had from an earlier batch go. Not the log's: the next batch may well read it. Then its rows stay as they are, and it is
//! tried again every time. A bike file that cannot be used is not the log's fault, nor is a channel map that fits it no more.

use crate::contract::rejection::RejectionCode;
use crate::store::tables::rows::Rejected;

/// Codes of rejections that are not the log's fault. Of the duplicates of an id the other log has the session; a log that
/// is gone stays in the archive until it is forgotten.
const NOT_ITS_OWN: [RejectionCode; 11] = [
    RejectionCode::Unreachable,
    RejectionCode::Unreadable,
    RejectionCode::Changed,
    RejectionCode::NotFound,
    RejectionCode::NoLogs,
    RejectionCode::DuplicateSessionId,
    RejectionCode::Killed,
    RejectionCode::NoWorker,
    RejectionCode::NoMemory,
    RejectionCode::NoBikeFile,
    RejectionCode::BadBikeFile,
];

/// Codes of logs that the channel maps of the batch do not fit, or that have who they are from one.
const OF_A_MAP: [RejectionCode; 12] = [
    RejectionCode::NoChannelMap,
    RejectionCode::BadDbc,
    RejectionCode::MissingColumn,
    RejectionCode::AmbiguousColumn,
    RejectionCode::WrongType,
    RejectionCode::UnknownUnit,
    RejectionCode::UnitMismatch,
    RejectionCode::MixedClocks,
    RejectionCode::CoordinateSystem,
    RejectionCode::NoBikeId,
    RejectionCode::BadBikeId,
    RejectionCode::BadSessionId,
];

/// Codes of logs that ended a worker, and would again.
pub(crate) const ENDS_A_WORKER: [RejectionCode; 3] =
    [RejectionCode::Crashed, RejectionCode::TooLarge, RejectionCode::TooSlow];

/// Whether a log that was rejected so has no session any more. A code of another version counts as the log's.
pub(crate) fn is_the_logs(row: &Rejected) -> bool {
    RejectionCode::parse(&row.code).is_none_or(|code| !NOT_ITS_OWN.contains(&code))
}

/// Whether the fault may be a channel map's: it is where a log has the bytes that once gave its session.
pub(crate) fn may_be_a_maps(row: &Rejected) -> bool {
    RejectionCode::parse(&row.code).is_some_and(|code| OF_A_MAP.contains(&code))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_ends_a_worker_is_the_logs_and_what_ends_it_from_outside_is_not() {
        let is =
            |code: &str| is_the_logs(&Rejected { code: code.to_owned(), ..Rejected::default() });
        assert!(ENDS_A_WORKER.into_iter().all(|code| is(code.as_str())));
        assert!(["damaged", "too_short", "internal_error", "of_tomorrow"].into_iter().all(is));
        assert!(
            !["killed", "no_worker", "unreadable", "changed", "bad_bike_file"].into_iter().any(is)
        );
    }
}
