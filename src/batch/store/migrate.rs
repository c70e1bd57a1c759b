//! Outputs of earlier versions, with a file per session and table: their sessions are left to be taken in as if they
//! came from a batch of today. Nothing is computed; what has no log any more is kept.

use std::collections::BTreeSet;

use super::contents::Contents;
use super::marker::Committed;
use super::merge;
use super::parts;
use super::staged::{self, Staged};
use crate::batch::error::Error;
use crate::batch::jobs::work::SessionFile;
use crate::store::objects::Location;
use crate::store::tables::names::{file_name, is_plain};
use crate::store::tables::rows::{DiagnosisRow, Ident, SessionRow};
use crate::store::tables::{file, read, registry};

/// Moves every session that has files of its own; whether anything was there.
///
/// # Errors
/// A file cannot be read or removed; what is not moved yet stays as it was.
pub(crate) fn migrate(there: &Contents) -> Result<bool, Error> {
    let waiting: BTreeSet<&str> = there.staged().map(|(_, s)| s.session_id.as_str()).collect();
    let is_old = |row: &&Committed| row.is_old || !parts::is_part(&row.part);
    let old: Vec<&Committed> = there.taken_in().filter(is_old).collect();
    for row in &old {
        // one that a batch was writing when it was killed may be of two pieces: it is computed anew
        let mark = there.root().join(format!("{}/{}", there.kind.writing, row.part));
        let is_torn = mark.exists().map_err(|e| Error::Output(e.to_string()))?;
        if !is_torn && !waiting.contains(row.session_id.as_str()) {
            stage(there, row)?;
        }
        let marker = there.file(there.kind.marker.name, "parquet", &row.bike_id, &row.part);
        for at in shared(there, row).map(|(_, at)| at).chain([marker, mark]) {
            remove(&at)?;
        }
    }
    let torn = remove_torn(there)?;
    if !old.is_empty() {
        tracing::info!("{} sessions of an older layout move into a file per month", old.len());
    }
    Ok(torn || !old.is_empty())
}

/// Removes the tables of sessions that were being written for the first time: no commit marker tells of them.
fn remove_torn(there: &Contents) -> Result<bool, Error> {
    let folder = there.root().join(there.kind.writing);
    let mut any = false;
    for entry in folder.list().map_err(|e| Error::Output(format!("{folder}: {e}")))? {
        let mark = folder.join(&entry.key);
        let bikes = mark.read().map_err(|e| Error::Output(format!("cannot read {mark}: {e}")))?;
        for bike_id in String::from_utf8_lossy(&bikes).lines().filter(|b| is_plain(b)) {
            let row = Committed {
                bike_id: bike_id.to_owned(),
                part: entry.key.clone(),
                ..Committed::default()
            };
            for (_, at) in shared(there, &row).filter(|_| !parts::is_part(&row.part)) {
                remove(&at)?;
            }
        }
        remove(&mark)?;
        any = true;
    }
    Ok(any)
}

fn remove(at: &Location) -> Result<(), Error> {
    at.remove().map_err(|e| Error::Output(format!("cannot remove {at}: {e}")))
}

/// The files of a session that are shared today, but for its commit marker.
fn shared<'a>(
    there: &'a Contents,
    row: &'a Committed,
) -> impl Iterator<Item = (&'static registry::TableSpec, Location)> + 'a {
    let tables = there.kind.tables().filter(|spec| parts::shares(spec));
    tables.map(|spec| (spec, there.file(spec.name, "parquet", &row.bike_id, &row.part)))
}

fn stage(there: &Contents, row: &Committed) -> Result<(), Error> {
    let kind = there.kind;
    let marker = (kind.marker, there.file(kind.marker.name, "parquet", &row.bike_id, &row.part));
    let mut files = Vec::new();
    for (spec, at) in shared(there, row).chain([marker]) {
        let bytes = match at.read() {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => continue,
            Err(e) => return Err(Error::Output(format!("cannot read {at}: {e}"))),
        };
        if let Err(e) = merge::of_today(spec, bytes.clone().into()) {
            tracing::warn!("{at}: {e}; session {} is computed anew", row.session_id);
            return Ok(());
        }
        files.push(SessionFile { folder: spec.name, extension: "parquet", bytes });
    }
    let bytes = files.iter().find(|f| f.folder == kind.marker.name).map(|f| f.bytes.clone());
    let start = bytes.and_then(|bytes| start(kind.marker, &row.session_id, bytes));
    let made = Committed { part: parts::of(start.as_deref()), is_old: false, ..row.clone() };
    // files of their own stay where they are, and are its own still
    let own = kind.tables().filter(|spec| !parts::shares(spec)).map(|spec| (spec.name, "parquet"));
    let mut folders: Vec<String> = files.iter().map(|f| f.folder.to_owned()).collect();
    for (folder, extension) in own.chain(kind.other_files.iter().copied()) {
        let at = there.file(folder, extension, &row.bike_id, &file_name(&row.session_id));
        if at.exists().map_err(|e| Error::Output(format!("{at}: {e}")))? {
            folders.push(folder.to_owned());
        }
    }
    let staged = Staged {
        bike_id: row.bike_id.clone(),
        session_id: row.session_id.clone(),
        made: Some(made),
        folders,
    };
    let bytes = staged::encode(&staged, &files).map_err(|e| Error::Internal(e.to_string()))?;
    Ok(file::write_bytes(there.staging(&row.key()), &bytes)?)
}

/// When a session began, as its commit marker says.
fn start(marker: &registry::TableSpec, session_id: &str, bytes: Vec<u8>) -> Option<String> {
    let at = Location::Local(session_id.into());
    let idents: Vec<Ident> = match marker.is(&registry::DIAGNOSES) {
        true => {
            let rows: Vec<DiagnosisRow> = read::rows_of(&at, bytes).ok()?;
            rows.into_iter().map(|row| row.ident).collect()
        }
        false => {
            let rows: Vec<SessionRow> = read::rows_of(&at, bytes).ok()?;
            rows.into_iter().map(|row| row.ident).collect()
        }
    };
    idents.into_iter().find(|ident| ident.session_id == session_id)?.start_time
}
