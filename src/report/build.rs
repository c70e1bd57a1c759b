//! Building the report's folder: the pages of sessions and diagnoses, the fleet's, the run's.

use std::path::Path;

use crate::report::assets::{self, Pages, Source};
use crate::report::diagnosis::sessions::Diagnosed;
use crate::report::error::Error;
use crate::report::lock::Lock;
use crate::report::run::write as run;
use crate::report::session::neighbours::{Neighbours, neighbours};
use crate::report::session::{bench_values, write::Writer};
use crate::report::tables::{self, RunTables, SessionTables};
use crate::report::written::Written;
use crate::report::{page_names, page_shell};

/// Builds `out/report/` from the tables in `out`; pages of an earlier build go.
///
/// # Errors
/// The folder holds no tables, one cannot be read, or a page cannot be written.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn write(out: &Path) -> Result<(), Error> {
    build(out, Pages::Auto, true)
}

/// As [`write()`], but a session's page that was made of the very same tables stays as it is.
///
/// # Errors
/// As [`write()`].
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn update(out: &Path) -> Result<(), Error> {
    build(out, Pages::Auto, false)
}

/// As [`write()`], or without `all` as [`update()`], with the pages of sessions as `kind` says; those
/// on demand stay while they are up to date.
///
/// # Errors
/// As [`write()`].
pub fn build(out: &Path, kind: Pages, all: bool) -> Result<(), Error> {
    tables::check(out)?;
    let _lock = Lock::take(out); // before the tables are read: the last to come sees the last tables
    let tables = RunTables::read(out)?;
    let bench = bench_values::read(out)?;
    let folder = out.join("report");
    let mut names = page_names::sessions(tables.sessions.iter().map(|s| s.ident.key()));
    if kind == Pages::None {
        names.iter_mut().for_each(String::clear);
    }
    let on_demand = kind.on_demand(names.len());
    let mut pages = names.clone();
    if on_demand {
        let there = page_shell::written(&folder);
        pages.iter_mut().filter(|p| !there.contains(*p)).for_each(String::clear);
    }
    // hundreds of thousands of files: not read where no page is made of them
    let none = pages.iter().all(String::is_empty);
    let forces = if none { Vec::new() } else { tables::forces(out)? };
    let stored = if none { SessionTables::default() } else { SessionTables::read(out)? };
    let environment = page_shell::environment()?;
    let diagnosed = Diagnosed::read(out, &tables.sessions, &pages, &names)?;
    let source = kind.source(tables.sessions.len().max(diagnosed.pages().count()));
    if source == Source::Folder {
        assets::write(&folder)?;
    }
    diagnosed.write(&environment, &folder, source)?;
    // pages on demand lead nowhere: each would be written again with the next
    let beside = match on_demand {
        true => vec![Neighbours::default(); tables.sessions.len()],
        false => neighbours(&tables.sessions, &pages),
    };
    // read before any page is replaced
    let whole = Written::whole(&folder);
    let writer = Writer {
        tables: &tables,
        stored: &stored,
        forces: &forces,
        bench: &bench,
        diagnosed: &diagnosed,
        environment: &environment,
        folder: &folder,
        source,
        kept: (on_demand || !all).then_some(kind),
        neighbours: &beside,
        whole: &whole,
    };
    let shared = writer.write(&pages)?;
    if on_demand {
        assets::write_written(&folder, pages.iter().map(String::as_str))?;
    }
    let (tables, diagnosed) = (&tables, &diagnosed);
    let (names, pages, environment) = (&names, &pages, &environment);
    let others =
        run::Writer { out, environment, tables, diagnosed, names, pages, on_demand, bench: &bench }
            .write()?;

    let own: Vec<&str> = pages
        .iter()
        .map(String::as_str)
        .chain(diagnosed.pages())
        .chain(others.iter().map(String::as_str))
        .collect();
    page_shell::remove_stale(&folder, &own);
    if shared {
        assets::write(&folder)?; // pages that stayed may have lost them
    }
    assets::remove_stale(&folder, shared, on_demand);
    Written::list(&folder)
}
