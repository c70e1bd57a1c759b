//! Holds an output against its checksums, its rows against one another, and its sessions against their logs.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use arrow::array::AsArray;
use bytes::Bytes;
use rayon::prelude::*;

use super::contents::Contents;
use super::error::Error;
use super::kind::{self, Kind};
use super::lock::Lock;
use super::log_hash::hash_file;
use super::manifest::{self, Manifest, checksum};
use super::marker::Committed;
use super::{parts, switch};
use crate::effects::pooled_effects;
use crate::objects::Location;
use crate::tables::file::TEMPORARY;
use crate::tables::read;
use crate::tables::registry::{self, TableSpec};

/// What is wrong with a file or a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wrong {
    /// A file has other bytes than were written.
    Changed,
    /// A file is not there any more.
    Missing,
    /// A table that cannot be read.
    Unreadable,
    /// A file of no session.
    Orphan,
    /// Rows of sessions that have no commit marker, among others.
    OrphanRows,
    /// What a killed run left.
    LeftOver,
    /// Sessions wait to be taken into the tables.
    Waiting,
    /// The log is not there any more.
    LogMissing,
    /// The log cannot be read: whether it is as it was cannot be told.
    LogUnreadable,
    /// The log has other bytes now.
    LogChanged,
}

impl Wrong {
    /// As it is printed.
    pub fn name(self) -> &'static str {
        match self {
            Wrong::Changed => "changed",
            Wrong::Missing => "missing",
            Wrong::Unreadable => "unreadable",
            Wrong::Orphan => "orphan",
            Wrong::OrphanRows => "orphan_rows",
            Wrong::LeftOver => "left_over",
            Wrong::Waiting => "waiting",
            Wrong::LogMissing => "log_missing",
            Wrong::LogUnreadable => "log_unreadable",
            Wrong::LogChanged => "log_changed",
        }
    }

    /// Whether the output is damaged; else a run, or nobody, has to do something about it.
    pub fn is_damage(self) -> bool {
        use Wrong::{Changed, Missing, Orphan, OrphanRows, Unreadable};
        matches!(self, Changed | Missing | Unreadable | Orphan | OrphanRows)
    }
}

/// One thing that is wrong.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Finding {
    /// What.
    pub wrong: Wrong,
    /// The file below the output, or the log.
    pub place: String,
    /// The rest, in words; may be empty.
    pub detail: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:12} {}", self.wrong.name(), self.place)?;
        if self.detail.is_empty() { Ok(()) } else { write!(f, ": {}", self.detail) }
    }
}

/// What was looked at, and what is wrong.
#[derive(Debug, Default)]
pub struct Verified {
    /// Files of tables, models and fleet.
    pub files: usize,
    /// Of those, without a checksum: written by an older roadbench, or by a run that was killed.
    pub unlisted: usize,
    /// Sessions.
    pub sessions: usize,
    /// Logs that were read.
    pub logs: usize,
    /// In order of what and where.
    pub findings: Vec<Finding>,
}

/// Looks an output through; with `logs` every session's log is read, too.
///
/// # Errors
/// The output cannot be read, or a run is writing into it.
pub fn verify(out: &Location, logs: bool) -> Result<Verified, Error> {
    let _lock = Lock::take(out)?; // nothing changes meanwhile
    switch::recover(out)?;
    look(out, logs)
}

/// What [`mend`] did.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Mended {
    /// Files that are removed, below the output.
    pub removed: Vec<String>,
    /// Damaged tables that stay: no run could make them again, since these sessions' logs are gone or changed.
    pub kept: BTreeMap<String, BTreeSet<String>>,
}

/// Removes damaged tables and what was left over: the next run computes their sessions again. A table with sessions whose logs
/// are not as they were stays, unless `lose` says that their rows may be lost.
///
/// # Errors
/// As [`verify`], or the output cannot be written.
pub fn mend(out: &Location, lose: bool) -> Result<Mended, Error> {
    let _lock = Lock::take(out)?;
    switch::recover(out)?;
    let found = look(out, false)?;
    let mut list = Manifest::read(out);
    let mut removed = BTreeSet::new();
    for finding in &found.findings {
        // a table with rows too many has good ones, too: the next change of its month drops the others
        let stays = finding.wrong == Wrong::OrphanRows;
        if (finding.wrong.is_damage() && !stays) || finding.wrong == Wrong::LeftOver {
            removed.insert(finding.place.clone());
        }
    }
    let mut kept = BTreeMap::new();
    if !lose {
        for kind in [&kind::RUN, &kind::DIAGNOSE] {
            kept.extend(without_log(kind, out, &removed)?);
        }
        removed.retain(|path| !kept.contains_key(path));
    }
    // before the files: see `manifest`
    list.take_off(removed.iter().map(String::as_str));
    list.write(out)?;
    for kind in [&kind::RUN, &kind::DIAGNOSE] {
        if removed.iter().any(|path| kind.files().any(|(f, _)| path.starts_with(f))) {
            crate::tables::file::write_bytes(out.join(kind.behind), b"")?;
        }
    }
    for path in &removed {
        let at = out.join(path);
        at.remove().map_err(|e| Error::Output(format!("cannot remove {at}: {e}")))?;
    }
    Ok(Mended { removed: removed.into_iter().collect(), kept })
}

