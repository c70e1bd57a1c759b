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

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use arrow::array::{Array, AsArray, RecordBatch};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::reader::ChunkReader;
use rayon::prelude::*;
use walkdir::WalkDir;

use super::Error;
use super::lock::Lock;
use super::names::file_name;
use crate::objects::{Stat, client, files, url};
use crate::pipeline::Outcome;
use crate::rows::Rejected;
use crate::schema::Table;
use crate::table;

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
    "discrepancies",
    "causes",
    "replays",
    "report",
];

/// The tables of one session but for its commit marker; `signals` only on request, `forces` only
/// off-road.
const PER_SESSION: &[&str] =
    &["coefficients", "manoeuvres", "forces", "warnings", "plots", "signals"];
/// Where sessions are marked that are being written.
const WRITING: &str = ".roadbench/writing";
/// In an object store: there while fleet and report are older than the sessions.
const BEHIND: &str = ".roadbench/behind";
/// Those that a session need not have.
const OPTIONAL: [&str; 2] = ["signals", "forces"];

/// A session whose tables are in the folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Committed {
    /// The session.
    pub session_id: String,
    /// Its bike: the hive partition.
    pub bike_id: String,
    /// The input as it was named then.
    pub path: String,
    /// From what the tables were made.
    pub input_hash: String,
    /// From what the tables were made.
    pub pipeline_hash: String,
    /// The roadbench that made them.
    pub version: String,
}

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
    schemas: BTreeMap<&'static str, Table>,
    found: Contents,
    lock: Lock,
    /// Set once something over all sessions has to be made anew.
    behind: OnceLock<()>,
}

/// The sessions of an output folder, as they are found there.
#[derive(Debug, Default)]
pub struct Contents {
    root: PathBuf,
    /// By file name; more than one only where an interrupted run left a session under two bikes.
    committed: BTreeMap<String, Vec<Committed>>,
    /// File names of sessions that a run was writing when it was killed.
    torn: BTreeSet<String>,
    /// Of an object store: everything that is there, but the report.
    names: Option<BTreeMap<PathBuf, Stat>>,
}

/// Why a session has to be computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stale {
    /// It is not there.
    New,
    /// The log's bytes are others.
    Log,
    /// The log has another name or place.
    Moved,
    /// It was another motorcycle's.
    Bike,
    /// Bike file, pipeline, model or channel map are others.
    Settings,
    /// Another roadbench made it.
    Version,
    /// A table of it is missing.
    Incomplete,
    /// A run was killed while it wrote its tables.
    Torn,
    /// It was asked for, as it is of a log that is named alone.
    Forced,
}

impl Stale {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Stale::New => "new",
            Stale::Log => "the log has changed",
            Stale::Moved => "the log was renamed or moved",
            Stale::Bike => "it was another motorcycle's",
            Stale::Settings => "the bike file or the settings have changed",
            Stale::Version => "another version of roadbench made it",
            Stale::Incomplete => "a table of it is missing",
            Stale::Torn => "a run was killed while it wrote its tables",
            Stale::Forced => "asked for (--force, or a log by itself)",
        }
    }
}

impl Contents {
    /// Reads which sessions are there; writes nothing.
    ///
    /// # Errors
    /// An object store does not tell.
    pub fn read(root: &Path) -> Result<Self, Error> {
        Self::read_again(root, &Contents::default())
    }

    /// Reads it once more; of an object store only the sessions that changed since.
    ///
    /// # Errors
    /// As [`Contents::read`].
    pub fn read_again(root: &Path, before: &Contents) -> Result<Self, Error> {
        let names = names(root).map_err(|e| Error::Output(format!("--out: {e}")))?;
        let (committed, torn) = match &names {
            None => (committed(root), torn(root)),
            Some(names) => (committed_there(root, names, before)?, torn_there(root, names)),
        };
        Ok(Contents { root: root.to_owned(), committed, torn, names })
    }

    fn has(&self, path: &Path) -> bool {
        match &self.names {
            None => path.is_file(),
            Some(names) => names.contains_key(path),
        }
    }

    /// Every session that is there.
    pub fn sessions(&self) -> impl Iterator<Item = &Committed> {
        self.committed.values().flatten()
    }

