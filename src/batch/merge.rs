//! Takes the sessions that wait ([`staged`](super::staged)) into the tables: each file of a motorcycle and month that they
//! concern is written anew, whole, with its sessions in order of id; the commit markers last.
//!
//! What waits is removed only when all of it is in: whoever is killed over it leaves it to the next, which does the same
//! once more. A file's bytes depend on the sessions in it only.

use std::collections::{BTreeMap, BTreeSet};

use arrow::array::{AsArray, RecordBatch};
use arrow::compute::concat_batches;
use bytes::Bytes;
use rayon::prelude::*;

use super::contents::Contents;
use super::error::Error;
use super::marker::Committed;
use super::parts;
use super::staged::{self, Files, Staged};
use crate::objects::Location;
use crate::objects::files::{read_many, remove_many};
use crate::tables::names::file_name;
use crate::tables::registry::{Presence, TableSpec};
use crate::tables::{file, read};

/// So many sessions of one motorcycle and month are in memory at once.
const TOGETHER: usize = 500;

/// What changes in the files of a motorcycle and month.
#[derive(Debug, Default)]
struct Group<'a> {
    /// Sessions that go, or are replaced.
    gone: BTreeSet<&'a str>,
    /// Sessions that come, and their files.
    come: Vec<(&'a Location, &'a Staged)>,
}

/// Takes in all that waits.
///
/// # Errors
/// A table cannot be read, or the output not be written: what waits goes on waiting.
pub fn merge(there: &Contents) -> Result<(), Error> {
    let mut waits: Vec<(&Location, &Staged)> = there.staged().collect();
    let mut groups: BTreeMap<(&str, &str), Group<'_>> = BTreeMap::new();
    let ids: BTreeSet<&str> = waits.iter().map(|(_, s)| s.session_id.as_str()).collect();
    let mut old: Vec<&Committed> = Vec::new();
    for row in there.taken_in().filter(|row| ids.contains(row.session_id.as_str())) {
        groups.entry((&row.bike_id, &row.part)).or_default().gone.insert(&row.session_id);
        old.push(row);
    }
    for (at, staged) in &waits {
        if let Some(made) = &staged.made {
            groups.entry((&made.bike_id, &made.part)).or_default().come.push((at, staged));
        }
    }
    let groups: Vec<_> = groups.into_iter().collect();
    let merged: Vec<Result<(), Error>> = groups
        .par_iter()
        .map(|((bike_id, part), Group { gone, come })| {
            let mut chunks = come.chunks(TOGETHER);
            take(there, bike_id, part, gone, chunks.next().unwrap_or_default())?;
            chunks.try_for_each(|some| take(there, bike_id, part, &BTreeSet::new(), some))
        })
        .collect();
    // what could not be taken in waits on, the rest is in
    let mut wait_on: BTreeSet<&str> = BTreeSet::new();
    let mut failed = None;
    for ((_, Group { gone, come }), merged) in groups.iter().zip(merged) {
        if let Err(e) = merged {
            wait_on.extend(gone);
            wait_on.extend(come.iter().map(|(_, staged)| staged.session_id.as_str()));
            failed.get_or_insert(e);
        }
    }
    waits.retain(|(_, staged)| !wait_on.contains(staged.session_id.as_str()));
    old.retain(|row| !wait_on.contains(row.session_id.as_str()));
    remove_own_files(there, &waits, &old)?;
    let files: Vec<&Location> = waits.iter().map(|(at, _)| *at).collect();
    remove_many(&files)
        .map_err(|e| Error::Output(format!("cannot remove what was taken in: {e}")))?;
    failed.map_or(Ok(()), Err)
}

