//! Whether the rejection of a log is the log's own fault.
//!
//! It is if its bytes are bad, or end the worker that reads them. Then the log has no session any more, and its rows from
//! an earlier batch are removed. Otherwise the next batch may read it: its rows stay, and every batch tries it again. A
//! bike file that cannot be used is not the log's fault, nor is a channel map that no longer fits.

use crate::contract::rejection::RejectionCode;
use crate::store::tables::rows::Rejected;

/// Codes of rejections that are not the log's fault. For a duplicate id the other log has the session. The session of a
/// missing log stays until `forget` removes it.
const NOT_THE_LOGS: [RejectionCode; 11] = [
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

/// Codes of rejections by a channel map: it does not fit the log, or gives it a wrong bike or session.
const MAP_CODES: [RejectionCode; 12] = [
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

/// Codes of logs that ended a worker and would do so again.
pub(crate) const ENDS_A_WORKER: [RejectionCode; 3] =
    [RejectionCode::Crashed, RejectionCode::TooLarge, RejectionCode::TooSlow];

/// Whether a rejection is the log's own fault, so that it has no session any more. Unknown codes count as its own.
pub(crate) fn is_own_fault(row: &Rejected) -> bool {
    RejectionCode::parse(&row.code).is_none_or(|code| !NOT_THE_LOGS.contains(&code))
}

/// Whether the fault may be a channel map's: it is if the log's bytes have given a session before.
pub(crate) fn may_be_map_fault(row: &Rejected) -> bool {
    RejectionCode::parse(&row.code).is_some_and(|code| MAP_CODES.contains(&code))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_ends_a_worker_is_the_logs_and_what_ends_it_from_outside_is_not() {
        let is =
            |code: &str| is_own_fault(&Rejected { code: code.to_owned(), ..Rejected::default() });
        assert!(ENDS_A_WORKER.into_iter().all(|code| is(code.as_str())));
        assert!(["damaged", "too_short", "internal_error", "of_tomorrow"].into_iter().all(is));
        assert!(
            !["killed", "no_worker", "unreadable", "changed", "bad_bike_file"].into_iter().any(is)
        );
    }
}
