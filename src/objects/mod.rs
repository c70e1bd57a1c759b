//! Object stores: logs, bike files and tables behind `s3://`, `gs://` and `az://`.
//!
//! ```text
//! url      what an address is, and how it travels through the program
//! client   list, get, put, delete: a plain function each, one request after the other
//! source   an open log, local or not: the readers need not know which
//! files    reading, listing, removing by path, here or there
//! lease    a run's lock on a prefix
//! counts   how many requests that took
//! ```
//!
//! Credentials and endpoints are taken from the environment, as each store's own tools do
//! (`AWS_ACCESS_KEY_ID`, `AWS_ENDPOINT_URL`, `GOOGLE_SERVICE_ACCOUNT`,
//! `AZURE_STORAGE_ACCOUNT_NAME`, ...). One client per bucket serves the whole process. Built
//! without the feature `cloud`, every address is an error that says so.

pub mod counts;
pub mod files;
pub mod lease;
pub mod source;
pub mod url;

#[cfg_attr(not(feature = "cloud"), path = "absent.rs")]
pub mod client;
#[cfg(feature = "cloud")]
mod connector;
#[cfg(feature = "cloud")]
mod words;

use std::time::SystemTime;

/// What a store tells of an object without giving it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stat {
    /// Bytes.
    pub size: u64,
    /// The store's name for just these bytes, without quotes.
    pub etag: Option<String>,
    /// When it was written.
    pub modified: SystemTime,
}

/// One object of a listing.
#[derive(Debug, Clone)]
pub struct Entry {
    /// Its key below the prefix that was listed.
    pub key: String,
    /// What is known of it.
    pub stat: Stat,
}
