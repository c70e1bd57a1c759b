//! The tables that are made over all sessions, so that they fit the sessions': at the end of every batch, and after one that
//! was killed in between.

use super::kind::{CHANGES, DIAGNOSE, RUN, SHARED, SHARED_PLACES};
use super::local_copy::LocalCopy;
use super::manifest::{self, Manifest};
use super::switch::Switching;
use super::verify;
use crate::batch::error::Error;
use crate::batch::jobs::pooled::{self, OverAll};
use crate::store::objects::Location;
use crate::store::tables::registry;

/// The fleet's tables.
///
/// # Errors
/// A table cannot be read, or the output not be written.
pub(crate) fn fleet(root: &Location, copy: &LocalCopy) -> Result<(), Error> {
    let made: Vec<&str> = registry::of_fleet().map(|spec| spec.name).collect();
    take_off(root, &made)?;
    #[cfg(feature = "fleet")]
    crate::batch::fleet::tables::write(copy.folder())?;
    if root.is_remote() {
        return Ok(()); // they are put when the report is there, too
    }
    copy.publish(made.iter().copied())?;
    list_again(root, copy, &made)
}

/// What diagnosed sessions share, and what differs between a motorcycle's.
///
/// # Errors
/// As [`fleet`].
pub(crate) fn pooled(root: &Location, copy: &LocalCopy) -> Result<OverAll, Error> {
    take_off(root, &SHARED_PLACES)?;
    let over_all = pooled::write(root, copy)?;
    if !root.is_remote() {
        copy.publish([SHARED, CHANGES])?;
        list_again(root, copy, &SHARED_PLACES)?;
    }
    Ok(over_all)
}

/// Makes what a killed batch has not: its tables are in place, and what is made over all sessions is older. The output is
/// locked by the caller.
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

/// Whether tables wait to be put in place, or are newer than what is made over all sessions.
pub(crate) fn is_unfinished(out: &std::path::Path) -> bool {
    [super::switch::COMMIT, RUN.switched, DIAGNOSE.switched]
        .iter()
        .any(|mark| out.join(mark).is_file())
}

/// Takes what is below some paths off the list of checksums: whoever is killed while it changes leaves files that are not
/// listed, never a checksum that is wrong.
fn take_off(root: &Location, below: &[&str]) -> Result<(), Error> {
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
    list.take_off(paths.iter().map(String::as_str));
    list.write(root)
}

/// Lists the checksums of what was made over all sessions.
///
/// # Errors
/// A file cannot be read, or the list not be written.
pub(crate) fn list_again(root: &Location, copy: &LocalCopy, below: &[&str]) -> Result<(), Error> {
    let before = Manifest::read(root);
    let mut list = match before.is_there {
        true => before.clone(),
        false => verify::adopt(root)?,
    };
    list.list_again(copy.folder(), below)?;
    if list == before { Ok(()) } else { list.write(root) }
}
