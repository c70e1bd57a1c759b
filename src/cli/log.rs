//! The log that a command is given.

use crate::cli::failure::Failure;
use crate::contract::file_kind::FileKind;
use crate::ingest;
use crate::store::objects::Location;
use crate::store::objects::files::read_text;

/// Makes sure that a log is there, before any work begins.
///
/// # Errors
/// Nothing is there, or what is there is a folder or one of the program's own files: wrong usage, as for `run`.
pub(super) fn require(log: &Location) -> Result<(), Failure> {
    let usage = |why: String| Err(Failure::Usage(format!("{log}: {why}")));
    match log.exists() {
        Ok(true) => {}
        Ok(false) => return usage("file not found".to_owned()),
        Err(e) => return usage(e.to_string()),
    }
    if log.as_path().is_some_and(std::path::Path::is_dir) {
        return usage(
            "this is a folder, and one log is wanted; `roadbench run` takes folders".to_owned(),
        );
    }
    refuse_own(log)
}

/// Refuses a file of the program's own in the place of a log.
///
/// # Errors
/// It is one: wrong usage.
pub(super) fn refuse_own(log: &Location) -> Result<(), Failure> {
    let Some(path) = log.as_path() else { return Ok(()) };
    let is_toml = path.extension().is_some_and(|x| x.eq_ignore_ascii_case("toml"));
    let text = if is_toml { read_text(path).ok() } else { None };
    match text.and_then(|text| FileKind::of(&text)) {
        Some(kind) => {
            Err(Failure::Usage(format!("{log}: this is {}, and a log is wanted", kind.name())))
        }
        None => Ok(()),
    }
}

/// A log that is there and cannot be used.
pub(super) fn rejected(e: ingest::Error) -> Failure {
    Failure::Rejected(format!("{e} ({})", e.code))
}
