//! The tables of `diagnose`, read back in the order of the report.

use std::path::Path;

use crate::report::error::Error;
use crate::tables::read::{self, Files};
use crate::tables::rows::{CauseRow, DiscrepancyRow, Ident, POOLED, ReplaySample};

/// Every `causes` row of a single session, by bike, session and rank.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn causes(out: &Path) -> Result<Vec<CauseRow>, Error> {
    let mut rows: Vec<CauseRow> = read::rows(out, "causes")?;
    // what several sessions share has no page
    rows.retain(|r| r.ident.session_id != POOLED);
    rows.sort_by(|a, b| (a.ident.key(), a.rank).cmp(&(b.ident.key(), b.rank)));
    Ok(rows)
}

/// Every `discrepancies` row, by bike and session, then as the diagnosis wrote them.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn discrepancies(out: &Path) -> Result<Vec<DiscrepancyRow>, Error> {
    let mut rows: Vec<DiscrepancyRow> = read::rows(out, "discrepancies")?;
    rows.sort_by(|a, b| a.ident.key().cmp(&b.ident.key()));
    Ok(rows)
}

/// One session's `replays` rows from the files that hold them, by channel, kind and manoeuvre, then
/// by time; without the names of session and bike.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn replays(files: &Files, session: &Ident) -> Result<Vec<ReplaySample>, Error> {
    let mut rows: Vec<ReplaySample> = read::session_rows(files, "replays", session.key())?;
    rows.retain(|r| r.time.is_finite());
    rows.sort_by(|a, b| {
        (&a.channel, &a.kind, a.manoeuvre)
            .cmp(&(&b.channel, &b.kind, b.manoeuvre))
            .then(a.time.total_cmp(&b.time))
    });
    Ok(rows)
}
