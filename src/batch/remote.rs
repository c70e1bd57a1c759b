//! Logs in object stores: prefixes and glob patterns, found by the rules that hold for folders.

use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::Path;

use super::Error;
use super::discover::{Found, NOT_LOGS, apart, is_log, no_logs, problem, refuse_tables};
use crate::objects::url::Url;
use crate::objects::{Entry, client, source};

/// Characters that make a key a pattern.
pub(super) const WILD: [char; 3] = ['*', '?', '['];

/// Every log behind an address: an object, what lies below a prefix, or what a pattern matches.
///
/// # Errors
/// The store cannot be asked, or logs and output are mixed up.
pub fn search(url: &Url, out: &Path, found: &mut Vec<Found>) -> Result<(), Error> {
    if url.key.contains(WILD) {
        return expand(url, out, found);
    }
    if is_log(Path::new(&url.key)) && object(url, out, found)? {
        return Ok(());
    }
    let entries = client::list(url).map_err(|e| Error::Usage(e.to_string()))?;
    if !entries.is_empty() {
        return folder(url, entries, out, found);
    }
    if url.key.is_empty() || is_log(Path::new(&url.key)) || !object(url, out, found)? {
        let message = format!("{url} does not exist");
        found.push(problem(&url.path(), "not_found", message));
    }
    Ok(())
}

/// Whether there is just that object; it was named itself and is taken, whatever it is.
fn object(url: &Url, out: &Path, found: &mut Vec<Found>) -> Result<bool, Error> {
    match client::stat(url) {
        Ok(stat) => {
            refuse_tables(&url.path(), out)?;
            take(url.clone(), stat, found);
            Ok(true)
        }
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(false),
        Err(e) => Err(Error::Usage(e.to_string())),
    }
}

fn take(url: Url, stat: crate::objects::Stat, found: &mut Vec<Found>) {
    found.push(Found { path: url.path(), problem: None });
    source::remember(url, stat);
}

/// What lies below a prefix, as [`super::discover`] has it for a folder.
fn folder(
    prefix: &Url,
    mut entries: Vec<Entry>,
    out: &Path,
    found: &mut Vec<Found>,
) -> Result<(), Error> {
    let mut root = prefix.clone();
    let archive = entries.iter().any(|e| e.key.starts_with("sessions/"));
    if archive {
        root = prefix.join("sessions");
        entries.retain_mut(|e| match e.key.strip_prefix("sessions/") {
            Some(below) => {
                e.key = below.to_owned();
                true
            }
            None => false,
        });
    }
    refuse_tables(&root.path(), out)?;
    apart(&root.path(), &root.path(), archive, out)?;
    let before = found.len();
    for Entry { key, stat } in entries {
        let url = root.join(&key);
        if wanted(&key) && !url.path().starts_with(out) {
            take(url, stat, found);
        }
    }
    if found.len() == before {
        found.push(no_logs(&root.path()));
    }
    Ok(())
}

/// Whether a key below a prefix is a log's: no part of it hidden or a folder without logs.
fn wanted(key: &str) -> bool {
    let (folders, name) = key.rsplit_once('/').unwrap_or(("", key));
    let passed_by = |part: &str| part.starts_with('.') || NOT_LOGS.contains(&part);
    !folders.split('/').any(passed_by) && !name.starts_with('.') && is_log(Path::new(name))
}

/// What a pattern matches: objects, and prefixes, which are searched like folders.
fn expand(pattern: &Url, out: &Path, found: &mut Vec<Found>) -> Result<(), Error> {
    let options = glob::MatchOptions {
        require_literal_leading_dot: true,
        require_literal_separator: true,
        ..glob::MatchOptions::new()
    };
    let compiled = glob::Pattern::new(&pattern.key)
        .map_err(|e| Error::Usage(format!("{pattern} is not a glob pattern: {e}")))?;
    let literal = pattern.key.split(WILD).next().unwrap_or_default();
    let base = literal.rsplit_once('/').map_or("", |(base, _)| base);
    let base = Url { key: base.to_owned(), ..pattern.clone() };
    let entries = client::list(&base).map_err(|e| Error::Usage(e.to_string()))?;
    let before = found.len();
    let mut folders = BTreeSet::new();
    for Entry { key, stat } in entries {
        let url = base.join(&key);
        // the outermost level that the pattern matches is what was meant
        let ends = url.key.match_indices('/').map(|(at, _)| at);
        match ends.map(|at| &url.key[..at]).find(|k| compiled.matches_with(k, options)) {
            Some(folder) => {
                folders.insert(folder.to_owned());
            }
            None if compiled.matches_with(&url.key, options) => {
                refuse_tables(&url.path(), out)?;
                take(url, stat, found);
            }
            None => {}
        }
    }
    for key in folders {
        let prefix = Url { key, ..pattern.clone() };
        let entries = client::list(&prefix).map_err(|e| Error::Usage(e.to_string()))?;
        folder(&prefix, entries, out, found)?;
    }
    if found.len() == before {
        let message = format!("nothing matches {pattern}");
        found.push(problem(&pattern.path(), "not_found", message));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rules_of_folders_hold_for_keys() {
        for (key, taken) in [
            ("bike=a/1.parquet", true),
            ("1.CSV", true),
            ("notes.md", false),
            (".hidden.csv", false),
            ("truth/truth.parquet", false),
            ("a/bikes/x.csv", false),
            ("a/.roadbench/x.csv", false),
            ("a/bikes.csv", true),
        ] {
            assert_eq!(wanted(key), taken, "{key}");
        }
    }
}
