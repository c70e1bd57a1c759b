//! The output folder: one file per session and table, and the rules that keep them whole.
//!
//! ```text
//! <out>/coefficients/bike=<id>/<session>.parquet   and likewise every table of a session
//! <out>/sessions/bike=<id>/<session>.parquet       written last: the commit marker of `run`
//! <out>/diagnoses/bike=<id>/<session>.parquet      the same of `diagnose`
//! <out>/rejected/<log>-<hash of its path>.parquet
//! <out>/.roadbench.lock                            held while a batch writes
//! <out>/.roadbench/writing/<session>               there while `run` replaces the session's tables
//! <out>/.roadbench/diagnosing/<session>            the same of `diagnose`
//! ```
//!
//! Each table is replaced whole, so that whoever reads along always reads tables. A session whose mark
//! a killed batch has left is computed again, whatever its commit marker says: some of its tables may
//! be newer than others. Sessions of earlier batches that are no input of this one stay as they are:
//! the folder is the fleet's archive. A session that is an input again is replaced.

use std::sync::OnceLock;

use walkdir::WalkDir;

use super::contents::{Contents, Stale};
use super::error::Error;
use super::kind::Kind;
use super::lock::Lock;
use super::marker::Committed;
use super::work::SessionFile;
use crate::objects::Location;
use crate::tables::names::file_name;
use crate::tables::rows::Rejected;
use crate::tables::{file, read, registry};

/// What the mark [`Kind::behind`] says where only the fleet's tables are missing: builds without them
/// made the rest.
const ONLY_FLEET: &[u8] = b"fleet";

/// The output folder, locked for one batch.
#[derive(Debug)]
pub struct Store {
    found: Contents,
    lock: Lock,
    /// Set once something over all sessions has to be made anew.
    behind: OnceLock<()>,
}

impl Store {
    /// Makes the folder where it is missing, locks it, removes what a killed batch left
    /// half-written, and reads which sessions are there.
    ///
    /// # Errors
    /// Another batch has it, or it cannot be written.
    pub fn open(kind: &'static Kind, root: &Location) -> Result<Self, Error> {
        Self::open_again(&Contents::unknown(kind, root))
    }

    /// As [`Store::open`], when it was read just before without the lock.
    ///
    /// # Errors
    /// As [`Store::open`].
    pub fn open_again(before: &Contents) -> Result<Self, Error> {
        let lock = Lock::take(before.root())?;
        remove_temporaries(before.root())?;
        let store = Store { found: before.read_again()?, lock, behind: OnceLock::new() };
        store.remove_uncommitted()?;
        Ok(store)
    }

    /// A worker's access to an output that the process which gave it the work holds open: nothing is
    /// locked or cleared. `there` is what that process found of the sessions this one writes.
    pub fn join(kind: &'static Kind, root: &Location, there: Vec<Committed>) -> Self {
        let mut found = Contents::unknown(kind, root);
        for row in there {
            let mark = found.writing_mark(&file_name(&row.session_id));
            let is_interrupted = mark.exists().unwrap_or(true);
            found.add(row, is_interrupted);
        }
        Store { found, lock: Lock::None, behind: OnceLock::new() }
    }

    /// Removes tables that belong to no session: a batch was killed before it wrote their marker, or
    /// after it removed it.
    fn remove_uncommitted(&self) -> Result<(), Error> {
        for file in self.found.interrupted() {
            let mark = self.found.writing_mark(file);
            let known = self.found.of_file(file);
            let bikes = mark.read().unwrap_or_default();
            let bikes = String::from_utf8_lossy(&bikes);
            for bike_id in bikes.lines().filter(|b| known.iter().all(|k| k.bike_id != *b)) {
                self.remove_tables(bike_id, file)?;
            }
            // one that is there stays marked until its tables are of one piece again
            if known.is_empty() {
                remove(&mark)?;
            }
        }
        Ok(())
    }

    /// Removes what killed workers left half-written.
    ///
    /// # Errors
    /// It cannot be removed.
    pub fn tidy(&self) -> Result<(), Error> {
        remove_temporaries(self.root())
    }

