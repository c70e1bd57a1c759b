//! Why a file that a user writes cannot be used.

use std::error::Error;
use std::fmt;

/// Why a file that a user writes cannot be used: the message names the file and, where it was read, the key.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// It is not there, or cannot be read.
    #[error("cannot read {file}: {source}{remedy}")]
    Read {
        /// Kind and path of the file.
        file: FileName,
        /// Error of the operating system.
        source: std::io::Error,
        /// Other possible inputs; may be empty.
        remedy: String,
    },
    /// Something in it is wrong.
    #[error("{file}: {source}")]
    Content {
        /// Kind and path of the file.
        file: FileName,
        /// Error: a [`KeyError`](super::key_error::KeyError), the parser's word, or a sentence.
        source: Box<dyn Error + Send + Sync>,
    },
    /// There is no such file, and nothing built in has the name.
    #[error("{0}")]
    Unknown(String),
}

/// A file in messages: its kind, and its path as the user gave it.
#[derive(Debug, Clone)]
pub struct FileName {
    kind: &'static str,
    name: String,
}

impl FileName {
    /// Of a kind, such as `scenario`.
    pub(crate) fn new(kind: &'static str, name: impl fmt::Display) -> Self {
        FileName { kind, name: name.to_string() }
    }

    /// Something in it is wrong.
    pub(crate) fn wrong(&self, source: impl Into<Box<dyn Error + Send + Sync>>) -> FileError {
        FileError::Content { file: self.clone(), source: source.into() }
    }

    /// It cannot be read.
    pub(crate) fn unread(&self, source: std::io::Error) -> FileError {
        FileError::Read { file: self.clone(), source, remedy: String::new() }
    }
}

impl fmt::Display for FileName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.kind, self.name)
    }
}

impl From<FileError> for String {
    fn from(e: FileError) -> Self {
        e.to_string()
    }
}
