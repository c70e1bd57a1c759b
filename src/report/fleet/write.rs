//! Writing the page over all sessions.

use std::path::Path;

use minijinja::value::Serde;
use minijinja::{Environment, Value, context};

use crate::report::assets::Source;
use crate::report::charts::chart::{self, Chart};
use crate::report::charts::figures::Figures;
use crate::report::charts::pack;
use crate::report::error::Error;
use crate::report::fleet::page::{self, PAGE, Page};
use crate::report::fleet::tables::FleetTables;
use crate::report::fleet::{ratios, tables};
use crate::report::page_shell;
use crate::tables::file;
use crate::tables::rows::SessionRow;

/// Writes the page; the number of events on it. `pages` are the sessions' pages.
pub(crate) fn write(
    out: &Path,
    environment: &Environment<'_>,
    sessions: &[SessionRow],
    pages: &[String],
) -> Result<usize, Error> {
    let (page, charts) = read(out, sessions, pages)?;
    let figures = Figures { charts, ..Figures::default() };
    let html = environment.get_template("fleet.html")?.render(context! {
        page => Serde(&page),
        charts => Serde(chart::heads(&figures.charts)),
        data => Value::from_safe_string(pack::pack(&figures)?),
        ..page_shell::context(Source::Page)
    })?;
    file::write_bytes(out.join("report").join(PAGE), html.as_bytes())?;
    Ok(page.events.len())
}

/// The page and its charts from the tables over all sessions; empty where there are none.
pub(crate) fn read(
    out: &Path,
    sessions: &[SessionRow],
    pages: &[String],
) -> Result<(Page, Vec<Chart>), Error> {
    let rows = tables::fleet(out)?;
    let events = tables::events(out)?;
    let histories = tables::histories(out, sessions)?;
    let (rows, events, histories) = (&rows, &events, &histories);
    let fleet = FleetTables { sessions, pages, rows, events, histories };
    let (mut page, charts) = page::build(&fleet);
    page.ratios = ratios::build(&tables::ratios(out)?, rows);
    Ok((page, charts))
}