/// Takes some sessions into the files of a motorcycle and month.
fn take(
    there: &Contents,
    bike_id: &str,
    part: &str,
    gone: &BTreeSet<&str>,
    come: &[(&Location, &Staged)],
) -> Result<(), Error> {
    let mut new: Vec<(&str, Files)> = Vec::with_capacity(come.len());
    let files: Vec<&Location> = come.iter().map(|(at, _)| *at).collect();
    for ((at, staged), bytes) in come.iter().zip(read_many(&files)) {
        let fail = |e: String| Error::Output(format!("cannot read {at}: {e}"));
        let bytes = bytes.map_err(|e| fail(e.to_string()))?;
        new.push((&staged.session_id, staged::files(bytes).map_err(fail)?));
    }
    new.sort_by_key(|(id, _)| *id);
    let mut replaced = gone.clone();
    replaced.extend(new.iter().map(|(id, _)| *id));
    let kind = there.kind;
    // files of their own
    for (id, files) in &new {
        for (folder, (extension, bytes)) in files {
            let is_shared = kind.tables().any(|spec| spec.name == folder && parts::shares(spec));
            if !is_shared && folder != kind.marker.name {
                let at = there.file(folder, extension, bike_id, &file_name(id));
                file::write_bytes(at, bytes)?;
            }
        }
    }
    let mut tables: Vec<&TableSpec> = kind.tables().filter(|spec| parts::shares(spec)).collect();
    tables.push(kind.marker);
    let marker = there.file(kind.marker.name, "parquet", bike_id, part);
    // rows whose commit marker somebody has removed are nobody's
    let mut committed: BTreeSet<String> =
        sessions(kind.marker, &marker, &replaced)?.into_keys().collect();
    committed.extend(new.iter().map(|(id, _)| (*id).to_owned()));
    let is_empty = committed.is_empty();
    for spec in tables {
        let at = there.file(spec.name, "parquet", bike_id, part);
        let mut rows = sessions(spec, &at, &replaced)?;
        rows.retain(|id, _| committed.contains(id));
        for (id, files) in &new {
            let Some((_, bytes)) = files.get(spec.name) else { continue };
            let batches = typed(spec, &at, bytes.clone())?;
            rows.entry((*id).to_owned()).or_default().extend(batches);
        }
        let batches: Vec<RecordBatch> = rows.into_values().flatten().collect();
        let is_needed =
            batches.iter().any(|b| b.num_rows() > 0) || spec.presence == Presence::Always;
        if is_empty || !is_needed {
            remove(&at)?;
            continue;
        }
        let table = spec.table();
        let all = concat_batches(&table.flat(), &batches)
            .map_err(|e| e.to_string())
            .and_then(|all| file::typed(table, &all))
            .map_err(|e| Error::Internal(format!("{at}: {e}")))?;
        file::write_batch(at, &all)?;
    }
    Ok(())
}

/// The rows that a file has, but for some sessions', session by session; none where there is no file.
fn sessions(
    spec: &TableSpec,
    at: &Location,
    without: &BTreeSet<&str>,
) -> Result<BTreeMap<String, Vec<RecordBatch>>, Error> {
    let mut out: BTreeMap<String, Vec<RecordBatch>> = BTreeMap::new();
    let bytes = match at.read() {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(out),
        bytes => bytes.map_err(|e| Error::Output(format!("cannot read {at}: {e}")))?,
    };
    for batch in typed(spec, at, Bytes::from(bytes))? {
        let ids = batch.column_by_name("session_id").and_then(|c| c.as_string_opt::<i32>());
        let Some(ids) = ids else { continue }; // every table of a session has it
        let mut from = 0;
        while from < batch.num_rows() {
            let id = ids.value(from);
            let n = (from..batch.num_rows()).take_while(|i| ids.value(*i) == id).count();
            if !without.contains(id) {
                out.entry(id.to_owned()).or_default().push(batch.slice(from, n));
            }
            from += n;
        }
    }
    Ok(out)
}

/// The batches of a table's file in its schema of today, categories as texts.
fn typed(spec: &TableSpec, at: &Location, bytes: Bytes) -> Result<Vec<RecordBatch>, Error> {
    let batches = read::batches_of(bytes).and_then(|batches| {
        batches.iter().map(|batch| file::flat(spec.table(), batch)).collect::<Result<Vec<_>, _>>()
    });
    batches.map_err(|e| {
        Error::Output(format!(
            "cannot read {at}: {e}; remove it and run again: its sessions are then computed anew"
        ))
    })
}

/// Removes the files of their own that sessions had and have no more.
fn remove_own_files(
    there: &Contents,
    waits: &[(&Location, &Staged)],
    old: &[&Committed],
) -> Result<(), Error> {
    let kind = there.kind;
    let own = kind.tables().filter(|spec| !parts::shares(spec)).map(|spec| (spec.name, "parquet"));
    let own: Vec<(&str, &str)> = own.chain(kind.other_files.iter().copied()).collect();
    let has: BTreeSet<Location> = waits
        .iter()
        .flat_map(|(_, staged)| staged.made.iter().map(move |made| (staged, made)))
        .flat_map(|(staged, made)| {
            let name = file_name(&made.session_id);
            let own = own.iter().filter(|(folder, _)| staged.folders.iter().any(|f| f == folder));
            own.map(move |(folder, end)| there.file(folder, end, &made.bike_id, &name))
        })
        .collect();
    for row in old {
        for (folder, extension) in &own {
            let at = there.file(folder, extension, &row.bike_id, &file_name(&row.session_id));
            if !has.contains(&at) && there.may_have(&at) {
                remove(&at)?;
            }
        }
    }
    Ok(())
}

fn remove(at: &Location) -> Result<(), Error> {
    at.remove().map_err(|e| Error::Output(format!("cannot remove {at}: {e}")))?;
    if let Some(folder) = at.as_path().and_then(std::path::Path::parent) {
        let _ = std::fs::remove_dir(folder); // if it was the motorcycle's last
    }
    Ok(())
}
