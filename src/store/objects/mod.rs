//! Object stores: logs, bike files and tables behind `s3://`, `gs://` and `az://`.
//!
//! ```text
//! location   a path on this machine or an address in a store: what the rest of the program has
//! url        the address of an object or a prefix
//! files      reading, writing, listing, removing, whichever of the two it is
//! replace    files of this machine that are replaced whole, and those at names of our own
//! search     the files of a folder or prefix, or those that match a glob pattern
//! pattern    the files that match a glob pattern
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

pub(crate) mod counts;
pub(crate) mod faults;
pub(crate) mod files;
pub(crate) mod lease;
pub(crate) mod location;
pub(crate) mod packed;
mod pattern;
pub(crate) mod plain;
pub(crate) mod replace;
pub(crate) mod search;
pub(crate) mod source;
pub(crate) mod stat;
pub(crate) mod url;

#[cfg(feature = "cloud")]
mod arrival;
#[cfg_attr(not(feature = "cloud"), path = "absent.rs")]
pub(crate) mod client;
#[cfg(feature = "cloud")]
mod connector;
#[cfg(feature = "cloud")]
mod errors;

pub(crate) use location::Location;
pub(crate) use stat::Stat;
