//! The work of a batch on each log, and the files that it writes for it.

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

/// Work on one log. Its result must depend on the log, the bike file, the pipeline, the channel maps and
/// [`Work::settings`] only: from these a later batch decides whether to do it again.
pub trait Work: Sync {
    /// Result of a session in addition to its files, shown while the batch runs.
    type Result: Send;

    /// Its files and their place in the output.
    fn kind(&self) -> &'static Kind;

    /// Its own settings as text, beside pipeline, channel maps and bike file.
    fn settings(&self) -> String {
        String::new()
    }

    /// Job of a worker process; `None` if this process does the work.
    fn what(&self) -> Option<JobKind> {
        None
    }

    /// Whether a table that is written on request was requested.
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

    /// Whether the results of sessions are shown, in a batch of so many logs.
    fn is_result_wanted(&self, _logs: usize) -> bool {
        true
    }

    /// Called with the number of logs, before the first.
    fn planned(&self, _logs: usize) {}

    /// Called after the last log, before tables are merged: resources for the logs may be released.
    fn all_done(&self) {}

    /// Computes the files of a session from its log.
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

/// Result of one log.
#[derive(Debug)]
pub struct Output<R> {
    /// Session, bike and start, as the log was read.
    pub ident: Ident,
    /// Samples on the common clock.
    pub samples: i64,
    /// Its files, the commit marker's among them.
    pub files: Vec<SessionFile>,
    /// Further result, if it is shown.
    pub result: Option<R>,
}

/// One file of a session, or its share of one: `<folder>/bike=<bike_id>/`.
#[derive(Debug)]
pub struct SessionFile {
    /// Folder: a table's name, or another.
    pub folder: &'static str,
    /// Extension, without the dot.
    pub extension: &'static str,
    pub bytes: Vec<u8>,
}

/// Extension of a session's share of a month's file: an Arrow stream. The month's file is Parquet.
pub(crate) const SHARE: &str = "arrow";
/// Extensions of a session's files.
pub(crate) const EXTENSIONS: [&str; 3] = [SHARE, "parquet", "toml"];

/// Encodes tables as the files of a session. Shares of a month's file stay Arrow, so that Parquet is written once.
///
/// # Errors
/// Arrow or Parquet cannot encode a table, which is a mistake of the program.
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

/// Runs something that may panic. A panic becomes a rejection, and the batch goes on.
pub fn guarded<T>(
    stage: Stage,
    work: impl FnOnce() -> Result<T, Rejection>,
) -> Result<T, Rejection> {
    // the call changes nothing that outlives it, so a panic leaves nothing half-done
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
