//! Merges staged sessions ([`mod@staged`]) into the tables. Each file of a motorcycle and month that has such sessions is
//! written anew, with its sessions in order of id; then all of these files are put in place at once
//! ([`mod@switch`](super::switch)).
//!
//! Staged sessions are removed only when all are merged: after a crash the next command merges them again. A file's
//! bytes depend only on the sessions in it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use arrow::array::{ArrayRef, AsArray, RecordBatch, StringArray};
use arrow::compute::concat_batches;
use bytes::Bytes;
use rayon::prelude::*;

use super::contents::Contents;
use super::manifest::{self, Manifest};
use super::marker::{Committed, Key};
use super::parts;
use super::staged::{self, Staged};
use super::switch::{Changes, Next, Switching};
use super::verify;
use crate::batch::error::Error;
use crate::batch::jobs::work::SHARE;
use crate::store::objects::Location;
use crate::store::objects::files::read_many;
use crate::store::tables::mismatch::Mismatch;
use crate::store::tables::names::file_name;
use crate::store::tables::registry::{Presence, TableSpec};
use crate::store::tables::{arrow_stream, file, read};

/// Largest number of sessions of one motorcycle and month that are in memory at once.
const MAX_SESSIONS: usize = 500;
/// Largest number of staged sessions that are read together: they may hold time series.
const MAX_READ: usize = 16;

/// Changes in the files of a motorcycle and month.
#[derive(Debug, Default)]
struct Group<'a> {
    /// Ids of sessions to remove or replace.
    gone: BTreeSet<&'a str>,
    /// Staged sessions to add, and their files.
    come: Vec<(&'a Location, &'a Staged)>,
}

/// A session's rows by table.
type Rows = BTreeMap<&'static str, Vec<RecordBatch>>;

/// Id of a staged session, and its rows.
type StagedRows<'a> = (&'a str, Rows);

/// Check that this process still holds the lock of the output.
pub(crate) type Check<'a> = &'a (dyn Fn() -> std::io::Result<()> + Sync);

/// Merges all staged sessions; `check` is called before any file is put in place. The first result keeps readers out until
/// the tables over all sessions are made. The second is the reason why a month of a motorcycle could not be merged: its
/// sessions stay staged.
///
/// # Errors
/// The output cannot be written: all sessions stay staged.
pub(crate) fn merge(
    there: &Contents,
    check: Check<'_>,
) -> Result<(Option<Switching>, Option<Error>), Error> {
    let mut waits: Vec<(&Location, &Staged)> = there.staged().collect();
    let mut groups: BTreeMap<(&str, &str), Group<'_>> = BTreeMap::new();
    let keys: BTreeSet<Key> = waits.iter().map(|(_, s)| s.key()).collect();
    let mut old: Vec<&Committed> = Vec::new();
    for row in there.taken_in().filter(|row| keys.contains(&row.key())) {
        groups.entry((&row.bike_id, &row.part)).or_default().gone.insert(&row.session_id);
        old.push(row);
    }
    for (at, staged) in &waits {
        if let Some(made) = &staged.made {
            groups.entry((&made.bike_id, &made.part)).or_default().come.push((at, staged));
        }
    }
    for row in earlier(there) {
        groups.entry(row).or_default();
    }
    let mut list = Manifest::read(there.root());
    if !list.is_there {
        list = verify::adopt(there.root())?;
    }
    let is_ours = || check().map_err(|e| Error::Output(format!("{}: {e}", there.root())));
    is_ours()?;
    let next = Next::begin(there.kind, there.root(), list, || concerned(there, &groups, &old))?;
    let groups: Vec<_> = groups.into_iter().collect();
    let merged: Vec<Result<Changes, Error>> = groups
        .par_iter()
        .map(|((bike_id, part), Group { gone, come })| {
            let files = Files { there, check, bike_id, part, next: &next };
            let mut changes = Changes::new();
            // sessions that a later chunk replaces stay until then
            let mut first = gone.clone();
            for (_, staged) in come.iter().skip(MAX_SESSIONS) {
                first.remove(staged.session_id.as_str());
            }
            let mut chunks = come.chunks(MAX_SESSIONS);
            files.merge_chunk(&first, chunks.next().unwrap_or_default(), &mut changes)?;
            chunks.try_for_each(|some| files.merge_chunk(&BTreeSet::new(), some, &mut changes))?;
            Ok(changes)
        })
        .collect();
    // groups that could not be merged stay staged, the others are merged
    let mut wait_on: BTreeSet<Key> = BTreeSet::new();
    let mut changes = Changes::new();
    let mut failed = None;
    for (((bike_id, _), Group { gone, come }), merged) in groups.iter().zip(merged) {
        match merged {
            Ok(some) => changes.extend(some),
            // nothing of it was to change but names
            Err(e) if gone.is_empty() && come.is_empty() => {
                tracing::warn!("{bike_id}: a month keeps the columns of an earlier version: {e}");
            }
            Err(e) => {
                wait_on.extend(gone.iter().map(|id| Key::new(bike_id, id)));
                wait_on.extend(come.iter().map(|(_, staged)| staged.key()));
                failed.get_or_insert(e);
            }
        }
    }
    waits.retain(|(_, staged)| !wait_on.contains(&staged.key()));
    old.retain(|row| !wait_on.contains(&row.key()));
    for path in own_files_gone(there, &next.list, &waits, &old) {
        next.remove(path, &mut changes)?;
    }
    let files: Vec<&Location> = waits.iter().map(|(at, _)| *at).collect();
    is_ours()?;
    let switching = next.commit(changes, &files)?;
    let bikes: BTreeSet<&str> = groups.iter().map(|((bike, _), _)| *bike).collect();
    remove_empty_folders(there, &bikes);
    Ok((switching, failed))
}

