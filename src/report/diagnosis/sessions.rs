//! The pages of diagnosed sessions: which there are, what they are called, and writing them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use kuva::render::render::Scene;
use minijinja::value::Serde;
use minijinja::{Environment, Value, context};
use rayon::prelude::*;

use crate::report::assets::Source;
use crate::report::charts::figures::Figures;
use crate::report::charts::pack;
use crate::report::diagnosis::{
    answer, changes, extended_model, misfits, outcome, overlays, page, tables,
};
use crate::report::error::Error;
use crate::report::static_figures::chart;
use crate::report::tables::rows_of;
use crate::report::{page_names, page_shell};
use crate::statistics::number_format::typeset_sentence;
use crate::store::tables::by_session::SessionFiles;
use crate::store::tables::file;
use crate::store::tables::names::file_name;
use crate::store::tables::rows::{
    CauseRow, ChangeRow, DiscrepancyRow, Ident, SessionRow, SimulatedSample, SimulationError,
};

/// Every diagnosed session of a folder.
#[derive(Debug)]
pub(crate) struct Diagnosed {
    out: PathBuf,
    sessions: Vec<Session>,
    causes: Vec<CauseRow>,
    /// Of what several sessions share.
    shared: Vec<CauseRow>,
    discrepancies: Vec<DiscrepancyRow>,
    simulation_errors: Vec<SimulationError>,
    replays: SessionFiles<SimulatedSample>,
    changes: Vec<ChangeRow>,
}

/// A sentence of the terminal without the name of the effect, which stands between backticks after a semicolon.
fn without_key(sentence: &str) -> String {
    let Some(from) = sentence.find("; `") else { return sentence.to_owned() };
    let Some(length) = sentence[from + 3..].find('`') else { return sentence.to_owned() };
    format!("{}{}", &sentence[..from], &sentence[from + 3 + length + 1..])
}

#[derive(Debug)]
struct Session {
    ident: Ident,
    page: String,
    /// The page with its coefficients.
    coefficients: Option<String>,
}

impl Diagnosed {
    /// Reads the tables of `diagnose`; `pages` are those of the `sessions`, an empty name where there is
    /// none, and none of the `taken` names becomes a diagnosis'. A folder without such tables has no
    /// diagnosed sessions.
    ///
    /// # Errors
    /// A table cannot be read.
    pub(crate) fn read(
        out: &Path,
        sessions: &[SessionRow],
        pages: &[String],
        taken: &[String],
    ) -> Result<Self, Error> {
        let (causes, shared) = tables::causes_and_shared(out)?;
        let discrepancies = tables::discrepancies(out)?;
        let simulation_errors = tables::simulation_errors(out)?;
        let mut idents: BTreeMap<(&str, &str), &Ident> = BTreeMap::new();
        for ident in causes.iter().map(|c| &c.ident).chain(discrepancies.iter().map(|d| &d.ident)) {
            idents.entry(ident.key()).or_insert(ident);
        }
        let known: BTreeMap<(&str, &str), &String> =
            sessions.iter().map(|s| s.ident.key()).zip(pages).collect();
        let named = page_names::diagnoses(idents.keys().copied(), taken);
        let sessions = idents
            .iter()
            .zip(named)
            .map(|((key, ident), page)| Session {
                ident: (*ident).clone(),
                page,
                coefficients: known.get(key).map(|p| (*p).clone()).filter(|p| !p.is_empty()),
            })
            .collect();
        let (replays, changes) = (SessionFiles::read(out)?, changes::read(out)?);
        let out = out.to_owned();
        Ok(Diagnosed {
            out,
            sessions,
            causes,
            shared,
            discrepancies,
            simulation_errors,
            replays,
            changes,
        })
    }

    /// The pages' file names.
    pub(crate) fn pages(&self) -> impl Iterator<Item = &str> {
        self.sessions.iter().map(|s| s.page.as_str())
    }

    /// The page of a session's diagnosis, if it has one.
    pub(crate) fn page_of(&self, ident: &Ident) -> Option<&str> {
        let found = self.sessions.binary_search_by(|s| s.ident.key().cmp(&ident.key())).ok()?;
        Some(&self.sessions[found].page)
    }

    /// Differences between the rides of each motorcycle.
    pub(crate) fn changes(&self) -> &[ChangeRow] {
        &self.changes
    }

