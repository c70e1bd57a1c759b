//! The work of `roadbench run`: each session's tables by [`pipeline::run`], then the fleet's tables and
//! the report over all sessions of the output.

use super::bikes::BikeFile;
use super::job_kind::JobKind;
use super::work::{Output, Work, encoded};
use crate::batch::error::Error;
use crate::batch::store::empty;
use crate::batch::store::finish_derived;
use crate::batch::store::folder::Store;
use crate::batch::store::kind;
use crate::batch::store::kind::Kind;
use crate::batch::store::local_copy::LocalCopy;
use crate::batch::store::mark;
use crate::contract::rejection::Stage;
use crate::pipeline::{self, Input, Outcome, Pipeline, Rejection};
use crate::report::{self, Pages};
use crate::store::tables::names::{file_name, is_plain};
use crate::store::tables::registry;
use crate::store::tables::registry::TableSpec;
use crate::store::tables::rows::WarningRow;

/// Characterises each session's tyres.
#[derive(Debug, Default)]
pub struct RunWork {
    /// Keep the estimated time series.
    pub signals: bool,
}

impl Work for RunWork {
    /// Everything that the session gave but its time series.
    type Result = Outcome;

    fn kind(&self) -> &'static Kind {
        &kind::RUN
    }

    fn what(&self) -> Option<JobKind> {
        Some(JobKind::Run { signals: self.signals })
    }

    fn is_result_wanted(&self, logs: usize) -> bool {
        logs == 1
    }

    fn is_requested(&self, table: &TableSpec) -> bool {
        self.signals && table.is(&registry::SIGNALS)
    }

    fn run(
        &self,
        input: &Input<'_>,
        bike: &BikeFile,
        pipeline: &Pipeline,
    ) -> Result<Output<Outcome>, Rejection> {
        output(pipeline::run(input, &bike.bike, pipeline)?)
    }
}

/// An outcome with its tables as files.
///
/// # Errors
/// A row does not fit its schema: our own mistake.
pub fn output(mut outcome: Outcome) -> Result<Output<Outcome>, Rejection> {
    note_unsafe_id(&mut outcome);
    let tables = outcome.tables().map_err(|e| Rejection::unwritable(&e))?;
    let files = encoded(&tables).map_err(|e| Rejection::unwritable(&e))?;
    Ok(Output {
        ident: outcome.session.ident.clone(),
        samples: outcome.session.n_samples,
        files,
        result: Some(Outcome { signals: None, ..outcome }),
    })
}

/// The tables keep the id as it is; a note says that the file's name differs.
pub(crate) fn note_unsafe_id(outcome: &mut Outcome) {
    let id = &outcome.session.ident.session_id;
    if is_plain(id) {
        return;
    }
    outcome.warnings.push(WarningRow {
        ident: outcome.session.ident.clone(),
        stage: Stage::Ingest.as_str().to_owned(),
        code: "unsafe_session_id".to_owned(),
        channel: None,
        count: 1,
        time: None,
        message: format!(
            "the session id cannot be a file name as it is; its tables are stored as {}.parquet",
            file_name(id)
        ),
    });
    outcome.session.n_warnings += 1;
}

/// Makes what is made over all sessions of the output, of this batch and of earlier ones: the fleet's
/// tables and the report. `also` may use the folder before it is published.
///
/// # Errors
/// A table cannot be read, or the output not be written.
pub fn finish(
    store: &Store,
    pages: Pages,
    also: impl FnOnce(&LocalCopy) -> Result<(), report::Error>,
) -> Result<LocalCopy, Error> {
    empty::write(store.root(), &kind::RUN)?;
    let copy = LocalCopy::of(store.root())?;
    finish_derived::fleet(store.root(), &copy)?;
    store.let_readers_in()?;
    report::build(copy.folder(), pages, false)?;
    also(&copy)?;
    let fleet: Vec<&str> = registry::of_fleet().map(|spec| spec.name).collect();
    copy.publish(fleet.iter().copied().chain(["report"]))?;
    if copy.is_copy() {
        finish_derived::rescan(store.root(), &copy, &fleet)?; // it is there only now
    }
    match copy.is_whole() {
        true => store.clear_behind()?,
        false => mark::mark_out_of_date(store.root())?,
    }
    Ok(copy)
}