/// The files of a motorcycle and month.
struct Files<'a> {
    there: &'a Contents,
    check: Check<'a>,
    bike_id: &'a str,
    part: &'a str,
    next: &'a Next<'a>,
}

/// Months whose tables are of an earlier version: they are written in that of today with the others, so that readers who
/// know of no versions find one set of columns. In an object store they stay as they are until a session of them changes.
fn earlier(there: &Contents) -> BTreeSet<(&str, &str)> {
    let is_renamed = |spec: &&TableSpec| parts::shares(spec) && spec.table().version > 1;
    let renamed: Vec<&TableSpec> = there.kind.tables().filter(is_renamed).collect();
    let is_earlier = |(bike, part): &(&str, &str)| {
        renamed.iter().any(|spec| {
            let at = there.file(spec.name, "parquet", bike, part);
            let file = at.as_path().and_then(|path| std::fs::File::open(path).ok());
            file.is_some_and(|file| read::is_earlier(spec, file))
        })
    };
    let months: BTreeSet<(&str, &str)> =
        there.taken_in().map(|row| (row.bike_id.as_str(), row.part.as_str())).collect();
    months.into_par_iter().filter(is_earlier).collect()
}

/// The files that a merge may change, as the list of checksums has them.
fn concerned(
    there: &Contents,
    groups: &BTreeMap<(&str, &str), Group<'_>>,
    old: &[&Committed],
) -> Vec<String> {
    let kind = there.kind;
    let mut paths = Vec::new();
    for (bike_id, part) in groups.keys() {
        let all = kind.tables().filter(|spec| parts::shares(spec)).chain([kind.marker]);
        paths.extend(all.map(|spec| there.file(spec.name, "parquet", bike_id, part)));
    }
    let own = kind.tables().filter(|spec| !parts::shares(spec)).map(|spec| (spec.name, "parquet"));
    let own: Vec<(&str, &str)> = own.chain(kind.other_files.iter().copied()).collect();
    let come = groups.iter().flat_map(|((bike, _), group)| {
        group.come.iter().map(move |(_, staged)| (*bike, staged.session_id.as_str()))
    });
    let gone = old.iter().map(|row| (row.bike_id.as_str(), row.session_id.as_str()));
    for (bike, session) in come.chain(gone) {
        let name = file_name(session);
        paths.extend(own.iter().map(|(folder, end)| there.file(folder, end, bike, &name)));
    }
    paths.iter().filter_map(|at| manifest::below(there.root(), at)).collect()
}

