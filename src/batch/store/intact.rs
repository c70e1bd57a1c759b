//! Damaged tables are detected before their numbers are printed or exported.
//!
//! A table with a bit that has changed may still be read, with another number in it. Every command that
//! prints or exports numbers first compares the files with the list of checksums ([`super::manifest`]). A file that is
//! not on the list, of an older roadbench or a killed run, is taken as it is.

use std::collections::BTreeSet;
use std::path::Path;

use super::manifest::{Manifest, is_below};
use crate::batch::error::Error;
use crate::store::objects::Location;
use crate::store::tables::by_session::SessionFiles;
use crate::store::tables::registry::{REJECTED, SESSIONS};
use crate::store::tables::rows::SessionRow;

/// Makes sure of some files of an output: `wanted` is asked with their paths below it.
///
/// # Errors
/// `Output`: some are missing or not as they were written; the first of them, and what to do.
pub(crate) fn require(out: &Location, wanted: impl Fn(&str) -> bool + Sync) -> Result<(), Error> {
    let damaged = Manifest::read(out).damaged(out, wanted);
    says(out, &damaged).map_or(Ok(()), |message| Err(Error::Output(message)))
}

/// Text for files that are missing or damaged; `None` if all are intact.
pub(crate) fn says(out: &Location, damaged: &BTreeSet<String>) -> Option<String> {
    let first = damaged.first()?;
    let more = match damaged.len() {
        1 => String::new(),
        n => format!(" and {} more", n - 1),
    };
    Some(format!(
        "{out}: {first}{more} missing or damaged, so numbers read from it may be wrong; run over \
         the logs again to repair it. `roadbench verify {out}` lists the damage"
    ))
}

/// Makes sure of the table `sessions`, where sessions are looked for.
///
/// # Errors
/// As [`require`].
pub(crate) fn require_sessions(out: &Location) -> Result<(), Error> {
    require(out, |path| is_below(path, SESSIONS.name))
}

/// Makes sure of the tables that account for every input.
///
/// # Errors
/// As [`require`].
pub(crate) fn require_lists(out: &Location) -> Result<(), Error> {
    let lists = [SESSIONS.name, REJECTED.name];
    require(out, |path| lists.iter().any(|table| is_below(path, table)))
}

/// Makes sure of some tables of some motorcycles.
///
/// # Errors
/// As [`require`].
pub(crate) fn require_bikes(
    out: &Location,
    tables: &[&str],
    bikes: &BTreeSet<&str>,
) -> Result<(), Error> {
    let folder = |path: &str, table: &&str| {
        let of_table = path.strip_prefix(*table).and_then(|rest| rest.strip_prefix("/bike="));
        of_table.and_then(|rest| rest.split_once('/')).is_some_and(|(bike, _)| bikes.contains(bike))
    };
    require(out, |path| tables.iter().any(|table| folder(path, table)))
}

/// Makes sure of what some tables say of the sessions of a name: of the files of their motorcycles.
///
/// # Errors
/// As [`require`], or the sessions cannot be read.
pub(crate) fn require_session(out: &Path, tables: &[&str], session: &str) -> Result<(), Error> {
    let at = Location::from(out);
    require_sessions(&at)?;
    let files = SessionFiles::<SessionRow>::read(out)?;
    let keys = files.keys().filter(|(_, id)| *id == session);
    require_bikes(&at, tables, &keys.map(|(bike, _)| bike).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::store::manifest::checksum;

    fn output(files: &[&str]) -> (tempfile::TempDir, Location) {
        let folder = tempfile::tempdir().expect("folder");
        let out = Location::from(folder.path());
        let mut list = Manifest::empty();
        for file in files {
            out.join(file).write(file.as_bytes()).expect("written");
            list.put((*file).to_owned(), checksum(file.as_bytes()));
        }
        list.write(&out).expect("listed");
        (folder, out)
    }

    #[test]
    fn a_file_that_changed_or_is_gone_is_refused_by_name_with_what_to_do() {
        let files = ["sessions/bike=b1/a.parquet", "plots/bike=b1/a.parquet"];
        let (_folder, out) = output(&files);
        let all = |_: &str| true;
        assert!(require(&out, all).is_ok());
        out.join(files[1]).write(b"other bytes").expect("written");
        let message = require(&out, all).expect_err("changed").to_string();
        for says in
            [files[1], "missing or damaged", "run over the logs again", "`roadbench verify "]
        {
            assert!(message.contains(says), "{message}");
        }
        assert!(require_sessions(&out).is_ok());
        out.join(files[0]).remove().expect("removed");
        assert!(require_sessions(&out).is_err());
        let message = require(&out, all).expect_err("two").to_string();
        assert!(message.contains(" and 1 more"), "{message}");
    }

    #[test]
    fn only_the_motorcycles_that_are_asked_for_count() {
        let (_folder, out) = output(&["plots/bike=b1/a.parquet", "plots/bike=b10/a.parquet"]);
        out.join("plots/bike=b10/a.parquet").write(b"other bytes").expect("written");
        let require = |bike| require_bikes(&out, &["plots"], &BTreeSet::from([bike]));
        assert!(require("b1").is_ok());
        assert!(require("b10").is_err());
    }

    #[test]
    fn an_output_without_a_list_is_taken_as_it_is() {
        let folder = tempfile::tempdir().expect("folder");
        let out = Location::from(folder.path());
        out.join("sessions/bike=b1/a.parquet").write(b"a table").expect("written");
        assert!(require_sessions(&out).is_ok());
    }
}
