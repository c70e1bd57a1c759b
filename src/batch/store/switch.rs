//! From one state of an output's tables to the next, at once.
//!
//! ```text
//! <out>/.roadbench/next/<path>     files that a merge has made, each whole
//! <out>/.roadbench/next.json       there from the moment on at which all of them are: what replaces what
//! <out>/.roadbench/switched        from then on until what is made over all sessions fits the new tables
//! <out>/.roadbench/tables.lock     shared while a command reads the tables ([`reading`](super::reading)), exclusive while
//!                                  they are switched
//! ```
//!
//! A crash before `next.json` exists changes nothing. After a later crash the next command continues: every step may
//! be done twice. In an object store nothing can be renamed: there objects are put one by one, and what changes is
//! off the list of checksums meanwhile.

use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::kind::Kind;
use super::manifest::{self, Manifest};
use crate::batch::error::Error;
use crate::store::objects::Location;
use crate::store::objects::files::remove_many;
use crate::store::objects::replace::{open_own, sync_folder};
use crate::store::tables::file;

/// Folder of files that are to be put in place.
const NEXT: &str = ".roadbench/next";
/// List of the replacements, below the output.
pub(crate) const COMMIT: &str = ".roadbench/next.json";
/// Held by who reads the tables, and by who switches them.
pub(crate) const LOCK: &str = ".roadbench/tables.lock";

/// So long readers are waited for: a report of 100,000 sessions takes a minute, one that hangs must not stop the night.
pub(crate) const PATIENCE: Duration = Duration::from_secs(600);

/// Nobody reads while this is held.
#[derive(Debug)]
pub(crate) struct Switching(#[allow(dead_code)] Option<File>);

impl Switching {
    /// Waits for the readers, and carries on what was killed.
    ///
    /// # Errors
    /// The output cannot be written.
    pub(crate) fn begin(out: &Path) -> Result<Self, Error> {
        let path = out.join(LOCK);
        let fail = |e: std::io::Error| Error::Output(format!("{}: {e}", path.display()));
        let file = open_own(&path, File::options().create(true).truncate(false).write(true));
        let held = Switching(wait(file.map_err(fail)?, out));
        apply(out)?;
        Ok(held)
    }
}

/// The lock, once no reader has it; `None` where the file system knows none, or a reader does not end.
fn wait(file: File, out: &Path) -> Option<File> {
    let start = Instant::now();
    let mut is_told = false;
    loop {
        match file.try_lock() {
            Ok(()) => return Some(file),
            Err(TryLockError::Error(e)) => {
                tracing::debug!("{LOCK}: {e}");
                return None;
            }
            Err(TryLockError::WouldBlock) if start.elapsed() > PATIENCE => {
                tracing::warn!(
                    "{}: another program has been reading the tables for ten minutes; they are \
                     replaced all the same",
                    out.display()
                );
                return None;
            }
            Err(TryLockError::WouldBlock) => {
                if !is_told {
                    tracing::info!(
                        "{}: waiting for another program that reads the tables",
                        out.display()
                    );
                    is_told = true;
                }
                std::thread::sleep(Duration::from_millis(20));
            }
        }
    }
}

/// Carries on a switch that was killed, and removes what one has left that had not begun.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn recover(root: &Location) -> Result<(), Error> {
    let Some(out) = root.as_path() else { return Ok(()) };
    if out.join(COMMIT).is_file() {
        Switching::begin(out)?;
    }
    let next = out.join(NEXT);
    match std::fs::remove_dir_all(&next) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::Output(format!("cannot remove {}: {e}", next.display())))
        }
        _ => Ok(()),
    }
}

/// Files below the output that change: their new checksum, none where they go.
pub(crate) type Changes = BTreeMap<String, Option<String>>;

/// Content of `next.json`.
#[derive(Debug, Serialize, Deserialize)]
struct Commit {
    /// The mark that is there until what is made over all sessions fits.
    mark: String,
    changes: Changes,
    /// Files to remove after the switch: the staged sessions.
    then_remove: Vec<String>,
}

/// Where the files of a merge go until all are there.
#[derive(Debug)]
pub(crate) struct Next<'a> {
    root: &'a Location,
    kind: &'static Kind,
    /// Checksums of what is in place.
    pub list: Manifest,
}

impl<'a> Next<'a> {
    /// Of an output whose list this is; in an object store `concerned` comes off it, for it may change from now on.
    ///
    /// # Errors
    /// The output cannot be written.
    pub(crate) fn begin(
        kind: &'static Kind,
        root: &'a Location,
        list: Manifest,
        concerned: impl FnOnce() -> Vec<String>,
    ) -> Result<Self, Error> {
        if root.is_remote() {
            let mut off = list.clone();
            off.unlist(concerned().iter().map(String::as_str));
            off.write(root)?;
        }
        Ok(Next { root, kind, list })
    }

