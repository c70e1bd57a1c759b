//! What can go wrong with a report.

use std::path::PathBuf;

use crate::store::tables::{file, read};

/// Errors of a report.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The folder holds none of our tables.
    #[error(
        "{path} holds no `sessions`, `rejected`, `causes` or `discrepancies` tables: name the \
         folder that `roadbench run` or `roadbench diagnose` wrote with --out"
    )]
    NotAnOutput {
        /// The folder that was given.
        path: PathBuf,
    },
    /// A table, or the file of bench values, cannot be read.
    #[error(transparent)]
    Read(#[from] read::Error),
    /// The session that was asked for is not there, or several are.
    #[error("{0}")]
    NoSession(String),
    /// A page cannot be written.
    #[error(transparent)]
    Write(#[from] file::Error),
    /// A figure cannot be drawn as PNG.
    #[error("cannot draw {path}: {message}")]
    Figure {
        /// Path of the figure.
        path: PathBuf,
        /// Message of the encoder.
        message: String,
    },
    /// A template is wrong: our own mistake.
    #[error("report template: {0}")]
    Template(#[from] minijinja::Error),
    /// A page's data cannot be written as JSON: our own mistake.
    #[error("report data: {0}")]
    Data(#[from] serde_json::Error),
}
