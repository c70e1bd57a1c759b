//! The work of `roadbench diagnose`: each session's causes by [`diagnose::run`], then what several
//! sessions share, and the report.

use serde::{Deserialize, Serialize};

use super::bikes::BikeFile;
use super::job_kind::JobKind;
use super::pooled::{self, OverAll};
use super::work::{Output, SessionFile, Work, encoded};
use crate::batch::error::Error;
use crate::batch::store::empty;
use crate::batch::store::finish_derived;
use crate::batch::store::folder::Store;
use crate::batch::store::kind;
use crate::batch::store::kind::{CHANGES, Kind, SHARED, SHARED_PLACES};
use crate::batch::store::local_copy::LocalCopy;
use crate::batch::store::mark;
use crate::diagnose::reference::against::Against;
use crate::diagnose::{self, Diagnosis, Settings};
use crate::pipeline::{Input, Pipeline, Rejection};
use crate::report::{self, Pages};
use crate::store::tables::rows::{CauseRow, DiagnosisRow, Ident, Provenance};
use crate::store::tables::{file, registry};

/// Work of `roadbench diagnose`: the diagnosis of one session.
#[derive(Debug, Default)]
pub struct DiagnoseWork {
    /// Number of fault-free simulations, candidates and advice.
    pub settings: Settings,
}

/// Summary of a session's diagnosis, for the terminal.
#[derive(Debug, Serialize, Deserialize)]
pub struct Verdict {
    /// Lines for a terminal, the last one not ended.
    pub summary: String,
    /// Its rows of `causes`.
    pub causes: Vec<CauseRow>,
    /// The session; without fault-free simulations it has no causes.
    pub ident: Ident,
}

impl Work for DiagnoseWork {
    type Result = Verdict;

    fn kind(&self) -> &'static Kind {
        &kind::DIAGNOSE
    }

    fn settings(&self) -> String {
        let Settings { nulls, advise, effects } = &self.settings;
        let effects: Vec<&str> = effects.iter().map(|e| e.name).collect();
        format!("nulls = {nulls}\nadvise = {advise}\neffects = {}\n", effects.join(", "))
    }

    /// Effects that were chosen are of tests and studies.
    fn what(&self) -> Option<JobKind> {
        let Settings { nulls, advise, effects } = &self.settings;
        let all = Settings::default().effects;
        let is_all = effects.iter().map(|e| e.name).eq(all.iter().map(|e| e.name));
        is_all.then_some(JobKind::Diagnose { nulls: *nulls, advise: *advise })
    }

    fn run(
        &self,
        input: &Input<'_>,
        bike: &BikeFile,
        pipeline: &Pipeline,
    ) -> Result<Output<Verdict>, Rejection> {
        let d = diagnose::run(input, &bike.bike, pipeline, &self.settings)?;
        let mut files = encoded(&self.tables(&d, input).map_err(|e| Rejection::unwritable(&e))?)
            .map_err(|e| Rejection::unwritable(&e))?;
        if let Some(model) = &d.model {
            let bytes = model.to_toml().into_bytes();
            files.push(SessionFile { folder: "models", extension: "toml", bytes });
        }
        let verdict = Verdict { summary: d.summary, causes: d.causes, ident: d.ident.clone() };
        Ok(Output { ident: d.ident, samples: d.n_samples, files, result: Some(verdict) })
    }
}

impl DiagnoseWork {
    /// Checks the settings.
    ///
    /// # Errors
    /// A sentence that begins with the number of nulls.
    pub fn new(settings: Settings) -> Result<Self, String> {
        match settings.nulls {
            0 | 8..=1000 => Ok(DiagnoseWork { settings }),
            nulls => Err(format!(
                "{nulls} fault-free simulations: give 8 to 1000, or 0 to compare only a motorcycle's rides"
            )),
        }
    }

    /// The tables of a diagnosis, the commit marker last.
    ///
    /// # Errors
    /// A row does not fit its schema: our own mistake.
    pub fn tables(
        &self,
        d: &Diagnosis,
        input: &Input<'_>,
    ) -> Result<Vec<(&'static registry::TableSpec, arrow::array::RecordBatch)>, file::Error> {
        let is_named = |row: &&CauseRow| matches!(row.verdict.as_str(), "named" | "ambiguous");
        let row = DiagnosisRow {
            ident: d.ident.clone(),
            path: input.log.to_string(),
            circumstances: d.circumstances.clone(),
            n_named: d.causes.iter().filter(is_named).count() as i64,
            unexplained: d.causes.iter().any(|row| row.verdict == "unexplained"),
            poolable: d.poolable,
            nulls: self.settings.nulls as i64,
            advise: self.settings.advise,
            provenance: Provenance {
                input_hash: input.input_hash.clone(),
                pipeline_hash: input.pipeline_hash.clone(),
                version: crate::VERSION.to_owned(),
            },
        };
        let mut tables = vec![
            (&registry::CAUSES, file::batch(&d.causes)?),
            (&registry::DISCREPANCIES, file::batch(&d.discrepancies)?),
        ];
        if d.model.is_some() || !d.estimates.is_empty() {
            tables.push((&registry::REPLAYS, file::batch(&d.replays)?));
            tables.push((&registry::SIMULATION_ERRORS, file::batch(&d.simulation_errors)?));
            tables.push((&registry::ESTIMATES, file::batch(&d.estimates)?));
            tables.push((&registry::EFFECT_TRACES, file::batch(&d.effect_traces)?));
        }
        tables.push((&registry::DIAGNOSES, file::batch(&[row])?));
        Ok(tables)
    }
}

/// Makes what is made over all diagnosed sessions of the output: the rows of `causes` that several
/// share and of `changes`, which are given back, the same for `run --model`, and the report.
///
/// # Errors
/// A table cannot be read, or the output not be written.
pub fn finish(store: &Store) -> Result<OverAll, Error> {
    empty::write(store.root(), &kind::DIAGNOSE)?;
    let copy = LocalCopy::of(store.root())?;
    let over_all = finish_derived::pooled(store.root(), &copy)?;
    store.let_readers_in()?;
    report::build(copy.folder(), Pages::Auto, false)?;
    copy.publish([SHARED, CHANGES, "report"])?;
    finish_derived::rescan(store.root(), &copy, &SHARED_PLACES)?;
    match copy.is_whole() {
        true => store.clear_behind()?,
        false => mark::mark_out_of_date(store.root())?,
    }
    Ok(over_all)
}

/// Differences of a motorcycle's other rides, as one group, from the rides that `text` selects.
///
/// # Errors
/// `Usage`: the text names none, or too few of a motorcycle. A table cannot be read.
pub(crate) fn against(store: &Store, text: &str) -> Result<Vec<Against>, Error> {
    pooled::against(LocalCopy::of(store.root())?.folder(), text)
}
