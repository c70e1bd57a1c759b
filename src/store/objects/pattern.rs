//! The files and folders of this machine that match a glob pattern, whatever bytes their names have.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use glob::{MatchOptions, Pattern, PatternError};
use walkdir::WalkDir;

use super::location::WILD;

/// Something that matches, or what could not be searched, and why.
pub(super) type Expanded = Result<PathBuf, (PathBuf, String)>;

/// A part of a pattern between two separators.
enum Part {
    /// No wildcard in it.
    Name(String),
    Some(Pattern),
    /// `**`: folders, as deep as there are any.
    Deep,
}

/// All that matches, in order of path. A wildcard takes no leading dot.
///
/// # Errors
/// It is no glob pattern.
pub(super) fn expand(pattern: &str) -> Result<Vec<Expanded>, PatternError> {
    Pattern::new(pattern)?;
    let wild = pattern.find(WILD).unwrap_or(pattern.len());
    let base = pattern[..wild].rfind(std::path::is_separator).map_or(0, |at| at + 1);
    let words = pattern[base..].split(std::path::is_separator).filter(|w| !w.is_empty());
    let parts = words
        .map(|word| match word {
            "**" => Ok(Part::Deep),
            word if word.contains(WILD) => Pattern::new(word).map(Part::Some),
            word => Ok(Part::Name(word.to_owned())),
        })
        .collect::<Result<Vec<Part>, _>>()?;
    let mut found = Vec::new();
    // without the separator after it
    let base: PathBuf = Path::new(&pattern[..base]).components().collect();
    below(&base, &parts, &mut found);
    if pattern.ends_with(std::path::is_separator) {
        found.retain(|one| one.as_ref().map_or(true, |path| path.is_dir()));
    }
    // several ways may lead to one place
    found.sort();
    found.dedup();
    Ok(found)
}

/// Matches of the parts below a folder.
fn below(folder: &Path, parts: &[Part], found: &mut Vec<Expanded>) {
    let cannot = |path: &Path, why: String| Err((path.to_owned(), why));
    let Some((first, rest)) = parts.split_first() else {
        found.push(Ok(folder.to_owned()));
        return;
    };
    // the folder that one is in has no name
    let place = if folder == Path::new("") { Path::new(".") } else { folder };
    match first {
        Part::Name(name) => {
            let path = folder.join(name);
            match std::fs::symlink_metadata(&path) {
                Ok(_) => below(&path, rest, found),
                Err(e) if is_nothing(&e) => {}
                Err(e) => found.push(cannot(&path, format!("cannot look at it: {e}"))),
            }
        }
        Part::Some(pattern) => {
            let options = MatchOptions { require_literal_leading_dot: true, ..MatchOptions::new() };
            let entries = match std::fs::read_dir(place) {
                Ok(entries) => entries,
                Err(e) if is_nothing(&e) => return,
                Err(e) => return found.push(cannot(place, format!("cannot be searched: {e}"))),
            };
            for entry in entries {
                match entry {
                    Err(e) => found.push(cannot(place, format!("cannot be searched: {e}"))),
                    // a letter that is none matches as one that is
                    Ok(entry) => {
                        let name = entry.file_name();
                        if pattern.matches_with(&name.to_string_lossy(), options) {
                            below(&folder.join(name), rest, found);
                        }
                    }
                }
            }
        }
        // after it comes nothing: a folder is searched through all its depths anyway
        Part::Deep if rest.is_empty() => {
            if place.is_dir() {
                found.push(Ok(place.to_owned()));
            }
        }
        Part::Deep => {
            let is_hidden = |e: &walkdir::DirEntry| {
                e.depth() > 0 && e.file_name().to_string_lossy().starts_with('.')
            };
            let walk = WalkDir::new(place).follow_links(true).into_iter();
            for entry in walk.filter_entry(|e| e.file_type().is_dir() && !is_hidden(e)) {
                match entry {
                    Ok(entry) => {
                        let path = match entry.path().strip_prefix(place) {
                            Ok(within) => folder.join(within),
                            Err(_) => entry.into_path(),
                        };
                        below(&path, rest, found);
                    }
                    Err(e) if e.io_error().is_some_and(is_nothing) => {}
                    Err(e) => {
                        let path = e.path().unwrap_or(place).to_owned();
                        found.push(Err((path, format!("cannot be searched: {e}"))));
                    }
                }
            }
        }
    }
}

fn is_nothing(e: &std::io::Error) -> bool {
    matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_matches_is_found_as_it_is_written() {
        let folder = tempfile::tempdir().expect("folder");
        for file in ["a/1.csv", "a/.x.csv", "a/b/2.csv", "a/b/c/3.csv", "d/4.csv", "5.csv"] {
            let path = folder.path().join(file);
            std::fs::create_dir_all(path.parent().expect("below")).expect("folder");
            std::fs::write(path, "x").expect("written");
        }
        let root = folder.path().display().to_string();
        let found = |pattern: &str| -> Vec<String> {
            let all = expand(&format!("{root}/{pattern}")).expect("a pattern").into_iter();
            let path = |one: Expanded| one.expect("readable").display().to_string();
            all.map(|one| path(one).trim_start_matches(&root)[1..].to_owned()).collect()
        };
        assert_eq!(found("*.csv"), ["5.csv"]);
        assert_eq!(found("*/*.csv"), ["a/1.csv", "d/4.csv"]);
        assert_eq!(found("[ab]/b/?.csv"), ["a/b/2.csv"]);
        let deep = ["5.csv", "a/1.csv", "a/b/2.csv", "a/b/c/3.csv", "d/4.csv"];
        assert_eq!(found("**/*.csv"), deep);
        assert_eq!(found("a/**"), ["a"]);
        assert_eq!(found("*/"), ["a", "d"]);
        assert_eq!(found("*/b"), ["a/b"]);
        assert_eq!(found("*/none"), [""; 0]);
        assert_eq!(found("none/*"), [""; 0]);
        assert!(expand("a[").is_err() && expand("a/***").is_err());
    }

    /// What a foreign machine wrote has names in another encoding.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_name_that_is_no_text_matches_too() {
        use std::os::unix::ffi::OsStrExt;
        let folder = tempfile::tempdir().expect("folder");
        let name = std::ffi::OsStr::from_bytes(b"f\xfcr.csv");
        std::fs::write(folder.path().join(name), "x").expect("written");
        std::fs::write(folder.path().join("plain.csv"), "x").expect("written");
        let found = expand(&format!("{}/*.csv", folder.path().display())).expect("a pattern");
        assert_eq!(found, [Ok(folder.path().join(name)), Ok(folder.path().join("plain.csv"))]);
    }
}
