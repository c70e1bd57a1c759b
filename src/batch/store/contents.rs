//! Which sessions an output holds, and why one of them has to be computed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use bytes::Bytes;
use rayon::prelude::*;
use walkdir::WalkDir;

use super::empty;
use super::kind::Kind;
use super::manifest::{self, Manifest};
use super::marker::{self, Committed, Key};
use super::parts;
use super::staged::{self, Staged};
use crate::batch::error::Error;
use crate::batch::log_hash::hash_file;
use crate::store::objects::url::Url;
use crate::store::objects::{Location, Stat, client};
use crate::store::tables::names::file_name;
use crate::store::tables::registry::TableSpec;

/// The sessions of an output that one command keeps, as they are found there.
#[derive(Debug)]
pub struct Contents {
    /// Command that they belong to.
    pub kind: &'static Kind,
    root: Location,
    /// The files with commit markers.
    markers: BTreeMap<Location, Marker>,
    /// Sessions whose tables wait to be taken in, and their files.
    staged: BTreeMap<Key, (Location, Staged)>,
    /// More than one of a key only where somebody copied a file.
    sessions: BTreeMap<Key, Vec<Committed>>,
    /// Sessions by the path of their log.
    by_path: BTreeMap<String, Vec<Key>>,
    /// Sessions by the hash of their log.
    by_hash: BTreeMap<String, Vec<Key>>,
    /// Files of sessions that are missing or not as they were written; looked for by [`Contents::with_damage`].
    damaged: BTreeSet<String>,
    /// Of an object store: everything that is there, but the report.
    names: Option<BTreeMap<Location, Stat>>,
}

/// A file with commit markers.
#[derive(Debug, Clone)]
struct Marker {
    /// Size and time, which show whether it has changed.
    stamp: Stat,
    rows: Vec<Committed>,
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
    /// A table of it is missing, or not as it was written.
    Incomplete,
    /// The user asked for it, as with a log given by itself.
    Forced,
}

