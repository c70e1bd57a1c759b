//! The output's tables where they can be worked on: in its folder, or, of an object store, in
//! copies that are fetched for it and whose results are put back.
//!
//! What is made over all sessions (fleet, report) reads whole folders of tables. Of an object store
//! they are fetched into a temporary folder (`TMPDIR` says where), which takes as much disk as the
//! tables do, but no more memory than a few of them.

use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::error::Error;
use crate::objects::url::Url;
use crate::objects::{Location, client};
use crate::report;
use crate::tables::{file, registry};

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
    fn new() -> std::io::Result<Self> {
        sweep(&std::env::temp_dir());
        let folder = tempfile::Builder::new().prefix(COPY).tempdir()?;
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
    origin: Option<(Url, Temporary)>,
}

impl LocalCopy {
    /// Of an output.
    ///
    /// # Errors
    /// A table cannot be fetched, or the temporary folder not be written.
    pub fn of(out: &Location) -> Result<LocalCopy, Error> {
        let fail = |e: std::io::Error| Error::Output(e.to_string());
        let url = match out {
            Location::Local(path) => {
                return Ok(LocalCopy { folder: path.clone(), origin: None });
            }
            Location::Remote(url) => url,
        };
        let copy = Temporary::new().map_err(|e| no_room(&std::env::temp_dir(), &e))?;
        let folder = copy.folder.path().to_owned();
        // an output, if it has nothing in it any more
        let sessions = folder.join(registry::SESSIONS.name);
        std::fs::create_dir_all(&sessions).map_err(|e| no_room(&sessions, &e))?;
        for name in registry::read_by_reports() {
            let prefix = url.join(name);
            let entries = client::list(&prefix).map_err(fail)?;
            for some in entries.chunks(SOME) {
                let urls: Vec<Url> = some.iter().map(|e| prefix.join(&e.key)).collect();
                for (entry, bytes) in some.iter().zip(client::get_many(&urls)) {
                    let bytes = bytes.map_err(fail)?; // it says of which object
                    let path = folder.join(name).join(&entry.key);
                    let parent = path.parent().unwrap_or(&folder);
                    std::fs::create_dir_all(parent)
                        .and_then(|()| std::fs::write(&path, bytes))
                        .map_err(|e| no_room(&path, &e))?;
                }
            }
        }
        Ok(LocalCopy { folder, origin: Some((url.clone(), copy)) })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Puts back the folders of what was made from the tables; files of an earlier batch that were not
    /// made again go, of the report only those that are its own.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn publish(&self, made: impl IntoIterator<Item = &'static str>) -> Result<(), Error> {
        let Some((url, _)) = &self.origin else { return Ok(()) };
        let fail = |e: std::io::Error| Error::Output(e.to_string());
        for name in made {
            let prefix = url.join(name);
            let folder = Location::Local(self.folder.join(name));
            let mut there = BTreeSet::new();
            for entry in folder.list().map_err(fail)? {
                let bytes = folder.join(&entry.key).read().map_err(fail)?;
                file::write_bytes(Location::Remote(prefix.join(&entry.key)), &bytes)?;
                there.insert(entry.key);
            }
            for entry in client::list(&prefix).map_err(fail)? {
                let old = prefix.join(&entry.key);
                if !there.contains(&entry.key)
                    && (name != "report" || is_own_page(&old, &entry.key))
                {
                    client::delete(&old).map_err(fail)?;
                }
            }
        }
        Ok(())
    }
}

fn is_own_page(page: &Url, key: &str) -> bool {
    (key.ends_with(".html") || key.starts_with("assets/"))
        && client::get(page).is_ok_and(|bytes| report::is_own(&bytes))
}
