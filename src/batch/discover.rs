//! The list of logs from the user's inputs: files, folders, glob patterns, here or in an object store.
//!
//! A folder is searched at all depths for files with a log's extension; other files (a README, bike files) are ignored.
//! A folder with `sessions/`, such as an archive, is searched there only. Hidden files, temporary files, the folders
//! `truth` and `bikes` and the output folder are skipped. A file that the user gives is always taken, whatever its
//! extension: if it is no log, its rejection says so.

use std::collections::BTreeSet;

use super::error::Error;
use super::settings::Settings;
use crate::contract::rejection::{RejectionCode, Stage};
use crate::ingest::formats::{extensions, has_log_extension};
use crate::pipeline::Rejection;
use crate::store::objects::search::{Folder, MatchKind, find};
use crate::store::objects::{Location, source};
use crate::store::tables::{output, registry};

/// Folders beside an archive's sessions that hold no logs.
const NOT_LOGS: &[&str] = &["truth", "bikes"];

/// One input, with its problem if it has one before it is opened.
#[derive(Debug, Clone)]
pub(crate) struct DiscoveredLog {
    /// Path as given by the user, or below the folder given.
    pub location: Location,
    /// Reason why it cannot be an input.
    pub problem: Option<Rejection>,
}

impl DiscoveredLog {
    fn log(location: Location) -> Self {
        DiscoveredLog { location, problem: None }
    }

    fn problem(location: Location, code: RejectionCode, message: String) -> Self {
        let problem = Some(Rejection { stage: Stage::Discover, code, message, limits: None });
        DiscoveredLog { location, problem }
    }
}

/// The logs of a batch and the folder of bike files.
///
/// # Errors
/// There is no log, no such folder, or the output lies among the logs.
pub(crate) fn inputs(settings: &Settings<'_>) -> Result<(Vec<DiscoveredLog>, Location), Error> {
    refuse_others_sessions(settings.out)?;
    let mut found = discover(settings.inputs, settings.out)?;
    if let Some(since) = settings.since {
        // logs without a date are kept
        let old = |f: &DiscoveredLog| {
            f.problem.is_none() && source::stat(&f.location).is_ok_and(|s| s.modified < since)
        };
        found.retain(|f| !old(f));
    }
    let beside = bikes_beside(settings.inputs)?;
    let bikes = settings.bikes.cloned().or(beside).ok_or_else(|| {
        let message = "which bikes? Give the folder of bike files with --bikes DIR; `roadbench bike new NAME` \
                       writes a bike file into the folder `bikes`";
        Error::Usage(message.to_owned())
    })?;
    Ok((found, bikes))
}

/// Every log behind the inputs, sorted by path, each file once.
///
/// # Errors
/// There is no log, or the output lies among the logs.
pub(crate) fn discover(inputs: &[Location], out: &Location) -> Result<Vec<DiscoveredLog>, Error> {
    let out = out.absolute();
    let mut found = Vec::new();
    for input in inputs {
        search(input, &out, &mut found)?;
    }
    if found.iter().all(|f| f.problem.is_some()) {
        let why: Vec<&str> =
            found.iter().filter_map(|f| f.problem.as_ref()).map(|p| p.message.as_str()).collect();
        return Err(Error::Usage(format!("no logs to read: {}", why.join("; "))));
    }
    found.sort_by(|a, b| a.location.cmp(&b.location));
    let mut seen = BTreeSet::new();
    found.retain(|f| seen.insert(f.location.absolute()));
    Ok(found)
}

/// The folder `bikes` of the inputs, if one has it.
///
/// # Errors
/// Several inputs have such a folder.
pub(crate) fn bikes_beside(inputs: &[Location]) -> Result<Option<Location>, Error> {
    let mut folders = Vec::new();
    // a pattern has no folder
    for input in inputs.iter().filter(|i| !(i.is_remote() && i.is_pattern())) {
        let folder = input.join("bikes");
        if folder.is_folder().map_err(|e| Error::Usage(e.to_string()))? {
            folders.push(folder);
        }
    }
    folders.sort();
    folders.dedup();
    match folders.len() {
        0 | 1 => Ok(folders.pop()),
        _ => Err(Error::Usage(format!(
            "{} and {} both hold bike files; say which with --bikes DIR",
            folders[0], folders[1]
        ))),
    }
}

