//! What tells a log's bytes from others.

use std::fs::File;

use crate::store::objects::{Location, source};

/// BLAKE3 of a file's bytes, as hexadecimal digits; of a log in an object store the store's own
/// name for its bytes ([`source::identity`]).
///
/// # Errors
/// It cannot be read.
pub(crate) fn hash_file(file: &Location) -> std::io::Result<String> {
    let path = match file {
        Location::Remote(url) => return source::identity(url),
        Location::Local(path) => path,
    };
    if !path.is_file() {
        return Err(std::io::ErrorKind::InvalidInput.into()); // a pipe would never end
    }
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(File::open(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}
