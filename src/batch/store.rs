//! The output folder: one file per session and table, and the rules that keep them whole.
//!
//! ```text
//! <out>/coefficients/bike=<id>/<session>.parquet   and likewise manoeuvres, forces, warnings, plots, signals
//! <out>/sessions/bike=<id>/<session>.parquet       written last: the session's commit marker
//! <out>/rejected/<log>-<hash of its path>.parquet
//! <out>/.roadbench.lock                            held while a run writes
//! <out>/.roadbench/writing/<session>               there while the session's tables are replaced
//! ```
//!
//! Each table is replaced whole, so that whoever reads along always reads tables. A session whose mark
//! in `writing` a killed run has left is computed again, whatever its marker says: some of its tables
//! may be newer than others. Sessions of earlier runs that are no input of this one stay as they are:
//! the folder is the fleet's archive. A session that is an input again is replaced.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use walkdir::WalkDir;

use super::Error;
pub use super::contents::{Committed, Contents, Stale};
use super::contents::{OPTIONAL, PER_SESSION, WRITING, mark, path};
use super::lock::Lock;
use crate::objects::{files, url};
use crate::pipeline::Outcome;
use crate::tables::file;
use crate::tables::names::file_name;
use crate::tables::rows::Rejected;

/// Every folder below the output that a run writes to.
pub const TABLES: &[&str] = &[
    "coefficients",
    "manoeuvres",
    "forces",
    "warnings",
    "plots",
    "signals",
    "sessions",
    "rejected",
    "fleet",
    "fleet_pooled",
    "fleet_events",
    "fleet_ratios",
    "discrepancies",
    "causes",
    "replays",
    "report",
];

/// There while fleet and report are older than the sessions.
const BEHIND: &str = ".roadbench/behind";
/// What it says where only the fleet's tables are: builds without them made the rest.
const ONLY_FLEET: &[u8] = b"fleet";

/// One session's tables as bytes, ready to be written.
#[derive(Debug)]
pub struct Files {
    tables: Vec<(&'static str, Vec<u8>)>,
    marker: Vec<u8>,
}

/// The output folder, locked for one run.
#[derive(Debug)]
pub struct Store {
    root: PathBuf,
    found: Contents,
    lock: Lock,
    /// Set once something over all sessions has to be made anew.
    behind: OnceLock<()>,
}

impl Store {
    /// Makes the folder where it is missing, locks it, removes what a killed run left
    /// half-written, and reads which sessions are there.
    ///
    /// # Errors
    /// Another run has it, or it cannot be written.
    pub fn open(root: &Path) -> Result<Self, Error> {
        Self::open_again(root, &Contents::default())
    }

    /// As [`Store::open`], when it was read just before without the lock.
    ///
    /// # Errors
    /// As [`Store::open`].
    pub fn open_again(root: &Path, before: &Contents) -> Result<Self, Error> {
        let lock = Lock::take(root)?;
        remove_temporaries(root)?;
        let store = Store {
            root: root.to_owned(),
            found: Contents::read_again(root, before)?,
            lock,
            behind: OnceLock::new(),
        };
        store.sweep()?;
        Ok(store)
    }

    /// Removes tables that belong to no session: a run was killed before it wrote their marker, or
    /// after it removed it.
    fn sweep(&self) -> Result<(), Error> {
        let output = |e: file::Error| Error::Output(e.to_string());
        for file in &self.found.torn {
            let mark = mark(&self.root, file);
            let known = self.found.committed.get(file).map(Vec::as_slice).unwrap_or_default();
            let bikes = files::read(&mark).unwrap_or_default();
            let bikes = String::from_utf8_lossy(&bikes);
            for bike_id in bikes.lines().filter(|b| known.iter().all(|k| k.bike_id != *b)) {
                for table in PER_SESSION {
                    self.remove_file(&self.path(table, bike_id, file)).map_err(output)?;
                }
            }
            // one that is there stays marked until its tables are of one piece again
            if known.is_empty() {
                remove_file(&mark).map_err(output)?;
            }
        }
        Ok(())
    }

