//! The tables over all sessions are brought up to date with the sessions: at the end of every batch, and after a batch
//! that was killed before that.

use super::kind::{CHANGES, DIAGNOSE, RUN, SHARED, SHARED_PLACES};
use super::local_copy::LocalCopy;
use super::manifest::{self, Manifest};
use super::switch::Switching;
use super::verify;
use crate::batch::error::Error;
use crate::batch::jobs::pooled::{self, OverAll};
use crate::store::objects::Location;
use crate::store::tables::registry;

/// Writes the fleet's tables.
///
/// # Errors
/// A table cannot be read, or the output cannot be written.
pub(crate) fn fleet(root: &Location, copy: &LocalCopy) -> Result<(), Error> {
    let made: Vec<&str> = registry::of_fleet().map(|spec| spec.name).collect();
    unlist(root, &made)?;
    #[cfg(feature = "fleet")]
    crate::batch::fleet::tables::write(copy.folder())?;
    if root.is_remote() {
        return Ok(()); // they are uploaded together with the report
    }
    copy.publish(made.iter().copied())?;
    rescan(root, copy, &made)
}

/// Writes the effects that diagnosed sessions share, and the changes between a motorcycle's rides.
///
/// # Errors
/// As [`fleet`].
pub(crate) fn pooled(root: &Location, copy: &LocalCopy) -> Result<OverAll, Error> {
    unlist(root, &SHARED_PLACES)?;
    let over_all = pooled::write(root, copy)?;
    if !root.is_remote() {
        copy.publish([SHARED, CHANGES])?;
        rescan(root, copy, &SHARED_PLACES)?;
    }
    Ok(over_all)
}

/// Writes the tables over all sessions that a killed batch did not write, although the sessions' tables are in place. The
/// caller has locked the output.
///
/// # Errors
/// As [`fleet`].
pub(crate) fn after_kill(root: &Location) -> Result<(), Error> {
    let Some(out) = root.as_path() else { return Ok(()) };
    let is_there = |mark: &str| out.join(mark).is_file();
    if !is_unfinished(out) {
        return Ok(());
    }
    let _switching = Switching::begin(out)?;
    let copy = LocalCopy::of(root)?;
    if is_there(RUN.switched) {
        fleet(root, &copy)?;
    }
    if is_there(DIAGNOSE.switched) {
        pooled(root, &copy)?;
    }
    for kind in [&RUN, &DIAGNOSE] {
        let mark = root.join(kind.switched);
        mark.remove().map_err(|e| Error::Output(format!("cannot remove {mark}: {e}")))?;
    }
    Ok(())
}

/// Whether a killed batch left work: tables to put in place, or tables over all sessions that are out of date.
pub(crate) fn is_unfinished(out: &std::path::Path) -> bool {
    [super::switch::COMMIT, RUN.switched, DIAGNOSE.switched]
        .iter()
        .any(|mark| out.join(mark).is_file())
}

/// Removes the files below some paths from the list of checksums. A crash in between leaves unlisted files, never a wrong
/// checksum.
fn unlist(root: &Location, below: &[&str]) -> Result<(), Error> {
    let mut list = Manifest::read(root);
    if !list.is_there {
        return Ok(());
    }
    let is_below = |path: &str| below.iter().any(|place| manifest::is_below(path, place));
    let paths: Vec<String> =
        list.files().map(|(path, _)| path).filter(|p| is_below(p)).map(str::to_owned).collect();
    if paths.is_empty() {
        return Ok(());
    }
    list.unlist(paths.iter().map(String::as_str));
    list.write(root)
}

/// Lists the checksums of the tables over all sessions.
///
/// # Errors
/// A file cannot be read, or the list cannot be written.
pub(crate) fn rescan(root: &Location, copy: &LocalCopy, below: &[&str]) -> Result<(), Error> {
    let before = Manifest::read(root);
    let mut list = match before.is_there {
        true => before.clone(),
        false => verify::adopt(root)?,
    };
    list.rescan(copy.folder(), below)?;
    if list == before { Ok(()) } else { list.write(root) }
}
