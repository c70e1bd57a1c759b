//! Which sessions of an output go: what a log was before it became another session, and what a rejected log has given.
//!
//! A batch and its dry run ask the same questions. What is archived, a ride whose own log is not in the batch, they know
//! themselves: `is_archived` says it of a session.

use std::collections::BTreeSet;

use super::contents::Contents;
use super::marker::{Committed, Key};
use crate::batch::workers::blame;
use crate::store::objects::Location;
use crate::store::tables::rows::Rejected;

/// Earlier sessions of the log that gives the session `made`: sessions from a log with its path, and sessions from the
/// same bytes under a path that no longer exists. Another ride that had the log's name stays.
pub(crate) fn by(
    made: &Committed,
    found: &Contents,
    is_archived: impl Fn(&Committed) -> bool,
) -> BTreeSet<Key> {
    let of_name = found.made_from(&made.path).iter().flat_map(|key| found.of(key));
    let of_name = of_name.filter(|row| row.path == made.path && !is_archived(row));
    let moved = found.of_bytes(&made.input_hash).filter(|row| is_gone(&row.path));
    let mut others: BTreeSet<Key> = of_name.chain(moved).map(Committed::key).collect();
    others.remove(&made.key());
    others
}

/// Whether a log is not there any more; one that cannot be looked for may be.
fn is_gone(path: &str) -> bool {
    Location::parse(path).is_ok_and(|at| at.exists().is_ok_and(|there| !there))
}

/// Whether the output keeps rows of a rejected log: it could not be read tonight, and is what it was for all we know.
pub(crate) fn keeps(
    rejected: &Rejected,
    found: &Contents,
    is_archived: impl Fn(&Committed) -> bool,
) -> bool {
    session_of(rejected, found, is_archived).is_some_and(|key| !loses(&key, found, rejected))
}

/// The session whose rows go with a rejected log; none where it has no rows, or keeps them.
pub(crate) fn with_rejected(
    rejected: &Rejected,
    found: &Contents,
    is_archived: impl Fn(&Committed) -> bool,
) -> Option<Key> {
    session_of(rejected, found, is_archived).filter(|key| loses(key, found, rejected))
}

/// Whether a session has no log any more when its log is rejected. One whose bytes are as they were then has only lost its
/// channel map.
fn loses(key: &Key, found: &Contents, rejected: &Rejected) -> bool {
    let is_as_it_was = |row: &Committed| rejected.input_hash.as_ref() == Some(&row.input_hash);
    let is_a_maps = || blame::may_be_map_fault(rejected) && found.of(key).iter().any(is_as_it_was);
    blame::is_own_fault(rejected) && !is_a_maps()
}

/// The session that was made from a rejected log. What another log gave, or another ride that had the log's name, is not it.
fn session_of(
    rejected: &Rejected,
    found: &Contents,
    is_archived: impl Fn(&Committed) -> bool,
) -> Option<Key> {
    let hash = rejected.input_hash.as_deref().unwrap_or_default();
    let is_own = |there: &&Committed| {
        let is_same = !hash.is_empty() && there.input_hash == hash;
        is_same || there.path == rejected.path && !is_archived(there)
    };
    match (&rejected.bike_id, &rejected.session_id) {
        (Some(bike_id), Some(session_id)) => {
            let key = Key::new(bike_id, session_id);
            found.of(&key).iter().find(is_own).map(Committed::key)
        }
        _ => made_from(&rejected.path, found),
    }
}

/// The session that an unreadable log was when it could still be read: the last one that was made from this very path, if
/// its name is the file's.
fn made_from(log: &str, found: &Contents) -> Option<Key> {
    let stem = std::path::Path::new(log).file_stem()?.to_str()?;
    let rows = found.made_from(log).iter().flat_map(|key| found.of(key));
    let last = rows.filter(|row| row.path == log).max_by_key(|row| row.start)?;
    (last.session_id == stem).then(|| last.key())
}
