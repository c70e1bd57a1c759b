//! The files of an input that a user gives: a file, a folder or prefix, or a glob pattern; by the same
//! rules here and in an object store.
//!
//! Where a folder's objects were listed, no further request is made for them: [`super::source`]
//! remembers what the listing said of each.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};

use walkdir::WalkDir;

use super::location::{Location, fixed_part};
use super::stat::Entry;
use super::url::Url;
use super::{client, pattern, source};

/// Something that is there.
#[derive(Debug)]
pub(crate) struct Match {
    pub location: Location,
    pub kind: MatchKind,
}

/// Kind of a [`Match`].
#[derive(Debug)]
pub(crate) enum MatchKind {
    /// A file or an object.
    File,
    /// A folder, or a prefix with at least one object below it.
    Folder(Folder),
    /// Neither: a device, a socket, a link that leads nowhere.
    Other,
    /// It cannot be looked at; the message says why.
    Unreadable(String),
}

/// A folder or a prefix whose files can be asked for.
#[derive(Debug)]
pub(crate) struct Folder {
    location: Location,
    /// Of a prefix: what was listed below it.
    entries: Vec<Entry>,
}

/// A file below a folder, or why a part of the folder could not be searched.
pub(crate) type Searched = std::result::Result<Location, (Location, String)>;

/// Matches of a name: nothing, the file or folder of that name, or all that a glob pattern
/// matches. Of a key that `is_file_name` takes for a file's the object is asked for first, of any
/// other the listing: mostly one request is enough.
///
/// # Errors
/// The store does not answer; `InvalidInput`: it is no glob pattern.
pub(crate) fn find(name: &Location, is_file_name: impl Fn(&str) -> bool) -> Result<Vec<Match>> {
    match name {
        Location::Remote(url) if name.is_pattern() => remote_pattern(url),
        Location::Remote(url) => remote(url, is_file_name(&url.key)),
        Location::Local(path) if name.exists().unwrap_or(true) => Ok(vec![local(path.clone())]),
        Location::Local(path) if name.is_pattern() => local_pattern(&path.to_string_lossy()),
        Location::Local(_) => Ok(Vec::new()),
    }
}

fn local(path: PathBuf) -> Match {
    let found = std::fs::metadata(&path);
    let location = Location::Local(path);
    let kind = match found {
        Ok(meta) if meta.is_file() => MatchKind::File,
        Ok(meta) if meta.is_dir() => {
            MatchKind::Folder(Folder { location: location.clone(), entries: Vec::new() })
        }
        // a link that leads nowhere
        Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            MatchKind::Other
        }
        Err(e) => MatchKind::Unreadable(format!("cannot look at {location}: {e}")),
        Ok(_) => MatchKind::Other,
    };
    Match { location, kind }
}

fn local_pattern(pattern: &str) -> Result<Vec<Match>> {
    let found = pattern::expand(pattern).map_err(|e| no_pattern(pattern, e))?;
    let found = found.into_iter().map(|path| match path {
        Ok(path) => local(path),
        Err((path, message)) => {
            Match { location: Location::Local(path), kind: MatchKind::Unreadable(message) }
        }
    });
    Ok(found.collect())
}

fn no_pattern(pattern: impl std::fmt::Display, e: glob::PatternError) -> Error {
    Error::new(ErrorKind::InvalidInput, format!("{pattern} is not a glob pattern: {e}"))
}

fn remote(url: &Url, looks_like_file: bool) -> Result<Vec<Match>> {
    let object = || -> Result<Vec<Match>> {
        match client::stat(url) {
            Ok(stat) => {
                source::remember(url.clone(), stat);
                Ok(vec![Match { location: url.clone().into(), kind: MatchKind::File }])
            }
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(Vec::new()),
            Err(e) => Err(e),
        }
    };
    if looks_like_file {
        let found = object()?;
        if !found.is_empty() {
            return Ok(found);
        }
    }
    let entries = client::list(url)?;
    if !entries.is_empty() {
        return Ok(vec![prefix(url.clone(), entries)]);
    }
    if url.key.is_empty() || looks_like_file { Ok(Vec::new()) } else { object() }
}

