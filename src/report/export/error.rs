//! Why a tyre could not be exported.

use crate::contract::bike;
use crate::contract::key_error::KeyError;
use crate::report;
use crate::tyre::tir;

/// Why a tyre could not be exported.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An option is wrong, or one more is needed.
    #[error("{0}")]
    Option(String),
    /// No session is meant, or several are.
    #[error("{0}")]
    Session(String),
    /// The session has no value of a coefficient, or none of a tyre.
    #[error("{0}")]
    NoValue(String),
    /// A table cannot be read.
    #[error(transparent)]
    Read(#[from] report::Error),
    /// The bike file cannot be used.
    #[error(transparent)]
    Bike(#[from] bike::Error),
    /// The coefficients are no tyre.
    #[error("session `{session}`: {source}")]
    Tyre {
        /// Id of the session.
        session: String,
        /// Coefficient that is missing or impossible.
        source: KeyError,
    },
    /// The fit of a property file does not come to an end.
    #[error("the property file's fit failed: {0}")]
    Fit(String),
    /// The file that was made does not read back: our own mistake.
    #[error(transparent)]
    Reading(#[from] tir::Error),
    /// TOML cannot hold it: our own mistake.
    #[error("cannot write TOML: {0}")]
    Toml(#[from] toml::ser::Error),
    /// The simulation unit cannot be packed.
    #[error("{0}")]
    Packing(String),
}