impl Stale {
    pub fn words(self) -> &'static str {
        match self {
            Stale::New => "new",
            Stale::Log => "the log has changed",
            Stale::Moved => "the log was renamed or moved",
            Stale::Bike => "it was another motorcycle's",
            Stale::Settings => "the bike file or the settings have changed",
            Stale::Version => "another version of roadbench made it",
            Stale::Incomplete => "a table of it is missing or damaged",
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
            markers: BTreeMap::new(),
            staged: BTreeMap::new(),
            sessions: BTreeMap::new(),
            by_path: BTreeMap::new(),
            by_hash: BTreeMap::new(),
            damaged: BTreeSet::new(),
            names: None,
        }
    }

    /// Looks through the tables of sessions, too: those whose files are missing or not as they were written are
    /// [`Stale::Incomplete`]. Of an object store only what is missing is known.
    #[must_use]
    pub fn with_damage(mut self) -> Self {
        let list = Manifest::read(&self.root);
        let kind = self.kind;
        let folders: Vec<&str> =
            kind.files().map(|(folder, _)| folder).chain([kind.marker.name]).collect();
        let derived = kind.derived();
        let wanted = |path: &str| {
            folders.iter().any(|f| manifest::is_below(path, f))
                && !derived.iter().any(|f| manifest::is_below(path, f))
                && !empty::is_one(path)
        };
        self.damaged = match &self.names {
            None => list.damaged(&self.root, wanted),
            Some(names) => {
                let lacks =
                    |path: &&str| wanted(path) && !names.contains_key(&self.root.join(path));
                list.files().map(|(path, _)| path).filter(lacks).map(str::to_owned).collect()
            }
        };
        self
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
        now.damaged.clone_from(&self.damaged);
        // what waits is read first: a run that takes it in meanwhile does not hide it from a reader
        match self.root.as_url() {
            None => {
                now.staged = now.local_staged()?;
                now.markers = now.local_markers(self)?;
            }
            Some(url) => {
                let fail = |e: std::io::Error| Error::Output(format!("--out: {e}"));
                let names = self.list(url).map_err(fail)?;
                now.staged = now.fetch_staged(&names)?;
                now.markers = now.fetch_markers(&names, self)?;
                now.names = Some(names);
            }
        }
        for row in now.markers.values().flat_map(|m| &m.rows) {
            let key = row.key();
            if !now.staged.contains_key(&key) {
                now.sessions.entry(key).or_default().push(row.clone());
            }
        }
        for (key, (_, staged)) in &now.staged {
            if let Some(made) = &staged.made {
                now.sessions.insert(key.clone(), vec![made.clone()]);
            }
        }
        for (key, rows) in &now.sessions {
            for row in rows {
                now.by_path.entry(row.path.clone()).or_default().push(key.clone());
                now.by_hash.entry(row.input_hash.clone()).or_default().push(key.clone());
            }
        }
        Ok(now)
    }

    pub fn root(&self) -> &Location {
        &self.root
    }

    /// Whether a file is there; of an object store as it was listed.
    pub fn has(&self, file: &Location) -> bool {
        match &self.names {
            None => match file.as_path() {
                Some(path) => path.is_file(),
                None => file.exists().unwrap_or(false), // a worker's, who has listed nothing
            },
            Some(names) => names.contains_key(file),
        }
    }

    /// Whether a file may be there that was when this was read; of a folder any may.
    pub fn may_have(&self, file: &Location) -> bool {
        self.names.as_ref().is_none_or(|names| names.contains_key(file))
    }

    /// Entries of a session.
    pub fn of(&self, key: &Key) -> &[Committed] {
        self.sessions.get(key).map(Vec::as_slice).unwrap_or_default()
    }

    /// Sessions from a log with that path.
    pub fn made_from(&self, path: &str) -> &[Key] {
        self.by_path.get(path).map(Vec::as_slice).unwrap_or_default()
    }

    /// Entries from a log with that hash.
    pub fn of_bytes<'a>(&'a self, input_hash: &'a str) -> impl Iterator<Item = &'a Committed> {
        let keys = self.by_hash.get(input_hash).into_iter().flatten();
        keys.flat_map(|key| self.of(key)).filter(move |row| row.input_hash == input_hash)
    }

    /// Hash of the log of a session, if the output has the session exactly once.
    pub fn input_hash(&self, key: &Key) -> Option<String> {
        match self.of(key) {
            [one] => Some(one.input_hash.clone()),
            _ => None,
        }
    }

    /// Every session that is there.
    pub fn sessions(&self) -> impl Iterator<Item = &Committed> {
        self.sessions.values().flatten()
    }

    /// Every session in the tables, be it that another state of it waits to be taken in.
    pub fn taken_in(&self) -> impl Iterator<Item = &Committed> {
        self.markers.values().flat_map(|m| &m.rows)
    }

    /// Sessions whose tables wait to be taken in, and the files that have them.
    pub fn staged(&self) -> impl Iterator<Item = (&Location, &Staged)> {
        self.staged.values().map(|(at, staged)| (at, staged))
    }

    /// Adds a session that is known to be there.
    pub fn add(&mut self, row: Committed) {
        self.sessions.entry(row.key()).or_default().push(row);
    }

    /// Another log with the same bytes, whose session is there: the same ride must not count twice.
    pub fn copied_from<'a>(&'a self, wanted: &'a Committed) -> Option<&'a Committed> {
        let own = wanted.key();
        self.of_bytes(&wanted.input_hash).find(|row| {
            let is_same = || {
                let Ok(at) = Location::parse(&row.path) else { return false };
                match hash_file(&at) {
                    Ok(hash) => hash == row.input_hash,
                    // one that cannot be read may be as it was: the ride must not count twice
                    Err(_) => at.exists().unwrap_or(true),
                }
            };
            row.key() != own && row.path != wanted.path && is_same()
        })
    }

    /// Why the session has to be computed; `None` when its tables are there, whole, and made from
    /// just this.
    pub fn stale(
        &self,
        wanted: &Committed,
        is_requested: impl Fn(&TableSpec) -> bool,
    ) -> Option<Stale> {
        let key = wanted.key();
        let [there] = self.of(&key) else {
            let is_other =
                |k: &Key| k.session_id == wanted.session_id && k.bike_id != wanted.bike_id;
            let moved = self.made_from(&wanted.path).iter().any(is_other);
            return Some(if moved { Stale::Bike } else { Stale::New });
        };
        let differs = [
            (there.input_hash != wanted.input_hash, Stale::Log),
            (there.path != wanted.path, Stale::Moved),
            (there.pipeline_hash != wanted.pipeline_hash, Stale::Settings),
            (there.version != wanted.version, Stale::Version),
        ];
        if let Some((_, why)) = differs.into_iter().find(|(differs, _)| *differs) {
            return Some(why);
        }
        let staged = self.staged.get(&key).map(|(_, staged)| staged);
        let has = |spec: &TableSpec| match staged {
            Some(staged) => staged.folders.iter().any(|folder| folder == spec.name),
            None => self.has(&self.table(spec, there)),
        };
        let is_whole = self.kind.required(is_requested).all(has);
        let is_whole = is_whole && (staged.is_some() || !self.is_damaged(there));
        (!is_whole).then_some(Stale::Incomplete)
    }

    /// Passes by what was damaged and is no more.
    pub fn forget_mended(&mut self) {
        if !self.root.is_remote() {
            self.damaged = self.still_damaged();
        }
    }

    /// Of the damaged files those that still are.
    pub fn still_damaged(&self) -> BTreeSet<String> {
        if self.damaged.is_empty() || self.root.is_remote() {
            return BTreeSet::new();
        }
        Manifest::read(&self.root).damaged(&self.root, |path| self.damaged.contains(path))
    }

    /// Whether a file that has rows of a session, or may have, is missing or not as it was written.
    fn is_damaged(&self, of: &Committed) -> bool {
        if self.damaged.is_empty() {
            return false;
        }
        let own = file_name(&of.session_id);
        let tables = self.kind.tables().chain([self.kind.marker]).map(|spec| {
            let file = if parts::shares(spec) { &of.part } else { &own };
            format!("{}/bike={}/{file}.parquet", spec.name, of.bike_id)
        });
        let others = self.kind.other_files.iter();
        let others =
            others.map(|(folder, end)| format!("{folder}/bike={}/{own}.{end}", of.bike_id));
        tables.chain(others).any(|path| self.damaged.contains(&path))
    }

    /// The file that has a session's rows of a table.
    pub fn table(&self, spec: &TableSpec, of: &Committed) -> Location {
        match parts::shares(spec) {
            true => self.file(spec.name, "parquet", &of.bike_id, &of.part),
            false => self.file(spec.name, "parquet", &of.bike_id, &file_name(&of.session_id)),
        }
    }

    /// Where a file of a session is.
    pub fn file(&self, folder: &str, extension: &str, bike_id: &str, file: &str) -> Location {
        self.root.join(format!("{folder}/bike={bike_id}/{file}.{extension}"))
    }

    /// Where a session's tables wait to be taken in.
    pub fn staging(&self, key: &Key) -> Location {
        let file = file_name(&format!("{}/{}", key.bike_id, key.session_id));
        self.root.join(format!("{}/{file}.{}", self.kind.staged, staged::EXTENSION))
    }

    /// The sessions of a folder that wait to be taken in.
    fn local_staged(&self) -> Result<BTreeMap<Key, (Location, Staged)>, Error> {
        let folder = self.root.join(self.kind.staged);
        let Some(path) = folder.as_path() else { return Ok(BTreeMap::new()) };
        let entries = match there(path, std::fs::read_dir(path))? {
            Some(entries) => entries.map(|e| Ok(e?.path())).collect::<std::io::Result<Vec<_>>>(),
            None => return Ok(BTreeMap::new()),
        };
        let files: Vec<PathBuf> = entries
            .map_err(|e| unreadable(path, &e))?
            .into_iter()
            .filter(|p| p.extension().is_some_and(|e| e == staged::EXTENSION))
            .collect();
        let head = |path: &PathBuf| {
            let file = there(path, File::open(path))?;
            Ok(file.map(|file| (path.into(), staged::head(&file))))
        };
        let heads: Vec<Option<_>> =
            files.par_iter().map(head).collect::<Result<Vec<_>, Error>>()?;
        Ok(by_session(heads.into_iter().flatten().collect()))
    }

    /// As [`Contents::local_staged`], of an object store.
    fn fetch_staged(
        &self,
        names: &BTreeMap<Location, Stat>,
    ) -> Result<BTreeMap<Key, (Location, Staged)>, Error> {
        let folder = self.root.join(self.kind.staged);
        let files = names.keys().filter(|n| n.starts_with(&folder));
        let files: Vec<&Location> = files.filter(|n| n.has_extension(staged::EXTENSION)).collect();
        let mut heads = Vec::with_capacity(files.len());
        fetch(&files, |at, bytes| heads.push((at.clone(), staged::head(&bytes))))?;
        Ok(by_session(heads))
    }

    /// Of an object store: every file below it that this command or the report wrote, but the
    /// report's other pages.
    fn list(&self, root: &Url) -> std::io::Result<BTreeMap<Location, Stat>> {
        let mut names = BTreeMap::new();
        let own = self.kind.files().map(|(folder, _)| folder);
        // what waits first: what is taken in meanwhile is then seen among the tables
        for folder in
            [".roadbench"].into_iter().chain(own).chain([self.kind.marker.name, "rejected"])
        {
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

    /// The commit markers of a folder. One that makes no sense does not count: it is made anew. One that cannot be opened is an
    /// error: with its sessions taken for new ones, the others' rows of its month would be lost.
    fn local_markers(&self, before: &Contents) -> Result<BTreeMap<Location, Marker>, Error> {
        let folder = self.root.join(self.kind.marker.name);
        let Some(folder) = folder.as_path() else { return Ok(BTreeMap::new()) };
        let mut paths = Vec::new();
        for entry in WalkDir::new(folder).min_depth(2).max_depth(2).sort_by_file_name() {
            let at = |e: &walkdir::Error| e.path().unwrap_or(folder).to_owned();
            match entry.map_err(|e| (at(&e), std::io::Error::from(e))) {
                Ok(entry) => paths.push(entry.into_path()),
                Err((_, e)) if is_nothing(&e) => {}
                Err((path, e)) => return Err(unreadable(&path, &e)),
            }
        }
        paths.retain(|path| path.extension().is_some_and(|e| e == "parquet"));
        // archives have thousands
        let read = |path: &PathBuf| {
            let at = Location::from(path);
            let Some(stamp) = there(path, at.stat())? else { return Ok(None) };
            let known = before.markers.get(&at).filter(|known| known.stamp == stamp);
            let rows = match known {
                Some(known) => Some(known.rows.clone()),
                None => match there(path, std::fs::read(path))? {
                    Some(bytes) => marker::rows(&at, Bytes::from(bytes)),
                    None => return Ok(None),
                },
            };
            Ok(Some((at, stamp, rows)))
        };
        let found: Vec<Option<_>> =
            paths.par_iter().map(read).collect::<Result<Vec<_>, Error>>()?;
        let found = found.into_iter().flatten();
        Ok(found.filter_map(|(at, stamp, rows)| kept(at, stamp, rows)).collect())
    }

    /// As [`Contents::local_markers`], of an object store. One that cannot be fetched is an error: it
    /// is whole.
    fn fetch_markers(
        &self,
        names: &BTreeMap<Location, Stat>,
        before: &Contents,
    ) -> Result<BTreeMap<Location, Marker>, Error> {
        let folder = self.root.join(self.kind.marker.name);
        let mut out = BTreeMap::new();
        let mut new = Vec::new();
        let markers = names.iter().filter(|(at, _)| at.starts_with(&folder));
        for (at, stat) in markers.filter(|(at, _)| at.has_extension("parquet")) {
            match before.markers.get(at) {
                Some(known) if known.stamp.etag.is_some() && known.stamp == *stat => {
                    out.insert(at.clone(), known.clone());
                }
                _ => new.push(at),
            }
        }
        fetch(&new, |at, bytes| {
            out.extend(kept(at.clone(), names[at].clone(), marker::rows(at, bytes)));
        })?;
        Ok(out)
    }
}

/// The opened file; `None` if there is none.
fn there<T>(path: &Path, opened: std::io::Result<T>) -> Result<Option<T>, Error> {
    match opened {
        Ok(open) => Ok(Some(open)),
        Err(e) if is_nothing(&e) => Ok(None), // taken in or replaced meanwhile
        Err(e) => Err(unreadable(path, &e)),
    }
}

fn is_nothing(e: &std::io::Error) -> bool {
    matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory)
}

