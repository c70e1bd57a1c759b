//! From what the user named to the list of logs: files, folders, glob patterns, and the same in an
//! object store ([`remote`]).
//!
//! A folder is searched through all its depths for files with a log's extension; anything else
//! in it (a README, bike files) is none of our business. A folder that holds `sessions/`, as an
//! archive does, is searched there only. Hidden files, our own temporaries, the folders `truth`
//! and `bikes` and the output folder are passed by. A file that was named itself is always
//! taken, whatever its extension: if it is no log, the rejection says so.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use walkdir::{DirEntry, WalkDir};

use super::store::TABLES;
use super::{Error, remote};
use crate::objects::{files, url};
use crate::pipeline::Rejection;

/// Extensions of files that are taken for logs when a folder is searched.
pub const EXTENSIONS: &[&str] =
    &["parquet", "csv", "tsv", "txt", "log", "mf4", "mdf", "mcap", "blf", "asc", "ld", "ctrk"];

/// Folders beside an archive's sessions that hold no logs.
pub(super) const NOT_LOGS: &[&str] = &["truth", "bikes"];

/// One input, or what is wrong with it before it is opened.
#[derive(Debug, Clone)]
pub struct Found {
    /// As it was named, or below the folder that was named.
    pub path: PathBuf,
    /// Why it cannot be an input.
    pub problem: Option<Rejection>,
}

