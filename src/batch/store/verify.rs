//! Holds an output against its checksums, its rows against one another, and its sessions against their logs.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use arrow::array::AsArray;
use bytes::Bytes;
use rayon::prelude::*;

use super::contents::Contents;
use super::kind::{self, Kind};
use super::lock::Lock;
use super::manifest::{self, Manifest, checksum};
use super::marker::Committed;
use super::{mark, parts, switch};
use crate::batch::error::Error;
use crate::batch::log_hash::hash_file;
use crate::report;
use crate::store::objects::Location;
use crate::store::tables::file::TEMPORARY;
use crate::store::tables::mismatch::Mismatch;
use crate::store::tables::names::file_name;
use crate::store::tables::read;
use crate::store::tables::registry;
use crate::store::tables::registry::{Scope, TableSpec};

/// Kind of a finding on a file or a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FindingKind {
    /// A file has other bytes than were written.
    Changed,
    /// A file is not there any more.
    Missing,
    /// A table that cannot be read.
    Unreadable,
    /// A table of ours that is no session's.
    Orphan,
    /// A file that roadbench did not write; it stays.
    Foreign,
    /// Rows of sessions that have no commit marker, among others.
    OrphanRows,
    /// Remains of a killed run.
    LeftOver,
    /// Sessions wait to be taken into the tables.
    Waiting,
    /// The log is not there any more.
    LogMissing,
    /// The log cannot be read: whether it is unchanged is unknown.
    LogUnreadable,
    /// The log has other bytes now.
    LogChanged,
}

impl FindingKind {
    /// As it is printed.
    pub fn name(self) -> &'static str {
        match self {
            FindingKind::Changed => "changed",
            FindingKind::Missing => "missing",
            FindingKind::Unreadable => "unreadable",
            FindingKind::Orphan => "orphan",
            FindingKind::Foreign => "foreign",
            FindingKind::OrphanRows => "orphan_rows",
            FindingKind::LeftOver => "left_over",
            FindingKind::Waiting => "waiting",
            FindingKind::LogMissing => "log_missing",
            FindingKind::LogUnreadable => "log_unreadable",
            FindingKind::LogChanged => "log_changed",
        }
    }

    /// Whether the output is damaged; else a run, or nobody, has to do something about it.
    pub fn is_damage(self) -> bool {
        use FindingKind::{Changed, Missing, Orphan, OrphanRows, Unreadable};
        matches!(self, Changed | Missing | Unreadable | Orphan | OrphanRows)
    }
}

/// One thing that is wrong.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Finding {
    /// Kind of the finding.
    pub wrong: FindingKind,
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

/// Counts of what was checked, and the findings.
#[derive(Debug, Default)]
pub struct Verified {
    /// Files of tables, models and fleet.
    pub files: usize,
    /// Of those, without a checksum: written by an older roadbench, or by a run that was killed.
    pub unlisted: usize,
    /// Number of sessions in the tables.
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
    mark::require(out)?;
    let _lock = Lock::take(out)?; // nothing changes meanwhile
    switch::recover(out)?;
    look(out, logs)
}

/// Files that [`mend`] changed.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Mended {
    /// Files that are removed, below the output.
    pub removed: Vec<String>,
    /// Damaged tables that stay: no run could make them again, since these sessions' logs are gone or changed.
    pub kept: BTreeMap<String, BTreeSet<String>>,
}

