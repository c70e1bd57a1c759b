//! Writing the page over all sessions.

use std::path::Path;

use minijinja::value::Serde;
use minijinja::{Environment, Value, context};

use crate::report::assets::{LONG_SCRIPT, Source};
use crate::report::charts::chart::{self, Chart};
use crate::report::charts::figures::Figures;
use crate::report::charts::pack;
use crate::report::error::Error;
use crate::report::fleet::page::{self, PAGE, Page};
use crate::report::fleet::tables::FleetTables;
use crate::report::fleet::tyres::{self, Tyres};
use crate::report::fleet::what_changed::motorcycle::Motorcycle;
use crate::report::fleet::{lists, ratios, tables};
use crate::report::page_shell;
use crate::store::tables::file;
use crate::store::tables::rows::SessionRow;

/// Writes the page. `changed` are the motorcycles of which something can be said.
pub(crate) fn write(
    out: &Path,
    environment: &Environment<'_>,
    fleet: &FleetTables<'_>,
    changed: &[Motorcycle],
) -> Result<(), Error> {
    let (page, charts) = of_tables(out, fleet)?;
    let found = Tyres::read(out)?;
    let tyres = match found.tyres.is_empty() {
        true => None,
        false => Some(tyres::tyres(&found.tyres).shown()?),
    };
    let doubted = match found.doubted.is_empty() {
        true => None,
        false => Some(tyres::bikes(&found.doubted).shown()?),
    };
    let figures = Figures { charts, ..Figures::default() };
    let list = lists::changes(changed);
    let changes = if list.rows.is_empty() { None } else { Some(list.shown()?) };
    let ratios = match &page.ratios {
        Some((ratios, _)) if !ratios.is_empty() => Some(lists::ratios(ratios).shown()?),
        _ => None,
    };
    let html = environment.get_template("fleet.html")?.render(context! {
        page => context! {
            bikes => page.bikes,
            verdict => page.verdict,
            sub => page.sub,
            more => page.more,
            tyres => Serde(&page.tyres),
        },
        tyres => Serde(tyres),
        tyres_summary => found.summary(),
        doubted => Serde(doubted),
        changes => Serde(changes),
        ratios => Serde(ratios),
        without_ratio => page.ratios.as_ref().map(|r| r.1.as_str()),
        long_script => Value::from_safe_string(LONG_SCRIPT.to_owned()),
        charts => Serde(chart::heads(&figures.charts)),
        data => Value::from_safe_string(pack::pack(&figures)?),
        ..page_shell::context(Source::Page)
    })?;
    file::write_bytes(out.join("report").join(PAGE), html.as_bytes())?;
    Ok(())
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
    of_tables(out, &FleetTables { sessions, pages, rows, events, histories })
}

fn of_tables(out: &Path, fleet: &FleetTables<'_>) -> Result<(Page, Vec<Chart>), Error> {
    let (mut page, charts) = page::build(fleet);
    page.ratios = ratios::build(&tables::ratios(out)?, fleet.rows);
    Ok((page, charts))
}