/// Every log behind the inputs, sorted by path, each file once.
///
/// # Errors
/// There is no log at all, or logs and output are mixed up.
pub fn discover(inputs: &[PathBuf], out: &Path) -> Result<Vec<Found>, Error> {
    let out = absolute(out);
    let mut found = Vec::new();
    for input in inputs {
        let text = input.to_string_lossy();
        if let Some(url) = url::parse(input).map_err(|e| Error::Usage(e.to_string()))? {
            remote::search(&url, &out, &mut found)?;
        } else if input.exists() {
            search(input, &out, &mut found)?;
        } else if text.contains(['*', '?', '[']) {
            expand(&text, &out, &mut found)?;
        } else {
            found.push(problem(input, "not_found", format!("{text} does not exist")));
        }
    }
    if found.iter().all(|f| f.problem.is_some()) {
        let why: Vec<&str> =
            found.iter().filter_map(|f| f.problem.as_ref()).map(|p| p.message.as_str()).collect();
        return Err(Error::Usage(format!("no logs to read: {}", why.join("; "))));
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    let mut seen = BTreeSet::new();
    found.retain(|f| seen.insert(absolute(&f.path)));
    Ok(found)
}

/// The folder of bike files that goes with the inputs, if they have one beside their sessions.
///
/// # Errors
/// Several inputs have one each.
pub fn bikes_beside(inputs: &[PathBuf]) -> Result<Option<PathBuf>, Error> {
    let mut folders = Vec::new();
    for folder in inputs.iter().map(|i| i.join("bikes")) {
        let there = match url::parse(&folder).map_err(|e| Error::Usage(e.to_string()))? {
            None => folder.is_dir(),
            // a pattern has nothing beside it
            Some(url) if url.key.contains(remote::WILD) => false,
            Some(_) => !files::list(&folder).map_err(|e| Error::Usage(e.to_string()))?.is_empty(),
        };
        if there {
            folders.push(folder);
        }
    }
    folders.sort();
    folders.dedup();
    match folders.len() {
        0 | 1 => Ok(folders.pop()),
        _ => Err(Error::Usage(format!(
            "{} and {} both hold bike files; say which with --bikes DIR",
            folders[0].display(),
            folders[1].display()
        ))),
    }
}

/// An absolute path without links, as far as it exists.
pub(super) fn absolute(path: &Path) -> PathBuf {
    if let Ok(Some(url)) = url::parse(path) {
        return url.path();
    }
    if let Ok(path) = path.canonicalize() {
        return path;
    }
    match (path.parent(), path.file_name()) {
        (Some(parent), Some(name)) => {
            let parent = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
            absolute(parent).join(name)
        }
        _ => path.to_owned(),
    }
}

pub(super) fn problem(path: &Path, code: &'static str, message: String) -> Found {
    let problem = Some(Rejection { stage: "discover", code, message });
    Found { path: path.to_owned(), problem }
}

fn expand(pattern: &str, out: &Path, found: &mut Vec<Found>) -> Result<(), Error> {
    let options =
        glob::MatchOptions { require_literal_leading_dot: true, ..glob::MatchOptions::new() };
    let paths = glob::glob_with(pattern, options)
        .map_err(|e| Error::Usage(format!("{pattern} is not a glob pattern: {e}")))?;
    let before = found.len();
    for path in paths {
        match path {
            Ok(path) => search(&path, out, found)?,
            Err(e) => found.push(problem(e.path(), "unreadable", e.to_string())),
        }
    }
    if found.len() == before {
        let message = format!("nothing matches {pattern}");
        found.push(problem(Path::new(pattern), "not_found", message));
    }
    Ok(())
}

/// One existing file or folder.
fn search(input: &Path, out: &Path, found: &mut Vec<Found>) -> Result<(), Error> {
    if input.is_file() {
        refuse_tables(input, out)?;
        found.push(Found { path: input.to_owned(), problem: None });
        return Ok(());
    }
    if !input.is_dir() {
        let message = format!("{} is neither a file nor a folder", input.display());
        found.push(problem(input, "unreadable", message));
        return Ok(());
    }
    let sessions = input.join("sessions");
    let archive = sessions.is_dir();
    let root = if archive { sessions } else { input.to_owned() };
    refuse_tables(&root, out)?;
    let place = absolute(&root);
    apart(&root, &place, archive, out)?;
    let before = found.len();
    let walk = WalkDir::new(&root).follow_links(true).sort_by_file_name();
    for entry in walk.into_iter().filter_entry(|e| wanted(e, out)) {
        match entry {
            Ok(e) if e.file_type().is_file() && is_log(e.path()) => {
                found.push(Found { path: e.into_path(), problem: None });
            }
            Ok(_) => {}
            Err(e) => {
                let path = e.path().unwrap_or(&root).to_owned();
                found.push(problem(&path, "unreadable", e.to_string()));
            }
        }
    }
    if found.len() == before {
        found.push(no_logs(&root));
    }
    Ok(())
}

pub(super) fn no_logs(root: &Path) -> Found {
    let message = format!(
        "{} holds no logs (looked for {})",
        root.display(),
        EXTENSIONS.iter().map(|e| format!("*.{e}")).collect::<Vec<_>>().join(", ")
    );
    problem(root, "no_logs", message)
}

/// The output may not lie in the folder of logs `root`, `place` in absolute terms: its tables
/// would be found as logs.
pub(super) fn apart(root: &Path, place: &Path, archive: bool, out: &Path) -> Result<(), Error> {
    let holds_sessions = archive || root.file_name().is_some_and(|n| n == "sessions");
    if out == place || (holds_sessions && out.starts_with(place)) {
        return Err(Error::Usage(format!(
            "--out {} lies in the logs' own folder {}; choose another",
            out.display(),
            root.display()
        )));
    }
    Ok(())
}

/// Inputs may not lie where our tables go: they would be taken for results, and overwritten.
pub(super) fn refuse_tables(input: &Path, out: &Path) -> Result<(), Error> {
    let place = absolute(input);
    match TABLES.iter().find(|t| place.starts_with(out.join(t))) {
        None => Ok(()),
        Some(table) => Err(Error::Usage(format!(
            "{} lies where this run would write its own tables ({}); choose another --out",
            input.display(),
            out.join(table).display()
        ))),
    }
}

fn wanted(entry: &DirEntry, out: &Path) -> bool {
    if entry.depth() == 0 {
        return true;
    }
    let name = entry.file_name().to_string_lossy();
    if name.starts_with('.') {
        return false; // hidden, and our own .roadbench-* temporaries
    }
    if !entry.file_type().is_dir() {
        return true;
    }
    !NOT_LOGS.contains(&name.as_ref()) && absolute(entry.path()) != *out
}

pub(super) fn is_log(path: &Path) -> bool {
    path.extension()
        .and_then(|e| e.to_str())
        .is_some_and(|e| EXTENSIONS.iter().any(|known| known.eq_ignore_ascii_case(e)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("temporary folder");
        for file in files {
            let path = folder.path().join(file);
            std::fs::create_dir_all(path.parent().expect("parent")).expect("folder");
            std::fs::write(path, "x").expect("file");
        }
        folder
    }

    fn names(root: &Path, found: &[Found]) -> Vec<String> {
        found
            .iter()
            .map(|f| f.path.strip_prefix(root).unwrap_or(&f.path).to_string_lossy().into_owned())
            .collect()
    }

    #[test]
    fn an_archive_gives_its_sessions_in_order() {
        let t = tree(&[
            "README.md",
            "bikes/a.toml",
            "truth/truth.parquet",
            "sessions/bike=b/2.parquet",
            "sessions/bike=a/9.PARQUET",
            "sessions/bike=a/.roadbench-x.tmp",
            "sessions/bike=a/.hidden.parquet",
            "sessions/bike=a/notes.md",
        ]);
        let found = discover(&[t.path().to_owned()], &t.path().join("out")).expect("found");
        assert_eq!(
            names(t.path(), &found),
            ["sessions/bike=a/9.PARQUET", "sessions/bike=b/2.parquet"]
        );
        assert_eq!(
            bikes_beside(&[t.path().to_owned()]).expect("one"),
            Some(t.path().join("bikes"))
        );
    }

    #[test]
    fn a_file_is_taken_once_however_it_is_named() {
        let t = tree(&["a.parquet", "b.csv", "c.xyz"]);
        let pattern = t.path().join("*.parquet");
        let dotted = t.path().join("./b.csv");
        let inputs = [t.path().to_owned(), pattern, dotted, t.path().join("c.xyz")];
        let found = discover(&inputs, &t.path().join("out")).expect("found");
        assert_eq!(names(t.path(), &found), ["a.parquet", "b.csv", "c.xyz"]);
    }

    #[test]
    fn the_output_folder_is_not_searched() {
        let t = tree(&["a.parquet", "out/coefficients/bike=a/a.parquet"]);
        let found = discover(&[t.path().to_owned()], &t.path().join("out")).expect("found");
        assert_eq!(names(t.path(), &found), ["a.parquet"]);
    }

    #[test]
    fn logs_and_output_are_kept_apart() {
        let t = tree(&["sessions/a.parquet"]);
        let sessions = t.path().join("sessions");
        for (input, out) in [
            (&sessions, t.path().to_owned()), // tables would go to <out>/sessions
            (&sessions, sessions.clone()),
            (&sessions, sessions.join("out")),
            (&sessions.join("a.parquet"), t.path().to_owned()),
            (&t.path().to_owned(), sessions.join("out")),
        ] {
            let e = discover(std::slice::from_ref(input), &out).expect_err("mixed up");
            assert!(matches!(e, Error::Usage(_)), "{input:?} {out:?}: {e}");
        }
        assert!(discover(&[sessions], &t.path().join("out")).is_ok());
    }

    #[test]
    fn what_is_missing_is_an_input_too_unless_there_is_nothing_else() {
        let t = tree(&["a.parquet", "empty/README.md"]);
        let out = t.path().join("out");
        let missing = t.path().join("b.parquet");
        let e = discover(&[missing.clone(), t.path().join("empty")], &out).expect_err("nothing");
        assert!(e.to_string().contains("b.parquet does not exist"), "{e}");
        let found = discover(&[t.path().join("a.parquet"), missing], &out).expect("found");
        assert_eq!(found.len(), 2);
        assert_eq!(found[1].problem.as_ref().map(|p| p.code), Some("not_found"));
    }

    #[cfg(unix)]
    #[test]
    fn a_loop_of_links_ends() {
        let t = tree(&["logs/a.parquet"]);
        std::os::unix::fs::symlink(t.path().join("logs"), t.path().join("logs/again"))
            .expect("link");
        let found = discover(&[t.path().join("logs")], &t.path().join("out")).expect("found");
        assert_eq!(found.iter().filter(|f| f.problem.is_none()).count(), 1);
    }
}