    /// Summary of the diagnoses, in sentences: shared causes first. Empty where nothing was diagnosed.
    pub(crate) fn answer(&self) -> Vec<String> {
        let sessions: Vec<Vec<CauseRow>> =
            self.sessions.iter().map(|s| self.rows(&s.ident).0.to_vec()).collect();
        let said = answer::said(&sessions, &self.shared);
        let named = |sentence: &String| {
            let here =
                sentence.replace(" of single rides: -v or the report.", ", in single rides.");
            typeset_sentence(&without_key(&here))
        };
        said.iter().map(named).collect()
    }

    /// Findings in a session, in clauses.
    pub(crate) fn causes_of(&self, ident: &Ident) -> Vec<String> {
        answer::of_session(self.rows(ident).0).iter().map(|c| typeset_sentence(c)).collect()
    }

    /// Lines of the run's page.
    pub(crate) fn entries(&self) -> Vec<outcome::Entry> {
        self.sessions
            .iter()
            .map(|s| {
                let (causes, discrepancies) = self.rows(&s.ident);
                outcome::entry(&s.ident, &s.page, causes, discrepancies, self.simulated(&s.ident))
            })
            .collect()
    }

    fn rows(&self, ident: &Ident) -> (&[CauseRow], &[DiscrepancyRow]) {
        (
            rows_of(&self.causes, ident, |c| &c.ident),
            rows_of(&self.discrepancies, ident, |d| &d.ident),
        )
    }

    fn simulated(&self, ident: &Ident) -> &[SimulationError] {
        rows_of(&self.simulation_errors, ident, |e| &e.ident)
    }

    /// The extended model that `diagnose` wrote beside its tables, if there is one.
    fn model(&self, ident: &Ident) -> Option<extended_model::Model> {
        let file = format!("{}.toml", file_name(&ident.session_id));
        let path = Path::new("models").join(format!("bike={}", ident.bike_id)).join(file);
        let text = std::fs::read_to_string(self.out.join(&path)).ok()?;
        extended_model::model(&text, &path.to_string_lossy())
    }

    /// Draws the overlays of the sessions that are wanted: `save` is given folder, name and figure
    /// of each; how many.
    ///
    /// # Errors
    /// The replays cannot be read, or `save` fails.
    pub(crate) fn draw(
        &self,
        wanted: &dyn Fn(&str) -> bool,
        save: &dyn Fn(&str, &str, &Scene) -> Result<(), Error>,
    ) -> Result<usize, Error> {
        let mut drawn = 0;
        for session in self.sessions.iter().filter(|s| wanted(&s.ident.session_id)) {
            let (_, discrepancies) = self.rows(&session.ident);
            let samples = tables::replays(&self.replays, &session.ident)?;
            let misfits = misfits::worst_first(discrepancies);
            let errors = self.simulated(&session.ident);
            let (overlays, mut charts) = overlays::overlays(&samples, errors, &misfits);
            let folder = session.page.trim_end_matches(".html");
            for (i, overlay) in overlays.iter().enumerate() {
                for (k, what) in ["signal", "residual"].into_iter().enumerate() {
                    let Some(chart) = charts.get_mut(overlay.charts[k]) else { continue };
                    chart.title = overlay.title.clone();
                    save(folder, &format!("{}_{what}", i + 1), &chart::scene(chart))?;
                    drawn += 1;
                }
            }
        }
        Ok(drawn)
    }

    /// Writes every page into the report's folder.
    ///
    /// # Errors
    /// The replays cannot be read, or a page cannot be written.
    pub(crate) fn write(
        &self,
        environment: &Environment<'_>,
        folder: &Path,
        source: Source,
    ) -> Result<(), Error> {
        self.sessions.par_iter().try_for_each(|session| {
            let (causes, discrepancies) = self.rows(&session.ident);
            let samples = tables::replays(&self.replays, &session.ident)?;
            let misfits = misfits::worst_first(discrepancies);
            let errors = self.simulated(&session.ident);
            let (overlays, charts) = overlays::overlays(&samples, errors, &misfits);
            let figures = Figures { charts, ..Figures::default() };
            let page = page::build(&session.ident, causes, discrepancies, errors);
            let html = environment.get_template("diagnosis.html")?.render(context! {
                page => Serde(page),
                changes => Serde(changes::of_session(&self.changes, &session.ident)),
                overlays => Serde(overlays),
                model => Serde(self.model(&session.ident)),
                session => session.coefficients.as_deref(),
                data => Value::from_safe_string(pack::pack(&figures)?),
                ..page_shell::context(source)
            })?;
            Ok(file::write_bytes(folder.join(&session.page), html.as_bytes())?)
        })
    }
}
