//! The output's tables where they can be worked on: in its folder, or, of an object store, in
//! copies that are fetched for it and whose results are put back.
//!
//! What is made over all sessions (fleet, report) reads whole folders of tables. Of an object store
//! they are fetched into a temporary folder (`TMPDIR` says where), which takes as much disk as the
//! tables do, but no more memory than a few of them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::Error;
use crate::objects::url::{self, Url};
use crate::objects::{client, files};
use crate::{report, tables::file};

/// Tables that fleet and report are made from.
const READ: &[&str] = &[
    "sessions",
    "coefficients",
    "manoeuvres",
    "forces",
    "warnings",
    "plots",
    "rejected",
    "discrepancies",
    "causes",
    "replays",
    "fleet",
    "fleet_pooled",
    "fleet_events",
    "fleet_ratios",
];

/// What is made from them.
const MADE: &[&str] = &["fleet", "fleet_pooled", "fleet_events", "fleet_ratios", "report"];

/// Objects fetched together; as many are in memory.
const SOME: usize = 64;

/// A folder with the output's tables.
#[derive(Debug)]
pub struct Desk {
    folder: PathBuf,
    copy: Option<(Url, TempDir)>,
}

impl Desk {
    /// Of an output.
    ///
    /// # Errors
    /// A table cannot be fetched, or the temporary folder not be written.
    pub fn of(out: &Path) -> Result<Desk, Error> {
        let fail = |e: std::io::Error| Error::Output(e.to_string());
        let Some(url) = url::parse(out).map_err(fail)? else {
            return Ok(Desk { folder: out.to_owned(), copy: None });
        };
        let copy = tempfile::tempdir()
            .map_err(|e| Error::Output(format!("cannot make a temporary folder: {e}")))?;
        let folder = copy.path().to_owned();
        for name in READ {
            let prefix = url.join(name);
            let entries = client::list(&prefix).map_err(fail)?;
            for some in entries.chunks(SOME) {
                let urls: Vec<Url> = some.iter().map(|e| prefix.join(&e.key)).collect();
                for (entry, bytes) in some.iter().zip(client::get_many(&urls)) {
                    let path = folder.join(name).join(&entry.key);
                    let parent = path.parent().unwrap_or(&folder);
                    std::fs::create_dir_all(parent)
                        .and_then(|()| std::fs::write(&path, bytes?))
                        .map_err(|e| Error::Output(format!("{}: {e}", prefix.join(&entry.key))))?;
                }
            }
        }
        Ok(Desk { folder, copy: Some((url, copy)) })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Puts back what was made from the tables; pages of an earlier report go.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn publish(&self) -> Result<(), Error> {
        let Some((url, _)) = &self.copy else { return Ok(()) };
        let fail = |e: std::io::Error| Error::Output(e.to_string());
        let mut pages = BTreeSet::new();
        for name in MADE {
            for entry in files::list(&self.folder.join(name)).map_err(fail)? {
                let bytes = std::fs::read(self.folder.join(name).join(&entry.key)).map_err(fail)?;
                file::write_bytes(&url.join(name).join(&entry.key).path(), &bytes)
                    .map_err(|e| Error::Output(e.to_string()))?;
                pages.insert(entry.key);
            }
        }
        let report = url.join("report");
        for entry in client::list(&report).map_err(fail)? {
            let page = report.join(&entry.key);
            let kind = entry.key.ends_with(".html") || entry.key.starts_with("assets/");
            if kind
                && !pages.contains(&entry.key)
                && client::get(&page).is_ok_and(|bytes| report::is_own(&bytes))
            {
                client::delete(&page).map_err(fail)?;
            }
        }
        Ok(())
    }
}
