//! Which sessions an output holds, and why one of them has to be computed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::time::SystemTime;

use rayon::prelude::*;
use walkdir::WalkDir;

use super::error::Error;
use super::kind::Kind;
use super::marker::{self, Committed};
use crate::objects::url::Url;
use crate::objects::{Location, Stat, client};
use crate::tables::file;
use crate::tables::names::file_name;
use crate::tables::registry::TableSpec;

/// The sessions of an output that one command keeps, as they are found there.
#[derive(Debug)]
pub struct Contents {
    /// Whose they are.
    pub kind: &'static Kind,
    root: Location,
    /// By file name; more than one only where an interrupted batch left a session under two bikes.
    committed: BTreeMap<String, Vec<Committed>>,
    /// File names of sessions that a batch was writing when it was killed.
    interrupted: BTreeSet<String>,
    /// Of an object store: everything that is there, but the report.
    names: Option<BTreeMap<Location, Stat>>,
    /// Of a folder: when its markers were written, and how long they are.
    stamps: BTreeMap<Location, (SystemTime, u64)>,
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
    /// Bike file, pipeline, model, channel map or the command's own settings are others.
    Settings,
    /// Another roadbench made it.
    Version,
    /// A table of it is missing.
    Incomplete,
    /// A batch was killed while it wrote its tables.
    Interrupted,
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
            Stale::Interrupted => "a run was killed while it wrote its tables",
            Stale::Forced => "asked for (--force, or a log by itself)",
        }
    }
}

impl Contents {
    /// An output of which nothing is known.
    pub fn unknown(kind: &'static Kind, root: &Location) -> Self {
        Contents {
            kind,
            root: root.clone(),
            committed: BTreeMap::new(),
            interrupted: BTreeSet::new(),
            names: None,
            stamps: BTreeMap::new(),
        }
    }

    /// Reads which sessions are there; writes nothing.
    ///
    /// # Errors
    /// An object store does not answer.
    pub fn read(kind: &'static Kind, root: &Location) -> Result<Self, Error> {
        Contents::unknown(kind, root).read_again()
    }

    /// Reads it once more; only the markers that changed since.
    ///
    /// # Errors
    /// As [`Contents::read`].
    pub fn read_again(&self) -> Result<Self, Error> {
        let mut now = Contents::unknown(self.kind, &self.root);
        match self.root.as_url() {
            None => {
                now.stamps = now.marker_stamps();
                now.committed = now.read_markers(self);
                now.interrupted = now.local_marks();
            }
            Some(url) => {
                let fail = |e: std::io::Error| Error::Output(format!("--out: {e}"));
                let names = self.list(url).map_err(fail)?;
                now.committed = now.fetch_markers(&names, self)?;
                now.interrupted = now.remote_marks(&names);
                now.names = Some(names);
            }
        }
        Ok(now)
    }

    /// The output.
    pub fn root(&self) -> &Location {
        &self.root
    }

    /// Whether a file is there; of an object store as it was listed.
    pub fn has(&self, file: &Location) -> bool {
        match &self.names {
            None => file.as_path().is_some_and(std::path::Path::is_file),
            Some(names) => names.contains_key(file),
        }
    }

    /// Whether a file may be there that was when this was read; of a folder any may.
    pub fn may_have(&self, file: &Location) -> bool {
        self.names.as_ref().is_none_or(|names| names.contains_key(file))
    }

    /// The sessions of a file name.
    pub fn of_file(&self, file: &str) -> &[Committed] {
        self.committed.get(file).map(Vec::as_slice).unwrap_or_default()
    }

    /// What is there of a session.
    pub fn of(&self, session_id: &str) -> &[Committed] {
        self.of_file(&file_name(session_id))
    }

    /// What a session's tables were made from, if it is there once.
    pub fn input_hash(&self, session_id: &str) -> Option<String> {
        match self.of(session_id) {
            [one] => Some(one.input_hash.clone()),
            _ => None,
        }
    }