    /// As [`Store::stale`].
    pub fn stale(&self, wanted: &Committed, signals: bool) -> Option<Stale> {
        let file = file_name(&wanted.session_id);
        let there = match self.committed.get(&file).map(Vec::as_slice) {
            Some([one]) if one.session_id == wanted.session_id => one,
            _ => return Some(Stale::New),
        };
        if there.bike_id != wanted.bike_id {
            return Some(Stale::Bike);
        }
        if self.torn.contains(&file) {
            return Some(Stale::Torn);
        }
        if there.input_hash != wanted.input_hash {
            return Some(Stale::Log);
        }
        if there.path != wanted.path {
            return Some(Stale::Moved);
        }
        if there.pipeline_hash != wanted.pipeline_hash {
            return Some(Stale::Settings);
        }
        if there.version != wanted.version {
            return Some(Stale::Version);
        }
        let whole = PER_SESSION
            .iter()
            .filter(|&table| !OPTIONAL.contains(table) || (*table == "signals" && signals))
            .all(|table| self.has(&path(&self.root, table, &wanted.bike_id, &file)));
        (!whole).then_some(Stale::Incomplete)
    }
}

fn path(root: &Path, table: &str, bike_id: &str, file: &str) -> PathBuf {
    root.join(table).join(format!("bike={bike_id}")).join(format!("{file}.parquet"))
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
        let schemas =
            ["sessions", "coefficients", "manoeuvres", "forces", "warnings", "plots", "rejected"]
                .map(|name| (name, Table::embedded(name)));
        let store = Store {
            root: root.to_owned(),
            schemas: BTreeMap::from(schemas),
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
        let output = |e: table::Error| Error::Output(e.to_string());
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
    pub fn encode(&self, outcome: &Outcome) -> Result<Files, table::Error> {
        let schema = |name: &str| &self.schemas[name];
        let mut tables = vec![
            ("coefficients", table::to_bytes(schema("coefficients"), &outcome.coefficients)?),
            ("manoeuvres", table::to_bytes(schema("manoeuvres"), &outcome.manoeuvres)?),
            ("warnings", table::to_bytes(schema("warnings"), &outcome.warnings)?),
            ("plots", table::to_bytes(schema("plots"), &outcome.plots)?),
        ];
        if !outcome.forces.is_empty() {
            tables.push(("forces", table::to_bytes(schema("forces"), &outcome.forces)?));
        }
        if let Some(signals) = &outcome.signals {
            tables.push(("signals", table::batch_to_bytes("signals", signals)?));
        }
        let marker = table::to_bytes(schema("sessions"), std::slice::from_ref(&outcome.session))?;
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
    ) -> Result<(), table::Error> {
        let file = file_name(session_id);
        let mark = mark(&self.root, &file);
        self.changes()?;
        table::write_bytes(&mark, bike_id.as_bytes())?;
        for (table, bytes) in &files.tables {
            table::write_bytes(&self.path(table, bike_id, &file), bytes)?;
        }
        // what it had and has no more
        for table in OPTIONAL.iter().filter(|t| files.tables.iter().all(|(name, _)| name != *t)) {
            self.remove_file(&self.path(table, bike_id, &file))?;
        }
        table::write_bytes(&self.path("sessions", bike_id, &file), &files.marker)?;
        self.remove_but(&file, Some(bike_id))?;
        self.forgive(log)?;
        remove_file(&mark)
    }

    /// Takes a session's tables out of the folder, under whatever bike they were.
    ///
    /// # Errors
    /// They are there and cannot be removed.
    pub fn remove(&self, session_id: &str) -> Result<(), table::Error> {
        let file = file_name(session_id);
        let Some(known) = self.found.committed.get(&file) else { return Ok(()) };
        let bikes: Vec<&str> = known.iter().map(|old| old.bike_id.as_str()).collect();
        let mark = mark(&self.root, &file);
        self.changes()?;
        table::write_bytes(&mark, bikes.join("\n").as_bytes())?;
        self.remove_but(&file, None)?;
        remove_file(&mark)
    }

    fn remove_but(&self, file: &str, kept: Option<&str>) -> Result<(), table::Error> {
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
    pub fn reject(&self, row: &Rejected) -> Result<(), table::Error> {
        self.changes()?;
        let rows = std::slice::from_ref(row);
        table::write(&self.rejected(&row.path), &self.schemas["rejected"], rows)
    }

    /// Removes the row that an input had in `rejected`.
    ///
    /// # Errors
    /// It is there and cannot be removed.
    pub fn forgive(&self, log: &str) -> Result<(), table::Error> {
        let path = self.rejected(log);
        if self.found.names.is_some() && self.found.has(&path) {
            self.changes()?;
        }
        self.remove_file(&path)
    }

    /// Removes a file that was there when the run began; of an object store no request is spent on
    /// one that was not.
    fn remove_file(&self, path: &Path) -> Result<(), table::Error> {
        match &self.found.names {
            Some(names) if !names.contains_key(path) => Ok(()),
            _ => remove_file(path),
        }
    }

    /// Before anything changes: the lock is still ours, and, of an object store, what is made over
    /// all sessions is known to be behind until it is made.
    fn changes(&self) -> Result<(), table::Error> {
        let path = || self.root.join(BEHIND);
        self.lock.check().map_err(|source| table::Error::Io { path: path(), source })?;
        if self.found.names.is_some() && self.behind.get().is_none() {
            table::write_bytes(&path(), b"")?;
            let _ = self.behind.set(()); // another worker may have been quicker
        }
        Ok(())
    }

    /// Whether fleet and report have to be made anew. Always, in a folder; in an object store, where
    /// that is dear, only after a change, be it one of a run that was killed.
    pub fn is_behind(&self) -> bool {
        match &self.found.names {
            None => true,
            Some(names) => {
                let reported = names.contains_key(&self.root.join("report/index.html"));
                !reported
                    || self.behind.get().is_some()
                    || names.contains_key(&self.root.join(BEHIND))
            }
        }
    }

    /// They are made.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn caught_up(&self) -> Result<(), Error> {
        match &self.found.names {
            None => Ok(()),
            Some(_) => {
                remove_file(&self.root.join(BEHIND)).map_err(|e| Error::Output(e.to_string()))
            }
        }
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

/// The mark of a session that is being written.
fn mark(root: &Path, file: &str) -> PathBuf {
    root.join(WRITING).join(file)
}

/// The sessions whose marks are there.
fn torn(root: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(root.join(WRITING)).into_iter().flatten();
    let names = entries.filter_map(|e| e.ok()?.file_name().into_string().ok());
    names.filter(|name| !name.starts_with(table::TEMPORARY.0)).collect()
}

/// Of an object store: every file below it, but the report's pages.
fn names(root: &Path) -> std::io::Result<Option<BTreeMap<PathBuf, Stat>>> {
    let Some(url) = url::parse(root)? else { return Ok(None) };
    let mut names = BTreeMap::new();
    for folder in PER_SESSION.iter().chain(&["sessions", "rejected", ".roadbench"]) {
        let below = url.join(folder);
        names
            .extend(client::list(&below)?.into_iter().map(|e| (below.join(&e.key).path(), e.stat)));
    }
    let index = url.join("report/index.html");
    match client::stat(&index) {
        Ok(stat) => _ = names.insert(index.path(), stat),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {}
        Err(e) => return Err(e),
    }
    Ok(Some(names))
}

fn torn_there(root: &Path, names: &BTreeMap<PathBuf, Stat>) -> BTreeSet<String> {
    let marks = names.keys().filter_map(|n| n.strip_prefix(root.join(WRITING)).ok());
    marks.map(|m| m.to_string_lossy().into_owned()).collect()
}

/// As [`committed`], of an object store. One that cannot be fetched is an error: it is whole.
fn committed_there(
    root: &Path,
    names: &BTreeMap<PathBuf, Stat>,
    before: &Contents,
) -> Result<BTreeMap<String, Vec<Committed>>, Error> {
    let fail = |e: std::io::Error| Error::Output(e.to_string());
    let mut out: BTreeMap<String, Vec<Committed>> = BTreeMap::new();
    let folder = root.join("sessions");
    let mut known = BTreeSet::new();
    for row in before.sessions() {
        let file = file_name(&row.session_id);
        let at = path(root, "sessions", &row.bike_id, &file);
        let then = before.names.as_ref().and_then(|names| names.get(&at));
        if then.is_some_and(|then| then.etag.is_some() && names.get(&at) == Some(then)) {
            known.insert(at);
            out.entry(file).or_default().push(row.clone());
        }
    }
    let markers = names
        .keys()
        .filter(|n| n.starts_with(&folder) && n.extension().is_some_and(|e| e == "parquet"));
    let paths: Vec<&PathBuf> = markers.filter(|n| !known.contains(*n)).collect();
    for some in paths.chunks(256) {
        let urls = some.iter().filter_map(|p| url::parse(p).transpose());
        let urls = urls.collect::<std::io::Result<Vec<_>>>().map_err(fail)?;
        for (path, bytes) in some.iter().zip(client::get_many(&urls)) {
            let row = marker(path, bytes.map_err(fail)?);
            match (path.file_stem().and_then(|s| s.to_str()), row) {
                (Some(stem), Some(row)) => out.entry(stem.to_owned()).or_default().push(row),
                _ => tracing::warn!("{}: not a sessions table; passed by", path.display()),
            }
        }
    }
    Ok(out)
}

fn remove_temporaries(root: &Path) -> Result<(), Error> {
    if url::is_url(root) {
        return Ok(()); // what is put is put whole
    }
    let folders = TABLES.iter().chain([&WRITING]).map(|t| root.join(t)).filter(|f| f.is_dir());
    let files = folders.flat_map(|f| WalkDir::new(f).into_iter().filter_map(Result::ok));
    for entry in files.filter(|e| e.file_type().is_file()) {
        let name = entry.file_name().to_string_lossy();
        if name.starts_with(table::TEMPORARY.0) && name.ends_with(table::TEMPORARY.1) {
            tracing::debug!("removing {}, left by a run that was killed", entry.path().display());
            remove_file(entry.path()).map_err(|e| Error::Output(e.to_string()))?;
        }
    }
    Ok(())
}

fn remove_file(path: &Path) -> Result<(), table::Error> {
    files::remove(path).map_err(|source| table::Error::Io { path: path.to_owned(), source })
}

/// The sessions in the folder. A file that cannot be read does not count: it is made anew.
pub(super) fn committed(root: &Path) -> BTreeMap<String, Vec<Committed>> {
    let mut out: BTreeMap<String, Vec<Committed>> = BTreeMap::new();
    let walk = WalkDir::new(root.join("sessions")).min_depth(2).max_depth(2).sort_by_file_name();
    let paths = walk.into_iter().filter_map(|e| Some(e.ok()?.into_path()));
    let paths: Vec<PathBuf> =
        paths.filter(|p| p.extension().is_some_and(|e| e == "parquet")).collect();
    // archives have tens of thousands
    let markers: Vec<Option<Committed>> = paths.par_iter().map(|p| read_marker(p)).collect();
    for (path, marker) in paths.iter().zip(markers) {
        match (path.file_stem().and_then(|s| s.to_str()), marker) {
            (Some(stem), Some(row)) => out.entry(stem.to_owned()).or_default().push(row),
            _ => tracing::warn!("{}: not a sessions table; passed by", path.display()),
        }
    }
    out
}

fn read_marker(path: &Path) -> Option<Committed> {
    marker(path, File::open(path).ok()?)
}

/// The row of a sessions table of that name.
fn marker(path: &Path, file: impl ChunkReader + 'static) -> Option<Committed> {
    let reader = ParquetRecordBatchReaderBuilder::try_new(file).ok()?.build().ok()?;
    let batch: RecordBatch = reader.into_iter().next()?.ok()?;
    let text = |name: &str| {
        let column = batch.column_by_name(name)?.as_string_opt::<i32>()?;
        (!column.is_empty()).then(|| column.value(0).to_owned())
    };
    let row = Committed {
        session_id: text("session_id")?,
        bike_id: text("bike_id")?,
        path: text("path")?,
        input_hash: text("input_hash")?,
        pipeline_hash: text("pipeline_hash")?,
        version: text("version")?,
    };
    // the row must be where its own words put it: nothing outside is ever removed on its account
    let folder = path.parent()?.file_name()?.to_str()?;
    let in_place = folder.strip_prefix("bike=") == Some(row.bike_id.as_str())
        && path.file_stem()?.to_str()? == file_name(&row.session_id);
    in_place.then_some(row)
}
