//! Which figures a folder has of roadbench: those of sessions and coefficients that are gone go with them, and no other
//! file that somebody keeps there.
//!
//! A name is on the list before its file is written, and leaves it after its file is removed, so that whatever a
//! killed process leaves is known to the next. Each output has its own list, by its path: several may have their figures
//! in one folder.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::store::objects::replace::open_own;
use crate::store::tables::file;

/// The list of a folder while its figures are written: a name relative to the folder per line.
#[derive(Debug)]
pub(crate) struct Listed {
    folder: PathBuf,
    path: PathBuf,
    before: BTreeSet<String>,
    now: Mutex<(File, BTreeSet<String>)>,
}

impl Listed {
    /// Those of an output in a folder, which is made where there is none.
    ///
    /// # Errors
    /// The folder cannot be made or the list not be opened.
    pub(crate) fn open(folder: &Path, out: &Path) -> Result<Self, file::Error> {
        let path = folder.join(name_for(out));
        let opened = open_own(&path, File::options().append(true).create(true));
        let list =
            opened.map_err(|source| file::Error::Io { path: path.as_path().into(), source })?;
        let (folder, before) = (folder.to_owned(), names(&path));
        Ok(Listed { folder, path, before, now: Mutex::new((list, BTreeSet::new())) })
    }

    /// Puts a figure on the list; then its file may be written.
    ///
    /// # Errors
    /// The list cannot be written.
    pub(crate) fn add(&self, name: &str) -> Result<(), file::Error> {
        let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        let (list, added) = &mut *now;
        let is_new = added.insert(name.to_owned()) && !self.before.contains(name);
        // in one piece: others may write into the same folder
        let written = if is_new { list.write_all(format!("{name}\n").as_bytes()) } else { Ok(()) };
        written.map_err(|source| self.error(source))
    }

    /// Removes earlier figures with one of some endings that were not written again; returns their number.
    ///
    /// # Errors
    /// One cannot be removed, or the list not be written.
    pub(crate) fn remove_others(self, endings: &[&str]) -> Result<usize, file::Error> {
        let (_, now) = &*self.now.lock().unwrap_or_else(PoisonError::into_inner);
        let has_ending = |name: &str| endings.iter().any(|e| name.ends_with(&format!(".{e}")));
        let is_gone = |name: &&String| has_ending(name) && !now.contains(*name);
        let gone: BTreeSet<&String> = self.before.iter().filter(is_gone).collect();
        for name in &gone {
            let path = self.folder.join(name);
            match fs::remove_file(&path) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(self.error(e)),
                _ => {}
            }
            // the last figure of a session; a folder with anything else in it stays
            let _ = path.parent().map(fs::remove_dir);
        }
        // what others have put on it meanwhile stays on it
        let mut left = names(&self.path);
        left.retain(|name| !gone.contains(name));
        let text: String = left.iter().map(|name| format!("{name}\n")).collect();
        file::write_bytes(self.path.as_path(), text.as_bytes())?;
        Ok(gone.len())
    }

    fn error(&self, source: io::Error) -> file::Error {
        file::Error::Io { path: self.path.as_path().into(), source }
    }
}

/// Name of an output's list.
fn name_for(out: &Path) -> String {
    let whole = fs::canonicalize(out).unwrap_or_else(|_| out.to_owned());
    let hash = blake3::hash(whole.as_os_str().as_encoded_bytes()).to_hex();
    format!(".roadbench-figures-{}", &hash[..8])
}

/// The names on a list that are those of figures: a folder and a file in it. Another word in the list, a way out of
/// the folder above all, is none.
fn names(list: &Path) -> BTreeSet<String> {
    let text = fs::read_to_string(list).unwrap_or_default();
    let is_figure = |name: &str| {
        let parts: Vec<Component<'_>> = Path::new(name).components().collect();
        let is_plain = |part: &Component<'_>| matches!(part, Component::Normal(_));
        parts.len() == 2 && parts.iter().all(is_plain)
    };
    text.lines().filter(|name| is_figure(name)).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Writes figures of an output as a report does.
    fn write_of(out: &str, folder: &Path, figures: &[&str]) -> usize {
        let listed = Listed::open(folder, Path::new(out)).expect("list");
        for name in figures {
            listed.add(name).expect("listed");
            file::write_bytes(folder.join(name), b"figure").expect("written");
        }
        listed.remove_others(&["svg"]).expect("removed")
    }

    fn write(folder: &Path, figures: &[&str]) -> usize {
        write_of("no/output", folder, figures)
    }

    fn list(folder: &Path) -> PathBuf {
        folder.join(name_for(Path::new("no/output")))
    }

    #[test]
    fn figures_that_are_gone_go_and_nothing_else() {
        let folder = tempfile::tempdir().expect("folder");
        let at = folder.path();
        assert_eq!(write(at, &["s1/a.svg", "s1/b.svg", "s2/a.svg", "s2/a.png"]), 0);
        fs::write(at.join("mine.svg"), "mine").expect("mine");
        fs::write(at.join("s1/mine.svg"), "mine").expect("mine");
        assert_eq!(write(at, &["s1/a.svg"]), 2);
        let is = |name: &str| at.join(name).exists();
        assert!(is("s1/a.svg") && is("mine.svg") && is("s1/mine.svg"));
        assert!(!is("s1/b.svg") && !is("s2/a.svg") && is("s2/a.png"), "other endings stay");
        assert_eq!(names(&list(at)).into_iter().collect::<Vec<_>>(), ["s1/a.svg", "s2/a.png"]);
    }

    #[test]
    fn what_a_killed_report_wrote_is_known_to_the_next() {
        let folder = tempfile::tempdir().expect("folder");
        let at = folder.path();
        let listed = Listed::open(at, Path::new("no/output")).expect("list");
        listed.add("s1/a.svg").expect("listed");
        file::write_bytes(at.join("s1/a.svg"), b"figure").expect("written");
        drop(listed); // killed
        assert_eq!(write(at, &["s2/a.svg"]), 1);
        assert!(!at.join("s1").exists() && at.join("s2/a.svg").exists());
    }

    #[test]
    fn two_outputs_leave_each_others_figures() {
        let folder = tempfile::tempdir().expect("folder");
        let at = folder.path();
        write_of("one", at, &["s1/a.svg"]);
        assert_eq!(write_of("other", at, &["s2/a.svg"]), 0);
        assert_eq!(write_of("one", at, &["s3/a.svg"]), 1);
        assert!(!at.join("s1").exists() && at.join("s2/a.svg").exists());
    }

    #[test]
    fn a_list_leads_nowhere_else() {
        let folder = tempfile::tempdir().expect("folder");
        let at = folder.path().join("figures");
        fs::create_dir_all(&at).expect("folder");
        fs::write(folder.path().join("other.svg"), "other").expect("other");
        fs::write(at.join("mine.svg"), "mine").expect("mine");
        let absolute = folder.path().join("other.svg").display().to_string();
        fs::write(list(&at), format!("../other.svg\nmine.svg\n{absolute}\n")).expect("list");
        assert_eq!(write(&at, &["s1/a.svg"]), 0);
        assert!(folder.path().join("other.svg").exists() && at.join("mine.svg").exists());
    }
}
