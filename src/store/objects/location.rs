//! Where a file or folder is: a path on this machine, or an address in an object store.
//!
//! What a user names is parsed once, at the edge of the program ([`Location::parse`]); from there
//! on the type tells the two apart.

use std::borrow::Cow;
use std::cmp::Ordering;
use std::ffi::OsStr;
use std::fmt;
use std::io::Result;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize, Serializer, de, ser};

use super::url::{Url, is_url};

/// Endings of the names of logs that are packed as a whole.
const PACKED: [&str; 2] = ["gz", "zst"];

/// Characters that make a name a glob pattern.
pub(super) const WILD: [char; 3] = ['*', '?', '['];

/// A file or folder, local or in an object store.
///
/// Sorted by path components, addresses in object stores like the paths that they look like.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Location {
    /// On this machine.
    Local(PathBuf),
    /// In an object store: an object, or all that lies below a prefix.
    Remote(Url),
}

impl Location {
    /// From what a user wrote: `s3://`, `gs://` and `az://` are object stores, `file:///some/path`
    /// and everything that is no URL is a local path.
    ///
    /// # Errors
    /// `InvalidInput`: a URL that cannot be used; the message says why.
    pub fn parse(text: impl AsRef<OsStr>) -> Result<Self> {
        let given = text.as_ref();
        let text = given.to_string_lossy();
        let local = text
            .strip_prefix("file://")
            .map(|rest| rest.strip_prefix("localhost").unwrap_or(rest))
            .filter(|path| path.starts_with('/'));
        match local {
            Some(path) => Ok(Self::Local(path.into())),
            None if is_url(&text) => Url::parse(&text).map(Self::Remote),
            None => Ok(Self::Local(given.into())),
        }
    }

    /// Whether it is in an object store.
    pub fn is_remote(&self) -> bool {
        matches!(self, Self::Remote(_))
    }

    /// The local path, if it is one.
    pub fn as_path(&self) -> Option<&Path> {
        match self {
            Self::Local(path) => Some(path),
            Self::Remote(_) => None,
        }
    }

    /// The address in an object store, if it is one.
    pub fn as_url(&self) -> Option<&Url> {
        match self {
            Self::Local(_) => None,
            Self::Remote(url) => Some(url),
        }
    }

    /// A file or folder below this one; `below` has slashes between its parts.
    #[must_use]
    pub fn join(&self, below: impl AsRef<str>) -> Self {
        let below = below.as_ref();
        match self {
            Self::Local(path) => Self::Local(path.join(below)),
            Self::Remote(url) => Self::Remote(url.join(below)),
        }
    }

    /// The folder or prefix that it lies in; `None` for a root, a whole bucket and the empty path.
    pub fn parent(&self) -> Option<Self> {
        match self {
            Self::Local(path) => path.parent().map(|p| Self::Local(p.to_owned())),
            Self::Remote(url) if url.key.is_empty() => None,
            Self::Remote(url) => {
                let key = url.key.rsplit_once('/').map_or("", |(folders, _)| folders);
                Some(Self::Remote(Url { key: key.to_owned(), ..url.clone() }))
            }
        }
    }

    /// The names of the folders that it lies in, outermost first.
    pub fn folders(&self) -> Vec<Cow<'_, str>> {
        match self {
            Self::Local(path) => path
                .parent()
                .into_iter()
                .flat_map(Path::components)
                .map(|part| part.as_os_str().to_string_lossy())
                .collect(),
            Self::Remote(url) => {
                let folders = url.key.rsplit_once('/').map_or("", |(folders, _)| folders);
                folders.split('/').filter(|part| !part.is_empty()).map(Cow::from).collect()
            }
        }
    }

    /// Its last part as a path: keys have names, stems and extensions as paths do.
    fn last(&self) -> &Path {
        match self {
            Self::Local(path) => path,
            Self::Remote(url) => Path::new(&url.key),
        }
    }

    /// The name without the folders; empty where there is none, as of a whole bucket.
    pub fn file_name(&self) -> Cow<'_, str> {
        self.last().file_name().unwrap_or_default().to_string_lossy()
    }

    /// The name without folders and extension (of a packed log, `ride.csv.gz`, without both); empty where there is
    /// none.
    pub fn file_stem(&self) -> Cow<'_, str> {
        self.unpacked_name().file_stem().unwrap_or_default().to_string_lossy()
    }

    /// Whether it is a packed log by its name.
    pub fn is_packed(&self) -> bool {
        PACKED.iter().any(|ending| self.is_named(ending))
    }

    /// Whether the name ends so (without the dot), in whatever case; what is packed is not looked through.
    pub fn is_named(&self, ending: &str) -> bool {
        self.last().extension().is_some_and(|e| e.eq_ignore_ascii_case(ending))
    }

    /// The last part without the ending that says how it is packed.
    fn unpacked_name(&self) -> &Path {
        let last = self.last();
        if self.is_packed() { Path::new(last.file_stem().unwrap_or_default()) } else { last }
    }

    /// Whether the name has this extension (without the dot), in whatever case; of a packed log that of what is in it.
    pub fn has_extension(&self, extension: &str) -> bool {
        self.unpacked_name().extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
    }

    /// Whether it is `folder` or lies in it, by the names alone.
    pub fn starts_with(&self, folder: &Self) -> bool {
        match (self, folder) {
            (Self::Local(path), Self::Local(folder)) => path.starts_with(folder),
            (Self::Remote(url), Self::Remote(folder)) => {
                let bucket = |u: &Url| (u.scheme, u.bucket.clone());
                let below = url.key.strip_prefix(&folder.key);
                bucket(url) == bucket(folder)
                    && below.is_some_and(|below| {
                        folder.key.is_empty() || below.is_empty() || below.starts_with('/')
                    })
            }
            _ => false,
        }
    }

    /// An absolute location, without links as far as it exists.
    #[must_use]
    pub fn absolute(&self) -> Self {
        fn absolute(path: &Path) -> PathBuf {
            if let Ok(path) = path.canonicalize() {
                return path;
            }
            match (path.parent(), path.file_name()) {
                (Some(parent), Some(name)) => {
                    let empty = parent.as_os_str().is_empty();
                    absolute(if empty { Path::new(".") } else { parent }).join(name)
                }
                _ => path.to_owned(),
            }
        }
        match self {
            Self::Local(path) => Self::Local(absolute(path)),
            Self::Remote(_) => self.clone(),
        }
    }

    /// Whether it is written like a glob pattern: it has `*`, `?` or `[` in it.
    pub fn is_pattern(&self) -> bool {
        match self {
            Self::Local(path) => path.to_string_lossy().contains(WILD),
            Self::Remote(url) => url.key.contains(WILD),
        }
    }
}