/// Removes damaged files that roadbench wrote, and what was left over: the next run makes them again. A table with sessions
/// whose logs are not as they were stays, unless `lose` says that their rows may be lost.
///
/// # Errors
/// As [`verify`], or the output cannot be written.
pub fn mend(out: &Location, lose: bool) -> Result<Mended, Error> {
    mark::require(out)?;
    let _lock = Lock::take(out)?;
    switch::recover(out)?;
    let found = look(out, false)?;
    let mut list = Manifest::read(out);
    let mut removed = BTreeSet::new();
    let mut missing = BTreeSet::new();
    for finding in &found.findings {
        // a table with rows too many has good ones, too: the next change of its month drops the others
        let stays = finding.wrong == FindingKind::OrphanRows;
        if finding.wrong == FindingKind::Missing {
            missing.insert(finding.place.clone());
        } else if (finding.wrong.is_damage() && !stays) || finding.wrong == FindingKind::LeftOver {
            removed.insert(finding.place.clone());
        }
    }
    let concerned: BTreeSet<String> = removed.union(&missing).cloned().collect();
    let mut kept = BTreeMap::new();
    let mut given_up = Vec::new();
    for kind in [&kind::RUN, &kind::DIAGNOSE] {
        let there = Contents::read(kind, out)?;
        let without = without_log(&there, &concerned);
        if lose {
            given_up.extend(without.into_iter().filter(|(_, (_, is_all))| *is_all).map(|(p, _)| p));
        } else {
            kept.extend(without.into_iter().map(|(path, (sessions, _))| (path, sessions)));
            kept.extend(unknown_sessions(&there, &removed));
        }
    }
    removed.retain(|path| !kept.contains_key(path));
    // what stays on the list is made again by the next run; no run makes again what was given up, or was nobody's
    let orphans =
        found.findings.iter().filter(|f| f.wrong == FindingKind::Orphan).map(|f| &f.place);
    if list.is_there {
        list.unlist(given_up.iter().chain(orphans).map(String::as_str));
        list.write(out)?; // else the next run makes one
    }
    for kind in [&kind::RUN, &kind::DIAGNOSE] {
        if removed.iter().any(|path| kind.files().any(|(f, _)| path.starts_with(f))) {
            crate::store::tables::file::write_bytes(out.join(kind.behind), b"")?;
        }
    }
    for path in &removed {
        let at = out.join(path);
        at.remove().map_err(|e| Error::Output(format!("cannot remove {at}: {e}")))?;
    }
    Ok(Mended { removed: removed.into_iter().collect(), kept })
}

/// Sessions whose logs are gone, changed or not readable, and whether no other session of the table has its log.
type WithoutLog = (BTreeSet<String>, bool);

/// Those of some tables that have sessions whose logs are gone, changed or not readable.
fn without_log(there: &Contents, paths: &BTreeSet<String>) -> BTreeMap<String, WithoutLog> {
    let kind = there.kind;
    let files: Vec<(&str, &str)> = kind.files().chain([(kind.marker.name, "parquet")]).collect();
    let rows: Vec<(&Committed, Vec<String>)> = there
        .taken_in()
        .filter_map(|row| {
            let own = file_name(&row.session_id);
            let path = |(folder, end): &(&str, &str)| {
                [&row.part, &own].map(|file| format!("{folder}/bike={}/{file}.{end}", row.bike_id))
            };
            let its: Vec<String> =
                files.iter().flat_map(path).filter(|p| paths.contains(p)).collect();
            (!its.is_empty()).then_some((row, its))
        })
        .collect();
    let gone: Vec<bool> =
        rows.par_iter().map(|(row, _)| log(&row.path, &row.input_hash).is_some()).collect();
    let mut found: BTreeMap<String, (BTreeSet<String>, usize)> = BTreeMap::new();
    for ((row, its), gone) in rows.into_iter().zip(gone) {
        for path in its {
            let (sessions, others) = found.entry(path).or_default();
            match gone {
                true => _ = sessions.insert(row.session_id.clone()),
                false => *others += 1,
            }
        }
    }
    let with_gone = found.into_iter().filter(|(_, (sessions, _))| !sessions.is_empty());
    with_gone.map(|(path, (sessions, others))| (path, (sessions, others == 0))).collect()
}

/// Those of some files of commit markers that cannot be read while tables of their month have rows: only a run over all logs
/// knows whether any of these sessions has none.
fn unknown_sessions(
    there: &Contents,
    paths: &BTreeSet<String>,
) -> BTreeMap<String, BTreeSet<String>> {
    let marker = there.kind.marker.name;
    let known: BTreeSet<String> = there
        .taken_in()
        .map(|row| format!("{marker}/bike={}/{}.parquet", row.bike_id, row.part))
        .collect();
    let is_unknown = |path: &&String| manifest::is_below(path, marker) && !known.contains(*path);
    let mut found = BTreeMap::new();
    for path in paths.iter().filter(is_unknown) {
        let rest = path.strip_prefix(marker).unwrap_or_default();
        let tables = there.kind.tables().filter(|spec| parts::shares(spec));
        let of_tables = tables.map(|spec| ids(&there.root().join(format!("{}{rest}", spec.name))));
        let sessions: BTreeSet<String> = of_tables.filter_map(Result::ok).flatten().collect();
        if !sessions.is_empty() {
            found.insert(path.clone(), sessions);
        }
    }
    found
}

