//! Object stores: logs, bike files and tables behind `s3://`, `gs://` and `az://`.
//!
//! ```text
//! location   a path on this machine or an address in a store: what the rest of the program has
//! url        the address of an object or a prefix
//! files      reading, writing, listing, removing, whichever of the two it is
//! replace    files of this machine that are replaced whole, and those at names of our own
//! search     the files of a folder or prefix, or behind a glob pattern
//! pattern    the files behind a glob pattern
//! source     an open log: the readers need not know where it is
//! faults     what an open log did not give
//! packed     a log that was packed as a whole, unpacked
//! client     list, get, put, delete in a store, one request after the other
//! lease      a run's lock on a prefix
//! counts     how many requests were made
//! plain      what the system says of files, in plain words
//! ```
//!
//! Credentials and endpoints are taken from the environment, as each store's own tools do
//! (`AWS_ACCESS_KEY_ID`, `AWS_ENDPOINT_URL`, `GOOGLE_SERVICE_ACCOUNT`,
//! `AZURE_STORAGE_ACCOUNT_NAME`, ...). One client per bucket serves the whole process. Built
//! without the feature `cloud`, every address is an error that says so.

pub mod counts;
mod faults;
pub mod files;
pub mod lease;
pub mod location;
pub mod packed;
mod pattern;
pub mod plain;
pub mod replace;
pub mod search;
pub mod source;
pub mod stat;
pub mod url;

#[cfg(feature = "cloud")]
mod arrival;
#[cfg_attr(not(feature = "cloud"), path = "absent.rs")]
pub mod client;
#[cfg(feature = "cloud")]
mod connector;
#[cfg(feature = "cloud")]
mod errors;

pub use location::Location;
pub use stat::{Entry, Stat};
