//! The summary of an output as Markdown, from its tables.

use std::path::Path;

use crate::report::diagnosis::sessions::Diagnosed;
use crate::report::error::Error;
use crate::report::tables::{self, RunTables, SessionTables};
use crate::report::{fleet, markdown, page_names, run, session};

/// The summary of an output as Markdown.
///
/// # Errors
/// The folder holds no tables, or one cannot be read.
pub fn markdown(out: &Path) -> Result<String, Error> {
    let tables = RunTables::read(out)?;
    let pages = page_names::sessions(tables.sessions.iter().map(|s| s.ident.key()));
    let rows = fleet::tables::fleet(out)?;
    let mut index = run::page::build(&tables, &pages, tables::rejected(out)?, &rows, &[]);
    index.diagnoses = Diagnosed::read(out, &tables.sessions, &pages, &pages)?.entries();
    let (over_all, _) = fleet::write::read(out, &tables.sessions, &pages)?;
    let only = match tables.sessions.as_slice() {
        [session] => {
            let ident = &session.ident;
            let stored = SessionTables::read(out)?;
            let manoeuvres = stored.manoeuvres(ident)?;
            let (laps, corners) = stored.laps(ident)?;
            let trends = stored.lap_trends(ident)?;
            let coefficients = tables.coefficients_of(ident);
            let warnings = tables.warnings_of(ident);
            let page = session::page::build(session, coefficients, &manoeuvres, warnings);
            let laps = session::laps::page(&laps, &corners, &trends);
            Some(session::page::Page { laps, ..page })
        }
        _ => None,
    };
    Ok(markdown::write(&index, Some(&over_all), only.as_ref()))
}