    /// Removes the mark that a session is being written: a worker that wrote the same as the one that
    /// was heard of was killed over it.
    ///
    /// # Errors
    /// It cannot be removed.
    pub fn clear_writing_mark(&self, session_id: &str) -> Result<(), Error> {
        Ok(remove(&self.found.writing_mark(&file_name(session_id)))?)
    }

    /// What was found in the folder when it was opened.
    pub fn found(&self) -> &Contents {
        &self.found
    }

    /// The folder.
    pub fn root(&self) -> &Location {
        self.found.root()
    }

    /// Why the session has to be computed; `None` when its tables are there, whole, and made from
    /// just this.
    pub fn stale(
        &self,
        wanted: &Committed,
        is_requested: impl Fn(&registry::TableSpec) -> bool,
    ) -> Option<Stale> {
        self.found.stale(wanted, is_requested)
    }

    /// Replaces a session's files, each whole, the marker last.
    ///
    /// # Errors
    /// The folder cannot be written. What was there before and what is new may then be mixed; the
    /// session counts as not done.
    pub fn commit(
        &self,
        session_id: &str,
        bike_id: &str,
        log: &str,
        files: &[SessionFile],
    ) -> Result<(), file::Error> {
        let name = file_name(session_id);
        let mark = self.found.writing_mark(&name);
        let marker = self.found.kind.marker.name;
        let at = |f: &SessionFile| self.found.file(f.folder, f.extension, bike_id, &name);
        self.mark_behind()?;
        file::write_bytes(&mark, bike_id.as_bytes())?;
        for f in files.iter().filter(|f| f.folder != marker) {
            file::write_bytes(at(f), &f.bytes)?;
        }
        // what it had and has no more
        for (folder, extension) in self.found.kind.files() {
            if files.iter().all(|f| f.folder != folder) {
                self.remove_found(&self.found.file(folder, extension, bike_id, &name))?;
            }
        }
        for f in files.iter().filter(|f| f.folder == marker) {
            file::write_bytes(at(f), &f.bytes)?;
        }
        self.remove_from_bikes(&name, Some(bike_id))?;
        self.remove_rejection(log)?;
        remove(&mark)
    }

    /// Takes a session's tables out of the folder, under whatever bike they were.
    ///
    /// # Errors
    /// They are there and cannot be removed.
    pub fn remove(&self, session_id: &str) -> Result<(), file::Error> {
        let known = self.found.of(session_id);
        if known.is_empty() {
            return Ok(());
        }
        let name = file_name(session_id);
        let bikes: Vec<&str> = known.iter().map(|old| old.bike_id.as_str()).collect();
        let mark = self.found.writing_mark(&name);
        self.mark_behind()?;
        file::write_bytes(&mark, bikes.join("\n").as_bytes())?;
        self.remove_from_bikes(&name, None)?;
        remove(&mark)
    }

    /// Removes a session from every bike but the one that is `kept`.
    fn remove_from_bikes(&self, name: &str, kept: Option<&str>) -> Result<(), file::Error> {
        let known = self.found.of_file(name).iter();
        for old in known.filter(|old| Some(old.bike_id.as_str()) != kept) {
            self.remove_found(&self.found.marker(&old.bike_id, name))?;
            self.remove_tables(&old.bike_id, name)?;
        }
        Ok(())
    }

    fn remove_tables(&self, bike_id: &str, name: &str) -> Result<(), file::Error> {
        for (folder, extension) in self.found.kind.files() {
            self.remove_found(&self.found.file(folder, extension, bike_id, name))?;
        }
        Ok(())
    }

