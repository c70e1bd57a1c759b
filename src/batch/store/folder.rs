//! The output folder: a file per table, motorcycle and month, and the rules that keep it whole.
//!
//! ```text
//! <out>/coefficients/bike=<id>/<month>.parquet     and likewise every table of sessions
//! <out>/sessions/bike=<id>/<month>.parquet         written last: the commit markers of `run`
//! <out>/diagnoses/bike=<id>/<month>.parquet        the same of `diagnose`
//! <out>/signals/bike=<id>/<session>.parquet        what is asked for by itself is a file per session
//! <out>/rejected/<log>-<hash of its path>.parquet
//! <out>/.roadbench.lock                            held while a batch writes
//! <out>/.roadbench/staged/run/<session>.session    a session whose tables wait to be taken in
//! <out>/.roadbench/staged/diagnose/...             the same of `diagnose`
//! ```
//!
//! Workers leave each session in one file ([`staged`]), which is there whole or not at all; at the end of the batch all
//! that waits is taken into the tables ([`merge`]), also what a killed batch has left. All tables are replaced at once
//! ([`mod@switch`]), so that a reader sees one state of them. Sessions of earlier batches that are no input of this one
//! stay as they are: the folder is the fleet's archive. A session that is an input again is replaced.

use std::collections::BTreeSet;
use std::fs::TryLockError;
use std::sync::{Mutex, OnceLock, PoisonError};

use rayon::prelude::*;
use walkdir::WalkDir;

use super::contents::{Contents, Stale};
use super::empty;
use super::kind::Kind;
use super::lock::Lock;
use super::manifest::{self, Manifest};
use super::mark;
use super::marker::{Committed, Key};
use super::staged::{self, Staged};
use super::switch::{self, Switching};
use super::{merge, migrate, superseded};
use crate::batch::error::Error;
use crate::batch::jobs::work::SessionFile;
use crate::batch::log_hash::hash_file;
use crate::batch::plan::Job;
use crate::report;
use crate::store::objects::Location;
use crate::store::tables::names::file_name;
use crate::store::tables::rows::Rejected;
use crate::store::tables::{file, read, registry};

/// Text of the mark [`Kind::behind`] if only the fleet's tables are missing: builds without them
/// made the rest.
const ONLY_FLEET: &[u8] = b"fleet";

/// A log of a batch, whatever becomes of it.
#[derive(Debug)]
struct Expected {
    key: Key,
    at: Location,
    log: String,
    start: Option<i64>,
    /// Of its bytes, where it is known already.
    hash: Option<String>,
}

/// The logs of a batch.
#[derive(Debug, Default)]
struct AllExpected {
    logs: Vec<Expected>,
    sessions: BTreeSet<Key>,
    /// The hashes of all of them; rarely asked for.
    hashes: OnceLock<BTreeSet<String>>,
}

impl AllExpected {
    /// Whether the log that a session was made from is among them, be it renamed, or cut or exported again.
    fn has(&self, there: &Committed) -> bool {
        let is_same = |one: &Expected| {
            one.log == there.path && one.key == there.key() && !there.is_other_ride(one.start)
        };
        let all = || {
            let hash = |one: &Expected| one.hash.clone().or_else(|| hash_file(&one.at).ok());
            self.logs.par_iter().filter_map(hash).collect()
        };
        self.logs.iter().any(is_same) || self.hashes.get_or_init(all).contains(&there.input_hash)
    }
}

