//! What a batch does with each log, and what it leaves of it in the output.

use std::panic::{AssertUnwindSafe, catch_unwind};

use arrow::array::RecordBatch;

use crate::contract::bike::Bike;
use crate::contract::session::Meta;
use crate::ingest;
use crate::ingest::map::ChannelMap;
use crate::objects::Location;
use crate::pipeline::{Input, Pipeline, Rejection};
use crate::tables::file;
use crate::tables::registry::{self, Command, Presence, TableSpec};

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

    /// Whether a table that is written on request is asked for.
    fn is_requested(&self, _table: &TableSpec) -> bool {
        false
    }

    /// Session, bike and start of a log.
    ///
    /// # Errors
    /// The log cannot be read that far.
    fn identify(&self, log: &Location, maps: &[ChannelMap]) -> Result<Meta, ingest::Error> {
        ingest::identify(log, maps)
    }

    /// From a log to the files of its session.
    ///
    /// # Errors
    /// The log cannot be used.
    fn run(
        &self,
        input: &Input<'_>,
        bike: &Bike,
        pipeline: &Pipeline,
    ) -> Result<Output<Self::Result>, Rejection>;
}

/// What a log gives.
#[derive(Debug)]
pub struct Output<R> {
    /// The session, as the log was read.
    pub session_id: String,
    /// Its bike.
    pub bike_id: String,
    /// Samples on the common clock; 0 where they are not counted.
    pub samples: i64,
    /// Its files, the commit marker's among them.
    pub files: Vec<SessionFile>,
    /// What else.
    pub result: R,
}

/// One file of a session: `<folder>/bike=<bike_id>/<session>.<extension>`.
#[derive(Debug)]
pub struct SessionFile {
    /// The table's name, or that of another folder.
    pub folder: &'static str,
    /// Without the dot.
    pub extension: &'static str,
    /// The whole content.
    pub bytes: Vec<u8>,
}

/// How an output keeps account of a command's sessions. Two commands may share an output: each has
/// its own tables and marks.
#[derive(Debug)]
pub struct Kind {
    /// The command, which says what tables there are per session.
    pub command: Command,
    /// The table whose row says that a session is done; it is written last.
    pub marker: &'static TableSpec,
    /// Folders of other files per session, with their extension.
    pub other_files: &'static [(&'static str, &'static str)],
    /// Folder of the marks of sessions that are being written.
    pub writing: &'static str,
    /// There while what is made over all sessions is older than the sessions.
    pub behind: &'static str,
    /// Stage of a rejection that comes from no stage of its own: a panic.
    pub stage: &'static str,
    /// Stages that reject for another command only: a success of this one does not remove their rows.
    pub foreign_stages: &'static [&'static str],
}

impl Kind {
    /// The tables of a session but for the commit marker.
    pub fn tables(&self) -> impl Iterator<Item = &'static TableSpec> {
        let marker = self.marker;
        registry::of_session(self.command).filter(move |spec| !spec.is(marker))
    }

    /// Folder and extension of every file that a session may have, but for the commit marker.
    pub fn files(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        let tables = self.tables().map(|spec| (spec.name, "parquet"));
        tables.chain(self.other_files.iter().copied())
    }

    /// The tables that a session must have to be whole: those that are always there, and of those on
    /// request the ones that are asked for.
    pub fn required(
        &self,
        is_requested: impl Fn(&TableSpec) -> bool,
    ) -> impl Iterator<Item = &'static TableSpec> {
        self.tables().filter(move |spec| match spec.presence {
            Presence::Always => true,
            Presence::WhereItApplies => false,
            Presence::OnRequest => is_requested(spec),
        })
    }
}

/// Tables as the files of a session.
///
/// # Errors
/// Parquet cannot hold one: our own mistake.
pub fn encoded(
    tables: &[(&'static TableSpec, RecordBatch)],
) -> Result<Vec<SessionFile>, file::Error> {
    let file = |(spec, batch): &(&'static TableSpec, RecordBatch)| {
        let bytes = file::batch_to_bytes(spec.name, batch)?;
        Ok(SessionFile { folder: spec.name, extension: "parquet", bytes })
    };
    tables.iter().map(file).collect()
}

/// A table that does not fit its schema, as what is said of the log that it is of.
pub fn unwritable(e: &file::Error) -> Rejection {
    let message = format!("{e}; this is a mistake in roadbench, please report it");
    Rejection { stage: "write", code: "internal_error", message }
}

/// Does something that may panic; a panic becomes a rejection, and the batch goes on.
pub fn guarded<T>(
    stage: &'static str,
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
        Err(Rejection { stage, code: "internal_error", message })
    })
}
