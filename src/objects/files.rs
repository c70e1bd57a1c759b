//! Files by their paths, local or in an object store: reading, listing, removing. Writing is
//! [`crate::tables::file::write_bytes`].

use std::io::{ErrorKind, Result};
use std::path::Path;
use std::time::SystemTime;

use walkdir::WalkDir;

use super::{Entry, Stat, client, url};

/// The whole of a file.
///
/// # Errors
/// It is not there (`NotFound`) or cannot be read.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    match url::parse(path)? {
        Some(url) => client::get(&url).map(Vec::from),
        None => std::fs::read(path),
    }
}

/// Removes a file; that it is not there is no error.
///
/// # Errors
/// It is there and cannot be removed.
pub fn remove(path: &Path) -> Result<()> {
    match url::parse(path)? {
        Some(url) => client::delete(&url),
        None => match std::fs::remove_file(path) {
            Err(e) if e.kind() != ErrorKind::NotFound => Err(e),
            _ => Ok(()),
        },
    }
}

/// Every file below a folder or a prefix, in order of name; none where there is no such thing.
/// The keys are below it and have slashes on every system.
///
/// # Errors
/// The store does not tell.
pub fn list(folder: &Path) -> Result<Vec<Entry>> {
    if let Some(url) = url::parse(folder)? {
        return client::list(&url);
    }
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
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::file::write_bytes;

    #[test]
    fn a_folder_gives_back_what_it_was_given() {
        let folder = tempfile::tempdir().expect("folder");
        let place = folder.path().join("t");
        assert!(list(&place).expect("list").is_empty());
        write_bytes(&place.join("bike=b/x.parquet"), b"one").expect("put");
        write_bytes(&place.join("a"), b"two").expect("put");
        let keys: Vec<String> = list(&place).expect("list").into_iter().map(|e| e.key).collect();
        assert_eq!(keys, ["a", "bike=b/x.parquet"]);
        assert_eq!(read(&place.join("a")).expect("read"), b"two");
        remove(&place.join("a")).expect("remove");
        remove(&place.join("a")).expect("twice is once");
        assert_eq!(read(&place.join("a")).expect_err("gone").kind(), ErrorKind::NotFound);
    }
}
