//! Why nothing could be simulated.

use crate::contract::file_error::FileError;
use crate::contract::key_error::KeyError;
use crate::simulate::multibody::description;
use crate::{contract, ingest, store, tyre};

/// Why nothing could be simulated.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scenario cannot be read, or something in it is wrong.
    #[error(transparent)]
    File(#[from] FileError),
    /// A number or name is wrong.
    #[error(transparent)]
    Key(#[from] KeyError),
    /// The bike file that would go with it is wrong.
    #[error(transparent)]
    Bike(#[from] contract::bike::Error),
    /// The motorcycle is wrong.
    #[error(transparent)]
    Motorcycle(#[from] description::Error),
    /// A tyre is wrong.
    #[error(transparent)]
    Tyre(#[from] tyre::tir::Error),
    /// The log cannot be cleaned.
    #[error(transparent)]
    Ingest(#[from] ingest::Error),
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] store::tables::file::Error),
    /// The motorcycle cannot stand, or cannot be ridden as planned.
    #[error("{0}")]
    Ride(String),
}

impl From<String> for Error {
    fn from(sentence: String) -> Self {
        Error::Ride(sentence)
    }
}

impl From<Error> for String {
    fn from(e: Error) -> Self {
        e.to_string()
    }
}