/// The output folder, locked for one batch.
#[derive(Debug)]
pub struct Store {
    found: Contents,
    lock: Lock,
    /// Set once something over all sessions has to be made anew.
    behind: OnceLock<()>,
    /// The logs of this batch.
    expected: OnceLock<AllExpected>,
    /// Why sessions wait that could not be taken into their tables.
    waits: Mutex<Option<Error>>,
    /// Keeps readers out from when the tables change until what is made over all sessions fits them.
    switching: Mutex<Option<Switching>>,
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
        // an output that is somebody else's is not even locked
        mark::claim(before.root())?;
        let lock = Lock::take(before.root())?;
        switch::recover(before.root())?;
        remove_temporaries(before.root())?;
        let mut found = before.read_again()?;
        if migrate::migrate(&found)? {
            found = found.read_again()?;
        }
        let mut store = Store {
            found,
            lock,
            behind: OnceLock::new(),
            expected: OnceLock::new(),
            waits: Mutex::default(),
            switching: Mutex::default(),
        };
        // what a killed batch has left is settled before anything is staged over it
        if store.merge()? {
            store.found = store.found.read_again()?;
        }
        store.found.forget_mended();
        // at the end of the batch it is tried again, and the error is the batch's
        if let Some(e) = store.take_error() {
            tracing::warn!("{e}");
        }
        store.release(); // what is made over all sessions follows: see `finish_derived`
        Ok(store)
    }

    /// A worker's access to an output that the process which gave it the work holds open: nothing is
    /// locked or cleared. `there` is what that process found of the sessions this one writes.
    pub fn join(kind: &'static Kind, root: &Location, there: Vec<Committed>) -> Self {
        let mut found = Contents::unknown(kind, root);
        there.into_iter().for_each(|row| found.add(row));
        Store {
            found,
            lock: Lock::None,
            behind: OnceLock::new(),
            expected: OnceLock::new(),
            waits: Mutex::default(),
            switching: Mutex::default(),
        }
    }

    /// Removes what killed workers left half-written.
    ///
    /// # Errors
    /// It cannot be removed.
    pub fn tidy(&self) -> Result<(), Error> {
        remove_temporaries(self.root())
    }

    /// Contents of the folder when it was opened.
    pub fn found(&self) -> &Contents {
        &self.found
    }

    /// Output folder or URL.
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

    /// Leaves a session's files to be taken in, all of them or none.
    ///
    /// # Errors
    /// The folder cannot be written; what was there before stays.
    pub fn commit(&self, made: &Committed, files: &[SessionFile]) -> Result<(), file::Error> {
        self.mark_behind()?;
        let staged = Staged {
            bike_id: made.bike_id.clone(),
            session_id: made.session_id.clone(),
            made: Some(made.clone()),
            folders: files.iter().map(|f| f.folder.to_owned()).collect(),
        };
        self.stage(&staged, files)?;
        self.remove_superseded(made)?;
        self.remove_rejection(&made.path)
    }

    /// Takes a session out of the tables.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn remove(&self, key: &Key) -> Result<(), file::Error> {
        if self.found.of(key).is_empty() {
            return Ok(());
        }
        self.mark_behind()?;
        let Key { bike_id, session_id } = key.clone();
        self.stage(&Staged { bike_id, session_id, made: None, folders: Vec::new() }, &[])
    }

    /// Says which logs this batch has: what another log was before is not taken for one of theirs.
    pub fn expect<'a>(&self, jobs: impl Iterator<Item = &'a Job>) {
        let mut expected = AllExpected::default();
        for job in jobs {
            expected.sessions.insert(job.key());
            expected.logs.push(Expected {
                key: job.key(),
                at: job.location.clone(),
                log: job.log.clone(),
                start: job.start,
                hash: job.hash.clone(),
            });
        }
        let _ = self.expected.set(expected); // it is said once
    }

    /// Entry of a session with this id from another ride, if the log of that ride is not in this batch: no log takes its
    /// place. Loggers use their file names again.
    pub fn archived(&self, key: &Key, hash: &str, start: Option<i64>) -> Option<&Committed> {
        self.found.of(key).iter().find(|there| self.is_archived(there, hash, start))
    }

    fn is_archived(&self, there: &Committed, hash: &str, start: Option<i64>) -> bool {
        let is_here = || self.expected.get().is_some_and(|all| all.has(there));
        there.input_hash != hash && there.is_other_ride(start) && !is_here()
    }

    /// Takes out what a log was before: [`superseded::by`].
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn remove_superseded(&self, made: &Committed) -> Result<(), file::Error> {
        let is_archived = |there: &Committed| self.is_archived(there, &made.input_hash, made.start);
        let others = superseded::by(made, &self.found, is_archived);
        // names may be exchanged among the logs of a batch
        let is_expected =
            |key: &Key| self.expected.get().is_some_and(|all| all.sessions.contains(key));
        for key in others.into_iter().filter(|key| !is_expected(key)) {
            tracing::info!(
                "{}: session {} of {} was this log",
                made.path,
                key.session_id,
                key.bike_id
            );
            self.remove(&key)?;
        }
        Ok(())
    }

    fn stage(&self, staged: &Staged, files: &[SessionFile]) -> Result<(), file::Error> {
        let bytes = staged::encode(staged, files)
            .map_err(|source| file::Error::Encode { table: "session".to_owned(), source })?;
        file::write_bytes(self.found.staging(&staged.key()), &bytes)
    }

    /// Takes into the tables what waits: of this batch, and of one that was killed. Whether there was anything.
    /// Sessions whose tables are damaged go on waiting: [`Store::take_error`].
    ///
    /// # Errors
    /// The output cannot be written; what waits goes on waiting.
    pub fn merge(&self) -> Result<bool, Error> {
        let now = self.found.read_again()?;
        if now.staged().next().is_none() {
            return Ok(false);
        }
        self.mark_behind()?;
        self.release(); // it is taken anew
        let (switching, waits) = merge::merge(&now, &|| self.lock.check())?;
        *self.switching.lock().unwrap_or_else(PoisonError::into_inner) = switching;
        *self.waits.lock().unwrap_or_else(PoisonError::into_inner) = waits;
        Ok(true)
    }

    /// Why sessions wait on that could not be taken into their tables.
    pub fn take_error(&self) -> Option<Error> {
        self.waits.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    fn release(&self) {
        *self.switching.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// The tables over all sessions are written, the report is not: tables may be read.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn let_readers_in(&self) -> Result<(), Error> {
        if !self.root().is_remote() {
            remove(&self.root().join(self.found.kind.switched))?;
        }
        self.release();
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
        let is_foreign = |row: &Rejected| self.found.kind.is_foreign(row);
        if matches!(rows, Ok(Ok(rows)) if rows.iter().any(is_foreign)) {
            return Ok(());
        }
        self.mark_behind()?;
        remove(&at)
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
    /// batch that was killed, or where something that is always made is not there or not as it was written.
    pub fn is_behind(&self) -> bool {
        let mark = self.root().join(self.found.kind.behind);
        let has = |name: &str| self.found.has(&self.root().join(name));
        let makes_fleet = cfg!(feature = "fleet");
        let is_marked = || {
            self.found.has(&mark)
                && (makes_fleet || !mark.read().is_ok_and(|says| says == ONLY_FLEET))
        };
        let makes = |file: &&&str| makes_fleet || !file.starts_with("fleet/");
        let lacks = || {
            self.found.kind.over_all.iter().filter(makes).any(|file| !has(file))
                || empty::lacks(self.found.kind, has)
        };
        self.behind.get().is_some() || is_marked() || lacks() || !self.is_derived_whole()
    }

    /// Whether the tables over all sessions, the list of checksums and the report are as they were written. An object
    /// store says only whether they are there.
    fn is_derived_whole(&self) -> bool {
        let Some(out) = self.root().as_path() else { return true };
        let list = Manifest::read(self.root());
        let folders = self.found.kind.derived();
        let is_derived =
            |path: &str| folders.iter().any(|f| manifest::is_below(path, f)) || empty::is_one(path);
        let has_fleet = !cfg!(feature = "fleet")
            || registry::of_fleet()
                .map(|spec| format!("{0}/{0}.parquet", spec.name))
                .filter(|path| is_derived(path))
                .all(|path| list.of(&path).is_some());
        list.is_there
            && has_fleet
            && list.damaged(self.root(), is_derived).is_empty()
            && report::is_whole(out)
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

    /// Removes the rows of inputs that are in the folders of this batch no more; `found` are those that are, and the
    /// folders that could not be searched: what is below these is not gone.
    ///
    /// # Errors
    /// The folder cannot be read or written.
    pub fn remove_rejections_of_gone(
        &self,
        inputs: &[Location],
        found: &BTreeSet<String>,
    ) -> Result<(), Error> {
        let folder = self.root().join("rejected");
        let fail = |e: std::io::Error| Error::Output(format!("{folder}: {e}"));
        for entry in folder.list().map_err(fail)? {
            let at = folder.join(&entry.key);
            let rows = at.read().ok().and_then(|b| read::rows_of::<Rejected>(&at, b).ok());
            let Some([row]) = rows.as_deref() else { continue };
            let Ok(log) = Location::parse(&row.path) else { continue };
            let is_below = inputs.iter().any(|i| log.starts_with(i) && log != *i);
            let is_hidden = || {
                let mut above = std::path::Path::new(&row.path).ancestors().skip(1);
                above.any(|folder| folder.to_str().is_some_and(|f| found.contains(f)))
                    || (!log.is_remote() && log.exists().is_err())
            };
            let is_foreign = self.found.kind.is_foreign(row);
            if is_below && !is_foreign && !found.contains(&row.path) && !is_hidden() {
                self.mark_behind()?;
                remove(&at)?;
            }
        }
        Ok(())
    }

    fn rejection(&self, log: &str) -> Location {
        let stem = std::path::Path::new(log).file_stem().unwrap_or_default().to_string_lossy();
        let hash = blake3::hash(log.as_bytes()).to_hex();
        let name = format!("rejected/{}-{}.parquet", file_name(&stem), &hash[..8]);
        self.root().join(name)
    }

    /// Whether the output keeps rows of a log that was rejected and says to begin at `start`: [`superseded::keeps`].
    pub fn keeps(&self, rejected: &Rejected, start: Option<i64>) -> bool {
        let hash = rejected.input_hash.as_deref().unwrap_or_default();
        superseded::keeps(rejected, &self.found, |there| self.is_archived(there, hash, start))
    }

    /// The session whose rows go with such a log: [`superseded::with_rejected`].
    pub fn given_up(&self, rejected: &Rejected, start: Option<i64>) -> Option<Key> {
        let hash = rejected.input_hash.as_deref().unwrap_or_default();
        let is_archived = |there: &Committed| self.is_archived(there, hash, start);
        superseded::with_rejected(rejected, &self.found, is_archived)
    }
}

/// The lock on the folder is held: whatever is half-written in it is nobody's, but for what a command that only reads the
/// tables writes beside them.
fn remove_temporaries(root: &Location) -> Result<(), Error> {
    let Some(root) = root.as_path() else { return Ok(()) }; // what is put is put whole
    let folders =
        registry::folders().chain([".roadbench"]).map(|name| (root.join(name), usize::MAX));
    let files = folders
        .chain([(root.to_owned(), 1)])
        .filter(|(folder, _)| folder.is_dir())
        .flat_map(|(f, depth)| WalkDir::new(f).max_depth(depth).into_iter().filter_map(Result::ok));
    for entry in files.filter(|e| e.file_type().is_file()) {
        let name = entry.file_name().to_string_lossy();
        if name.starts_with(file::TEMPORARY.0) && name.ends_with(file::TEMPORARY.1) {
            // a report that is being written holds its own
            let is_held = std::fs::File::open(entry.path())
                .is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)));
            if !is_held {
                tracing::debug!("removing {}, which a killed run left", entry.path().display());
                remove(&entry.path().into())?;
            }
        }
    }
    Ok(())
}

fn remove(at: &Location) -> Result<(), file::Error> {
    at.remove().map_err(|source| file::Error::Io { path: at.clone(), source })
}
