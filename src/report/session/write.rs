//! Writing the pages of the sessions.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use minijinja::value::Serde;
use minijinja::{Environment, Value, context};
use rayon::prelude::*;

use crate::report::assets::{Pages, Source};
use crate::report::charts::pack;
use crate::report::charts::{chart, figures};
use crate::report::diagnosis::sessions::Diagnosed;
use crate::report::error::Error;
use crate::report::page_shell;
use crate::report::session::bench_values::BenchValues;
use crate::report::session::neighbours::Neighbours;
use crate::report::session::{forces, laps, page};
use crate::report::tables::{self, RunTables, SessionTables};
use crate::store::tables::file;
use crate::store::tables::rows::{ForceRow, SessionRow};

/// All that the pages of a run's sessions are made from.
pub(crate) struct Writer<'a> {
    pub(crate) tables: &'a RunTables,
    pub(crate) stored: &'a SessionTables,
    pub(crate) forces: &'a [ForceRow],
    pub(crate) bench: &'a BenchValues,
    pub(crate) diagnosed: &'a Diagnosed,
    pub(crate) environment: &'a Environment<'a>,
    /// Where the pages go.
    pub(crate) folder: &'a Path,
    /// Where a page that is written now has script and style from.
    pub(crate) source: Source,
    /// Of which kind an existing page may be that is up to date and so stays; none is to stay.
    pub(crate) kept: Option<Pages>,
    /// Neighbours of each session's page.
    pub(crate) neighbours: &'a [Neighbours],
    /// Names of the existing pages that are as they were written.
    pub(crate) whole: &'a BTreeSet<String>,
}

impl Writer<'_> {
    /// Writes the pages called `names`, one per session in their order, an empty name none; whether
    /// any page, written or kept, uses the shared script and style.
    pub(crate) fn write(&self, names: &[String]) -> Result<bool, Error> {
        let shared = AtomicBool::new(self.source == Source::Folder);
        // pages are independent of each other: their order of writing shows nowhere
        let sessions = self.tables.sessions.par_iter().zip(names).zip(self.neighbours);
        sessions.filter(|((_, name), _)| !name.is_empty()).try_for_each(
            |((session, name), n)| {
                if self.one(session, name, n)? == Source::Folder {
                    shared.fetch_or(true, Ordering::Relaxed);
                }
                Ok::<(), Error>(())
            },
        )?;
        Ok(shared.into_inner())
    }

    /// Writes or keeps one page; where it has its script and style from.
    fn one(
        &self,
        session: &SessionRow,
        name: &str,
        neighbours: &Neighbours,
    ) -> Result<Source, Error> {
        let path = self.folder.join(name);
        let ident = &session.ident;
        let diagnosis = self.diagnosed.page_of(ident);
        let causes = self.diagnosed.causes_of(ident);
        let links = neighbours.each_ref().map(|n| n.as_ref().map_or("", |n| &n.page));
        let forces = tables::rows_of(self.forces, ident, |f| &f.ident);
        let (coefficients, warnings) =
            (self.tables.coefficients_of(ident), self.tables.warnings_of(ident));
        let parameters = self.tables.parameters_of(ident);
        // a table that was damaged has no rows here, and has them again once it is repaired
        let of_run = [coefficients.len(), warnings.len(), parameters.len(), forces.len()];
        let rows: Vec<usize> = of_run.into_iter().chain(self.stored.counts(ident)).collect();
        let fingerprint = page_shell::fingerprint(
            session,
            &rows,
            [diagnosis.unwrap_or_default(), &causes.join("\n")],
            &self.bench.text,
            links,
        );
        if let Some(kind) = self.kept
            && self.whole.contains(name)
            && let Some(source) = page_shell::source_if_current(&path, &fingerprint)
            && kind.accepts(source)
        {
            return Ok(source);
        }
        let manoeuvres = self.stored.manoeuvres(ident)?;
        let points = self.stored.plots(ident)?;
        let mut drawn = figures::build(&points, &manoeuvres);
        self.bench.draw(&ident.bike_id, &mut drawn.charts);
        let mut page = page::build(session, coefficients, &manoeuvres, warnings);
        page.compare(self.bench);
        if let Some(answer) = forces::answer(forces, &manoeuvres) {
            page.answer = answer;
            // of tyres it rarely determines anything
            page.cards.retain(|card| card.rows.iter().any(|row| !row.value.is_empty()));
        }
        let (lap_rows, corners) = self.stored.laps(ident)?;
        if !lap_rows.is_empty() {
            page.laps = laps::page(&lap_rows, &corners, &self.stored.lap_trends(ident)?);
            drawn.laps = laps::figure(&lap_rows, &corners, &self.stored.lap_points(ident)?);
        }
        figures::share_time(&mut drawn.panels);
        let explored: Vec<&str> = parameters.iter().map(|p| p.tyre.as_str()).collect();
        let html = self.environment.get_template("session.html")?.render(context! {
            page => Serde(page),
            charts => Serde(chart::heads(&drawn.charts)),
            panels => Serde(chart::heads(&drawn.panels)),
            residuals => Serde(chart::residuals(&drawn.charts)),
            bins => crate::report::plots::sheet::TIMELINE_BINS,
            absent => page::absent_charts(&drawn),
            offroad => page::is_offroad(&drawn),
            forces => Serde(forces::table(forces)),
            diagnosis => diagnosis,
            causes => Serde(&causes),
            explored => Serde(&explored),
            neighbours => Serde(neighbours),
            data => Value::from_safe_string(pack::pack(&drawn)?),
            ..page_shell::context(self.source)
        })?;
        let html = page_shell::stamped(&html, &fingerprint, self.source);
        file::write_bytes(&path, html.as_bytes())?;
        Ok(self.source)
    }
}
