//! The output's tables where they can be worked on: in its folder, or, of an object store, in
//! copies that are fetched for it and whose results are put back.
//!
//! What is made over all sessions (fleet, report) reads whole folders of tables. Of an object store
//! they are fetched into a temporary folder (`TMPDIR` says where), which takes as much disk as the
//! tables do, but no more memory than a few of them. Where a table is damaged it is left out, and of a folder the others
//! are linked into a temporary one: [`LocalCopy::left_out`] says which are missing.

use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use bytes::Bytes;

use super::intact;
use super::kind::{self, DIAGNOSE, RUN};
use super::manifest::{self, Manifest};
use super::mark;
use crate::batch::error::Error;
use crate::report;
use crate::store::objects::url::Url;
use crate::store::objects::{Location, client};
use crate::store::tables::{file, registry};

/// Objects fetched together; as many are in memory.
const SOME: usize = 64;

/// How the name of a folder with copies starts.
const COPY: &str = "roadbench-copy-";
/// The file in it that its owner holds locked.
const OWNED: &str = ".owned";

/// A temporary folder; what owners left that were killed goes when another one is made.
#[derive(Debug)]
struct Temporary {
    folder: TempDir,
    /// Locked as long as the process lives.
    _owned: File,
}

impl Temporary {
    fn new(below: &Path) -> std::io::Result<Self> {
        sweep(below);
        let folder = tempfile::Builder::new().prefix(COPY).tempdir_in(below)?;
        // it is locked before it has the name by which others look for it
        let making = folder.path().join(format!("{OWNED}.new"));
        let owned = File::create(&making)?;
        let _ = owned.lock(); // where there are no locks nobody gets one
        std::fs::rename(making, folder.path().join(OWNED))?;
        Ok(Temporary { folder, _owned: owned })
    }
}

/// Removes folders whose owner is no more.
fn sweep(temporary: &Path) {
    let entries = std::fs::read_dir(temporary).into_iter().flatten().filter_map(Result::ok);
    for entry in entries.filter(|e| e.file_name().to_string_lossy().starts_with(COPY)) {
        // one that has no such file yet is being made
        let owned = File::open(entry.path().join(OWNED));
        if owned.is_ok_and(|file| file.try_lock().is_ok()) {
            let _ = std::fs::remove_dir_all(entry.path()); // another process may be at it too
        }
    }
}

/// It is this machine's folder that cannot take the copies.
fn no_room(at: &Path, e: &std::io::Error) -> Error {
    Error::Output(format!(
        "cannot write {} in the temporary folder, which takes a copy of the output's tables: {e}; set TMPDIR to a folder with \
         room for them, then run again",
        at.display()
    ))
}

/// A folder with the output's tables.
#[derive(Debug)]
pub struct LocalCopy {
    folder: PathBuf,
    origin: Option<(Location, Temporary)>,
    left_out: BTreeSet<String>,
}

/// Whether a path below the output is of the tables over all sessions, which a batch makes again at its end.
fn is_derived(path: &str) -> bool {
    let mut derived = [&RUN, &DIAGNOSE].into_iter().flat_map(|kind| kind.derived());
    derived.any(|folder| manifest::is_below(path, folder))
}

impl LocalCopy {
    /// Of an output whose tables over all sessions are made again.
    ///
    /// # Errors
    /// A table cannot be fetched, or the temporary folder not be written.
    pub fn of(out: &Location) -> Result<LocalCopy, Error> {
        let fail = |e: std::io::Error| Error::Output(e.to_string());
        let url = match out {
            Location::Local(path) => return Self::of_folder(path, |path| !is_derived(path)),
            Location::Remote(url) => url,
        };
        let list = Manifest::read(out);
        let temporary = std::env::temp_dir();
        let copy = Temporary::new(&temporary).map_err(|e| no_room(&temporary, &e))?;
        let folder = copy.folder.path().to_owned();
        // an output, if it has nothing in it any more
        let sessions = folder.join(registry::SESSIONS.name);
        std::fs::create_dir_all(&sessions).map_err(|e| no_room(&sessions, &e))?;
        let mut damaged = BTreeSet::new();
        for name in registry::read_by_reports() {
            let prefix = url.join(name);
            let entries = client::list(&prefix).map_err(fail)?;
            for some in entries.chunks(SOME) {
                let urls: Vec<Url> = some.iter().map(|e| prefix.join(&e.key)).collect();
                for (entry, bytes) in some.iter().zip(client::get_many(&urls)) {
                    let bytes = bytes.map_err(fail)?; // it says of which object
                    let path = folder.join(name).join(&entry.key);
                    let at = format!("{name}/{}", entry.key);
                    let is_as_listed = |bytes: &Bytes| {
                        list.of(&at).is_none_or(|sum| manifest::checksum(bytes) == sum)
                    };
                    if !is_as_listed(&bytes) {
                        left_out(out, &at);
                        damaged.insert(at);
                        continue;
                    }
                    let parent = path.parent().unwrap_or(&folder);
                    std::fs::create_dir_all(parent)
                        .and_then(|()| std::fs::write(&path, bytes))
                        .map_err(|e| no_room(&path, &e))?;
                }
            }
        }
        Ok(LocalCopy { folder, origin: Some((out.clone(), copy)), left_out: damaged })
    }

