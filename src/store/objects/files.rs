//! Files and folders, local or in an object store: reading, writing, listing, removing.

use std::fs::File;
use std::io::{Error, ErrorKind, Read as _, Result};
use std::path::Path;
use std::time::SystemTime;

use bytes::Bytes;
use walkdir::WalkDir;

use super::client;
use super::location::Location;
use super::replace::replace;
use super::stat::{Entry, Stat};
use super::url::Url;

impl Location {
    /// The whole of a file.
    ///
    /// # Errors
    /// It is not there (`NotFound`) or cannot be read.
    pub fn read(&self) -> Result<Vec<u8>> {
        match self {
            Self::Remote(url) => client::get(url).map(Vec::from),
            Self::Local(path) => std::fs::read(path),
        }
    }

    /// Writes a file, whole or not at all, making its folder: a temporary beside it, then renamed;
    /// in an object store one object. What a user names is written by
    /// [`tables::output`](crate::store::tables::output).
    ///
    /// # Errors
    /// The folder cannot be made or the file not be written.
    pub fn write(&self, bytes: &[u8]) -> Result<()> {
        match self {
            Self::Remote(url) => client::put(url, bytes),
            Self::Local(path) => replace(path, bytes),
        }
    }

    /// Removes a file; that it is not there is no error.
    ///
    /// # Errors
    /// It is there and cannot be removed.
    pub fn remove(&self) -> Result<()> {
        match self {
            Self::Remote(url) => client::delete(url),
            Self::Local(path) => match std::fs::remove_file(path) {
                Err(e) if e.kind() != ErrorKind::NotFound => Err(e),
                _ => Ok(()),
            },
        }
    }

    /// Size, version and age of a file, asked for anew ([`super::source::stat`] remembers those
    /// of logs).
    ///
    /// # Errors
    /// It is not there (`NotFound`), or the store does not answer.
    pub fn stat(&self) -> Result<Stat> {
        match self {
            Self::Remote(url) => client::stat(url),
            Self::Local(path) => stat_local(path),
        }
    }

    /// Whether there is such a file, or such a local folder.
    ///
    /// # Errors
    /// Unknown: the store does not answer, or a folder on the way to it may not be looked into.
    pub fn exists(&self) -> Result<bool> {
        match self {
            Self::Local(path) => is_there(std::fs::metadata(path)),
            Self::Remote(url) => is_there(client::stat(url)),
        }
    }

    /// Whether it is a folder, or a prefix with at least one object below it.
    ///
    /// # Errors
    /// The store does not answer.
    pub fn is_folder(&self) -> Result<bool> {
        match self {
            Self::Local(path) => Ok(path.is_dir()),
            Self::Remote(url) => Ok(!client::list(url)?.is_empty()),
        }
    }

    /// Every file below a folder or a prefix, at any depth, in order of key; none where there is no
    /// such folder. Links are not followed, and what cannot be read is left out.
    ///
    /// # Errors
    /// The store does not answer.
    pub fn list(&self) -> Result<Vec<Entry>> {
        match self {
            Self::Remote(url) => client::list(url),
            Self::Local(folder) => Ok(list_local(folder)),
        }
    }
}

/// Whether something was found; what cannot be looked at is not gone.
fn is_there<T>(found: Result<T>) -> Result<bool> {
    match found {
        Ok(_) => Ok(true),
        Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(false),
        Err(e) => Err(e),
    }
}

/// The whole of many files, in their order; from an object store a few at a time.
///
/// # Errors
/// Each may be one, as of [`Location::read`].
pub(crate) fn read_many(files: &[&Location]) -> Vec<Result<Bytes>> {
    let urls: Vec<Url> = files.iter().filter_map(|at| at.as_url().cloned()).collect();
    let mut remote = client::get_many(&urls).into_iter();
    let read = |at: &&Location| match at {
        Location::Local(path) => std::fs::read(path).map(Bytes::from),
        Location::Remote(url) => remote.next().unwrap_or_else(|| client::get(url)),
    };
    files.iter().map(read).collect()
}

/// Removes many files, of an object store a few at a time.
///
/// # Errors
/// One is there and cannot be removed.
pub(crate) fn remove_many(files: &[&Location]) -> Result<()> {
    let urls: Vec<Url> = files.iter().filter_map(|at| at.as_url().cloned()).collect();
    client::delete_many(&urls)?;
    files.iter().filter(|at| !at.is_remote()).try_for_each(|at| at.remove())
}

pub(super) fn stat_local(path: &Path) -> Result<Stat> {
    let meta = std::fs::metadata(path)?;
    let modified = meta.modified().unwrap_or(SystemTime::UNIX_EPOCH);
    Ok(Stat { size: meta.len(), etag: None, modified })
}

fn list_local(folder: &Path) -> Vec<Entry> {
    let mut entries = Vec::new();
    for entry in WalkDir::new(folder).into_iter().filter_map(std::result::Result::ok) {
        let (Ok(below), Ok(meta)) = (entry.path().strip_prefix(folder), entry.metadata()) else {
            continue;
        };
        if meta.is_file() {
            let key = below.iter().map(|p| p.to_string_lossy()).collect::<Vec<_>>().join("/");
            let modified = meta.modified().unwrap_or(SystemTime::UNIX_EPOCH);
            entries.push(Entry { key, stat: Stat { size: meta.len(), etag: None, modified } });
        }
    }
    entries.sort_by(|a, b| a.key.cmp(&b.key));
    entries
}

/// Opens a file. Opening a pipe may wait for its other end for ever.
///
/// # Errors
/// It is not there, cannot be read, or is no file.
pub(crate) fn open_file(path: &Path) -> Result<File> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(Error::new(
            ErrorKind::InvalidInput,
            "it is no file, but a folder, pipe or device",
        ));
    }
    File::open(path)
}

/// Reads a file of text.
///
/// # Errors
/// As [`open_file`], or it is not UTF-8.
pub fn read_text(path: impl AsRef<Path>) -> Result<String> {
    let mut text = String::new();
    open_file(path.as_ref())?.read_to_string(&mut text)?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_gives_back_what_it_was_given() {
        let folder = tempfile::tempdir().expect("folder");
        let place = Location::from(folder.path().join("t"));
        assert!(place.list().expect("list").is_empty());
        place.join("bike=b/x.parquet").write(b"one").expect("put");
        place.join("a").write(b"two").expect("put");
        let keys: Vec<String> = place.list().expect("list").into_iter().map(|e| e.key).collect();
        assert_eq!(keys, ["a", "bike=b/x.parquet"]);
        let a = place.join("a");
        assert_eq!((a.read().expect("read"), a.stat().expect("there").size), (b"two".to_vec(), 3));
        a.remove().expect("remove");
        a.remove().expect("twice is once");
        assert_eq!(a.read().expect_err("gone").kind(), ErrorKind::NotFound);
    }
}