/// The folders whose files have a checksum.
fn listed_folders() -> impl Iterator<Item = &'static str> {
    registry::folders().filter(|name| !["report", "rejected"].contains(name))
}

/// Whether a file of them has one.
fn has_checksum(path: &str) -> bool {
    listed_folders().any(|f| path.strip_prefix(f).is_some_and(|p| p.starts_with('/')))
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
                    wrong: FindingKind::LeftOver,
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
        wrong: FindingKind::Missing,
        place: path.to_owned(),
        detail: String::new(),
    }));
    let files: Vec<&String> =
        paths.iter().filter(|p| has_checksum(p) || p.starts_with("rejected/")).collect();
    let looked: Vec<Option<Finding>> =
        files.par_iter().map(|path| file(out, path, list.of(path))).collect();
    let mut done = Verified { files: files.len(), ..Verified::default() };
    findings.extend(looked.into_iter().flatten());
    let of_report = out.as_path().and_then(report::damaged).unwrap_or_default();
    findings.extend(of_report.into_iter().map(|(name, is_there)| Finding {
        wrong: if is_there { FindingKind::Changed } else { FindingKind::Missing },
        place: format!("report/{name}"),
        detail: "the next run writes it again".to_owned(),
    }));
    let damaged: BTreeSet<String> = findings.iter().map(|f| f.place.clone()).collect();
    let mut of_log: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for kind in [&kind::RUN, &kind::DIAGNOSE] {
        let there = Contents::read(kind, out)?;
        done.sessions = done.sessions.max(there.sessions().count());
        let waits = there.staged().count();
        if waits > 0 {
            let detail = format!("{waits} sessions; the next run takes them in");
            findings.push(Finding {
                wrong: FindingKind::Waiting,
                place: kind.staged.to_owned(),
                detail,
            });
        }
        for row in there.taken_in() {
            let hashes: &mut BTreeSet<String> = of_log.entry(row.path.clone()).or_default();
            hashes.insert(row.input_hash.clone());
        }
        findings.extend(rows(out, kind, &there, &paths, &damaged));
    }
    if logs {
        // several where another ride has the log's name now
        let all: Vec<(&String, &BTreeSet<String>)> = of_log.iter().collect();
        done.logs = all.len();
        let look = |(path, hashes): &(&String, &BTreeSet<String>)| {
            let found: Vec<Finding> = hashes.iter().filter_map(|hash| log(path, hash)).collect();
            let another = hashes.len() - found.len() > 0;
            found.into_iter().next().map(|finding| match another {
                true => Finding {
                    wrong: FindingKind::LogMissing,
                    detail: "another ride has its name now; the session stays".to_owned(),
                    ..finding
                },
                false => finding,
            })
        };
        findings.extend(all.par_iter().filter_map(look).collect::<Vec<_>>());
    }
    let foreign: BTreeSet<&str> = findings
        .iter()
        .filter(|f| f.wrong == FindingKind::Foreign)
        .map(|f| f.place.as_str())
        .collect();
    let has_none = |p: &&&String| has_checksum(p) && list.of(p).is_none();
    done.unlisted = files.iter().filter(has_none).filter(|p| !foreign.contains(p.as_str())).count();
    findings.sort();
    findings.dedup();
    done.findings = findings;
    Ok(done)
}

/// Finding on one file by itself.
fn file(out: &Location, path: &str, sum: Option<&str>) -> Option<Finding> {
    let finding = |wrong, detail| Some(Finding { wrong, place: path.to_owned(), detail });
    let bytes = match out.join(path).read() {
        Ok(bytes) => bytes,
        Err(e) => return finding(FindingKind::Unreadable, e.to_string()),
    };
    match sum {
        Some(sum) if checksum(&bytes) == sum => None,
        Some(_) => finding(FindingKind::Changed, "the bytes are not those written".to_owned()),
        None => {
            let folder = path.split('/').next().unwrap_or_default();
            let bytes = Bytes::from(bytes);
            let is_own = match path.ends_with(".parquet") {
                true => mark::table_of(bytes.clone()).is_some_and(|spec| spec.name == folder),
                false => path.ends_with(".toml") && folder == "models",
            };
            match (is_own, is_place_of_ours(path)) {
                // a table of ours whose pages are damaged
                (true, _) if path.ends_with(".parquet") => match read::batches_of(bytes) {
                    Ok(_) => None,
                    Err(e) => finding(FindingKind::Unreadable, e.to_string()),
                },
                (true, _) => None,
                (false, true) => {
                    finding(FindingKind::Unreadable, "it cannot be read as a table".to_owned())
                }
                (false, false) => {
                    finding(FindingKind::Foreign, "roadbench did not write it; it stays".to_owned())
                }
            }
        }
    }
}

