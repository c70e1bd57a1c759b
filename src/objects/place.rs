//! Where tables are written: a folder, or a prefix of an object store.
//!
//! Names below it have slashes on every system. Whatever is written is only ever seen whole: in a
//! folder through a temporary that is renamed, in an object store as one request.

use std::io::{ErrorKind, Result};
use std::path::{Path, PathBuf};

use walkdir::WalkDir;

use super::url::{self, Url};
use super::{Entry, Stat, client};
use crate::table;

/// A folder or a prefix.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// Here.
    Folder(PathBuf),
    /// There.
    Prefix(Url),
}

impl Place {
    /// Of a path or a URL.
    ///
    /// # Errors
    /// It is a URL of a kind that cannot be used.
    pub fn of(path: &Path) -> Result<Self> {
        Ok(match url::parse(path)? {
            Some(url) => Place::Prefix(url),
            None => Place::Folder(path.to_owned()),
        })
    }

    /// The name as messages and other paths have it.
    pub fn path(&self, name: &str) -> PathBuf {
        match self {
            Place::Folder(folder) => folder.join(name),
            Place::Prefix(url) => url.join(name).path(),
        }
    }

    /// Writes it, whole or not at all.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn put(&self, name: &str, bytes: &[u8]) -> std::result::Result<(), table::Error> {
        match self {
            Place::Folder(folder) => table::write_bytes(&folder.join(name), bytes),
            Place::Prefix(url) => client::put(&url.join(name), bytes)
                .map_err(|source| table::Error::Io { path: self.path(name), source }),
        }
    }

    /// Removes it; that it is not there is no error.
    ///
    /// # Errors
    /// It is there and cannot be removed.
    pub fn remove(&self, name: &str) -> std::result::Result<(), table::Error> {
        let removed = match self {
            Place::Folder(folder) => std::fs::remove_file(folder.join(name)),
            Place::Prefix(url) => client::delete(&url.join(name)),
        };
        match removed {
            Err(source) if source.kind() != ErrorKind::NotFound => {
                Err(table::Error::Io { path: self.path(name), source })
            }
            _ => Ok(()),
        }
    }

    /// The whole of it.
    ///
    /// # Errors
    /// It is not there (`NotFound`) or cannot be read.
    pub fn get(&self, name: &str) -> Result<Vec<u8>> {
        match self {
            Place::Folder(folder) => std::fs::read(folder.join(name)),
            Place::Prefix(url) => client::get(&url.join(name)).map(Vec::from),
        }
    }

    /// Everything below a name, in order of name; none where there is no such thing. The keys are
    /// below that name.
    ///
    /// # Errors
    /// The store does not tell.
    pub fn list(&self, name: &str) -> Result<Vec<Entry>> {
        let folder = match self {
            Place::Prefix(url) => return client::list(&url.join(name)),
            Place::Folder(folder) => folder.join(name),
        };
        let mut entries = Vec::new();
        for entry in WalkDir::new(&folder).into_iter().filter_map(std::result::Result::ok) {
            let (Ok(below), Ok(meta)) = (entry.path().strip_prefix(&folder), entry.metadata())
            else {
                continue;
            };
            if meta.is_file() {
                let parts = below.iter().map(|part| part.to_string_lossy());
                let key = parts.collect::<Vec<_>>().join("/");
                let modified = meta.modified().unwrap_or(std::time::SystemTime::UNIX_EPOCH);
                entries.push(Entry { key, stat: Stat { size: meta.len(), etag: None, modified } });
            }
        }
        entries.sort_by(|a, b| a.key.cmp(&b.key));
        Ok(entries)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_gives_back_what_it_was_given() {
        let folder = tempfile::tempdir().expect("folder");
        let place = Place::of(folder.path()).expect("place");
        assert!(place.list("t").expect("list").is_empty());
        place.put("t/bike=b/x.parquet", b"one").expect("put");
        place.put("t/a", b"two").expect("put");
        let keys: Vec<String> = place.list("t").expect("list").into_iter().map(|e| e.key).collect();
        assert_eq!(keys, ["a", "bike=b/x.parquet"]);
        assert_eq!(place.get("t/a").expect("get"), b"two");
        place.remove("t/a").expect("remove");
        place.remove("t/a").expect("twice is once");
        assert_eq!(place.get("t/a").expect_err("gone").kind(), ErrorKind::NotFound);
    }
}
