//! What makes a folder an output: the file `<out>/.roadbench/output.json`, which every batch writes first.
//!
//! Commands that remove or replace files do so only below a folder with this mark. Versions that wrote none are known
//! by their checksums or by a table of theirs.

use std::io::ErrorKind;

use bytes::Bytes;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::reader::ChunkReader;
use serde::{Deserialize, Serialize};

use super::kind::{DIAGNOSE, RUN};
use super::manifest;
use crate::batch::error::Error;
use crate::store::objects::Location;
use crate::store::tables::file;
use crate::store::tables::registry;
use crate::store::tables::registry::TableSpec;

/// What roadbench keeps for itself of an output.
pub(crate) const FOLDER: &str = ".roadbench";
/// Where the mark is, below the output.
pub(crate) const PATH: &str = ".roadbench/output.json";

/// The layout of outputs that this version writes.
const FORMAT: u32 = 1;

/// Tables of which an output of an earlier version has one at least.
const TABLES: [&TableSpec; 3] = [&registry::SESSIONS, &registry::DIAGNOSES, &registry::REJECTED];

#[derive(Debug, Serialize, Deserialize)]
struct Mark {
    program: String,
    format: u32,
}

/// Whether this is an output.
///
/// # Errors
/// It cannot be looked at, or a newer roadbench made it.
pub fn is_output(root: &Location) -> Result<bool, Error> {
    let fail = |e: std::io::Error| Error::Output(format!("cannot read {root}: {e}"));
    let at = root.join(PATH);
    match at.read() {
        Ok(bytes) => return check(root, &bytes).map(|()| true),
        Err(e) if [ErrorKind::NotFound, ErrorKind::NotADirectory].contains(&e.kind()) => {}
        Err(e) => return Err(fail(e)),
    }
    if root.join(manifest::PATH).exists().map_err(fail)? {
        return Ok(true);
    }
    for spec in TABLES {
        let folder = root.join(spec.name);
        let entries = folder.list().map_err(fail)?;
        let first = entries.iter().find(|e| e.key.ends_with(".parquet"));
        let bytes = first.and_then(|entry| folder.join(&entry.key).read().ok());
        if bytes.is_some_and(|bytes| table_of(Bytes::from(bytes)).is_some_and(|t| t.is(spec))) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// A mark that cannot be read is one all the same: only roadbench has a file of that name there.
fn check(root: &Location, bytes: &[u8]) -> Result<(), Error> {
    match serde_json::from_slice::<Mark>(bytes) {
        Ok(mark) if mark.format > FORMAT => Err(Error::Usage(format!(
            "{root} was made by a newer roadbench (format {}, this one knows {FORMAT}); use that one, or choose another \
             --out",
            mark.format
        ))),
        _ => Ok(()),
    }
}

/// Refuses what is no output.
///
/// # Errors
/// It is none, cannot be looked at, or a newer roadbench made it.
pub(crate) fn require(root: &Location) -> Result<(), Error> {
    match is_output(root)? {
        true => Ok(()),
        false => Err(Error::Usage(format!(
            "{root} is not an output of roadbench ({PATH} is not there); give the folder of `roadbench run --out`"
        ))),
    }
}

/// Makes a folder an output. What it has below the names of tables must be ours.
///
/// # Errors
/// Somebody else's files are where tables would go, a newer roadbench made it, or it cannot be written.
pub(crate) fn claim(root: &Location) -> Result<(), Error> {
    let fail = |e: std::io::Error| Error::Output(format!("cannot read --out {root}: {e}"));
    if !is_output(root)? {
        for folder in registry::folders() {
            let entries = root.join(folder).list().map_err(fail)?;
            // a file in place of a folder is told of when the folder is made
            if let Some(first) = entries.iter().find(|e| !e.key.is_empty()) {
                return Err(Error::Usage(format!(
                    "--out {root}: {folder}/{} is where tables would go, and roadbench did not write it; choose another \
                     --out",
                    first.key
                )));
            }
        }
    }
    let mark = Mark { program: "roadbench".to_owned(), format: FORMAT };
    let text = serde_json::to_vec_pretty(&mark).map_err(|e| Error::Internal(e.to_string()))?;
    let at = root.join(PATH);
    if at.read().is_ok_and(|there| there == text) {
        return Ok(());
    }
    Ok(file::write_bytes(at, &text)?)
}

/// Marks what is made over all sessions as older than they are, of each command that has sessions: it was made without
/// tables that were damaged. They may come back from a backup, which changes no session; the next batch makes it again.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn stay_behind(root: &Location) -> Result<(), Error> {
    for kind in [&RUN, &DIAGNOSE] {
        let sessions = root.join(kind.marker.name);
        let has_any =
            sessions.is_folder().map_err(|e| Error::Output(format!("{sessions}: {e}")))?;
        if has_any {
            file::write_bytes(root.join(kind.behind), b"")?;
        }
    }
    Ok(())
}

/// The table that a Parquet file says to be; none where it is no such file, or no output table.
pub(crate) fn table_of(file: impl ChunkReader + 'static) -> Option<&'static TableSpec> {
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).ok()?;
    registry::find(builder.schema().metadata().get("roadbench.table")?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tables::rows::SessionRow;

    #[test]
    fn a_folder_is_an_output_by_its_mark_or_by_a_table_of_ours() {
        let folder = tempfile::tempdir().expect("folder");
        let root = Location::from(folder.path());
        assert!(!is_output(&root).expect("looked at"));
        // logs of riding are no tables of ours, whatever their folder is called
        root.join("sessions/bike=b/ride.parquet").write(b"no table").expect("written");
        assert!(!is_output(&root).expect("looked at"));
        let refused = claim(&root).expect_err("somebody else's").to_string();
        assert!(refused.contains("sessions/bike=b/ride.parquet"), "{refused}");
        let bytes = file::to_bytes(&[SessionRow::default()]).expect("a table");
        root.join("sessions/bike=b/ride.parquet").write(&bytes).expect("written");
        assert!(is_output(&root).expect("looked at"), "an earlier version's");
        claim(&root).expect("ours");
        root.join("sessions/bike=b/ride.parquet").remove().expect("removed");
        assert!(is_output(&root).expect("looked at"), "by its mark");
        root.join(PATH).write(br#"{"program": "roadbench", "format": 2}"#).expect("written");
        assert!(matches!(is_output(&root), Err(Error::Usage(m)) if m.contains("newer")));
    }
}
