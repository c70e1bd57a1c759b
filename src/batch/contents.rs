//! Which sessions an output holds, and why one of them has to be computed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use arrow::array::{Array, AsArray, RecordBatch};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ArrowReaderOptions, ParquetRecordBatchReaderBuilder};
use parquet::file::reader::ChunkReader;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use walkdir::WalkDir;

use super::Error;
use crate::objects::{Stat, client, url};
use crate::tables::file;
use crate::tables::names::file_name;

/// The tables of one session but for its commit marker; `signals` only on request, `forces` only
/// off-road.
pub(super) const PER_SESSION: &[&str] =
    &["coefficients", "manoeuvres", "forces", "warnings", "plots", "signals"];
/// Where sessions are marked that are being written.
pub(super) const WRITING: &str = ".roadbench/writing";
/// Those that a session need not have.
pub(super) const OPTIONAL: [&str; 2] = ["signals", "forces"];

/// A session whose tables are in the folder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
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

/// The sessions of an output folder, as they are found there.
#[derive(Debug, Default)]
pub struct Contents {
    pub(super) root: PathBuf,
    /// By file name; more than one only where an interrupted run left a session under two bikes.
    pub(super) committed: BTreeMap<String, Vec<Committed>>,
    /// File names of sessions that a run was writing when it was killed.
    pub(super) torn: BTreeSet<String>,
    /// Of an object store: everything that is there, but the report.
    pub(super) names: Option<BTreeMap<PathBuf, Stat>>,
    /// Of a folder: when its markers were written, and how long they are.
    pub(super) stamps: BTreeMap<PathBuf, (SystemTime, u64)>,
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

    /// Reads it once more; only the markers that changed since.
    ///
    /// # Errors
    /// As [`Contents::read`].
    pub fn read_again(root: &Path, before: &Contents) -> Result<Self, Error> {
        let names = names(root).map_err(|e| Error::Output(format!("--out: {e}")))?;
        let mut stamps = BTreeMap::new();
        let (committed, torn) = match &names {
            None => {
                stamps = marker_stamps(root);
                (committed(&stamps, before), torn(root))
            }
            Some(names) => (committed_there(root, names, before)?, torn_there(root, names)),
        };
        Ok(Contents { root: root.to_owned(), committed, torn, names, stamps })
    }

    pub(super) fn has(&self, path: &Path) -> bool {
        match &self.names {
            None => path.is_file(),
            Some(names) => names.contains_key(path),
        }
    }

    /// What a session's tables were made from, if it is there once.
    pub fn input_hash(&self, session_id: &str) -> Option<String> {
        match self.committed.get(&file_name(session_id)).map(Vec::as_slice) {
            Some([one]) => Some(one.input_hash.clone()),
            _ => None,
        }
    }

    /// Every session that is there.
    pub fn sessions(&self) -> impl Iterator<Item = &Committed> {
        self.committed.values().flatten()
    }

    /// As `Store::stale`.
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

/// Where a table of a session is.
pub(super) fn path(root: &Path, table: &str, bike_id: &str, file: &str) -> PathBuf {
    root.join(table).join(format!("bike={bike_id}")).join(format!("{file}.parquet"))
}

/// The mark of a session that is being written.
pub(super) fn mark(root: &Path, file: &str) -> PathBuf {
    root.join(WRITING).join(file)
}

/// The sessions whose marks are there.
fn torn(root: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(root.join(WRITING)).into_iter().flatten();
    let names = entries.filter_map(|e| e.ok()?.file_name().into_string().ok());
    names.filter(|name| !name.starts_with(file::TEMPORARY.0)).collect()
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

/// The commit markers in the folder.
fn marker_stamps(root: &Path) -> BTreeMap<PathBuf, (SystemTime, u64)> {
    let walk = WalkDir::new(root.join("sessions")).min_depth(2).max_depth(2);
    let entries = walk.into_iter().filter_map(Result::ok);
    let markers = entries.filter(|e| e.path().extension().is_some_and(|e| e == "parquet"));
    let stamp = |e: walkdir::DirEntry| {
        let about = e.metadata().ok()?;
        let written = about.modified().unwrap_or(SystemTime::UNIX_EPOCH);
        Some((e.into_path(), (written, about.len())))
    };
    markers.filter_map(stamp).collect()
}

/// The sessions in the folder. A file that cannot be read does not count: it is made anew.
fn committed(
    stamps: &BTreeMap<PathBuf, (SystemTime, u64)>,
    before: &Contents,
) -> BTreeMap<String, Vec<Committed>> {
    let known: BTreeMap<PathBuf, &Committed> = before
        .sessions()
        .map(|row| (path(&before.root, "sessions", &row.bike_id, &file_name(&row.session_id)), row))
        .filter(|(at, _)| stamps.contains_key(at) && before.stamps.get(at) == stamps.get(at))
        .collect();
    // archives have tens of thousands
    let paths: Vec<&PathBuf> = stamps.keys().collect();
    let markers: Vec<Option<Committed>> = paths
        .par_iter()
        .map(|path| known.get(*path).map_or_else(|| read_marker(path), |row| Some((*row).clone())))
        .collect();
    let mut out: BTreeMap<String, Vec<Committed>> = BTreeMap::new();
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

/// Columns of a commit marker that are read.
const MARKER: [&str; 6] =
    ["session_id", "bike_id", "path", "input_hash", "pipeline_hash", "version"];

/// The row of a sessions table of that name. There are tens of thousands: only what is needed is
/// decoded.
fn marker(path: &Path, file: impl ChunkReader + 'static) -> Option<Committed> {
    let plain = ArrowReaderOptions::new().with_skip_arrow_metadata(true);
    let builder = ParquetRecordBatchReaderBuilder::try_new_with_options(file, plain).ok()?;
    let wanted = ProjectionMask::columns(builder.parquet_schema(), MARKER);
    let reader = builder.with_projection(wanted).build().ok()?;
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