    /// Where a file is, or waits to be put in place, given what a merge has changed so far.
    pub(crate) fn place(&self, path: &str, changes: &Changes) -> Option<Location> {
        match changes.get(path) {
            Some(None) => None,
            Some(Some(_)) => Some(self.target(path)),
            None => Some(self.root.join(path)),
        }
    }

    /// The checksum that a file has, given what a merge has changed so far.
    pub(crate) fn checksum<'b>(&'b self, path: &str, changes: &'b Changes) -> Option<&'b str> {
        match changes.get(path) {
            Some(sum) => sum.as_deref(),
            None => self.list.of(path),
        }
    }

    /// Writes a file.
    ///
    /// # Errors
    /// The output cannot be written.
    pub(crate) fn write(
        &self,
        path: String,
        bytes: &[u8],
        changes: &mut Changes,
    ) -> Result<(), Error> {
        file::write_bytes(self.target(&path), bytes)?;
        changes.insert(path, Some(manifest::checksum(bytes)));
        Ok(())
    }

    /// Removes a file.
    ///
    /// # Errors
    /// The output cannot be written.
    pub(crate) fn remove(&self, path: String, changes: &mut Changes) -> Result<(), Error> {
        if self.root.is_remote() {
            let at = self.root.join(&path);
            at.remove().map_err(|e| Error::Output(format!("cannot remove {at}: {e}")))?;
        }
        changes.insert(path, None);
        Ok(())
    }

    fn target(&self, path: &str) -> Location {
        match self.root.is_remote() {
            true => self.root.join(path),
            false => self.root.join(format!("{NEXT}/{path}")),
        }
    }

    /// Puts all in place, and removes what waited for that. Gives back the lock that keeps readers out.
    ///
    /// # Errors
    /// The output cannot be written.
    pub(crate) fn commit(
        mut self,
        changes: Changes,
        then_remove: &[&Location],
    ) -> Result<Option<Switching>, Error> {
        self.list.unlist(changes.keys().map(String::as_str));
        for (path, sum) in &changes {
            if let Some(sum) = sum {
                self.list.put(path.clone(), sum.clone());
            }
        }
        let Some(out) = self.root.as_path() else {
            self.list.write(self.root)?;
            let fail = |e| Error::Output(format!("cannot remove the merged sessions: {e}"));
            return remove_many(then_remove).map_err(fail).map(|()| None);
        };
        self.list.write(&out.join(NEXT).into())?;
        let below = then_remove.iter().filter_map(|at| manifest::below(self.root, at));
        let mark = self.kind.switched.to_owned();
        let commit = Commit { mark, changes, then_remove: below.collect() };
        let text =
            serde_json::to_string(&commit).map_err(|e| Error::Internal(format!("commit: {e}")))?;
        file::write_bytes(out.join(COMMIT), text.as_bytes())?;
        Switching::begin(out).map(Some)
    }
}

/// Puts in place what waits for it, if anything does; twice is once.
fn apply(out: &Path) -> Result<(), Error> {
    let path = out.join(COMMIT);
    let bytes = match std::fs::read(&path) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        bytes => {
            bytes.map_err(|e| Error::Output(format!("cannot read {}: {e}", path.display())))?
        }
    };
    let commit: Commit = serde_json::from_slice(&bytes)
        .map_err(|e| Error::Output(format!("{}: {e}; remove it, and run again", path.display())))?;
    file::write_bytes(below(out, &commit.mark)?, b"")?;
    let mut folders = std::collections::BTreeSet::new();
    for (path, sum) in &commit.changes {
        let to = below(out, path)?;
        match sum {
            Some(_) => folders.extend(put(&out.join(NEXT).join(path), &to)?),
            None => {
                remove(&to)?;
                folders.extend(to.parent().filter(|folder| folder.is_dir()).map(Path::to_owned));
            }
        }
    }
    let list = out.join(manifest::PATH);
    folders.extend(put(&out.join(NEXT).join(manifest::PATH), &list)?);
    // all has its name for good before the last that knows of it goes
    for folder in &folders {
        sync_folder(folder).map_err(|e| Error::Output(format!("{}: {e}", folder.display())))?;
    }
    for path in &commit.then_remove {
        remove(&below(out, path)?)?;
    }
    remove(&path)?;
    let _ = std::fs::remove_dir_all(out.join(NEXT)); // the next run does it
    Ok(())
}

