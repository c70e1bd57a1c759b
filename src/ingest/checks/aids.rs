//! What a log cannot be understood without and does not hold itself.

use std::path::{Path, PathBuf};

use crate::contract::file_error::{FileError, FileName};

/// CAN databases; a channel map or the command line names them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Aids {
    /// Texts of CAN databases (DBC).
    pub dbc: Vec<String>,
    /// Their names, for people.
    pub names: Vec<String>,
}

impl Aids {
    /// Reads the files.
    ///
    /// # Errors
    /// Error text that names the file.
    pub fn read(dbc: &[PathBuf]) -> Result<Self, FileError> {
        let names = dbc.iter().map(|path| path.display().to_string()).collect();
        let dbc = dbc.iter().map(|path| read_dbc(path)).collect::<Result<_, FileError>>()?;
        Ok(Aids { dbc, names })
    }
}

/// The text of a CAN database. Old ones are not UTF-8; their names and numbers are plain ASCII.
///
/// # Errors
/// Error text that names the file.
pub(crate) fn read_dbc(path: &Path) -> Result<String, FileError> {
    let bytes = std::fs::read(path).map_err(|e| FileName::new("DBC", path.display()).unread(e))?;
    Ok(match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(e) => e.into_bytes().into_iter().map(char::from).collect(),
    })
}
