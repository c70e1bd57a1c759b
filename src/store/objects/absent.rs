//! In place of the client where roadbench was built without the feature `cloud`: every request is
//! an error that says so.

use std::io::{Error, ErrorKind, Result};
use std::ops::Range;

use bytes::Bytes;

use super::stat::{Entry, Stat};
use super::url::Url;

fn absent<T>(url: &Url) -> Result<T> {
    let message = format!(
        "{url}: this roadbench was built without the feature `cloud` and cannot reach object \
         stores; build it with `--features cloud`, or copy the files to a folder"
    );
    Err(Error::new(ErrorKind::Unsupported, message))
}

/// An error.
///
/// # Errors
/// Always.
pub fn stat(url: &Url) -> Result<Stat> {
    absent(url)
}

/// An error.
///
/// # Errors
/// Always.
pub fn list(prefix: &Url) -> Result<Vec<Entry>> {
    absent(prefix)
}

/// An error.
///
/// # Errors
/// Always.
pub fn get(url: &Url) -> Result<Bytes> {
    absent(url)
}

/// Errors.
///
/// # Errors
/// Each.
pub fn get_many(urls: &[Url]) -> Vec<Result<Bytes>> {
    urls.iter().map(absent).collect()
}

/// An error.
///
/// # Errors
/// Always.
pub fn get_version(url: &Url, _: Option<&str>) -> Result<Bytes> {
    absent(url)
}

/// No object is.
pub fn should_be_whole(_: &Stat) -> bool {
    false
}

/// An error.
///
/// # Errors
/// Always.
pub fn get_ranges(url: &Url, _: Option<&str>, _: &[Range<u64>]) -> Result<Vec<(u64, Bytes)>> {
    absent(url)
}

/// An error.
///
/// # Errors
/// Always.
pub fn put(url: &Url, _: &[u8]) -> Result<()> {
    absent(url)
}

/// An error.
///
/// # Errors
/// Always.
pub fn put_if(url: &Url, _: &[u8], _: Option<&str>) -> Result<Option<String>> {
    absent(url)
}

/// An error.
///
/// # Errors
/// Always.
pub fn delete(url: &Url) -> Result<()> {
    absent(url)
}

/// An error, unless there is nothing to remove.
///
/// # Errors
/// Where anything is to be removed.
pub fn delete_many(urls: &[Url]) -> Result<()> {
    urls.first().map_or(Ok(()), absent)
}
