//! The mark of an output: the file `<out>/.roadbench/output.json`, which every batch writes first.
//!
//! Commands that remove or replace files do so only below a folder with this mark. Outputs of versions that wrote no mark
//! are recognised by their checksums or tables.

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

/// Folder of internal files, below the output.
pub(crate) const FOLDER: &str = ".roadbench";
/// Path of the mark, below the output.
pub(crate) const PATH: &str = ".roadbench/output.json";

/// Version of the output's layout that this program writes.
const FORMAT: u32 = 1;

/// Tables: an output of an earlier version has at least one of them.
const TABLES: [&TableSpec; 3] = [&registry::SESSIONS, &registry::DIAGNOSES, &registry::REJECTED];

#[derive(Debug, Serialize, Deserialize)]
struct Mark {
    program: String,
    format: u32,
}

/// Whether a folder is an output.
///
/// # Errors
/// It cannot be read, or a newer roadbench made it.
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

/// Checks the version of a mark. A mark that cannot be parsed counts, too: only roadbench writes a file of that name.
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

/// Refuses a folder that is no output.
///
/// # Errors
/// It is no output, cannot be read, or a newer roadbench made it.
pub(crate) fn require(root: &Location) -> Result<(), Error> {
    match is_output(root)? {
        true => Ok(()),
        false => Err(Error::Usage(format!(
            "{root} is not an output of roadbench ({PATH} is not there); give the folder of `roadbench run --out`"
        ))),
    }
}

/// Makes a folder an output. Files in the folders of tables must be roadbench's own.
///
/// # Errors
/// Other files are where tables would go, a newer roadbench made the output, or it cannot be written.
pub(crate) fn claim(root: &Location) -> Result<(), Error> {
    let fail = |e: std::io::Error| Error::Output(format!("cannot read --out {root}: {e}"));
    if !is_output(root)? {
        for folder in registry::folders() {
            let entries = root.join(folder).list().map_err(fail)?;
            // a file in place of the folder is reported when the folder is created
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

/// Marks the tables over all sessions as out of date, for each command with sessions: they were made without damaged
/// tables. Those may come back from a backup, which changes no session; the next batch then makes the tables again.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn mark_out_of_date(root: &Location) -> Result<(), Error> {
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

/// Table of a Parquet file, by its metadata; `None` if the file is not a table of an output.
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
