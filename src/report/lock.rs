//! One roadbench at a time writes a report: two at once would leave pages of different tables side by side.

use std::fs::{File, TryLockError};
use std::path::Path;

/// Held while a report is written; the folder itself is locked, so nothing is left behind.
#[derive(Debug)]
pub(super) struct Lock(#[allow(dead_code)] Option<File>);

impl Lock {
    /// Waits until no other roadbench writes the report below an output folder. Where the system knows no such
    /// locks nothing is waited for.
    pub(super) fn take(out: &Path) -> Lock {
        let folder = out.join("report");
        if std::fs::create_dir_all(&folder).is_err() {
            return Lock(None); // the first page says why
        }
        let Ok(file) = File::open(&folder) else { return Lock(None) };
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            tracing::info!("{}: another roadbench writes the report; waiting", out.display());
            if let Err(e) = file.lock() {
                tracing::debug!("{}: {e}", folder.display());
            }
        }
        Lock(Some(file))
    }
}
