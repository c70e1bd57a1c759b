//! Reading a bike file.

use std::path::Path;

use crate::contract::bike::{Bike, Error};
use crate::store::objects::files::read_text;

impl Bike {
    /// Reads and checks a bike file.
    ///
    /// # Errors
    /// The file cannot be read, is not TOML, or a key is missing, misspelt or out of range;
    /// the message names the key.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text =
            read_text(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        Self::parse(&text, &stem, path)
    }
}