/// A path of the output; the commit is a file that anybody may have written.
fn below(out: &Path, path: &str) -> Result<PathBuf, Error> {
    let is_plain =
        Path::new(path).components().all(|c| matches!(c, std::path::Component::Normal(_)));
    match is_plain {
        true => Ok(out.join(path)),
        false => Err(Error::Output(format!("{COMMIT}: `{path}` is no file of the output"))),
    }
}

/// Renames a file; one that is not there was put in place before. Gives back the folders that have to be written down.
fn put(from: &Path, to: &Path) -> Result<Vec<PathBuf>, Error> {
    let fail = |e: std::io::Error| Error::Output(format!("cannot write {}: {e}", to.display()));
    let folder = to.parent().unwrap_or(to);
    let mut folders = vec![folder.to_owned()];
    if !folder.is_dir() {
        std::fs::create_dir_all(folder).map_err(fail)?;
        folders.extend(folder.ancestors().skip(1).take(2).map(Path::to_owned));
    }
    match std::fs::rename(from, to) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(folders),
        other => other.map(|()| folders).map_err(fail),
    }
}

fn remove(path: &Path) -> Result<(), Error> {
    let at = Location::from(path);
    at.remove().map_err(|e| Error::Output(format!("cannot remove {at}: {e}")))
}

#[cfg(test)]
mod tests {
    use super::super::kind::RUN;
    use super::*;

    fn put_text(out: &Path, path: &str, text: &str) {
        Location::from(out.join(path)).write(text.as_bytes()).expect("written");
    }

    fn text(out: &Path, path: &str) -> Option<String> {
        std::fs::read_to_string(out.join(path)).ok()
    }

    /// An output with the tables `a` and `b`, and a commit that replaces the first and removes the second, not applied.
    fn committed() -> tempfile::TempDir {
        let out = tempfile::tempdir().expect("folder");
        put_text(out.path(), "t/a", "old");
        put_text(out.path(), "t/b", "old");
        put_text(out.path(), ".roadbench/staged/s", "waits");
        put_text(out.path(), &format!("{NEXT}/t/a"), "new");
        put_text(out.path(), &format!("{NEXT}/{}", manifest::PATH), "{}");
        let changes = [("t/a".to_owned(), Some("sum".to_owned())), ("t/b".to_owned(), None)];
        let commit = Commit {
            mark: RUN.switched.to_owned(),
            changes: changes.into_iter().collect(),
            then_remove: vec![".roadbench/staged/s".to_owned()],
        };
        put_text(out.path(), COMMIT, &serde_json::to_string(&commit).expect("text"));
        put_text(out.path(), LOCK, "");
        out
    }

    #[test]
    fn a_switch_that_was_killed_is_carried_on() {
        let out = committed();
        // killed after the first file was in place
        let folder = out.path();
        std::fs::rename(folder.join(NEXT).join("t/a"), folder.join("t/a")).expect("renamed");
        recover(&folder.into()).expect("carried on");
        assert_eq!(text(folder, "t/a").as_deref(), Some("new"));
        assert_eq!(text(folder, manifest::PATH).as_deref(), Some("{}"));
        for gone in ["t/b", ".roadbench/staged/s", COMMIT, NEXT] {
            assert!(!folder.join(gone).exists(), "{gone} is still there");
        }
        assert!(folder.join(RUN.switched).is_file(), "the fleet's tables are older");
        recover(&folder.into()).expect("twice is once");
        assert_eq!(text(folder, "t/a").as_deref(), Some("new"));
    }

    #[test]
    fn what_was_not_committed_has_changed_nothing() {
        let out = committed();
        std::fs::remove_file(out.path().join(COMMIT)).expect("not that far");
        recover(&out.path().into()).expect("recovered");
        assert_eq!(text(out.path(), "t/a").as_deref(), Some("old"));
        assert_eq!(text(out.path(), "t/b").as_deref(), Some("old"));
        assert!(out.path().join(".roadbench/staged/s").exists(), "it waits on");
        assert!(!out.path().join(NEXT).exists());
    }

    #[test]
    fn a_commit_touches_nothing_outside_of_its_output() {
        let out = committed();
        let name = format!("{}-outside", Location::from(out.path()).file_name());
        let evil =
            format!(r#"{{"mark": "m", "changes": {{"../{name}": null}}, "then_remove": []}}"#);
        put_text(out.path(), COMMIT, &evil);
        let outside = out.path().with_file_name(&name);
        std::fs::write(&outside, "not ours").expect("written");
        let told = recover(&out.path().into()).expect_err("refused").to_string();
        assert!(told.contains(&format!("`../{name}`")), "{told}");
        assert!(outside.exists());
        let _ = std::fs::remove_file(outside);
    }
}