    /// Every session that is there.
    pub fn sessions(&self) -> impl Iterator<Item = &Committed> {
        self.committed.values().flatten()
    }

    /// File names of sessions that a batch was writing when it was killed.
    pub fn interrupted(&self) -> impl Iterator<Item = &str> {
        self.interrupted.iter().map(String::as_str)
    }

    /// Adds a session that is known to be there.
    pub fn add(&mut self, row: Committed, is_interrupted: bool) {
        let file = file_name(&row.session_id);
        if is_interrupted {
            self.interrupted.insert(file.clone());
        }
        self.committed.entry(file).or_default().push(row);
    }

    /// Why the session has to be computed; `None` when its tables are there, whole, and made from
    /// just this.
    pub fn stale(
        &self,
        wanted: &Committed,
        is_requested: impl Fn(&TableSpec) -> bool,
    ) -> Option<Stale> {
        let file = file_name(&wanted.session_id);
        let there = match self.of_file(&file) {
            [one] if one.session_id == wanted.session_id => one,
            _ => return Some(Stale::New),
        };
        let differs = [
            (there.bike_id != wanted.bike_id, Stale::Bike),
            (self.interrupted.contains(&file), Stale::Interrupted),
            (there.input_hash != wanted.input_hash, Stale::Log),
            (there.path != wanted.path, Stale::Moved),
            (there.pipeline_hash != wanted.pipeline_hash, Stale::Settings),
            (there.version != wanted.version, Stale::Version),
        ];
        if let Some((_, why)) = differs.into_iter().find(|(differs, _)| *differs) {
            return Some(why);
        }
        let mut required = self.kind.required(is_requested);
        let is_whole =
            required.all(|spec| self.has(&self.file(spec.name, "parquet", &wanted.bike_id, &file)));
        (!is_whole).then_some(Stale::Incomplete)
    }

    /// Where a file of a session is.
    pub fn file(&self, folder: &str, extension: &str, bike_id: &str, file: &str) -> Location {
        self.root.join(format!("{folder}/bike={bike_id}/{file}.{extension}"))
    }

    /// Where the commit marker of a session is.
    pub fn marker(&self, bike_id: &str, file: &str) -> Location {
        self.file(self.kind.marker.name, "parquet", bike_id, file)
    }

    /// The mark of a session that is being written.
    pub fn writing_mark(&self, file: &str) -> Location {
        self.root.join(format!("{}/{file}", self.kind.writing))
    }

    /// The sessions of a folder that are marked as being written.
    fn local_marks(&self) -> BTreeSet<String> {
        let folder = self.root.join(self.kind.writing);
        let entries = folder.as_path().and_then(|f| std::fs::read_dir(f).ok());
        let entries = entries.into_iter().flatten();
        let names = entries.filter_map(|e| e.ok()?.file_name().into_string().ok());
        names.filter(|name| !name.starts_with(file::TEMPORARY.0)).collect()
    }

    /// As [`Contents::local_marks`], of an object store.
    fn remote_marks(&self, names: &BTreeMap<Location, Stat>) -> BTreeSet<String> {
        let folder = self.root.join(self.kind.writing);
        let marks = names.keys().filter(|n| n.parent().as_ref() == Some(&folder));
        marks.map(|m| m.file_name().into_owned()).collect()
    }

    /// Of an object store: every file below it that this command or the report wrote, but the
    /// report's other pages.
    fn list(&self, root: &Url) -> std::io::Result<BTreeMap<Location, Stat>> {
        let mut names = BTreeMap::new();
        let own = self.kind.files().map(|(folder, _)| folder);
        for folder in own.chain([self.kind.marker.name, "rejected", ".roadbench"]) {
            let below = root.join(folder);
            let entries = client::list(&below)?.into_iter();
            names.extend(entries.map(|e| (Location::Remote(below.join(&e.key)), e.stat)));
        }
        let index = root.join("report/index.html");
        match client::stat(&index) {
            Ok(stat) => _ = names.insert(index.into(), stat),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {}
            Err(e) => return Err(e),
        }
        Ok(names)
    }