/// Those of some tables that have sessions whose logs are gone, changed or not readable, with these sessions.
fn without_log(
    kind: &'static Kind,
    out: &Location,
    paths: &BTreeSet<String>,
) -> Result<BTreeMap<String, BTreeSet<String>>, Error> {
    let there = Contents::read(kind, out)?;
    let rows: Vec<(&Committed, Vec<String>)> = there
        .taken_in()
        .filter_map(|row| {
            let path = |(folder, extension): (&str, &str)| {
                format!("{folder}/bike={}/{}.{extension}", row.bike_id, row.part)
            };
            let its: Vec<String> = kind.files().map(path).filter(|p| paths.contains(p)).collect();
            (!its.is_empty()).then_some((row, its))
        })
        .collect();
    let gone: Vec<bool> =
        rows.par_iter().map(|(row, _)| log(&row.path, &row.input_hash).is_some()).collect();
    let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for ((row, its), gone) in rows.into_iter().zip(gone) {
        for path in its.into_iter().filter(|_| gone) {
            found.entry(path).or_default().insert(row.session_id.clone());
        }
    }
    Ok(found)
}

/// The folders whose files have a checksum.
fn listed_folders() -> impl Iterator<Item = &'static str> {
    registry::folders().filter(|name| !["report", "rejected"].contains(name))
}

/// Whether a file of them has one; what sessions share is in the models' folder, and is made at every end.
fn has_checksum(path: &str) -> bool {
    let shared = format!("models/{}", pooled_effects::FILE);
    path != shared
        && listed_folders().any(|f| path.strip_prefix(f).is_some_and(|p| p.starts_with('/')))
}

fn look(out: &Location, logs: bool) -> Result<Verified, Error> {
    let list = Manifest::read(out);
    let fail = |e: std::io::Error| Error::Output(format!("{out}: {e}"));
    let mut paths = BTreeSet::new();
    let mut findings = Vec::new();
    for folder in registry::folders().chain([".roadbench"]) {
        for entry in out.join(folder).list().map_err(fail)? {
            let path = format!("{folder}/{}", entry.key);
            let name = entry.key.rsplit('/').next().unwrap_or_default();
            if name.starts_with(TEMPORARY.0) && name.ends_with(TEMPORARY.1) {
                findings.push(Finding {
                    wrong: Wrong::LeftOver,
                    place: path,
                    detail: String::new(),
                });
            } else if folder != ".roadbench" {
                paths.insert(path);
            }
        }
    }
    let lacks = list.files().filter(|(path, _)| !paths.contains(*path));
    findings.extend(lacks.map(|(path, _)| Finding {
        wrong: Wrong::Missing,
        place: path.to_owned(),
        detail: String::new(),
    }));
    let files: Vec<&String> =
        paths.iter().filter(|p| has_checksum(p) || p.starts_with("rejected/")).collect();
    let looked: Vec<Option<Finding>> =
        files.par_iter().map(|path| file(out, path, list.of(path))).collect();
    let mut done = Verified {
        files: files.len(),
        unlisted: files.iter().filter(|p| has_checksum(p) && list.of(p).is_none()).count(),
        ..Verified::default()
    };
    findings.extend(looked.into_iter().flatten());
    let damaged: BTreeSet<String> = findings.iter().map(|f| f.place.clone()).collect();
    let mut of_log = BTreeMap::new();
    for kind in [&kind::RUN, &kind::DIAGNOSE] {
        let there = Contents::read(kind, out)?;
        done.sessions = done.sessions.max(there.sessions().count());
        let waits = there.staged().count();
        if waits > 0 {
            let detail = format!("{waits} sessions; the next run takes them in");
            findings.push(Finding { wrong: Wrong::Waiting, place: kind.staged.to_owned(), detail });
        }
        for row in there.taken_in() {
            of_log.insert(row.path.clone(), row.input_hash.clone());
        }
        findings.extend(rows(out, kind, &there, &paths, &damaged));
    }
    if logs {
        let all: Vec<(&String, &String)> = of_log.iter().collect();
        done.logs = all.len();
        findings
            .extend(all.par_iter().filter_map(|(path, hash)| log(path, hash)).collect::<Vec<_>>());
    }
    findings.sort();
    findings.dedup();
    done.findings = findings;
    Ok(done)
}

/// What is wrong with a file by itself.
fn file(out: &Location, path: &str, sum: Option<&str>) -> Option<Finding> {
    let finding = |wrong, detail| Some(Finding { wrong, place: path.to_owned(), detail });
    let bytes = match out.join(path).read() {
        Ok(bytes) => bytes,
        Err(e) => return finding(Wrong::Unreadable, e.to_string()),
    };
    match sum {
        Some(sum) if checksum(&bytes) == sum => None,
        Some(_) => finding(Wrong::Changed, "not what was written".to_owned()),
        None if path.ends_with(".parquet") => match read::batches_of(Bytes::from(bytes)) {
            Ok(_) => None,
            Err(e) => finding(Wrong::Unreadable, e),
        },
        None => None,
    }
}

