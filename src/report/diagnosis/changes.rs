//! What differs between a motorcycle's rides, for the page of one of them.

use std::path::Path;

use serde::Serialize;

use crate::report::error::Error;
use crate::statistics::number_format::typeset_sentence;
use crate::store::tables::read;
use crate::store::tables::rows::{ChangeRow, Ident};

#[derive(Debug, Clone, Serialize)]
#[allow(missing_docs)] // parts of the line in the template
pub(crate) struct Change {
    pub(crate) sentence: String,
    pub(crate) moved: String,
}

/// Every `changes` row, in order of motorcycle and time.
///
/// # Errors
/// The file cannot be read or lacks a column.
pub(crate) fn read(out: &Path) -> Result<Vec<ChangeRow>, Error> {
    Ok(read::rows(out)?)
}

/// Text about one session: its changes, or that it is as before; empty where it cannot be compared.
pub(crate) fn of_session(rows: &[ChangeRow], session: &Ident) -> Vec<Change> {
    let change = |row: &ChangeRow| Change {
        sentence: typeset_sentence(&row.sentence),
        moved: typeset_sentence(row.moved.as_deref().unwrap_or_default()),
    };
    let own = rows.iter().filter(|r| r.ident.key() == session.key() && r.verdict != "too_few");
    own.map(change).collect()
}
