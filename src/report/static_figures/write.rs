//! Writing every plot of a report as an SVG or PNG file.

use std::path::Path;

use kuva::render::render::Scene;
use rayon::prelude::*;

use crate::report::charts::figures;
use crate::report::diagnosis::sessions::Diagnosed;
use crate::report::error::Error;
use crate::report::fleet::tables::FleetTables;
use crate::report::session::bench_values;
use crate::report::static_figures::chart;
use crate::report::static_figures::listed::Listed;
use crate::report::tables::{self, SessionTables};
use crate::report::{fleet, page_names};
use crate::store::tables::file;

/// File formats of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Lines and letters that stay sharp at any size and can be edited.
    Svg,
    /// Pixels, for what takes no SVG.
    Png,
    /// One file of each.
    Both,
}

impl Format {
    fn endings(self) -> &'static [&'static str] {
        match self {
            Format::Svg => &["svg"],
            Format::Png => &["png"],
            Format::Both => &["svg", "png"],
        }
    }
}

/// Writes every plot of every session, diagnosis and of the fleet into `to`: a folder each, a
/// file per plot and format; how many plots. Earlier figures whose session or coefficient is gone
/// go ([`Listed`]). `only` limits all to one session and leaves out the fleet; then nothing goes.
///
/// # Errors
/// The folder holds no tables, one cannot be read, or a file cannot be written.
pub fn figures(out: &Path, to: &Path, format: Format, only: Option<&str>) -> Result<usize, Error> {
    tables::check(out)?;
    let sessions = tables::sessions(out)?;
    let pages = page_names::sessions(sessions.iter().map(|s| s.ident.key()));
    let wanted = |id: &str| only.is_none_or(|o| o == id);
    let stored = SessionTables::read(out)?;
    let bench = bench_values::read(out)?;
    let listed = Listed::open(to, out)?;
    let save = |folder: &str, name: &str, figure: &Scene| -> Result<(), Error> {
        for ending in format.endings() {
            let name = format!("{folder}/{}.{ending}", page_names::stem(name));
            let path = to.join(&name);
            let bytes = match *ending {
                "svg" => chart::svg(figure).into_bytes(),
                _ => chart::png(figure)
                    .map_err(|message| Error::Figure { path: path.clone(), message })?,
            };
            listed.add(&name)?;
            file::write_bytes(path, &bytes)?;
        }
        Ok(())
    };
    let drawn = sessions
        .par_iter()
        .zip(&pages)
        .filter(|(s, _)| wanted(&s.ident.session_id))
        .map(|(session, name)| -> Result<usize, Error> {
            let points = stored.plots(&session.ident)?;
            let manoeuvres = stored.manoeuvres(&session.ident)?;
            let mut drawn = figures::build(&points, &manoeuvres);
            bench.draw(&session.ident.bike_id, &mut drawn.charts);
            let folder = name.trim_end_matches(".html");
            for chart in &drawn.charts {
                save(folder, &chart.name, &chart::scene(chart))?;
            }
            let timeline = usize::from(!drawn.panels.is_empty());
            if timeline > 0 {
                save(folder, "timeline", &chart::timeline(&drawn.panels, &drawn.segments))?;
            }
            Ok(drawn.charts.len() + timeline)
        })
        .try_reduce(|| 0, |a, b| Ok(a + b))?;
    let diagnosed = Diagnosed::read(out, &sessions, &pages, &pages)?;
    let of_diagnoses = diagnosed.draw(&wanted, &save)?;
    if only.is_some() {
        return Ok(drawn + of_diagnoses);
    }
    let (_, charts) = fleet::write::read(out, &sessions, &pages)?;
    for chart in &charts {
        save("fleet", &chart.name, &chart::scene(chart))?;
    }
    let tables = FleetTables {
        sessions: &sessions,
        pages: &pages,
        rows: &fleet::tables::fleet(out)?,
        events: &[],
        histories: &fleet::tables::histories(out, &sessions)?,
    };
    let compared = fleet::comparison::boxes(&tables);
    for boxes in &compared {
        save("fleet", &boxes.name, &chart::boxes(boxes))?;
    }
    listed.remove_others(format.endings())?;
    Ok(drawn + of_diagnoses + charts.len() + compared.len())
}