/// What is wrong with the rows of sessions, table by table.
fn rows(
    out: &Location,
    kind: &'static Kind,
    there: &Contents,
    paths: &BTreeSet<String>,
    damaged: &BTreeSet<String>,
) -> Vec<Finding> {
    let mut parts_of: BTreeMap<(&str, &str), BTreeSet<&str>> = BTreeMap::new();
    for row in there.taken_in() {
        let Committed { bike_id, part, session_id, .. } = row;
        parts_of.entry((bike_id, part)).or_default().insert(session_id);
    }
    let tables: Vec<&TableSpec> = kind.tables().filter(|spec| parts::shares(spec)).collect();
    let mut work: Vec<(&TableSpec, String)> = Vec::new();
    let mut findings = Vec::new();
    for spec in tables {
        for (bike, part) in parts_of.keys() {
            let path = format!("{}/bike={bike}/{part}.parquet", spec.name);
            let always = spec.presence == registry::Presence::Always;
            match paths.contains(&path) {
                true if !damaged.contains(&path) => work.push((spec, path)),
                // one that is on the list is told already
                false if always && !damaged.contains(&path) => findings.push(Finding {
                    wrong: Wrong::Missing,
                    place: path,
                    detail: "its sessions are computed again".to_owned(),
                }),
                _ => {}
            }
        }
        // a file of a motorcycle and month that no commit marker knows
        let prefix = format!("{}/bike=", spec.name);
        for path in paths.range(prefix.clone()..).take_while(|p| p.starts_with(&prefix)) {
            let rest = path[prefix.len()..].strip_suffix(".parquet");
            let known =
                rest.and_then(|r| r.split_once('/')).is_some_and(|key| parts_of.contains_key(&key));
            if !known && !path.contains("bike=_") {
                let detail = "no session of that motorcycle and month is in the output".to_owned();
                findings.push(Finding { wrong: Wrong::Orphan, place: path.clone(), detail });
            }
        }
    }
    let look = |(spec, path): &(&TableSpec, String)| {
        let rest = path.strip_prefix(&format!("{}/bike=", spec.name))?;
        let sessions = parts_of.get(&rest.strip_suffix(".parquet")?.split_once('/')?)?;
        let ids = ids(&out.join(path)).ok()?; // told already
        let strange: Vec<&str> =
            ids.iter().map(String::as_str).filter(|id| !sessions.contains(id)).collect();
        let [first, ..] = strange[..] else { return None };
        let detail =
            format!("rows of {} sessions that are not in the output ({first})", strange.len());
        Some(Finding { wrong: Wrong::OrphanRows, place: path.clone(), detail })
    };
    findings.extend(work.par_iter().filter_map(look).collect::<Vec<_>>());
    findings
}

/// The sessions that a table has rows of.
fn ids(at: &Location) -> Result<BTreeSet<String>, String> {
    let bytes = at.read().map_err(|e| e.to_string())?;
    let mut ids = BTreeSet::new();
    for batch in read::batches_of(Bytes::from(bytes))? {
        let column = batch.column_by_name("session_id").ok_or("no session_id")?;
        let texts = arrow::compute::cast(column, &arrow::datatypes::DataType::Utf8)
            .map_err(|e| e.to_string())?;
        let texts = texts.as_string_opt::<i32>().ok_or("session_id is no text")?;
        let mut last = "";
        for id in texts.iter().flatten() {
            if id != last {
                ids.insert(id.to_owned());
                last = id;
            }
        }
    }
    Ok(ids)
}

/// What is wrong with a session's log.
fn log(path: &str, hash: &str) -> Option<Finding> {
    let finding = |wrong, detail: &str| {
        Some(Finding { wrong, place: path.to_owned(), detail: detail.to_owned() })
    };
    let at = Location::parse(path).ok()?;
    match at.exists() {
        Ok(false) => {
            finding(Wrong::LogMissing, "the session stays; `forget --missing` takes it out")
        }
        _ => match hash_file(&at) {
            Ok(now) if now == hash => None,
            Ok(_) => finding(Wrong::LogChanged, "the next run computes it again"),
            Err(e) => finding(
                Wrong::LogUnreadable,
                &format!("{e}; the session stays, and the next run tries to read it"),
            ),
        },
    }
}

/// Lists the checksums of an output that has no list yet.
///
/// # Errors
/// A file cannot be read.
pub fn adopt(out: &Location) -> Result<Manifest, Error> {
    let mut list = Manifest::empty();
    for folder in listed_folders() {
        let at = out.join(folder);
        for entry in at.list().map_err(|e| Error::Output(format!("{at}: {e}")))? {
            let one = at.join(&entry.key);
            let name = entry.key.rsplit('/').next().unwrap_or_default();
            if let Some(path) = manifest::below(out, &one)
                .filter(|path| !name.starts_with('.') && has_checksum(path))
            {
                let bytes =
                    one.read().map_err(|e| Error::Output(format!("cannot read {one}: {e}")))?;
                list.put(path, checksum(&bytes));
            }
        }
    }
    Ok(list)
}
