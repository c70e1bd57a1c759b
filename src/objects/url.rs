//! The address of an object, or of everything below a prefix: `s3://bucket/some/key`.
//!
//! Inside the program a URL travels as a [`Path`] like any other: what names files (messages, the
//! column `path`, `bike=` parts) needs no second kind of name. Keys are taken as they are
//! written: nothing in them is percent-decoded.

use std::fmt;
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};

/// Whose store it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Scheme {
    /// Amazon's S3, and whatever speaks its language.
    S3,
    /// Google Cloud Storage.
    Gs,
    /// Azure Blob Storage.
    Az,
}

impl Scheme {
    /// As it is written before `://`.
    pub fn name(self) -> &'static str {
        match self {
            Scheme::S3 => "s3",
            Scheme::Gs => "gs",
            Scheme::Az => "az",
        }
    }
}

/// An address in an object store.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Url {
    /// Whose store.
    pub scheme: Scheme,
    /// Bucket, or container.
    pub bucket: String,
    /// Key or prefix, without a slash at either end; empty for the whole bucket.
    pub key: String,
}

impl Url {
    /// The address one or more levels below.
    pub fn join(&self, below: &str) -> Url {
        let below = below.trim_matches('/');
        let key = match (self.key.is_empty(), below.is_empty()) {
            (true, _) => below.to_owned(),
            (_, true) => self.key.clone(),
            _ => format!("{}/{below}", self.key),
        };
        Url { key, ..self.clone() }
    }

    /// As the program's paths are.
    pub fn path(&self) -> PathBuf {
        PathBuf::from(self.to_string())
    }
}

impl fmt::Display for Url {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}://{}", self.scheme.name(), self.bucket)?;
        if !self.key.is_empty() {
            write!(f, "/{}", self.key)?;
        }
        Ok(())
    }
}

/// Whether it is written as a URL, of whatever kind.
pub fn is_url(path: &Path) -> bool {
    let text = path.to_string_lossy();
    text.split_once("://").is_some_and(|(scheme, _)| {
        !scheme.is_empty() && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'+')
    })
}

/// The address, where it is one in an object store; `None` for a local path.
///
/// # Errors
/// It is a URL, but none that can be used; the message says why.
pub fn parse(path: &Path) -> Result<Option<Url>> {
    if !is_url(path) {
        return Ok(None);
    }
    let text = path.to_string_lossy().replace('\\', "/");
    let bad = |why: &str| Error::new(ErrorKind::InvalidInput, format!("{text}: {why}"));
    let (scheme, rest) = text.split_once("://").unwrap_or_default();
    let scheme = match scheme.to_ascii_lowercase().as_str() {
        "s3" | "s3a" => Scheme::S3,
        "gs" => Scheme::Gs,
        "az" => Scheme::Az,
        "file" => return Err(bad("a file:// URL has three slashes and an absolute path")),
        other => {
            let why = format!("cannot read `{other}` URLs; s3://, gs://, az:// and file:// can be");
            return Err(bad(&why));
        }
    };
    let (bucket, key) = rest.split_once('/').unwrap_or((rest, ""));
    if bucket.is_empty() {
        return Err(bad("the bucket is missing; write BUCKET/KEY after the two slashes"));
    }
    let key = key.trim_matches('/');
    if key.split('/').any(|part| part == "." || part == "..") || key.contains("//") {
        return Err(bad("a key may have no empty, `.` or `..` parts"));
    }
    Ok(Some(Url { scheme, bucket: bucket.to_owned(), key: key.to_owned() }))
}

/// `file:///some/where` as the path that it is; anything else stays.
pub fn plain(path: &Path) -> PathBuf {
    let text = path.to_string_lossy();
    let local =
        text.strip_prefix("file://").map(|rest| rest.strip_prefix("localhost").unwrap_or(rest));
    match local {
        Some(local) if local.starts_with('/') => PathBuf::from(local),
        _ => path.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Option<Url>> {
        parse(Path::new(text))
    }

    #[test]
    fn addresses() {
        let url = parsed("s3://b/a/bike=x/1 %20.csv/").expect("fine").expect("url");
        assert_eq!((url.scheme, &*url.bucket, &*url.key), (Scheme::S3, "b", "a/bike=x/1 %20.csv"));
        assert_eq!(url.to_string(), "s3://b/a/bike=x/1 %20.csv");
        let root = parsed("gs://b").expect("fine").expect("url");
        assert_eq!(root.to_string(), "gs://b");
        assert_eq!(root.join("x/y").to_string(), "gs://b/x/y");
        assert_eq!(root.join("x").join("").join("y").path(), Path::new("gs://b/x/y"));
        // as a path it can be joined too
        let joined = root.path().join("bikes").join("a.toml");
        assert_eq!(parse(&joined).expect("fine").expect("url").key, "bikes/a.toml");
        for local in ["a/b.csv", "/x", "C:\\x", "a:b", "://x"] {
            assert!(parsed(local).expect("fine").is_none(), "{local}");
        }
    }

    #[test]
    fn bad_addresses_say_why() {
        for (text, word) in [
            ("s3://", "bucket"),
            ("s3:///key", "bucket"),
            ("http://b/k", "`http`"),
            ("s3://b/../k", "`..`"),
            ("s3://b/a//k", "empty"),
            ("file://b/k", "three slashes"),
        ] {
            let e = parsed(text).expect_err(text).to_string();
            assert!(e.contains(word) && e.contains(text), "{e}");
        }
    }

    #[test]
    fn file_urls_are_paths() {
        assert_eq!(plain(Path::new("file:///a/b")), Path::new("/a/b"));
        assert_eq!(plain(Path::new("file://localhost/a")), Path::new("/a"));
        assert_eq!(plain(Path::new("s3://b/a")), Path::new("s3://b/a"));
        assert_eq!(plain(Path::new("a/b")), Path::new("a/b"));
    }
}
