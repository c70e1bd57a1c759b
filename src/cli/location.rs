//! Paths and object store addresses as arguments.

use std::path::Path;

use clap::builder::{PathBufValueParser, TypedValueParser};

use crate::cli::failure::Failure;
use crate::store::objects::Location;

/// A path, or a URL of an object store; the message of one that cannot be used, or is empty, says why.
pub(super) fn location() -> impl TypedValueParser<Value = Location> {
    PathBufValueParser::new().try_map(Location::parse)
}

/// Makes sure that a local folder is there, before any work begins.
///
/// # Errors
/// Nothing is there, or a file.
pub(super) fn require_folder(path: &Path) -> Result<(), Failure> {
    let at = path.display();
    match (path.is_dir(), path.exists()) {
        (true, _) => Ok(()),
        (_, true) => Err(Failure::Usage(format!("{at} is a file; a folder is wanted"))),
        _ => Err(Failure::Usage(format!("{at} is not a folder: file not found"))),
    }
}
