//! What is known of files without reading them.

use std::time::SystemTime;

/// Size, version and age of a file or object.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stat {
    /// Size, bytes.
    pub size: u64,
    /// The store's ETag of just these bytes, without quotes; `None` for local files.
    pub etag: Option<String>,
    /// When it was last written.
    pub modified: SystemTime,
}

/// One file of a listing.
#[derive(Debug, Clone)]
pub struct Entry {
    /// Its path below the folder or prefix that was listed, with slashes on every system.
    pub key: String,
    /// Size, version and age.
    pub stat: Stat,
}
