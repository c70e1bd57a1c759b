//! Reading one state of an output's tables, while runs write.

use std::fs::{File, TryLockError};
use std::path::Path;
use std::time::{Duration, Instant};

use super::finish_derived;
use super::intact;
use super::lock::Lock;
use super::mark;
use super::switch::{LOCK, PATIENCE};
use crate::batch::error::Error;
use crate::store::objects::files::open_file;
use crate::store::objects::replace::open_own;

/// The tables stay as they are while this is held.
#[derive(Debug)]
pub struct Reading(#[allow(dead_code)] Option<File>);

impl Reading {
    /// Of an output, waiting while its tables are replaced and those made over all sessions are older. What a killed run
    /// has left half-done is done first. Where the folder cannot be written there is no lock, and what is there is read.
    ///
    /// # Errors
    /// The rest of a killed run's work fails.
    pub fn of(out: &Path) -> Result<Self, Error> {
        let start = Instant::now();
        loop {
            let Some(file) = open(out) else { return Ok(Reading(None)) };
            if let Err(TryLockError::WouldBlock) = file.try_lock_shared() {
                tracing::info!("{}: its tables are being replaced; waiting", out.display());
                if let Err(e) = file.lock_shared() {
                    tracing::debug!("{LOCK}: {e}");
                }
            }
            if !finish_derived::is_unfinished(out) {
                return Ok(Reading(Some(file)));
            }
            // the process that switches waits for this one, or was killed
            match Lock::take_over(&out.into()) {
                Ok(_held) => {
                    drop(file);
                    finish_derived::after_kill(&out.into())?;
                }
                Err(Error::Usage(_)) if start.elapsed() < PATIENCE => {
                    drop(file);
                    std::thread::sleep(Duration::from_millis(50));
                }
                Err(e) => {
                    tracing::warn!(
                        "{}: the fleet's tables may be older than the sessions' ({e})",
                        out.display()
                    );
                    return Ok(Reading(Some(file)));
                }
            }
        }
    }
    /// As [`Reading::of`], and what some tables say of the sessions of a name is as it was written.
    ///
    /// # Errors
    /// As [`Reading::of`]; a file that is missing or has other bytes, and what to do.
    pub fn of_session(out: &Path, tables: &[&str], session: &str) -> Result<Self, Error> {
        let reading = Self::of(out)?;
        intact::require_session(out, tables, session)?;
        Ok(reading)
    }
}

/// The file that is locked; made where an output has none yet. None where it cannot be, and where there is no output.
fn open(out: &Path) -> Option<File> {
    let path = out.join(LOCK);
    if let Ok(file) = open_file(&path) {
        return Some(file);
    }
    // nothing is made in a folder that is no output
    if !mark::is_output(&out.into()).unwrap_or_default() {
        return None;
    }
    open_own(&path, File::options().create(true).truncate(false).write(true)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::store::kind::RUN;
    use crate::batch::store::manifest::Manifest;
    use crate::batch::store::switch::{Changes, Next};
    use crate::store::objects::Location;

    fn text(out: &Path, path: &str) -> Option<String> {
        std::fs::read_to_string(out.join(path)).ok()
    }

    #[test]
    fn tables_are_not_switched_under_a_reader_and_the_next_waits_for_the_fleet() {
        let out = tempfile::tempdir().expect("folder");
        let folder = out.path();
        let root = Location::from(folder);
        mark::claim(&root).expect("an output");
        root.join("sessions/a").write(b"old").expect("written");
        let reading = Reading::of(folder).expect("free");
        let _run = Lock::take(&root).expect("one run");
        std::thread::scope(|scope| {
            let writer = scope.spawn(|| {
                let list = Manifest::empty();
                let next = Next::begin(&RUN, &root, list, Vec::new).expect("begun");
                let mut changes = Changes::new();
                next.write("sessions/a".to_owned(), b"new", &mut changes).expect("written");
                next.commit(changes, &[]).expect("committed")
            });
            std::thread::sleep(Duration::from_millis(200));
            assert_eq!(text(folder, "sessions/a").as_deref(), Some("old"), "somebody reads it");
            // a second reader lets the writer go first
            let reader = scope.spawn(|| Reading::of(folder).map(|_| text(folder, "fleet")));
            std::thread::sleep(Duration::from_millis(200));
            assert!(!reader.is_finished());
            drop(reading);
            let switching = writer.join().expect("switched");
            assert_eq!(text(folder, "sessions/a").as_deref(), Some("new"));
            std::thread::sleep(Duration::from_millis(200));
            assert!(!reader.is_finished(), "the fleet is of the tables before");
            root.join("fleet").write(b"of the new tables").expect("written");
            root.join(RUN.switched).remove().expect("removed");
            drop(switching);
            let read = reader.join().expect("read").expect("read");
            assert_eq!(read.as_deref(), Some("of the new tables"));
        });
    }
}