/// The part of a pattern that has no wildcard in it, cut back to whole folders.
pub(super) fn fixed_part(pattern: &str) -> &str {
    let literal = pattern.split(WILD).next().unwrap_or_default();
    literal.rsplit_once('/').map_or("", |(folders, _)| folders)
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Local(path) => path.display().fmt(f),
            Self::Remote(url) => url.fmt(f),
        }
    }
}

impl Ord for Location {
    fn cmp(&self, other: &Self) -> Ordering {
        let path = |at: &Self| match at {
            Self::Local(path) => path.clone(),
            Self::Remote(url) => PathBuf::from(url.to_string()),
        };
        match (self, other) {
            (Self::Local(a), Self::Local(b)) => a.cmp(b),
            _ => path(self).cmp(&path(other)),
        }
    }
}

impl PartialOrd for Location {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl From<&Location> for Location {
    fn from(location: &Location) -> Self {
        location.clone()
    }
}

impl From<Url> for Location {
    fn from(url: Url) -> Self {
        Self::Remote(url)
    }
}

/// A local path, whatever it looks like: [`Location::parse`] is what reads URLs.
impl From<PathBuf> for Location {
    fn from(path: PathBuf) -> Self {
        Self::Local(path)
    }
}

/// As from a [`PathBuf`].
impl From<&PathBuf> for Location {
    fn from(path: &PathBuf) -> Self {
        Self::Local(path.clone())
    }
}

/// As from a [`PathBuf`].
impl From<&Path> for Location {
    fn from(path: &Path) -> Self {
        Self::Local(path.to_owned())
    }
}

impl Serialize for Location {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let text = match self {
            Self::Local(path) => path.to_str().map(Cow::from),
            Self::Remote(url) => Some(Cow::from(url.to_string())),
        };
        let text = text.ok_or_else(|| ser::Error::custom("a path is not valid UTF-8"))?;
        serializer.serialize_str(&text)
    }
}

impl<'de> Deserialize<'de> for Location {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        Self::parse(String::deserialize(deserializer)?).map_err(de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(text: &str) -> Location {
        Location::parse(text).expect(text)
    }

    #[test]
    fn paths_and_addresses_are_told_apart() {
        for local in ["a/b.csv", "/x", "C:\\x", "a:b", "://x"] {
            assert_eq!(at(local), Location::Local(local.into()), "{local}");
        }
        assert!(at("s3://b/a").is_remote());
        assert_eq!(at("file:///a/b"), Location::Local("/a/b".into()));
        assert_eq!(at("file://localhost/a"), Location::Local("/a".into()));
        for bad in ["http://b/k", "file://b/k", "s3://"] {
            assert!(Location::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn both_kinds_have_the_same_parts() {
        for root in ["/data", "s3://data"] {
            let folder = at(root).join("sessions/bike=a");
            let log = folder.join("ride 1.CSV");
            assert_eq!(log.to_string(), format!("{root}/sessions/bike=a/ride 1.CSV"));
            assert_eq!((&*log.file_name(), &*log.file_stem()), ("ride 1.CSV", "ride 1"));
            assert!(log.has_extension("csv") && !folder.has_extension("csv"));
            let packed = at(root).join("sessions/ride.1.csv.GZ");
            assert!(packed.is_packed() && packed.has_extension("csv") && !log.is_packed());
            assert_eq!((&*packed.file_name(), &*packed.file_stem()), ("ride.1.csv.GZ", "ride.1"));
            assert!(log.folders().ends_with(&["sessions".into(), "bike=a".into()]));
            assert_eq!(log.parent().as_ref(), Some(&folder));
            assert!(log.starts_with(&folder) && log.starts_with(&at(root)));
            assert!(!at(root).join("sessions2").starts_with(&at(root).join("sessions")));
            assert!(!log.is_pattern() && folder.join("*.csv").is_pattern());
        }
        assert_eq!(at("s3://data").parent(), None);
        assert_eq!(at("s3://data").file_name(), "");
        assert!(!at("s3://data/a").starts_with(&at("gs://data")));
    }

    #[test]
    fn the_order_is_that_of_path_components() {
        for root in ["", "s3://b/"] {
            let [a, b] = ["a/b", "a-1/b"].map(|key| at(&format!("{root}{key}")));
            assert!(a < b, "{a} {b}");
        }
        assert!(at("s3://b") < at("t") && at("r") < at("s3://b"));
    }

    #[test]
    fn as_text_and_back() {
        for text in ["a/b c", "gs://bucket/key"] {
            let json = serde_json::to_string(&at(text)).expect("json");
            assert_eq!(json, format!("{text:?}"));
            assert_eq!(serde_json::from_str::<Location>(&json).expect("location"), at(text));
        }
        assert!(serde_json::from_str::<Location>("\"http://x/y\"").is_err());
    }
}
