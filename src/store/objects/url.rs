//! The address of an object, or of everything below a prefix: `s3://bucket/some/key`.
//!
//! Keys are taken as they are written: nothing in them is percent-decoded.

use std::fmt;
use std::io::{Error, ErrorKind, Result};

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
    /// Kind of the store.
    pub scheme: Scheme,
    /// Bucket, or container.
    pub bucket: String,
    /// Key or prefix, without a slash at either end; empty for the whole bucket.
    pub key: String,
}

impl Url {
    /// From `SCHEME://BUCKET/KEY`.
    ///
    /// # Errors
    /// `InvalidInput`: no address in an object store; the message says why.
    pub fn parse(text: &str) -> Result<Self> {
        let text = text.replace('\\', "/");
        let bad = |why: &str| Error::new(ErrorKind::InvalidInput, format!("{text}: {why}"));
        let (scheme, rest) = text.split_once("://").ok_or_else(|| bad("not a URL"))?;
        let scheme = match scheme.to_ascii_lowercase().as_str() {
            "s3" | "s3a" => Scheme::S3,
            "gs" => Scheme::Gs,
            "az" => Scheme::Az,
            "file" => return Err(bad("a file:// URL has three slashes and an absolute path")),
            other => {
                return Err(bad(&format!(
                    "cannot read `{other}` URLs; s3://, gs://, az:// and file:// can be"
                )));
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
        Ok(Url { scheme, bucket: bucket.to_owned(), key: key.to_owned() })
    }

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
pub(super) fn is_url(text: &str) -> bool {
    text.split_once("://").is_some_and(|(scheme, _)| {
        !scheme.is_empty() && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'+')
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses() {
        let url = Url::parse("s3://b/a/bike=x/1 %20.csv/").expect("url");
        assert_eq!((url.scheme, &*url.bucket, &*url.key), (Scheme::S3, "b", "a/bike=x/1 %20.csv"));
        assert_eq!(url.to_string(), "s3://b/a/bike=x/1 %20.csv");
        let root = Url::parse("gs://b").expect("url");
        assert_eq!(root.to_string(), "gs://b");
        assert_eq!(root.join("x/y").to_string(), "gs://b/x/y");
        assert_eq!(root.join("x").join("").join("y").to_string(), "gs://b/x/y");
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
            let e = Url::parse(text).expect_err(text).to_string();
            assert!(e.contains(word) && e.contains(text), "{e}");
        }
    }
}