/// Adds the logs of one input to `found`.
fn search(input: &Location, out: &Location, found: &mut Vec<DiscoveredLog>) -> Result<(), Error> {
    let before = found.len();
    let is_log = |key: &str| has_log_extension(&Location::Local(key.into()));
    let matches = find(input, is_log).map_err(|e| Error::Usage(e.to_string()))?;
    for one in matches {
        match one.kind {
            MatchKind::File => {
                refuse_tables(&one.location, out)?;
                found.push(DiscoveredLog::log(one.location));
            }
            MatchKind::Folder(folder) => search_folder(folder, out, found)?,
            MatchKind::Other => {
                let message = format!("{} is neither a file nor a folder", one.location);
                found.push(DiscoveredLog::problem(
                    one.location,
                    RejectionCode::Unreadable,
                    message,
                ));
            }
            MatchKind::Unreadable(message) => {
                found.push(DiscoveredLog::problem(
                    one.location,
                    RejectionCode::Unreadable,
                    message,
                ));
            }
        }
    }
    if found.len() == before {
        let message = match input.is_pattern() {
            true => format!("nothing matches {input}"),
            false => format!("{input} does not exist"),
        };
        found.push(DiscoveredLog::problem(input.clone(), RejectionCode::NotFound, message));
    }
    Ok(())
}

fn search_folder(
    folder: Folder,
    out: &Location,
    found: &mut Vec<DiscoveredLog>,
) -> Result<(), Error> {
    let (folder, is_archive) = match folder.subfolder("sessions") {
        Ok(sessions) => (sessions, true),
        Err(folder) => (folder, false),
    };
    let root = folder.location().clone();
    refuse_tables(&root, out)?;
    refuse_output_among_logs(&root, is_archive, out)?;
    let before = found.len();
    for file in folder.files(&|at, is_folder| is_wanted(at, is_folder, out)) {
        found.push(match file {
            Ok(log) => DiscoveredLog::log(log),
            Err((at, message)) => DiscoveredLog::problem(at, RejectionCode::Unreadable, message),
        });
    }
    if found.len() == before {
        let extensions: Vec<String> = extensions().iter().map(|e| format!("*.{e}")).collect();
        let message = format!("{root} holds no logs (looked for {})", extensions.join(", "));
        found.push(DiscoveredLog::problem(root, RejectionCode::NoLogs, message));
    }
    Ok(())
}

/// Refuses an output in the folder of logs `root`: its tables would be found as logs.
fn refuse_output_among_logs(
    root: &Location,
    is_archive: bool,
    out: &Location,
) -> Result<(), Error> {
    let place = root.absolute();
    let holds_sessions = is_archive || root.file_name() == "sessions";
    if *out == place || (holds_sessions && out.starts_with(&place)) {
        return Err(Error::Usage(format!(
            "--out {out} lies in the logs' own folder {root}; choose another"
        )));
    }
    Ok(())
}

/// Refuses an output whose folder of sessions has files that no run wrote. Otherwise tables would be written among
/// somebody's logs, and `verify --mend` would take the logs for damaged tables.
///
/// # Errors
/// There are such files.
pub(crate) fn refuse_others_sessions(out: &Location) -> Result<(), Error> {
    let Some(path) = out.as_path() else { return Ok(()) };
    let sessions = path.join(registry::SESSIONS.name);
    let holds_any = std::fs::read_dir(&sessions).is_ok_and(|mut all| all.next().is_some());
    // tables that were copied without the folder `.roadbench`
    let has_tables = || {
        let others = registry::folders().filter(|name| *name != registry::SESSIONS.name);
        others.filter(|name| *name != registry::BIKES.name).any(|name| path.join(name).is_dir())
    };
    if !holds_any || output::is_output(path) || has_tables() {
        return Ok(());
    }
    let sessions = sessions.display();
    Err(Error::Usage(format!("{sessions} holds files that no run wrote; choose another --out")))
}

/// Refuses inputs in the folder of a table: they would be taken for results and overwritten.
fn refuse_tables(input: &Location, out: &Location) -> Result<(), Error> {
    let place = input.absolute();
    match registry::folders().map(|f| out.join(f)).find(|folder| place.starts_with(folder)) {
        None => Ok(()),
        Some(folder) => Err(Error::Usage(format!(
            "{input} lies where this run would write its own tables ({folder}); choose another --out"
        ))),
    }
}

