//! Removes sessions from an output: from tables, fleet, diagnosis and report.

use std::collections::{BTreeMap, BTreeSet};

use super::contents::Contents;
use super::finish_derived;
use super::kind::{self, Kind};
use super::mark;
use super::marker::Key;
use crate::batch::error::Error;
use crate::batch::jobs::{diagnose, run};
use crate::batch::store::folder::Store;
use crate::contract::schema::meant;
use crate::report::Pages;
use crate::store::objects::Location;
use crate::store::tables::read;
use crate::store::tables::rows::Rejected;

#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// By id.
    pub sessions: Vec<String>,
    /// All of a motorcycle.
    pub bikes: Vec<String>,
    /// Those whose log is not there any more.
    pub missing: bool,
}

/// A session, or an input that was rejected, that is taken out.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Forgotten {
    /// The log, as the tables name it.
    pub log: String,
    /// The session; empty of a rejected input that has none.
    pub session_id: String,
    /// Its motorcycle; likewise.
    pub bike_id: String,
}

impl Forgotten {
    fn key(&self) -> Key {
        Key::new(&self.bike_id, &self.session_id)
    }
}

/// Sessions to remove, in order of log; with `for_good` they are removed. Work that a killed command left is done first; a
/// name that is gone by that is no error.
///
/// # Errors
/// A name that the output has not, another roadbench is writing, or the output cannot be written.
pub fn forget(out: &Location, which: &Selection, for_good: bool) -> Result<Vec<Forgotten>, Error> {
    mark::require(out)?;
    let is_carried_on = for_good && carry_on(out)?;
    let of_run = Contents::read(&kind::RUN, out)?;
    let of_diagnosis = Contents::read(&kind::DIAGNOSE, out)?;
    match known(&[&of_run, &of_diagnosis], which) {
        Err(e) if is_carried_on => tracing::info!("{e}; a killed command has already removed it"),
        known => known?,
    }
    let mut found = BTreeSet::new();
    let mut logs = Logs::default();
    for row in of_run.sessions().chain(of_diagnosis.sessions()) {
        let is_named =
            which.sessions.contains(&row.session_id) || which.bikes.contains(&row.bike_id);
        if is_named || (which.missing && logs.is_gone(&row.path)?) {
            found.insert(Forgotten {
                log: row.path.clone(),
                session_id: row.session_id.clone(),
                bike_id: row.bike_id.clone(),
            });
        }
    }
    let rejected = rejections(out, which, &mut logs)?;
    if which.missing {
        logs.check()?;
    }
    if for_good {
        take_out(out, &of_diagnosis, &found)?;
        take_out(out, &of_run, &found)?;
        for (at, _) in &rejected {
            at.remove().map_err(|e| Error::Output(format!("cannot remove {at}: {e}")))?;
        }
        if !found.is_empty() || !rejected.is_empty() {
            anew(out)?;
        }
    }
    found.extend(rejected.into_iter().map(|(_, forgotten)| forgotten));
    Ok(found.into_iter().collect())
}

/// Carries on what a killed command has left; whether there was anything.
fn carry_on(out: &Location) -> Result<bool, Error> {
    let mut is_left = false;
    for kind in [&kind::DIAGNOSE, &kind::RUN] {
        let there = Contents::read(kind, out)?;
        let is_behind = || {
            let mark = out.join(kind.behind);
            mark.exists().map_err(|e| Error::Output(format!("{mark}: {e}")))
        };
        if there.staged().next().is_some()
            || out.as_path().is_some_and(finish_derived::is_unfinished)
            || is_behind()?
        {
            let _open = Store::open(kind, out)?; // takes in what waits
            finish_derived::after_kill(out)?;
            is_left = true;
        }
    }
    if is_left {
        anew(out)?;
    }
    Ok(is_left)
}

/// Every name is one of the output's.
fn known(contents: &[&Contents], which: &Selection) -> Result<(), Error> {
    let rows = || contents.iter().flat_map(|c| c.sessions());
    let named = |what: &str, name: &String, all: BTreeSet<&str>| match all.contains(name.as_str()) {
        true => Ok(()),
        false => Err(Error::Usage(format!(
            "the output has no {what} `{name}`{}",
            meant(name, all.into_iter())
        ))),
    };
    for name in &which.sessions {
        named("session", name, rows().map(|r| r.session_id.as_str()).collect())?;
    }
    for name in &which.bikes {
        named("motorcycle", name, rows().map(|r| r.bike_id.as_str()).collect())?;
    }
    Ok(())
}