    /// Of a folder of which no table is made again: what is damaged of those over all sessions is left out, too. The next
    /// batch then makes the report again, with what was repaired.
    ///
    /// # Errors
    /// As [`LocalCopy::of`].
    pub(crate) fn of_whole_folder(out: &Path) -> Result<LocalCopy, Error> {
        let copy = Self::of_folder(out, |_| true)?;
        if !copy.is_whole() {
            mark::mark_out_of_date(&out.into())?;
        }
        Ok(copy)
    }

    /// Of a folder: itself, or where tables of it are damaged links to all others; `wanted` says which are looked at.
    fn of_folder(out: &Path, wanted: fn(&str) -> bool) -> Result<LocalCopy, Error> {
        let root = Location::from(out);
        let folders: Vec<&str> = registry::read_by_reports().collect();
        let is_read =
            |path: &str| wanted(path) && folders.iter().any(|f| manifest::is_below(path, f));
        let damaged = Manifest::read(&root).damaged(&root, is_read);
        damaged.iter().for_each(|path| left_out(&root, path));
        if !damaged.iter().any(|path| out.join(path).exists()) {
            return Ok(LocalCopy { folder: out.to_owned(), origin: None, left_out: damaged });
        }
        let fail = |e: std::io::Error| Error::Output(format!("{root}/.roadbench: {e}"));
        let copy = Temporary::new(&out.join(".roadbench")).map_err(fail)?;
        let folder = copy.folder.path().to_owned();
        std::fs::create_dir_all(folder.join(registry::SESSIONS.name)).map_err(fail)?;
        let of_root = std::fs::read_dir(out).map_err(fail)?.filter_map(Result::ok);
        let of_root = of_root.filter(|e| e.path().is_file()).map(|e| e.file_name());
        let mut paths: Vec<String> = of_root.map(|n| n.to_string_lossy().into_owned()).collect();
        for name in folders.iter().chain(&["report", mark::FOLDER]) {
            // what roadbench keeps for itself is two levels deep; only its lists are needed
            let entries = root.join(name).list().map_err(fail)?.into_iter();
            let entries = entries.filter(|e| *name != mark::FOLDER || !e.key.contains('/'));
            paths.extend(entries.map(|e| format!("{name}/{}", e.key)));
        }
        for path in paths.iter().filter(|path| !damaged.contains(*path) && !path.ends_with(".lock"))
        {
            let (from, to) = (out.join(path), folder.join(path));
            std::fs::create_dir_all(to.parent().unwrap_or(&folder)).map_err(fail)?;
            if std::fs::hard_link(&from, &to).is_err() {
                std::fs::copy(&from, &to).map_err(fail)?;
            }
        }
        Ok(LocalCopy { folder, origin: Some((root, copy)), left_out: damaged })
    }

    /// Whether the tables are not worked on in their own place.
    pub fn is_copy(&self) -> bool {
        self.origin.is_some()
    }

    /// Whether no table is left out.
    pub(crate) fn is_whole(&self) -> bool {
        self.left_out.is_empty()
    }

    /// Error text for tables that are missing or damaged; `None` if all are intact.
    pub(crate) fn left_out(&self, out: &Location) -> Option<String> {
        intact::says(out, &self.left_out)
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Puts back the folders of what was made from the tables; files of an earlier batch that were not
    /// made again go, of the report only those that are its own.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn publish(&self, made: impl IntoIterator<Item = &'static str>) -> Result<(), Error> {
        let Some((out, _)) = &self.origin else { return Ok(()) };
        let fail = |e: std::io::Error| Error::Output(e.to_string());
        for name in made {
            let there = out.join(name);
            let folder = Location::Local(self.folder.join(name));
            let mut keys = BTreeSet::new();
            for entry in folder.list().map_err(fail)? {
                let bytes = folder.join(&entry.key).read().map_err(fail)?;
                let at = there.join(&entry.key);
                if out.is_remote() || !at.read().is_ok_and(|old| old == bytes) {
                    file::write_bytes(at, &bytes)?;
                }
                keys.insert(entry.key);
            }
            for entry in there.list().map_err(fail)? {
                let old = there.join(&entry.key);
                if !keys.contains(&entry.key) && is_own(name, &entry.key, &old) {
                    old.remove().map_err(|e| Error::Output(format!("cannot remove {old}: {e}")))?;
                }
            }
        }
        Ok(())
    }
}

/// Says that a table is passed by.
fn left_out(out: &Location, path: &str) {
    tracing::error!(
        "{path} is missing or damaged: the report and the tables over all sessions are made \
         without it; see `roadbench verify {out}`"
    );
}

/// Whether a file of an earlier batch that was not made again is ours: of the report its pages, else what sessions share.
/// Every other folder has one table, which is always made.
fn is_own(name: &str, key: &str, at: &Location) -> bool {
    match name {
        "report" => {
            (key.ends_with(".html") || key.starts_with("assets/"))
                && at.read().is_ok_and(|bytes| report::is_own(&bytes))
        }
        kind::SHARED => key == kind::SHARED_TABLE,
        _ => false,
    }
}
