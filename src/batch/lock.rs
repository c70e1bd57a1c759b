//! One run at a time on an output: an advisory lock on a file, or a lock object with an end.

use std::fs::{File, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::time::Duration;

use super::error::Error;
use crate::objects::Location;
use crate::objects::lease::{Lease, Refusal};
use crate::objects::url::Url;

/// What the file says while it is held for a moment only.
const MOMENT: &[u8] = b"for a moment";

/// Held while a run writes.
#[derive(Debug)]
pub enum Lock {
    /// Of a folder.
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
    pub fn take(root: &Location) -> Result<Lock, Error> {
        match root {
            Location::Remote(url) => prefix(url),
            Location::Local(path) => folder(path).map(Lock::File),
        }
    }

    /// Locks an output for a moment, to do what a killed run has left: a run that begins meanwhile waits.
    ///
    /// # Errors
    /// As [`Lock::take`].
    pub fn take_over(root: &Location) -> Result<Lock, Error> {
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
    pub fn check(&self) -> std::io::Result<()> {
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
    let path = root.join(".roadbench.lock");
    let file =
        File::options().create(true).truncate(false).write(true).open(&path).map_err(cannot)?;
    let is_for_a_moment = || std::fs::read(&path).is_ok_and(|text| text == MOMENT);
    let mut taken = file.try_lock();
    while matches!(taken, Err(TryLockError::WouldBlock)) && is_for_a_moment() {
        std::thread::sleep(Duration::from_millis(50));
        taken = file.try_lock();
    }
    match taken {
        Ok(()) => {
            let _ = file.set_len(0); // of one that was killed
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
