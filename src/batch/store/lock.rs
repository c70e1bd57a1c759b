//! One run at a time on an output: an advisory lock on a file, or a lock object with an end.

use std::fs::{File, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::time::Duration;

use crate::batch::error::Error;
use crate::store::objects::Location;
use crate::store::objects::lease::{Lease, Refusal};
use crate::store::objects::replace::open_own;
use crate::store::objects::url::Url;
use crate::store::tables::registry;

/// Text of the file while it is held for a moment only.
const MOMENT: &[u8] = b"for a moment";

/// Held while a run writes.
#[derive(Debug)]
pub(crate) enum Lock {
    File(File),
    /// Of a prefix in an object store.
    Lease(Lease),
    /// The store knows none.
    None,
}

impl Lock {
    /// Locks an output, making its folder where it is missing.
    ///
    /// # Errors
    /// Another run has it, or it cannot be written.
    pub(crate) fn take(root: &Location) -> Result<Lock, Error> {
        match root {
            Location::Remote(url) => prefix(url),
            Location::Local(path) => folder(path).map(Lock::File),
        }
    }

    /// Locks an output for a moment, to do what a killed run has left: a run that begins meanwhile waits.
    ///
    /// # Errors
    /// As [`Lock::take`].
    pub(crate) fn take_over(root: &Location) -> Result<Lock, Error> {
        let lock = Lock::take(root)?;
        if let Lock::File(file) = &lock {
            let _ = (&*file).write_all(MOMENT); // without it that run is refused
        }
        Ok(lock)
    }

    /// Whether it is still ours.
    ///
    /// # Errors
    /// It is not.
    pub(crate) fn check(&self) -> std::io::Result<()> {
        match self {
            Lock::Lease(lease) => lease.check(),
            Lock::File(_) | Lock::None => Ok(()),
        }
    }
}

fn prefix(root: &Url) -> Result<Lock, Error> {
    match Lease::take(&root.join(".roadbench/lock")) {
        Ok(lease) => Ok(Lock::Lease(lease)),
        Err(Refusal::Taken(owner, until)) => Err(Error::Usage(format!(
            "another roadbench ({owner}) is writing to {root}; wait for it to end, or choose \
             another --out. If it was killed, its lock ends at {until:.0}"
        ))),
        Err(Refusal::Unknown) => {
            tracing::warn!(
                "{root}: this store has no conditional puts; run one roadbench at a time"
            );
            Ok(Lock::None)
        }
        Err(Refusal::Failed(e)) => Err(Error::Output(format!("cannot write to --out {root}: {e}"))),
    }
}

fn folder(root: &Path) -> Result<File, Error> {
    let cannot =
        |e: std::io::Error| Error::Output(format!("cannot write to --out {}: {e}", root.display()));
    std::fs::create_dir_all(root).map_err(cannot)?;
    let path = root.join(registry::LOCK);
    let here = |e: std::io::Error| Error::Output(format!("{}: {e}", path.display()));
    let file = open_own(&path, File::options().create(true).truncate(false).write(true));
    let file = file.map_err(here)?;
    let is_for_a_moment = || std::fs::read(&path).is_ok_and(|text| text == MOMENT);
    refuse_strange(&file, &path).map_err(here)?;
    let mut taken = file.try_lock();
    while matches!(taken, Err(TryLockError::WouldBlock)) && is_for_a_moment() {
        std::thread::sleep(Duration::from_millis(50));
        taken = file.try_lock();
    }
    match taken {
        Ok(()) => {
            let _ = file.set_len(0); // of one that was killed: see above
            Ok(file)
        }
        Err(TryLockError::WouldBlock) => Err(Error::Usage(format!(
            "another roadbench is writing to {}; wait for it to end, or choose another --out",
            root.display()
        ))),
        Err(TryLockError::Error(e)) if e.kind() == ErrorKind::Unsupported => {
            tracing::warn!(
                "{}: this file system has no locks; run one roadbench at a time on it",
                root.display()
            );
            Ok(file)
        }
        Err(TryLockError::Error(e)) => Err(cannot(e)),
    }
}

/// The lock's name may be a second one of somebody's file: nothing is written into that.
fn refuse_strange(file: &File, path: &Path) -> std::io::Result<()> {
    let is_ours = file.metadata()?.len() <= MOMENT.len() as u64
        && std::fs::read(path).is_ok_and(|text| MOMENT.starts_with(&text));
    let why = "it is no lock of roadbench's; remove it";
    if is_ours { Ok(()) } else { Err(std::io::Error::new(ErrorKind::InvalidData, why)) }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    /// Makes a second way to a file.
    type Plant = fn(&Path, &Path) -> std::io::Result<()>;

    /// Somebody's file has the name of the lock, by a link or as a second name.
    #[test]
    fn a_lock_empties_nobodys_file() {
        let out = tempfile::tempdir().expect("folder");
        let (kept, lock) = (out.path().join("kept"), out.path().join(registry::LOCK));
        std::fs::write(&kept, "somebody's text").expect("written");
        let plant: [(&str, Plant); 2] =
            [("link", |a, b| symlink(a, b)), ("second name", |a, b| std::fs::hard_link(a, b))];
        for (how, plant) in plant {
            plant(&kept, &lock).expect(how);
            for take in [Lock::take, Lock::take_over] {
                let e = take(&out.path().into()).expect_err(how).to_string();
                assert!(e.contains(registry::LOCK) && e.contains("remove it"), "{how}: {e}");
            }
            assert_eq!(std::fs::read_to_string(&kept).expect(how), "somebody's text");
            std::fs::remove_file(&lock).expect(how);
        }
        symlink(out.path().join("not there"), &lock).expect("link");
        Lock::take(&out.path().into()).expect_err("dangling");
        assert!(!out.path().join("not there").exists());
        std::fs::remove_file(&lock).expect("removed");
        drop(Lock::take_over(&out.path().into()).expect("taken"));
        drop(Lock::take(&out.path().into()).expect("what one says for a moment is ours"));
    }
}