/// Which logs are there; each is looked for once.
#[derive(Default)]
struct Logs(BTreeMap<String, bool>);

impl Logs {
    fn is_gone(&mut self, path: &str) -> Result<bool, Error> {
        if let Some(gone) = self.0.get(path) {
            return Ok(*gone);
        }
        let at = Location::parse(path).map_err(|e| Error::Output(e.to_string()))?;
        let gone = !at.exists().map_err(|e| {
            Error::Output(format!(
                "cannot tell whether the log {path} exists: {e}; no session was removed. Make it \
                 readable, or give the sessions by --session or --bike"
            ))
        })?;
        self.0.insert(path.to_owned(), gone);
        Ok(gone)
    }

    /// Where most logs are gone it is rather their disk or the folder that is missing.
    fn check(&self) -> Result<(), Error> {
        let gone = self.0.values().filter(|gone| **gone).count();
        let first = self.0.iter().find(|(_, gone)| **gone).map(|(path, _)| path);
        match first {
            Some(first) if 2 * gone > self.0.len() => Err(Error::Usage(format!(
                "{gone} of the {} logs of this output do not exist ({first}, ...). Mount their \
                 disk, or start this command in the folder of `roadbench run`. To remove these \
                 sessions all the same, give them by --session or --bike",
                self.0.len()
            ))),
            _ => Ok(()),
        }
    }
}

/// Rows of `rejected` whose log is gone, or that name a session or motorcycle that goes.
fn rejections(
    out: &Location,
    which: &Selection,
    logs: &mut Logs,
) -> Result<Vec<(Location, Forgotten)>, Error> {
    let folder = out.join("rejected");
    let mut found = Vec::new();
    for entry in folder.list().map_err(|e| Error::Output(e.to_string()))? {
        let at = folder.join(&entry.key);
        if !at.has_extension("parquet") {
            continue;
        }
        let bytes = at.read().map_err(|e| Error::Output(format!("cannot read {at}: {e}")))?;
        let rows: Vec<Rejected> =
            read::rows_of(&at, bytes).map_err(|e| Error::Output(e.to_string()))?;
        let Some(row) = rows.into_iter().next() else { continue };
        let names =
            |all: &[String], name: &Option<String>| name.as_ref().is_some_and(|n| all.contains(n));
        let is_named = names(&which.sessions, &row.session_id) || names(&which.bikes, &row.bike_id);
        if is_named || (which.missing && logs.is_gone(&row.path)?) {
            let (session_id, bike_id) =
                (row.session_id.unwrap_or_default(), row.bike_id.unwrap_or_default());
            found.push((at, Forgotten { log: row.path, session_id, bike_id }));
        }
    }
    Ok(found)
}

/// Removes sessions from the tables of one command.
fn take_out(out: &Location, there: &Contents, found: &BTreeSet<Forgotten>) -> Result<(), Error> {
    let own: Vec<&Forgotten> = found.iter().filter(|f| !there.of(&f.key()).is_empty()).collect();
    if own.is_empty() {
        return Ok(());
    }
    let store = Store::open(there.kind, out)?;
    for session in own {
        // a run that ended meanwhile may have made it of another log
        if store.found().of(&session.key()).iter().any(|now| now.path == session.log) {
            store.remove(&session.key())?;
        }
    }
    store.merge()?;
    store.take_error().map_or(Ok(()), Err)
}

/// Writes the tables over all sessions again, for each command that has or had sessions.
fn anew(out: &Location) -> Result<(), Error> {
    let is_needed = |kind: &'static Kind| -> Result<bool, Error> {
        let mark = out.join(kind.behind);
        let is_behind = mark.exists().map_err(|e| Error::Output(format!("{mark}: {e}")))?;
        Ok(is_behind || Contents::read(kind, out)?.sessions().next().is_some())
    };
    if is_needed(&kind::DIAGNOSE)? {
        diagnose::finish(&Store::open(&kind::DIAGNOSE, out)?)?;
    }
    if is_needed(&kind::RUN)? {
        run::finish(&Store::open(&kind::RUN, out)?, Pages::Auto, |_| Ok(()))?;
    }
    Ok(())
}