/// Whether a file is a log, or a folder may contain logs.
fn is_wanted(at: &Location, is_folder: bool, out: &Location) -> bool {
    let name = at.file_name();
    if name.starts_with('.') {
        return false; // hidden or temporary (.roadbench-*)
    }
    match is_folder {
        true => !NOT_LOGS.contains(&name.as_ref()) && at.absolute() != *out,
        false => has_log_extension(at),
    }
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

    fn at(folder: &tempfile::TempDir, name: &str) -> Location {
        Location::from(folder.path().join(name))
    }

    fn names(folder: &tempfile::TempDir, found: &[DiscoveredLog]) -> Vec<String> {
        let root = format!("{}/", folder.path().display());
        found.iter().map(|f| f.location.to_string().replace(&root, "")).collect()
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
        let found = discover(&[t.path().into()], &at(&t, "out")).expect("found");
        assert_eq!(names(&t, &found), ["sessions/bike=a/9.PARQUET", "sessions/bike=b/2.parquet"]);
        assert_eq!(bikes_beside(&[t.path().into()]).expect("one"), Some(at(&t, "bikes")));
    }

    #[test]
    fn a_file_is_taken_once_however_it_is_named() {
        let t = tree(&["a.parquet", "b.csv", "c.xyz"]);
        let inputs = [t.path().into(), at(&t, "*.parquet"), at(&t, "./b.csv"), at(&t, "c.xyz")];
        let found = discover(&inputs, &at(&t, "out")).expect("found");
        assert_eq!(names(&t, &found), ["a.parquet", "b.csv", "c.xyz"]);
    }

    #[test]
    fn the_output_folder_is_not_searched() {
        let t = tree(&["a.parquet", "out/coefficients/bike=a/a.parquet"]);
        let found = discover(&[t.path().into()], &at(&t, "out")).expect("found");
        assert_eq!(names(&t, &found), ["a.parquet"]);
    }

    #[test]
    fn logs_and_output_are_kept_apart() {
        let t = tree(&["sessions/a.parquet"]);
        let sessions = at(&t, "sessions");
        for (input, out) in [
            (&sessions, t.path().into()), // tables would go to <out>/sessions
            (&sessions, sessions.clone()),
            (&sessions, sessions.join("out")),
            (&sessions.join("a.parquet"), t.path().into()),
            (&t.path().into(), sessions.join("out")),
        ] {
            let e = discover(std::slice::from_ref(input), &out).expect_err("mixed up");
            assert!(matches!(e, Error::Usage(_)), "{input:?} {out:?}: {e}");
        }
        assert!(discover(&[sessions], &at(&t, "out")).is_ok());
    }

    #[test]
    fn a_folder_of_somebodys_sessions_is_no_output() {
        let t = tree(&["archive/sessions/bike=a/x.parquet", "tables/sessions/bike=a/1.parquet"]);
        let wrong = refuse_others_sessions(&at(&t, "archive")).expect_err("an archive");
        assert!(matches!(&wrong, Error::Usage(m) if m.contains("archive/sessions")), "{wrong}");
        for own in ["coefficients", ".roadbench"] {
            refuse_others_sessions(&at(&t, "tables")).expect_err("not yet");
            std::fs::create_dir_all(t.path().join("tables").join(own)).expect("folder");
            refuse_others_sessions(&at(&t, "tables")).expect(own);
            std::fs::remove_dir(t.path().join("tables").join(own)).expect("removed");
        }
        refuse_others_sessions(&at(&t, "new")).expect("nothing there");
    }

    #[test]
    fn what_is_missing_is_an_input_too_unless_there_is_nothing_else() {
        let t = tree(&["a.parquet", "empty/README.md"]);
        let out = at(&t, "out");
        let missing = at(&t, "b.parquet");
        let e = discover(&[missing.clone(), at(&t, "empty")], &out).expect_err("nothing");
        assert!(e.to_string().contains("b.parquet does not exist"), "{e}");
        let found = discover(&[at(&t, "a.parquet"), missing], &out).expect("found");
        assert_eq!(found.len(), 2);
        assert_eq!(found[1].problem.as_ref().map(|p| p.code.as_str()), Some("not_found"));
    }

    #[cfg(unix)]
    #[test]
    fn a_loop_of_links_ends() {
        let t = tree(&["logs/a.parquet"]);
        std::os::unix::fs::symlink(t.path().join("logs"), t.path().join("logs/again"))
            .expect("link");
        let found = discover(&[at(&t, "logs")], &at(&t, "out")).expect("found");
        assert_eq!(found.iter().filter(|f| f.problem.is_none()).count(), 1);
    }
}
