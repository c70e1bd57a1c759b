//! Tables without rows: a query over a table never fails because no ride of an output had rows for it.
//!
//! Each table of a command has one file without rows, in a partition of no motorcycle, so that every pattern that finds
//! the other files finds this one. (The name that hive has for a null partition pyarrow cannot read.)

use super::kind::Kind;
use super::manifest::{self, Manifest};
use crate::batch::error::Error;
use crate::store::objects::Location;
use crate::store::tables::file;
use crate::store::tables::registry;
use crate::store::tables::registry::TableSpec;

/// Folder of rows of no motorcycle.
const NOBODY: &str = "bike=_none";

/// The tables of a command that may have no rows, and their files without any, below the output.
fn files(kind: &Kind) -> impl Iterator<Item = (&'static TableSpec, String)> {
    let of_sessions = registry::of_session(kind.command);
    let of_sessions =
        of_sessions.map(|spec| (spec, format!("{}/{NOBODY}/empty.parquet", spec.name)));
    let rejected = &registry::REJECTED;
    of_sessions.chain([(rejected, format!("{}/empty.parquet", rejected.name))])
}

/// Whether it is such a file: it has nothing to lose, and the next run writes it again.
pub(crate) fn is_one(path: &str) -> bool {
    path.ends_with(&format!("/{NOBODY}/empty.parquet"))
}

/// Whether one of them is not there; `has` says of each.
pub(crate) fn lacks(kind: &Kind, has: impl Fn(&str) -> bool) -> bool {
    files(kind).any(|(_, path)| !has(&path))
}

/// Writes those that are not there as they should be.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn write(root: &Location, kind: &Kind) -> Result<(), Error> {
    let before = Manifest::read(root);
    let mut list = before.clone();
    for (spec, path) in files(kind) {
        let bytes = file::batches_to_bytes(spec.table(), &[])?;
        let at = root.join(&path);
        if !at.read().is_ok_and(|there| there == bytes) {
            file::write_bytes(at, &bytes)?;
        }
        if !spec.is(&registry::REJECTED) {
            list.put(path, manifest::checksum(&bytes));
        }
    }
    // an output of an earlier version has no list: it is made with that of what is over all sessions
    if before.is_there && list != before { list.write(root) } else { Ok(()) }
}
