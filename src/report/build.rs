//! Building the report's folder: the pages of sessions and diagnoses, the fleet's, the run's.

use std::path::Path;

use minijinja::value::Serde;
use minijinja::{Environment, Value, context};

use crate::report::assets::{self, LONG_SCRIPT, Pages, Source};
use crate::report::diagnosis::sessions::Diagnosed;
use crate::report::error::Error;
use crate::report::fleet::{self, page::PAGE};
use crate::report::run::page as run;
use crate::report::session::{bench_values, write::Writer};
use crate::report::tables::{self, RunTables, SessionTables};
use crate::report::{page_names, page_shell};
use crate::tables::file;

/// Builds `out/report/` from the tables in `out`; pages of an earlier build go.
///
/// # Errors
/// The folder holds no tables, one cannot be read, or a page cannot be written.
pub fn write(out: &Path) -> Result<(), Error> {
    build(out, Pages::Auto, true)
}

/// As [`write()`], but a session's page that was made of the very same tables stays as it is.
///
/// # Errors
/// As [`write()`].
pub fn update(out: &Path) -> Result<(), Error> {
    build(out, Pages::Auto, false)
}

/// As [`write()`], or without `all` as [`update()`], with the pages of sessions as `kind` says.
///
/// # Errors
/// As [`write()`].
pub fn build(out: &Path, kind: Pages, all: bool) -> Result<(), Error> {
    let tables = RunTables::read(out)?;
    let bench = bench_values::read(out)?;
    let forces = tables::forces(out)?;
    let stored = SessionTables::read(out)?;
    let mut pages = page_names::sessions(tables.sessions.iter().map(|s| s.ident.key()));
    if kind == Pages::None {
        pages.iter_mut().for_each(String::clear);
    }
    let environment = page_shell::environment()?;
    let folder = out.join("report");
    let diagnosed = Diagnosed::read(out, &tables.sessions, &pages)?;
    let source = kind.source(tables.sessions.len().max(diagnosed.pages().count()));
    if source == Source::Folder {
        assets::write(&folder)?;
    }
    diagnosed.write(&environment, &folder, source)?;
    let writer = Writer {
        tables: &tables,
        stored: &stored,
        forces: &forces,
        bench: &bench,
        diagnosed: &diagnosed,
        environment: &environment,
        folder: &folder,
        source,
        kept: (!all).then_some(kind),
    };
    let shared = writer.write(&pages)?;
    let with_fleet = write_run(out, &environment, &tables, &pages, &diagnosed)?;

    let own: Vec<&str> = pages
        .iter()
        .map(String::as_str)
        .chain(diagnosed.pages())
        .chain(with_fleet.then_some(PAGE))
        .collect();
    page_shell::remove_stale(&folder, &own);
    if shared {
        assets::write(&folder)?; // pages that stayed may have lost them
    }
    assets::remove_stale(&folder, shared);
    Ok(())
}

/// Writes the run's page and, where there are tables of a fleet, the fleet's; whether there are.
fn write_run(
    out: &Path,
    environment: &Environment<'_>,
    tables: &RunTables,
    pages: &[String],
    diagnosed: &Diagnosed,
) -> Result<bool, Error> {
    let rejected = tables::rejected(out)?;
    let fleet = fleet::tables::fleet(out)?;
    let mut page = run::build(tables, pages, rejected, &fleet);
    page.diagnoses = diagnosed.entries();
    if !fleet.is_empty() && !tables.sessions.is_empty() {
        page.fleet = Some(fleet::write::write(out, environment, &tables.sessions, pages)?);
    }
    let html = environment.get_template("run.html")?.render(context! {
        run => Serde(&page),
        long_script => Value::from_safe_string(LONG_SCRIPT.to_owned()),
        ..page_shell::context(Source::Page)
    })?;
    file::write_bytes(out.join("report/index.html"), html.as_bytes())?;
    Ok(page.fleet.is_some())
}
