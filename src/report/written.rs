//! The files of a report as they were written: `report/.written.json`, their BLAKE3 by name. A page that somebody changed,
//! or a bad disk, or that is gone, is written again by the next build.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use rayon::prelude::*;
use walkdir::WalkDir;

use super::error::Error;
use super::page_shell;
use crate::store::tables::file;

/// Name of the list in the report's folder.
pub(crate) const FILE: &str = ".written.json";

/// Checksums by name, with slashes.
#[derive(Debug, Default)]
pub(super) struct Written(BTreeMap<String, String>);

fn checksum(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

impl Written {
    /// Reads a report's list; none where there is no list that can be read.
    fn read(folder: &Path) -> Option<Self> {
        let bytes = std::fs::read(folder.join(FILE)).ok()?;
        serde_json::from_slice(&bytes).ok().map(Written)
    }

    /// Names of the files that are as they were written.
    pub(super) fn whole(folder: &Path) -> BTreeSet<String> {
        let Written(files) = Self::read(folder).unwrap_or_default();
        let is_whole = |(name, sum): &(String, String)| {
            std::fs::read(folder.join(name)).is_ok_and(|bytes| checksum(&bytes) == *sum)
        };
        files.into_par_iter().filter(is_whole).map(|(name, _)| name).collect()
    }

    /// Lists what roadbench has written below the folder, and writes the list.
    pub(super) fn list(folder: &Path) -> Result<(), Error> {
        let walk = WalkDir::new(folder).max_depth(2).into_iter().filter_map(Result::ok);
        let paths: Vec<_> = walk.filter(|e| e.file_type().is_file()).collect();
        let own = |entry: &walkdir::DirEntry| {
            let below = entry.path().strip_prefix(folder).ok()?;
            let parts: Vec<_> = below.iter().map(|part| part.to_string_lossy()).collect();
            let bytes = std::fs::read(entry.path()).ok()?;
            page_shell::is_own(&bytes).then(|| (parts.join("/"), checksum(&bytes)))
        };
        let files: BTreeMap<String, String> = paths.par_iter().filter_map(own).collect();
        let text = serde_json::to_vec_pretty(&files)?;
        Ok(file::write_bytes(folder.join(FILE), &text)?)
    }
}

/// Files of an output's report that are missing or not as they were written, below the report's folder, and whether each
/// is there; `None` where the report has no list of them.
pub(crate) fn damaged(out: &Path) -> Option<Vec<(String, bool)>> {
    let folder = out.join("report");
    let Written(files) = Written::read(&folder)?;
    let is_other = |(name, sum): (String, String)| match std::fs::read(folder.join(&name)) {
        Ok(bytes) if checksum(&bytes) == sum => None,
        Ok(_) => Some((name, true)),
        Err(_) => Some((name, false)),
    };
    Some(files.into_par_iter().filter_map(is_other).collect())
}

/// Whether an output's report is there as it was written.
pub(crate) fn is_whole(out: &Path) -> bool {
    damaged(out).is_some_and(|damaged| damaged.is_empty())
}
