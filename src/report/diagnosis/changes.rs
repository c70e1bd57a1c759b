//! What differs between a motorcycle's rides, for the pages.

use std::path::Path;

use serde::Serialize;

use crate::report::error::Error;
use crate::statistics::number_format::typeset;
use crate::store::tables::changes::{head, is_change, place};
use crate::store::tables::read;
use crate::store::tables::rows::{ChangeRow, Ident};

/// One change.
#[derive(Debug, Clone, Serialize)]
#[allow(missing_docs)] // parts of the line in the template
pub(crate) struct Change {
    pub(crate) place: String,
    pub(crate) sentence: String,
    pub(crate) moved: String,
    pub(crate) page: Option<String>,
}

/// One motorcycle.
#[derive(Debug, Clone, Serialize)]
#[allow(missing_docs)] // parts of the line in the template
pub(crate) struct Motorcycle {
    pub(crate) bike_id: String,
    pub(crate) head: String,
    pub(crate) changes: Vec<Change>,
}

/// Every `changes` row, in order of motorcycle and time.
///
/// # Errors
/// The file cannot be read or lacks a column.
pub(crate) fn read(out: &Path) -> Result<Vec<ChangeRow>, Error> {
    Ok(read::rows(out)?)
}

/// The motorcycles with rides enough; those of which something changed come first.
pub(crate) fn motorcycles<'a>(
    rows: &[ChangeRow],
    page_of: impl Fn(&Ident) -> Option<&'a str>,
) -> Vec<Motorcycle> {
    let of_bike = |rows: &[ChangeRow]| {
        Some(Motorcycle {
            bike_id: rows[0].ident.bike_id.clone(),
            head: head(rows)?,
            changes: rows.iter().filter(|r| is_change(r)).map(|r| change(r, &page_of)).collect(),
        })
    };
    let chunks = rows.chunk_by(|a, b| a.ident.bike_id == b.ident.bike_id);
    let mut all: Vec<Motorcycle> = chunks.filter_map(of_bike).collect();
    all.sort_by_key(|m| m.changes.is_empty());
    all
}

fn change<'a>(row: &ChangeRow, page_of: impl Fn(&Ident) -> Option<&'a str>) -> Change {
    Change {
        place: place(row),
        sentence: typeset(&row.sentence),
        moved: typeset(row.moved.as_deref().unwrap_or_default()),
        page: page_of(&row.ident).map(str::to_owned),
    }
}

/// What is said of one session: its changes, or that it is as before; empty where it cannot be compared.
pub(crate) fn of_session(rows: &[ChangeRow], session: &Ident) -> Vec<Change> {
    rows.iter()
        .filter(|r| r.ident.key() == session.key() && r.verdict != "too_few")
        .map(|r| change(r, |_| None))
        .collect()
}