impl Files<'_> {
    /// Adds some sessions and removes others, table by table, so that only one table and the new rows are in memory. The
    /// files are not put in place yet: if a later table cannot be read, none of them is.
    fn merge_chunk(
        &self,
        gone: &BTreeSet<&str>,
        come: &[(&Location, &Staged)],
        changes: &mut Changes,
    ) -> Result<(), Error> {
        let kind = self.there.kind;
        let mut tables: Vec<&'static TableSpec> =
            kind.tables().filter(|spec| parts::shares(spec)).collect();
        tables.push(kind.marker);
        let mut new = self.come(&tables, come, changes)?;
        let mut replaced = gone.clone();
        // one that could not be read stays as it was
        come.iter().for_each(|(_, staged)| _ = replaced.remove(staged.session_id.as_str()));
        replaced.extend(new.iter().map(|(id, _)| *id));
        // rows without a commit marker belong to no session
        let marker = match self.sessions(kind.marker, &replaced, changes) {
            Ok(marker) => marker,
            // damaged markers do not matter if all their sessions are replaced
            Err(_) if self.others(&tables, &replaced, changes)?.is_empty() => BTreeMap::new(),
            Err(e) => return Err(e),
        };
        let kept: BTreeSet<String> = marker.into_keys().collect();
        let mut is_lost = false;
        for spec in tables {
            let at = self.at(spec);
            self.refuse_newer(spec, &at, changes)?;
            // if no session is kept, the existing file need not be read
            let mut rows = match kept.is_empty() {
                true => BTreeMap::new(),
                false => self.sessions(spec, &replaced, changes)?,
            };
            rows.retain(|id, _| kept.contains(id));
            let is_always = spec.presence == Presence::Always;
            is_lost |= is_always
                && !kept.is_empty()
                && rows.is_empty()
                && self.read(&at, changes)?.is_none();
            if spec.is(kind.marker) && is_lost {
                // a table of the month is missing: the next run computes its other sessions
                for batches in rows.values_mut() {
                    *batches = batches.iter().map(without_input).collect::<Result<_, _>>()?;
                }
            }
            for (id, of_session) in &mut new {
                let batches = of_session.remove(spec.name).unwrap_or_default();
                rows.entry((*id).to_owned()).or_default().extend(batches);
            }
            // one batch per session, so that the file's bytes do not depend on how its rows were read
            let schema = spec.table().arrow();
            let whole = |some: Vec<RecordBatch>| match <[RecordBatch; 1]>::try_from(some) {
                Ok([batch]) => Ok(batch),
                Err(some) => concat_batches(&schema, &some),
            };
            let batches: Vec<RecordBatch> = rows
                .into_values()
                .map(whole)
                .collect::<Result<_, _>>()
                .map_err(|e| Error::Internal(format!("{at}: {e}")))?;
            let is_empty = kept.is_empty() && new.is_empty();
            let is_needed = is_always || batches.iter().any(|b| b.num_rows() > 0);
            (self.check)().map_err(|e| Error::Output(format!("{at}: {e}")))?;
            match !is_empty && is_needed {
                true => {
                    let bytes = file::batches_to_bytes(spec.table(), &batches)?;
                    self.next.write(self.path(&at)?, &bytes, changes)?;
                }
                false => self.next.remove(self.path(&at)?, changes)?,
            }
        }
        Ok(())
    }

    /// Sessions that have rows in any table but the commit markers, without some.
    fn others(
        &self,
        tables: &[&'static TableSpec],
        without: &BTreeSet<&str>,
        changes: &Changes,
    ) -> Result<BTreeSet<String>, Error> {
        let mut ids = BTreeSet::new();
        for spec in tables.iter().filter(|spec| !spec.is(self.there.kind.marker)) {
            ids.extend(self.sessions(spec, without, changes)?.into_keys());
        }
        Ok(ids)
    }

    /// Reads the staged sessions. Files that a session has for itself are written at once, as they may be large. A staged
    /// session that cannot be read is removed: the next run computes it.
    fn come<'a>(
        &self,
        tables: &[&'static TableSpec],
        come: &[(&Location, &'a Staged)],
        changes: &mut Changes,
    ) -> Result<Vec<StagedRows<'a>>, Error> {
        let mut new: Vec<StagedRows<'a>> = Vec::with_capacity(come.len());
        for some in come.chunks(MAX_READ) {
            let files: Vec<&Location> = some.iter().map(|(at, _)| *at).collect();
            for ((at, staged), bytes) in some.iter().zip(read_many(&files)) {
                let bytes = bytes.map_err(|e| Error::Output(format!("cannot read {at}: {e}")))?;
                match self.session(tables, &staged.session_id, bytes, changes)? {
                    Ok(rows) => new.push((&staged.session_id, rows)),
                    Err(e) => {
                        tracing::error!(
                            "{at}: {e}; the file was removed, and the next run computes the session"
                        );
                        remove(at)?;
                    }
                }
            }
        }
        new.sort_by_key(|(id, _)| *id);
        Ok(new)
    }

    /// A session's rows by table, and why they cannot be read; its own files are written.
    fn session(
        &self,
        tables: &[&'static TableSpec],
        id: &str,
        bytes: Bytes,
        changes: &mut Changes,
    ) -> Result<Result<Rows, Mismatch>, Error> {
        let files = match staged::files(bytes) {
            Ok(files) => files,
            Err(e) => return Ok(Err(e)),
        };
        let mut rows = BTreeMap::new();
        for spec in tables {
            let Some((extension, bytes)) = files.get(spec.name) else { continue };
            let batches = match extension == SHARE {
                true => arrow_stream::decode(bytes.clone()).and_then(|some| conform(spec, &some)),
                false => of_today(spec, bytes.clone()), // what an earlier version left
            };
            match batches {
                Ok(batches) => _ = rows.insert(spec.name, batches),
                Err(e) => return Ok(Err(Mismatch::from(format!("{}: {e}", spec.name)))),
            }
        }
        for (folder, (extension, bytes)) in &files {
            if tables.iter().all(|spec| spec.name != folder) {
                let at = self.there.file(folder, extension, self.bike_id, &file_name(id));
                (self.check)().map_err(|e| Error::Output(format!("{at}: {e}")))?;
                self.next.write(self.path(&at)?, bytes, changes)?;
            }
        }
        Ok(Ok(rows))
    }

    /// Refuses a table of a newer roadbench: this one would lose columns that it does not know.
    fn refuse_newer(
        &self,
        spec: &TableSpec,
        at: &Location,
        changes: &Changes,
    ) -> Result<(), Error> {
        let Some(path) =
            at.as_path().filter(|_| !changes.contains_key(&*self.path(at).unwrap_or_default()))
        else {
            return Ok(());
        };
        let newer = std::fs::File::open(path).ok().and_then(|file| read::newer_schema(spec, file));
        match newer {
            None => Ok(()),
            Some(schema) => Err(Error::Output(format!(
                "{at} was written by a newer roadbench ({schema}); use that one, or choose another --out"
            ))),
        }
    }

    /// A file as the output names it.
    fn path(&self, at: &Location) -> Result<String, Error> {
        let path = manifest::below(self.there.root(), at);
        path.ok_or_else(|| Error::Internal(format!("{at} is not in the output")))
    }

    /// Reads a table of the output; a table whose checksum is wrong is refused.
    fn read(&self, at: &Location, changes: &Changes) -> Result<Option<Vec<u8>>, Error> {
        let path = self.path(at)?;
        let Some(place) = self.next.place(&path, changes) else { return Ok(None) };
        let bytes = match place.read() {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            bytes => bytes.map_err(|e| Error::Output(format!("cannot read {at}: {e}")))?,
        };
        match self.next.checksum(&path, changes) {
            Some(sum) if manifest::checksum(&bytes) != sum => Err(Error::Output(format!(
                "{at} is damaged (a bad disk, or another program), and has sessions whose logs are \
                 not among the inputs; new sessions of its month wait. Restore it from a backup, \
                 run over all logs, or remove its rows with `roadbench verify {} --mend --lose`",
                self.there.root()
            ))),
            _ => Ok(Some(bytes)),
        }
    }

    /// Rows of a file by session, without those of some sessions; empty if there is no file.
    fn sessions(
        &self,
        spec: &TableSpec,
        without: &BTreeSet<&str>,
        changes: &Changes,
    ) -> Result<BTreeMap<String, Vec<RecordBatch>>, Error> {
        let mut out: BTreeMap<String, Vec<RecordBatch>> = BTreeMap::new();
        let at = self.at(spec);
        let Some(bytes) = self.read(&at, changes)? else { return Ok(out) };
        for batch in typed(spec, &at, Bytes::from(bytes))? {
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

    fn at(&self, spec: &TableSpec) -> Location {
        self.there.file(spec.name, "parquet", self.bike_id, self.part)
    }
}

/// Rows of commit markers that name no input: their sessions are computed again.
fn without_input(batch: &RecordBatch) -> Result<RecordBatch, Error> {
    let schema = batch.schema();
    let columns = schema.fields().iter().zip(batch.columns()).map(|(field, column)| {
        match field.name() == "input_hash" {
            true => Arc::new(StringArray::from(vec![""; batch.num_rows()])) as ArrayRef,
            false => Arc::clone(column),
        }
    });
    RecordBatch::try_new(Arc::clone(&schema), columns.collect())
        .map_err(|e| Error::Internal(e.to_string()))
}

/// The batches of a table's file.
fn typed(spec: &TableSpec, at: &Location, bytes: Bytes) -> Result<Vec<RecordBatch>, Error> {
    of_today(spec, bytes).map_err(|e| {
        Error::Output(format!(
            "cannot read {at}: {e}; restore it from a backup, or remove it with `roadbench verify \
             OUT --mend` and run again to compute its sessions"
        ))
    })
}

/// The batches of a table in its current schema.
///
/// # Errors
/// The columns are those of another table.
pub(crate) fn of_today(spec: &TableSpec, bytes: Bytes) -> Result<Vec<RecordBatch>, Mismatch> {
    conform(spec, &read::batches_of(bytes)?)
}

fn conform(spec: &TableSpec, batches: &[RecordBatch]) -> Result<Vec<RecordBatch>, Mismatch> {
    batches.iter().map(|batch| file::typed(spec.table(), batch)).collect()
}

/// Files of single sessions that the sessions no longer have.
fn own_files_gone(
    there: &Contents,
    list: &Manifest,
    waits: &[(&Location, &Staged)],
    old: &[&Committed],
) -> Vec<String> {
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
    let all = old.iter().flat_map(|row| {
        own.iter().map(|(folder, extension)| {
            there.file(folder, extension, &row.bike_id, &file_name(&row.session_id))
        })
    });
    let gone = all.filter(|at| !has.contains(at) && there.may_have(at));
    // folders are not listed; the removal of an absent file costs a system call
    let paths = gone.filter_map(|at| Some((manifest::below(there.root(), &at)?, at)));
    let is_there = |(path, at): &(String, Location)| {
        at.as_path().is_none_or(Path::exists) || list.of(path).is_some()
    };
    paths.filter(is_there).map(|(path, _)| path).collect()
}

/// Removes the folders of motorcycles that have nothing in a table any more.
fn remove_empty_folders(there: &Contents, bikes: &BTreeSet<&str>) {
    let kind = there.kind;
    for folder in kind.files().map(|(folder, _)| folder).chain([kind.marker.name]) {
        for bike in bikes {
            if let Some(path) = there.root().join(format!("{folder}/bike={bike}")).as_path() {
                let _ = std::fs::remove_dir(path); // does nothing where it is not empty
            }
        }
    }
}

fn remove(at: &Location) -> Result<(), Error> {
    at.remove().map_err(|e| Error::Output(format!("cannot remove {at}: {e}")))
}