    /// A worker's hand in a folder that the process which gave it the work holds open: nothing is
    /// locked or cleared. `there` is what that process found of the sessions this one writes.
    pub fn join(root: &Path, there: Vec<Committed>) -> Self {
        let mut found = Contents { root: root.to_owned(), ..Contents::default() };
        for row in there {
            let file = file_name(&row.session_id);
            if mark(root, &file).exists() {
                found.torn.insert(file.clone());
            }
            found.committed.entry(file).or_default().push(row);
        }
        Store { root: root.to_owned(), found, lock: Lock::None, behind: OnceLock::new() }
    }

    /// Removes what killed workers left half-written.
    ///
    /// # Errors
    /// It cannot be removed.
    pub fn tidy(&self) -> Result<(), Error> {
        remove_temporaries(&self.root)
    }

    /// Removes a session's mark: a worker that wrote the same as the one that was heard of was
    /// killed over it.
    ///
    /// # Errors
    /// It cannot be removed.
    pub fn settle(&self, session_id: &str) -> Result<(), Error> {
        let mark = mark(&self.root, &file_name(session_id));
        remove_file(&mark).map_err(|e| Error::Output(e.to_string()))
    }

    /// What was found of a session when the folder was opened.
    pub fn there(&self, session_id: &str) -> &[Committed] {
        self.found.committed.get(&file_name(session_id)).map(Vec::as_slice).unwrap_or_default()
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    fn path(&self, table: &str, bike_id: &str, file: &str) -> PathBuf {
        path(&self.root, table, bike_id, file)
    }

    /// Why the session has to be computed; `None` when its tables are there, whole, and made from
    /// just this.
    pub fn stale(&self, wanted: &Committed, signals: bool) -> Option<Stale> {
        self.found.stale(wanted, signals)
    }

    /// An outcome as files.
    ///
    /// # Errors
    /// A row does not fit its schema: our own mistake.
    pub fn encode(&self, outcome: &Outcome) -> Result<Files, file::Error> {
        let tables = outcome.tables()?;
        let mut tables = tables
            .iter()
            .map(|(spec, batch)| Ok((spec.name, file::batch_to_bytes(spec.name, batch)?)))
            .collect::<Result<Vec<_>, file::Error>>()?;
        let marker = tables.pop().map(|(_, bytes)| bytes).unwrap_or_default(); // `sessions`
        Ok(Files { tables, marker })
    }

    /// Replaces a session's tables, each whole, the marker last.
    ///
    /// # Errors
    /// The folder cannot be written. What was there before and what is new may then be mixed; the
    /// session counts as not done.
    pub fn commit(
        &self,
        session_id: &str,
        bike_id: &str,
        log: &str,
        files: &Files,
    ) -> Result<(), file::Error> {
        let file = file_name(session_id);
        let mark = mark(&self.root, &file);
        self.changes()?;
        file::write_bytes(&mark, bike_id.as_bytes())?;
        for (table, bytes) in &files.tables {
            file::write_bytes(&self.path(table, bike_id, &file), bytes)?;
        }
        // what it had and has no more
        for table in OPTIONAL.iter().filter(|t| files.tables.iter().all(|(name, _)| name != *t)) {
            self.remove_file(&self.path(table, bike_id, &file))?;
        }
        file::write_bytes(&self.path("sessions", bike_id, &file), &files.marker)?;
        self.remove_but(&file, Some(bike_id))?;
        self.forgive(log)?;
        remove_file(&mark)
    }

    /// Takes a session's tables out of the folder, under whatever bike they were.
    ///
    /// # Errors
    /// They are there and cannot be removed.
    pub fn remove(&self, session_id: &str) -> Result<(), file::Error> {
        let file = file_name(session_id);
        let Some(known) = self.found.committed.get(&file) else { return Ok(()) };
        let bikes: Vec<&str> = known.iter().map(|old| old.bike_id.as_str()).collect();
        let mark = mark(&self.root, &file);
        self.changes()?;
        file::write_bytes(&mark, bikes.join("\n").as_bytes())?;
        self.remove_but(&file, None)?;
        remove_file(&mark)
    }

    fn remove_but(&self, file: &str, kept: Option<&str>) -> Result<(), file::Error> {
        let known = self.found.committed.get(file).into_iter().flatten();
        for old in known.filter(|old| Some(old.bike_id.as_str()) != kept) {
            self.remove_file(&self.path("sessions", &old.bike_id, file))?;
            for table in PER_SESSION {
                self.remove_file(&self.path(table, &old.bike_id, file))?;
            }
        }
        Ok(())
    }

    /// Writes the row of an input that could not be used.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn reject(&self, row: &Rejected) -> Result<(), file::Error> {
        let (path, rows) = (self.rejected(&row.path), std::slice::from_ref(row));
        let bytes = file::to_bytes(rows)?;
        // it says the same every night
        if self.found.has(&path) && files::read(&path).is_ok_and(|there| there == bytes) {
            return Ok(());
        }
        self.changes()?;
        file::write_bytes(&path, &bytes)
    }