    /// Writes the row of an input that could not be used.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn reject(&self, row: &Rejected) -> Result<(), file::Error> {
        let at = self.rejection(&row.path);
        let bytes = file::to_bytes(std::slice::from_ref(row))?;
        // it says the same every night
        if self.found.has(&at) && at.read().is_ok_and(|there| there == bytes) {
            return Ok(());
        }
        self.mark_behind()?;
        file::write_bytes(&at, &bytes)
    }

    /// Removes the row that an input had in `rejected`, unless it is there for another command.
    ///
    /// # Errors
    /// It is there and cannot be removed.
    pub fn remove_rejection(&self, log: &str) -> Result<(), file::Error> {
        let at = self.rejection(log);
        if !self.found.has(&at) {
            return Ok(());
        }
        let rows = at.read().map(|bytes| read::rows_of::<Rejected>(&at, bytes));
        let is_foreign = |row: &Rejected| self.found.kind.foreign_stages.contains(&&*row.stage);
        if matches!(rows, Ok(Ok(rows)) if rows.iter().any(is_foreign)) {
            return Ok(());
        }
        self.mark_behind()?;
        remove(&at)
    }

    /// Removes a file that was there when the batch began; of an object store no request is spent on
    /// one that was not.
    fn remove_found(&self, at: &Location) -> Result<(), file::Error> {
        match self.found.may_have(at) {
            true => remove(at),
            false => Ok(()),
        }
    }

    /// Before anything changes: the lock is still ours, and what is made over all sessions is known to
    /// be behind until it is made.
    fn mark_behind(&self) -> Result<(), file::Error> {
        let at = self.root().join(self.found.kind.behind);
        let check = self.lock.check();
        check.map_err(|source| file::Error::Io { path: at.clone(), source })?;
        if self.behind.get().is_none() {
            file::write_bytes(at, b"")?;
            let _ = self.behind.set(()); // another worker may have been quicker
        }
        Ok(())
    }

    /// Whether what is made over all sessions has to be made anew: only after a change, be it one of a
    /// batch that was killed, or where something that is always made is not there.
    pub fn is_behind(&self) -> bool {
        let mark = self.root().join(self.found.kind.behind);
        let has = |name: &str| self.found.has(&self.root().join(name));
        let makes_fleet = cfg!(feature = "fleet");
        let is_marked = || {
            self.found.has(&mark)
                && (makes_fleet || !mark.read().is_ok_and(|says| says == ONLY_FLEET))
        };
        let makes = |file: &&&str| makes_fleet || !file.starts_with("fleet/");
        let lacks = || self.found.kind.over_all.iter().filter(makes).any(|file| !has(file));
        self.behind.get().is_some() || is_marked() || lacks()
    }

    /// All is made that this build makes: without the feature `fleet` its tables stay behind.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn clear_behind(&self) -> Result<(), Error> {
        let mark = self.root().join(self.found.kind.behind);
        let makes_fleet = self.found.kind.over_all.iter().any(|file| file.starts_with("fleet/"));
        match makes_fleet && !cfg!(feature = "fleet") {
            false => remove(&mark)?,
            true => file::write_bytes(&mark, ONLY_FLEET)?,
        }
        Ok(())
    }

    fn rejection(&self, log: &str) -> Location {
        let stem = std::path::Path::new(log).file_stem().unwrap_or_default().to_string_lossy();
        let hash = blake3::hash(log.as_bytes()).to_hex();
        let name = format!("rejected/{}-{}.parquet", file_name(&stem), &hash[..8]);
        self.root().join(name)
    }

    /// The session that an unreadable log was when it could still be read: the one that was
    /// made from this very path and is named like the file.
    pub fn session_made_from(&self, log: &str) -> Option<&str> {
        let stem = std::path::Path::new(log).file_stem()?.to_str()?;
        let known = self.found.of(stem).iter().find(|c| c.path == log);
        known.map(|c| c.session_id.as_str())
    }
}

/// The lock on the folder is held: whatever is half-written in it is nobody's.
fn remove_temporaries(root: &Location) -> Result<(), Error> {
    let Some(root) = root.as_path() else { return Ok(()) }; // what is put is put whole
    let folders = registry::folders().chain([".roadbench"]).map(|name| root.join(name));
    let files = folders
        .filter(|f| f.is_dir())
        .flat_map(|f| WalkDir::new(f).into_iter().filter_map(Result::ok));
    for entry in files.filter(|e| e.file_type().is_file()) {
        let name = entry.file_name().to_string_lossy();
        if name.starts_with(file::TEMPORARY.0) && name.ends_with(file::TEMPORARY.1) {
            tracing::debug!("removing {}, left by a run that was killed", entry.path().display());
            remove(&entry.path().into())?;
        }
    }
    Ok(())
}

fn remove(at: &Location) -> Result<(), file::Error> {
    at.remove().map_err(|source| file::Error::Io { path: at.clone(), source })
}
