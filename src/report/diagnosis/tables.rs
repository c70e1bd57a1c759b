//! The tables of `diagnose`, read back in the order of the report.

use std::path::Path;

use crate::report::error::Error;
use crate::store::tables::by_session::SessionFiles;
use crate::store::tables::read;
use crate::store::tables::rows::{
    CauseRow, DiscrepancyRow, Ident, POOLED, SimulatedSample, SimulationError,
};

/// Every `causes` row of a single session, by bike, session and rank.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub(crate) fn causes(out: &Path) -> Result<Vec<CauseRow>, Error> {
    Ok(causes_and_shared(out)?.0)
}

/// The same, and the rows of what several sessions share, by rank: these have no page.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub(crate) fn causes_and_shared(out: &Path) -> Result<(Vec<CauseRow>, Vec<CauseRow>), Error> {
    let rows: Vec<CauseRow> = read::rows(out)?;
    let (mut shared, mut rows): (Vec<CauseRow>, Vec<CauseRow>) =
        rows.into_iter().partition(|r| r.ident.session_id == POOLED);
    shared.sort_by_key(|r| r.rank);
    rows.sort_by(|a, b| (a.ident.key(), a.rank).cmp(&(b.ident.key(), b.rank)));
    Ok((rows, shared))
}

/// Every `discrepancies` row, by bike and session, then as the diagnosis wrote them.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub(crate) fn discrepancies(out: &Path) -> Result<Vec<DiscrepancyRow>, Error> {
    let mut rows: Vec<DiscrepancyRow> = read::rows(out)?;
    rows.sort_by(|a, b| a.ident.key().cmp(&b.ident.key()));
    Ok(rows)
}

/// Every `simulation_errors` row, by bike and session, then as the diagnosis wrote them.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub(crate) fn simulation_errors(out: &Path) -> Result<Vec<SimulationError>, Error> {
    let mut rows: Vec<SimulationError> = read::rows(out)?;
    rows.sort_by(|a, b| a.ident.key().cmp(&b.ident.key()));
    Ok(rows)
}

/// One session's `replays` rows, by channel, kind and manoeuvre, then by time.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub(crate) fn replays(
    files: &SessionFiles<SimulatedSample>,
    session: &Ident,
) -> Result<Vec<SimulatedSample>, Error> {
    let mut rows = files.rows(session)?;
    rows.retain(|r| r.time.is_finite());
    rows.sort_by(|a, b| {
        (&a.channel, &a.kind, a.replay_id)
            .cmp(&(&b.channel, &b.kind, b.replay_id))
            .then(a.time.total_cmp(&b.time))
    });
    Ok(rows)
}