    /// Removes the row that an input had in `rejected`.
    ///
    /// # Errors
    /// It is there and cannot be removed.
    pub fn forgive(&self, log: &str) -> Result<(), file::Error> {
        let path = self.rejected(log);
        if self.found.has(&path) {
            self.changes()?;
        }
        self.remove_file(&path)
    }

    /// Removes a file that was there when the run began; of an object store no request is spent on
    /// one that was not.
    fn remove_file(&self, path: &Path) -> Result<(), file::Error> {
        match &self.found.names {
            Some(names) if !names.contains_key(path) => Ok(()),
            _ => remove_file(path),
        }
    }

    /// Before anything changes: the lock is still ours, and what is made over all sessions is known to
    /// be behind until it is made.
    fn changes(&self) -> Result<(), file::Error> {
        let path = || self.root.join(BEHIND);
        self.lock.check().map_err(|source| file::Error::Io { path: path(), source })?;
        if self.behind.get().is_none() {
            file::write_bytes(&path(), b"")?;
            let _ = self.behind.set(()); // another worker may have been quicker
        }
        Ok(())
    }

    /// Whether fleet and report have to be made anew: only after a change, be it one of a run that was
    /// killed, or where they are not there.
    pub fn is_behind(&self) -> bool {
        let mark = self.root.join(BEHIND);
        let there = |name: &str| self.found.has(&self.root.join(name));
        let makes_fleet = cfg!(feature = "fleet");
        let marked = || {
            self.found.has(&mark)
                && (makes_fleet || !files::read(&mark).is_ok_and(|says| says == ONLY_FLEET))
        };
        self.behind.get().is_some()
            || marked()
            || !there("report/index.html")
            || (makes_fleet && !there("fleet/fleet.parquet"))
    }

    /// All is made that this build makes: without the feature `fleet` its tables stay behind.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn caught_up(&self) -> Result<(), Error> {
        let mark = self.root.join(BEHIND);
        let done = match cfg!(feature = "fleet") {
            true => remove_file(&mark),
            false => file::write_bytes(&mark, ONLY_FLEET),
        };
        done.map_err(|e| Error::Output(e.to_string()))
    }

    fn rejected(&self, log: &str) -> PathBuf {
        let stem = Path::new(log).file_stem().unwrap_or_default().to_string_lossy();
        let hash = blake3::hash(log.as_bytes()).to_hex();
        self.root.join("rejected").join(format!("{}-{}.parquet", file_name(&stem), &hash[..8]))
    }

    /// The session that an unreadable log was when it could still be read: the one that was
    /// made from this very path and is named like the file.
    pub fn once_was(&self, log: &str) -> Option<&str> {
        let stem = Path::new(log).file_stem()?.to_str()?;
        self.found
            .committed
            .get(&file_name(stem))?
            .iter()
            .find(|c| c.path == log)
            .map(|c| c.session_id.as_str())
    }
}

fn remove_temporaries(root: &Path) -> Result<(), Error> {
    if url::is_url(root) {
        return Ok(()); // what is put is put whole
    }
    let folders = TABLES.iter().chain([&WRITING]).map(|t| root.join(t)).filter(|f| f.is_dir());
    let files = folders.flat_map(|f| WalkDir::new(f).into_iter().filter_map(Result::ok));
    for entry in files.filter(|e| e.file_type().is_file()) {
        let name = entry.file_name().to_string_lossy();
        if name.starts_with(file::TEMPORARY.0) && name.ends_with(file::TEMPORARY.1) {
            tracing::debug!("removing {}, left by a run that was killed", entry.path().display());
            remove_file(entry.path()).map_err(|e| Error::Output(e.to_string()))?;
        }
    }
    Ok(())
}

fn remove_file(path: &Path) -> Result<(), file::Error> {
    files::remove(path).map_err(|source| file::Error::Io { path: path.to_owned(), source })
}
