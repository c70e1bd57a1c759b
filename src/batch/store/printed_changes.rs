//! The rows of `changes` as a diagnosis last printed them: what is new differs from them.
//!
//! `changes` is written again wherever it is found out of date, by a batch, a reader after a killed batch, `forget`. Its rows are
//! kept from then on until a diagnosis has printed what is new. So a night that is killed, stopped or fails loses no news.

use std::collections::BTreeSet;
use std::io::ErrorKind;

use super::kind::CHANGES;
use crate::batch::error::Error;
use crate::store::objects::Location;
use crate::store::tables::rows::{ChangeRow, Ident};
use crate::store::tables::{file, read};

/// The kept rows, below the output; absent while `changes` itself was the last to be printed. A Parquet file, but not by its
/// name: it is no table for readers of `**/*.parquet`.
pub(crate) const PATH: &str = ".roadbench/changes.printed";

/// The rows of `changes` that an output has; of one without the table none. `None` with a warning where it cannot be read.
pub(crate) fn standing(root: &Location) -> Option<Vec<ChangeRow>> {
    let rows = table(root, &format!("{CHANGES}/{CHANGES}.parquet"));
    let rows = rows.inspect_err(|e| {
        tracing::warn!("{e}; what is new is not known; see `roadbench verify {root}`");
    });
    rows.ok().map(Option::unwrap_or_default)
}

/// The kept rows; without any before the first diagnosis was printed. `None` if `changes` itself was printed, or they cannot
/// be read.
pub(crate) fn kept(root: &Location) -> Option<Vec<ChangeRow>> {
    table(root, PATH).ok().flatten()
}

/// Rows as last printed, kept before `changes` becomes `now`. Rides that the output has no longer are in none of them, if
/// `is_whole` says that no table was left out.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn keep(
    root: &Location,
    now: &[ChangeRow],
    is_whole: bool,
) -> Result<Vec<ChangeRow>, Error> {
    let before = kept(root);
    // a damaged table is made again: it is no reason to stop
    let own = || table(root, &format!("{CHANGES}/{CHANGES}.parquet")).ok().flatten();
    let mut rows = before.clone().or_else(own).unwrap_or_default();
    if is_whole {
        rows = of_rides(rows, now);
    }
    let is_there = before.as_ref() == Some(&rows);
    if !is_there && (before.is_some() || rows != now) {
        file::write(root.join(PATH), &rows)?;
    }
    Ok(rows)
}

/// Forgets the kept rows: what is new was printed.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn clear(root: &Location) -> Result<(), Error> {
    let at = root.join(PATH);
    at.remove().map_err(|e| Error::Output(format!("cannot remove {at}: {e}")))
}

/// Rows of a file below an output; `None` if it is not there.
fn table(root: &Location, path: &str) -> Result<Option<Vec<ChangeRow>>, String> {
    let at = root.join(path);
    match at.read() {
        Ok(bytes) => read::rows_of(&at, bytes).map(Some).map_err(|e| e.to_string()),
        Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
        Err(e) => Err(format!("cannot read {at}: {e}")),
    }
}

/// Rows without rides that the output has no longer; what lasts begins at the next ride instead.
fn of_rides(rows: Vec<ChangeRow>, now: &[ChangeRow]) -> Vec<ChangeRow> {
    let rides: BTreeSet<(&str, &str)> = now.iter().map(|row| row.ident.key()).collect();
    let of_place = |mut row: ChangeRow| {
        if rides.contains(&row.ident.key()) {
            return Some(row);
        }
        let own = || now.iter().map(|r| &r.ident).filter(|i| i.bike_id == row.ident.bike_id);
        let is_later = |ride: &&Ident| ride.start_time >= row.ident.start_time;
        let next = own().find(is_later).or_else(|| own().next_back()).cloned();
        row.ident = next.filter(|_| row.rides != "ride")?;
        Some(row)
    };
    rows.into_iter().filter_map(of_place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(day: usize, rides: &str, cause: &str) -> ChangeRow {
        ChangeRow {
            ident: Ident {
                bike_id: "a".to_owned(),
                session_id: format!("ride_{day}"),
                start_time: Some(format!("2026-05-{day:02}T10:00:00Z")),
            },
            rides: rides.to_owned(),
            verdict: if cause.is_empty() { "as_before" } else { "named" }.to_owned(),
            cause: (!cause.is_empty()).then(|| cause.to_owned()),
            ..ChangeRow::default()
        }
    }

    /// Writes `changes` as a batch does.
    fn write(root: &Location, now: &[ChangeRow]) -> Vec<ChangeRow> {
        let before = keep(root, now, true).expect("kept");
        file::write(root.join("changes/changes.parquet"), now).expect("written");
        before
    }

    #[test]
    fn rows_as_printed_outlast_every_writer_until_the_next_are_printed() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = Location::from(folder.path());
        let first: Vec<ChangeRow> = (1..=4).map(|day| row(day, "ride", "")).collect();
        // nothing was printed yet, by which writer does not matter
        assert!(write(&root, &first).is_empty() && write(&root, &first).is_empty());
        assert_eq!(kept(&root), Some(Vec::new()));
        clear(&root).expect("printed");
        assert_eq!((kept(&root), standing(&root)), (None, Some(first.clone())));
        let mut second = first.clone();
        second.push(row(5, "ride", "wind"));
        for _ in 0..2 {
            assert_eq!(write(&root, &second), first);
            assert_eq!(kept(&root).as_ref(), Some(&first));
        }
        clear(&root).expect("printed");
        // where nothing changes nothing is kept
        assert_eq!(write(&root, &second), second);
        assert_eq!(kept(&root), None);
        // kept rows that cannot be read: the table itself counts
        root.join(PATH).write(b"no table").expect("written");
        assert_eq!(kept(&root), None);
        assert_eq!(write(&root, &first), first, "the ride of wind is gone");
    }

    #[test]
    fn a_table_that_cannot_be_read_is_no_error() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = Location::from(folder.path());
        assert_eq!(standing(&root), Some(Vec::new()));
        root.join("changes/changes.parquet").write(b"no table").expect("written");
        assert_eq!(standing(&root), None);
        assert!(keep(&root, &[row(1, "ride", "")], true).expect("kept").is_empty());
    }

    #[test]
    fn a_ride_that_was_removed_is_in_no_kept_row() {
        let now: Vec<ChangeRow> = [1, 2, 4, 5].map(|day| row(day, "ride", "")).to_vec();
        let before = vec![row(3, "ride", "wind"), row(3, "since", "latency"), row(4, "ride", "")];
        let rows = of_rides(before.clone(), &now);
        assert_eq!(rows, [row(4, "since", "latency"), row(4, "ride", "")]);
        // the last one
        let rows = of_rides(before, &now[..2]);
        assert_eq!(rows, [row(2, "since", "latency")]);
        assert!(of_rides(vec![row(3, "drift", "wear")], &[]).is_empty());
    }
}