fn prefix(url: Url, entries: Vec<Entry>) -> Match {
    let location = Location::Remote(url);
    let folder = Folder { location: location.clone(), entries };
    Match { location, kind: MatchKind::Folder(folder) }
}

/// Objects, and prefixes: of a key the outermost part that the pattern matches is what was meant.
fn remote_pattern(pattern: &Url) -> Result<Vec<Match>> {
    let options = glob::MatchOptions {
        require_literal_leading_dot: true,
        require_literal_separator: true,
        ..glob::MatchOptions::new()
    };
    let compiled = glob::Pattern::new(&pattern.key).map_err(|e| no_pattern(pattern, e))?;
    let base = Url { key: fixed_part(&pattern.key).to_owned(), ..pattern.clone() };
    let mut found = Vec::new();
    let mut folders: BTreeSet<String> = BTreeSet::new();
    for Entry { key, stat } in client::list(&base)? {
        let url = base.join(&key);
        let ends = url.key.match_indices('/').map(|(at, _)| at);
        match ends.map(|at| &url.key[..at]).find(|k| compiled.matches_with(k, options)) {
            Some(folder) => {
                folders.insert(folder.to_owned());
            }
            None if compiled.matches_with(&url.key, options) => {
                source::remember(url.clone(), stat);
                found.push(Match { location: url.into(), kind: MatchKind::File });
            }
            None => {}
        }
    }
    for key in folders {
        let url = Url { key, ..pattern.clone() };
        let entries = client::list(&url)?;
        found.push(prefix(url, entries));
    }
    Ok(found)
}

impl Folder {
    pub(crate) fn location(&self) -> &Location {
        &self.location
    }

    /// The folder of that name directly below, if there is one.
    ///
    /// # Errors
    /// This folder itself, unchanged, where there is none.
    pub(crate) fn subfolder(mut self, name: &str) -> std::result::Result<Self, Self> {
        let location = self.location.join(name);
        if let Location::Local(path) = &location {
            // one that cannot be looked at is found when it is searched
            let there = !matches!(std::fs::metadata(path), Ok(meta) if !meta.is_dir())
                && location.exists().unwrap_or(true);
            return if there { Ok(Folder { location, entries: Vec::new() }) } else { Err(self) };
        }
        let below = format!("{name}/");
        if !self.entries.iter().any(|e| e.key.starts_with(&below)) {
            return Err(self);
        }
        self.entries.retain_mut(|e| match e.key.strip_prefix(&below) {
            Some(key) => {
                e.key = key.to_owned();
                true
            }
            None => false,
        });
        Ok(Folder { location, entries: self.entries })
    }

    /// The files below that `keep` takes, at any depth, those of a folder in order of name; links
    /// are followed. `keep` is asked of folders too (its second argument says which it is), and
    /// nothing below one that it leaves is looked at.
    pub(crate) fn files(self, keep: &dyn Fn(&Location, bool) -> bool) -> Vec<Searched> {
        match &self.location {
            Location::Local(path) => local_files(path, keep),
            Location::Remote(url) => remote_files(url, self.entries, keep),
        }
    }
}

fn local_files(root: &Path, keep: &dyn Fn(&Location, bool) -> bool) -> Vec<Searched> {
    let wanted =
        |e: &walkdir::DirEntry| e.depth() == 0 || keep(&e.path().into(), e.file_type().is_dir());
    let walk = WalkDir::new(root).follow_links(true).sort_by_file_name();
    let found = walk.into_iter().filter_entry(wanted).filter_map(|entry| match entry {
        Ok(e) => e.file_type().is_file().then(|| Ok(Location::Local(e.into_path()))),
        Err(e) => {
            let path = e.path().unwrap_or(root).to_owned();
            Some(Err((Location::Local(path), e.to_string())))
        }
    });
    found.collect()
}