    /// The commit markers of a folder.
    fn marker_stamps(&self) -> BTreeMap<Location, (SystemTime, u64)> {
        let folder = self.root.join(self.kind.marker.name);
        let Some(folder) = folder.as_path() else { return BTreeMap::new() };
        let walk = WalkDir::new(folder).min_depth(2).max_depth(2);
        let entries = walk.into_iter().filter_map(Result::ok);
        let markers = entries.filter(|e| e.path().extension().is_some_and(|e| e == "parquet"));
        let stamp = |e: walkdir::DirEntry| {
            let about = e.metadata().ok()?;
            let written = about.modified().unwrap_or(SystemTime::UNIX_EPOCH);
            Some((Location::Local(e.into_path()), (written, about.len())))
        };
        markers.filter_map(stamp).collect()
    }

    /// The sessions of a folder. A marker that cannot be read does not count: it is made anew.
    fn read_markers(&self, before: &Contents) -> BTreeMap<String, Vec<Committed>> {
        let at = |row: &Committed| self.marker(&row.bike_id, &file_name(&row.session_id));
        let known: BTreeMap<Location, &Committed> = before
            .sessions()
            .map(|row| (at(row), row))
            .filter(|(at, _)| {
                let now = self.stamps.get(at);
                now.is_some() && before.stamps.get(at) == now
            })
            .collect();
        // archives have tens of thousands
        let paths: Vec<&Location> = self.stamps.keys().collect();
        let read = |at: &&Location| match known.get(*at) {
            Some(row) => Some((*row).clone()),
            None => marker::row(at, File::open(at.as_path()?).ok()?),
        };
        let markers: Vec<Option<Committed>> = paths.par_iter().map(read).collect();
        let mut out = BTreeMap::new();
        for (at, row) in paths.into_iter().zip(markers) {
            keep(&mut out, at, row);
        }
        out
    }

    /// As [`Contents::read_markers`], of an object store. One that cannot be fetched is an error: it
    /// is whole.
    fn fetch_markers(
        &self,
        names: &BTreeMap<Location, Stat>,
        before: &Contents,
    ) -> Result<BTreeMap<String, Vec<Committed>>, Error> {
        let mut out: BTreeMap<String, Vec<Committed>> = BTreeMap::new();
        let mut known = BTreeSet::new();
        for row in before.sessions() {
            let file = file_name(&row.session_id);
            let at = self.marker(&row.bike_id, &file);
            let then = before.names.as_ref().and_then(|names| names.get(&at));
            if then.is_some_and(|then| then.etag.is_some() && names.get(&at) == Some(then)) {
                known.insert(at);
                out.entry(file).or_default().push(row.clone());
            }
        }
        let folder = self.root.join(self.kind.marker.name);
        let markers = names.keys().filter(|n| n.starts_with(&folder) && n.has_extension("parquet"));
        let new: Vec<&Location> = markers.filter(|n| !known.contains(*n)).collect();
        for some in new.chunks(256) {
            let urls: Vec<Url> = some.iter().filter_map(|at| at.as_url().cloned()).collect();
            for (at, bytes) in some.iter().zip(client::get_many(&urls)) {
                let bytes = bytes.map_err(|e| Error::Output(e.to_string()))?;
                keep(&mut out, at, marker::row(at, bytes));
            }
        }
        Ok(out)
    }
}

/// Files a marker's row under the marker's name.
fn keep(out: &mut BTreeMap<String, Vec<Committed>>, marker: &Location, row: Option<Committed>) {
    match row {
        Some(row) => out.entry(marker.file_stem().into_owned()).or_default().push(row),
        None => tracing::warn!("{marker}: not a commit marker of a session; passed by"),
    }
}
