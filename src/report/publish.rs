//! The report for other places than a browser: every plot as an SVG or PNG file, the summary as
//! Markdown.

use std::path::Path;

use kuva::render::render::Scene;
use rayon::prelude::*;

use crate::report::diagnosis_pages::Diagnosed;
use crate::report::fleet::Page as Fleet;
use crate::report::{
    Error, bench, check, figures, fleet, index, markdown, names, page, ratios, run_of, still,
    tables, tables_fleet,
};
use crate::tables::file;
use crate::tables::rows::SessionRow;

/// What files a figure becomes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// Lines and letters that stay sharp at any size and can be edited.
    #[default]
    Svg,
    /// Pixels, for what takes no SVG.
    Png,
    /// One file of each.
    Both,
}

/// Writes every plot of every session, diagnosis and of the fleet into `to`: a folder each, a
/// file per plot and format; how many plots. `only` limits them to one session and leaves out the
/// fleet.
///
/// # Errors
/// The folder holds no tables, one cannot be read, or a file cannot be written.
pub fn figures(out: &Path, to: &Path, format: Format, only: Option<&str>) -> Result<usize, Error> {
    check(out)?;
    let sessions = tables::sessions(out)?;
    let pages = pages(&sessions);
    let wanted = |id: &str| only.is_none_or(|o| o == id);
    let plot_files = tables::session_files(out, "plots")?;
    let manoeuvre_files = tables::session_files(out, "manoeuvres")?;
    let bench = bench::read(out)?;
    let save = |folder: &str, name: &str, figure: &Scene| -> Result<(), Error> {
        let file = |ending: &str| to.join(folder).join(format!("{}.{ending}", names::stem(name)));
        if format != Format::Png {
            file::write_bytes(&file("svg"), still::svg(figure).as_bytes())?;
        }
        if format != Format::Svg {
            let path = file("png");
            let bytes = still::png(figure)
                .map_err(|message| Error::Figure { path: path.clone(), message })?;
            file::write_bytes(&path, &bytes)?;
        }
        Ok(())
    };
    let drawn = sessions
        .par_iter()
        .zip(&pages)
        .filter(|(s, _)| wanted(&s.ident.session_id))
        .map(|(session, name)| -> Result<usize, Error> {
            let (bike, id) = tables::key(&session.ident);
            let files = |f: &tables::Files| {
                f.get(&(bike.to_owned(), id.to_owned())).cloned().unwrap_or_default()
            };
            let points = tables::plots(&files(&plot_files), bike, id)?;
            let manoeuvres = tables::manoeuvres(&files(&manoeuvre_files), bike, id)?;
            let mut figures = figures::build(&points, &manoeuvres);
            bench.draw(bike, &mut figures.charts);
            let folder = name.trim_end_matches(".html");
            for chart in &figures.charts {
                save(folder, &chart.name, &still::chart(chart))?;
            }
            let timeline = usize::from(!figures.panels.is_empty());
            if timeline > 0 {
                save(folder, "timeline", &still::timeline(&figures.panels, &figures.segments))?;
            }
            Ok(figures.charts.len() + timeline)
        })
        .try_reduce(|| 0, |a, b| Ok(a + b))?;
    let diagnosed = Diagnosed::read(out, &sessions, &pages)?;
    let of_diagnoses = diagnosed.draw(&wanted, &save)?;
    if only.is_some() {
        return Ok(drawn + of_diagnoses);
    }
    let (_, charts) = over_all(out, &sessions, &pages)?;
    for chart in &charts {
        save("fleet", &chart.name, &still::chart(chart))?;
    }
    let compared =
        fleet::compared(&sessions, &tables_fleet::fleet(out)?, &histories(out, &sessions)?);
    for boxes in &compared {
        save("fleet", &boxes.name, &still::boxes(boxes))?;
    }
    Ok(drawn + of_diagnoses + charts.len() + compared.len())
}

/// The summary of an output as Markdown.
///
/// # Errors
/// The folder holds no tables, or one cannot be read.
pub fn summary(out: &Path) -> Result<String, Error> {
    check(out)?;
    let sessions = tables::sessions(out)?;
    let pages = pages(&sessions);
    let coefficients = tables::coefficients(out)?;
    let warnings = tables::warnings(out)?;
    let rows = tables_fleet::fleet(out)?;
    let rejected = tables::rejected(out)?;
    let mut run = index::build(&sessions, &pages, &coefficients, &warnings, rejected, &rows);
    run.diagnoses = Diagnosed::read(out, &sessions, &pages)?.entries();
    let fleet = over_all(out, &sessions, &pages)?.0;
    let only = match sessions.as_slice() {
        [session] => {
            let key = tables::key(&session.ident);
            let files = tables::session_files(out, "manoeuvres")?;
            let own = files.get(&(key.0.to_owned(), key.1.to_owned()));
            let manoeuvres = tables::manoeuvres(own.map_or(&[], Vec::as_slice), key.0, key.1)?;
            let coefficients = run_of(&coefficients, key, |c| tables::key(&c.ident));
            let warnings = run_of(&warnings, key, |w| tables::key(&w.ident));
            Some(page::build(session, coefficients, &manoeuvres, warnings))
        }
        _ => None,
    };
    Ok(markdown::write(&run, Some(&fleet), only.as_ref()))
}

fn pages(sessions: &[SessionRow]) -> Vec<String> {
    names::pages(sessions.iter().map(|s| tables::key(&s.ident)))
}

fn histories(out: &Path, sessions: &[SessionRow]) -> Result<tables_fleet::Histories, Error> {
    let places = sessions.iter().enumerate().map(|(i, s)| (tables::key(&s.ident), i)).collect();
    tables_fleet::histories(out, &places)
}

/// What the tables over all sessions say; empty where there are none.
pub(super) fn over_all(
    out: &Path,
    sessions: &[SessionRow],
    pages: &[String],
) -> Result<(Fleet, Vec<figures::Chart>), Error> {
    let rows = tables_fleet::fleet(out)?;
    let events = tables_fleet::events(out)?;
    let histories = histories(out, sessions)?;
    let (mut page, charts) = fleet::build(sessions, pages, &rows, &events, &histories);
    page.ratios = ratios::build(&tables_fleet::ratios(out)?, &rows);
    Ok((page, charts))
}
