//! The checksums of an output's files: `<out>/.roadbench/checksums.json`, BLAKE3 by path below the output.
//!
//! A file that is about to change is taken off the list first and comes back with its new checksum: a crash in
//! between leaves unlisted files, never a wrong checksum.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use rayon::prelude::*;

use crate::batch::error::Error;
use crate::batch::log_hash::hash_file;
use crate::store::objects::Location;
use crate::store::tables::file;

/// Where it is, below the output.
pub(crate) const PATH: &str = ".roadbench/checksums.json";

/// Checksums by path below the output, as hexadecimal digits.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Manifest {
    files: BTreeMap<String, String>,
    /// Whether the output has a list; one of an older roadbench has none.
    pub is_there: bool,
}

/// The checksum of a file's bytes.
pub(crate) fn checksum(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

impl Manifest {
    /// Of an output that has none.
    pub(crate) fn empty() -> Self {
        Manifest { files: BTreeMap::new(), is_there: true }
    }

    /// Reads an output's list; one that cannot be read does not count.
    pub(crate) fn read(root: &Location) -> Self {
        let bytes = root.join(PATH).read().ok();
        match bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok()) {
            Some(files) => Manifest { files, is_there: true },
            None => Manifest::default(),
        }
    }

    /// Writes it.
    ///
    /// # Errors
    /// The output cannot be written.
    pub(crate) fn write(&self, root: &Location) -> Result<(), Error> {
        let text = serde_json::to_string_pretty(&self.files)
            .map_err(|e| Error::Internal(format!("checksums: {e}")))?;
        Ok(file::write_bytes(root.join(PATH), text.as_bytes())?)
    }

    /// Files and their checksums.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&str, &str)> {
        self.files.iter().map(|(path, sum)| (path.as_str(), sum.as_str()))
    }

    /// Checksum that a file should have.
    pub(crate) fn of(&self, path: &str) -> Option<&str> {
        self.files.get(path).map(String::as_str)
    }

    /// Files on the list that are missing or not as they were written, of those that are `wanted`. All are read.
    pub(crate) fn damaged(
        &self,
        root: &Location,
        wanted: impl Fn(&str) -> bool + Sync,
    ) -> BTreeSet<String> {
        let files = self.files.par_iter().filter(|(path, _)| wanted(path));
        // a store has names of its own for bytes
        let sum_of = |at: &Location| match at {
            Location::Local(_) => hash_file(at),
            Location::Remote(_) => at.read().map(|bytes| checksum(&bytes)),
        };
        let is_other = |(path, sum): &(&String, &String)| {
            sum_of(&root.join(path)).map_or(true, |now| now != **sum)
        };
        files.filter(is_other).map(|(path, _)| path.clone()).collect()
    }

    /// Takes files off the list.
    pub(crate) fn unlist<'a>(&mut self, paths: impl IntoIterator<Item = &'a str>) {
        for path in paths {
            self.files.remove(path);
        }
    }

    /// Puts a file on the list.
    pub(crate) fn put(&mut self, path: String, checksum: String) {
        self.files.insert(path, checksum);
    }

    /// Lists what is below some paths anew, from a local folder that has the same.
    ///
    /// # Errors
    /// A file cannot be read.
    pub(crate) fn rescan(&mut self, folder: &Path, below: &[&str]) -> Result<(), Error> {
        for name in below {
            self.files.retain(|path, _| !is_below(path, name));
            let at = Location::Local(folder.join(name));
            let read = |at: &Location| {
                at.read().map_err(|e| Error::Output(format!("cannot read {at}: {e}")))
            };
            if at.as_path().is_some_and(Path::is_file) {
                self.put((*name).to_owned(), checksum(&read(&at)?));
                continue;
            }
            for entry in at.list().map_err(|e| Error::Output(format!("{at}: {e}")))? {
                if !entry.key.starts_with('.') {
                    let sum = checksum(&read(&at.join(&entry.key))?);
                    self.put(format!("{name}/{}", entry.key), sum);
                }
            }
        }
        Ok(())
    }
}

/// Whether a path is a file or folder of the output, or below it.
pub(crate) fn is_below(path: &str, place: &str) -> bool {
    path.strip_prefix(place).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// A file's path below its output, as the list has it; `None` where it is elsewhere.
pub(crate) fn below(root: &Location, at: &Location) -> Option<String> {
    match (root, at) {
        (Location::Local(root), Location::Local(at)) => {
            let parts = at.strip_prefix(root).ok()?.iter().map(|p| p.to_string_lossy());
            Some(parts.collect::<Vec<_>>().join("/"))
        }
        (Location::Remote(root), Location::Remote(at)) => {
            let rest = at.key.strip_prefix(&root.key)?;
            Some(rest.trim_start_matches('/').to_owned())
        }
        _ => None,
    }
}
