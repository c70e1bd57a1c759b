//! What a batch does with each log, and what it leaves of it in the output.

use std::panic::{AssertUnwindSafe, catch_unwind};

use arrow::array::RecordBatch;

use super::bikes::BikeFile;
use super::job_kind::JobKind;
use crate::batch::store::kind::Kind;
use crate::batch::store::parts;
use crate::contract::rejection::{RejectionCode, Stage};
use crate::ingest::maps::ChannelMap;
use crate::ingest::{self, Identified};
use crate::pipeline::{Input, Pipeline, Rejection};
use crate::store::objects::Location;
use crate::store::tables::mismatch::Mismatch;
use crate::store::tables::registry::TableSpec;
use crate::store::tables::rows::Ident;
use crate::store::tables::{arrow_stream, file};

/// What is done with one log. What it gives must depend on the log, the bike file, the pipeline, the
/// channel maps and [`Work::settings`] only: by these a later batch knows whether to do it again.
pub trait Work: Sync {
    /// What a session gives beside its files, for whoever watches the batch.
    type Result: Send;

    /// Its files, and how the output keeps account of them.
    fn kind(&self) -> &'static Kind;

    /// Its own settings as text, beside pipeline, channel maps and bike file.
    fn settings(&self) -> String {
        String::new()
    }

    /// What a worker process does for it; none where it is done in this process only.
    fn what(&self) -> Option<JobKind> {
        None
    }

    /// Whether a table that is written on request is asked for.
    fn is_requested(&self, _table: &TableSpec) -> bool {
        false
    }

    /// Session, bike, start and channel map of a log.
    ///
    /// # Errors
    /// The log cannot be read that far.
    fn identify(&self, log: &Location, maps: &[ChannelMap]) -> Result<Identified, Rejection> {
        ingest::identify(log, maps).map_err(Rejection::from)
    }

    /// Whether anybody looks at what a session gives beside its files, in a batch of so many logs.
    fn is_result_wanted(&self, _logs: usize) -> bool {
        true
    }

    /// How many logs there are, before the first is worked on.
    fn planned(&self, _logs: usize) {}

    /// The last log is done: what served the logs may go, before tables are merged.
    fn all_done(&self) {}

    /// From a log to the files of its session.
    ///
    /// # Errors
    /// The log cannot be used.
    fn run(
        &self,
        input: &Input<'_>,
        bike: &BikeFile,
        pipeline: &Pipeline,
    ) -> Result<Output<Self::Result>, Rejection>;
}

/// What a log gives.
#[derive(Debug)]
pub struct Output<R> {
    /// Session, bike and start, as the log was read.
    pub ident: Ident,
    /// Samples on the common clock.
    pub samples: i64,
    /// Its files, the commit marker's among them.
    pub files: Vec<SessionFile>,
    /// What else, where somebody looks at it.
    pub result: Option<R>,
}

/// One file of a session, or its share of one: `<folder>/bike=<bike_id>/`.
#[derive(Debug)]
pub struct SessionFile {
    /// The table's name, or that of another folder.
    pub folder: &'static str,
    /// Without the dot.
    pub extension: &'static str,
    /// The whole content.
    pub bytes: Vec<u8>,
}

/// Extension of a session's share of a month's file: an Arrow stream. The month's file is Parquet.
pub(crate) const SHARE: &str = "arrow";
/// Extensions of all that a session may leave.
pub(crate) const EXTENSIONS: [&str; 3] = [SHARE, "parquet", "toml"];

/// Tables as the files of a session. What is to be a part of a month's file is not made Parquet twice.
///
/// # Errors
/// Arrow or Parquet cannot hold one: our own mistake.
pub(crate) fn encoded(
    tables: &[(&'static TableSpec, RecordBatch)],
) -> Result<Vec<SessionFile>, file::Error> {
    let file = |(spec, batch): &(&'static TableSpec, RecordBatch)| {
        let (extension, bytes) = match parts::shares(spec) {
            true => {
                (SHARE, arrow_stream::encode(batch).map_err(|source| unwritable(spec, source))?)
            }
            false => ("parquet", file::batch_to_bytes(spec.name, batch)?),
        };
        Ok(SessionFile { folder: spec.name, extension, bytes })
    };
    tables.iter().map(file).collect()
}

fn unwritable(spec: &TableSpec, source: Mismatch) -> file::Error {
    file::Error::Encode { table: spec.name.to_owned(), source }
}

/// Does something that may panic; a panic becomes a rejection, and the batch goes on.
pub fn guarded<T>(
    stage: Stage,
    work: impl FnOnce() -> Result<T, Rejection>,
) -> Result<T, Rejection> {
    // nothing that outlives the call is changed by it, so there is nothing to be left half-done
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic
            .downcast_ref::<&str>()
            .map(|s| (*s).to_owned())
            .or_else(|| panic.downcast_ref::<String>().cloned())
            .unwrap_or_default();
        let message = format!(
            "roadbench failed on this log (\"{text}\"); this is a mistake in roadbench, please \
             report it"
        );
        Err(Rejection { stage, code: RejectionCode::InternalError, message, limits: None })
    })
}