/// Whether only a table of ours has such a name: any other file of it would be replaced by the next run.
fn is_place_of_ours(path: &str) -> bool {
    let Some((folder, rest)) = path.split_once('/') else { return false };
    let Some((spec, stem)) = registry::find(folder).zip(rest.strip_suffix(".parquet")) else {
        return false;
    };
    match spec.scope {
        Scope::Fleet => stem == folder,
        Scope::Session => stem.split_once('/').is_some_and(|(bike, part)| {
            bike.starts_with("bike=") && (parts::is_part(part) || path == POOLED_TABLE)
        }),
        Scope::Log => stem.rsplit_once('-').is_some_and(|(_, hash)| {
            hash.len() == 8 && hash.bytes().all(|b| b.is_ascii_hexdigit())
        }),
        Scope::Truth | Scope::Single => false,
    }
}

/// The table of what sessions share.
const POOLED_TABLE: &str = "causes/bike=_pooled/pooled.parquet";

/// Findings on the rows of sessions, table by table.
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
                // one that is on the list is reported already
                false if always && !damaged.contains(&path) => findings.push(Finding {
                    wrong: FindingKind::Missing,
                    place: path,
                    detail: "the next run computes its sessions again".to_owned(),
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
            if !known && !path.contains("bike=_") && !damaged.contains(path) {
                let detail = "no session of that motorcycle and month is in the output".to_owned();
                findings.push(Finding { wrong: FindingKind::Orphan, place: path.clone(), detail });
            }
        }
    }
    let look = |(spec, path): &(&TableSpec, String)| {
        let rest = path.strip_prefix(&format!("{}/bike=", spec.name))?;
        let sessions = parts_of.get(&rest.strip_suffix(".parquet")?.split_once('/')?)?;
        let ids = ids(&out.join(path)).ok()?; // reported already
        let strange: Vec<&str> =
            ids.iter().map(String::as_str).filter(|id| !sessions.contains(id)).collect();
        let [first, ..] = strange[..] else { return None };
        let detail =
            format!("rows of {} sessions that are not in the output ({first})", strange.len());
        Some(Finding { wrong: FindingKind::OrphanRows, place: path.clone(), detail })
    };
    findings.extend(work.par_iter().filter_map(look).collect::<Vec<_>>());
    findings
}

/// The sessions that a table has rows of.
fn ids(at: &Location) -> Result<BTreeSet<String>, Mismatch> {
    let bytes = at.read().map_err(|e| Mismatch::from(e.to_string()))?;
    let mut ids = BTreeSet::new();
    for batch in read::batches_of(Bytes::from(bytes))? {
        let column = batch.column_by_name("session_id").ok_or("no session_id")?;
        let texts = arrow::compute::cast(column, &arrow::datatypes::DataType::Utf8)
            .map_err(|e| Mismatch::from(e.to_string()))?;
        let texts = texts.as_string_opt::<i32>().ok_or("session_id is not text")?;
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

/// Finding on a session's log.
fn log(path: &str, hash: &str) -> Option<Finding> {
    let finding = |wrong, detail: &str| {
        Some(Finding { wrong, place: path.to_owned(), detail: detail.to_owned() })
    };
    let at = Location::parse(path).ok()?;
    match at.exists() {
        Ok(false) => {
            finding(FindingKind::LogMissing, "the session stays; `forget --missing` removes it")
        }
        _ => match hash_file(&at) {
            Ok(now) if now == hash => None,
            Ok(_) => finding(FindingKind::LogChanged, "the next run computes it again"),
            Err(e) => finding(
                FindingKind::LogUnreadable,
                &format!("{e}; the session stays, and the next run tries to read it"),
            ),
        },
    }
}

/// Lists the checksums of an output that has no list yet.
///
/// # Errors
/// A file cannot be read.
pub(crate) fn adopt(out: &Location) -> Result<Manifest, Error> {
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