fn remote_files(
    root: &Url,
    entries: Vec<Entry>,
    keep: &dyn Fn(&Location, bool) -> bool,
) -> Vec<Searched> {
    let mut folders: BTreeMap<String, bool> = BTreeMap::new();
    let mut found = Vec::new();
    for Entry { key, stat } in entries {
        let mut above = key.match_indices('/').map(|(at, _)| &key[..at]);
        let kept = above.all(|folder| match folders.get(folder) {
            Some(kept) => *kept,
            None => {
                let kept = keep(&root.join(folder).into(), true);
                folders.insert(folder.to_owned(), kept);
                kept
            }
        });
        let url = root.join(&key);
        let location = Location::Remote(url.clone());
        if kept && keep(&location, false) {
            source::remember(url, stat);
            found.push(Ok(location));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use std::time::SystemTime;

    use super::*;
    use crate::store::objects::Stat;

    const KEYS: [&str; 5] = ["a/1.csv", "a/.x.csv", "a/b/2.csv", "notes.md", "skip/3.csv"];

    fn keep(at: &Location, is_folder: bool) -> bool {
        let name = at.file_name();
        let hidden = name.starts_with('.');
        !hidden && if is_folder { name != "skip" } else { at.has_extension("csv") }
    }

    fn names(root: &Location, found: Vec<Searched>) -> Vec<String> {
        let name = |at: Location| at.to_string()[root.to_string().len() + 1..].to_owned();
        found.into_iter().map(|at| name(at.expect("readable"))).collect()
    }

    fn local_tree() -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("folder");
        for key in KEYS {
            Location::from(folder.path()).join(key).write(b"x").expect("written");
        }
        folder
    }

    fn listed() -> Folder {
        let stat = Stat { size: 1, etag: None, modified: SystemTime::UNIX_EPOCH };
        let entry = |key: &&str| Entry { key: (*key).to_owned(), stat: stat.clone() };
        let location = Location::parse("s3://bucket/logs").expect("url");
        Folder { location, entries: KEYS.iter().map(entry).collect() }
    }

    #[test]
    fn folders_and_prefixes_are_searched_alike() {
        let tree = local_tree();
        let local = find(&tree.path().into(), |_| false).expect("there").pop().expect("one");
        let MatchKind::Folder(local) = local.kind else { panic!("a folder") };
        for folder in [local, listed()] {
            let root = folder.location().clone();
            assert_eq!(names(&root, folder.files(&keep)), ["a/1.csv", "a/b/2.csv"]);
        }
    }

    #[test]
    fn a_folder_below() {
        let tree = local_tree();
        let local = Folder { location: tree.path().into(), entries: Vec::new() };
        for folder in [local, listed()] {
            let folder = folder.subfolder("sessions").expect_err("there is none");
            let folder = folder.subfolder("a").expect("there is one");
            let root = folder.location().clone();
            assert_eq!(root.file_name(), "a");
            assert_eq!(names(&root, folder.files(&keep)), ["1.csv", "b/2.csv"]);
        }
    }

    #[test]
    fn names_that_are_not_there_and_patterns() {
        let tree = local_tree();
        let root = Location::from(tree.path());
        let found = |name: &str| find(&root.join(name), |_| false).expect("asked");
        assert!(found("none").is_empty() && found("none*").is_empty());
        assert!(matches!(found("a/1.csv")[0].kind, MatchKind::File));
        let all = found("*");
        assert_eq!(all.len(), 3);
        assert!(all.iter().any(|m| matches!(m.kind, MatchKind::Folder(_))));
        assert_eq!(
            find(&root.join("a["), |_| false).expect_err("no").kind(),
            ErrorKind::InvalidInput
        );
    }
}