fn unreadable(path: &Path, e: &std::io::Error) -> Error {
    Error::Output(format!("cannot read {} of the output: {e}", path.display()))
}

/// Fetches objects, some at a time.
fn fetch(what: &[&Location], mut take: impl FnMut(&Location, Bytes)) -> Result<(), Error> {
    for some in what.chunks(256) {
        let urls: Vec<Url> = some.iter().filter_map(|at| at.as_url().cloned()).collect();
        for (at, bytes) in some.iter().zip(client::get_many(&urls)) {
            take(at, bytes.map_err(|e| Error::Output(e.to_string()))?);
        }
    }
    Ok(())
}

fn kept(at: Location, stamp: Stat, rows: Option<Vec<Committed>>) -> Option<(Location, Marker)> {
    match rows {
        Some(rows) => Some((at, Marker { stamp, rows })),
        None => {
            tracing::warn!("{at}: not a table of commit markers; ignored");
            None
        }
    }
}

fn by_session(heads: Vec<(Location, Option<Staged>)>) -> BTreeMap<Key, (Location, Staged)> {
    let mut out = BTreeMap::new();
    for (at, head) in heads {
        match head {
            Some(head) => _ = out.insert(head.key(), (at, head)),
            None => tracing::warn!("{at}: not the tables of a session; ignored"),
        }
    }
    out
}
