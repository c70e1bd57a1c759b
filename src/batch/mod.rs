//! Many sessions: discovery, parallel work, whole files.
//!
//! ```text
//! inputs -> discover -> plan -> engine (a session per worker) -> store -> fleet -> report
//!            files      who, bike,      pipeline::run             tables
//!                       duplicates
//! ```
//!
//! [`cluster`] is the same over many machines, [`alone`] one session in memory.
//!
//! Assumes nothing of the inputs. Every one of them ends as a session in the tables or as a row
//! of `rejected`: *sessions in = sessions out + rejected*, checked at the end of every run.
//!
//! A run may be stopped at any time, gently or not: only whole files are left, and the same
//! command carries on with the sessions that are not there yet. A session is there when its row
//! in `sessions` names the same input, the same settings and the same roadbench (see
//! [`store`]). The files' bytes depend on inputs and settings only, not on the number of
//! workers, the time or the machine's load.

pub mod alone;
pub mod contents;
pub mod desk;
pub mod discover;
pub mod distributed;
pub mod engine;
#[cfg(feature = "fleet")]
pub mod fleet;
pub mod fleet_rows;
pub mod lock;
pub mod plan;
pub mod progress;
pub mod remote;
pub mod spread;
pub mod store;
pub mod summary;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

pub use engine::{Finished, Intended, Run, State, Watch, intend, run};

use crate::contract::bike::Bike;
use crate::contract::session::Meta;
use crate::ingest;
use crate::ingest::map::ChannelMap;
use crate::pipeline::{self, Input, Outcome, Pipeline, Rejection};

/// Why a run did not take place, or had to end early.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The command or its configuration is wrong; nothing was written.
    #[error("{0}")]
    Usage(String),
    /// The output cannot be written.
    #[error("{0}")]
    Output(String),
    /// Our own mistake.
    #[error("{0}; this is a mistake in roadbench, please report it")]
    Internal(String),
}

/// What a run is asked to do.
#[derive(Debug)]
pub struct Settings<'a> {
    /// Logs, folders and glob patterns.
    pub inputs: &'a [PathBuf],
    /// Folder of bike files; where absent, the `bikes` beside the inputs' sessions.
    pub bikes: Option<&'a Path>,
    /// Output folder.
    pub out: &'a Path,
    /// The stages' settings.
    pub pipeline: &'a Pipeline,
    /// The channel maps to choose from; none means those that come with the program.
    pub maps: &'a Maps,
    /// Workers; 0 takes one per core.
    pub jobs: usize,
    /// Compute again what is there already.
    pub force: bool,
    /// Only logs that were written since then.
    pub since: Option<SystemTime>,
    /// Keep the estimated time series.
    pub signals: bool,
}

/// Channel maps, with the text that they were read from: it is part of what the tables are
/// made from.
#[derive(Debug, Default)]
pub struct Maps {
    list: Vec<ChannelMap>,
    /// The hashes of the files, one after the other.
    text: Vec<u8>,
}

impl Maps {
    /// The maps.
    pub fn list(&self) -> &[ChannelMap] {
        &self.list
    }

    /// Reads map files.
    ///
    /// # Errors
    /// A sentence that names the file and the key.
    pub fn read(paths: &[PathBuf]) -> Result<Self, String> {
        Self::parse(&Self::texts(paths)?)
    }

    /// The names and texts of map files.
    ///
    /// # Errors
    /// One cannot be read.
    pub fn texts(paths: &[PathBuf]) -> Result<Vec<(String, String)>, String> {
        let text = |path: &PathBuf| Ok((path.display().to_string(), ChannelMap::text_of(path)?));
        paths.iter().map(text).collect()
    }

    /// From names, for messages, and texts.
    ///
    /// # Errors
    /// A sentence that names the file and the key.
    pub fn parse(texts: &[(String, String)]) -> Result<Self, String> {
        let mut maps = Maps::default();
        for (name, text) in texts {
            maps.list.push(ChannelMap::parse(text, name)?);
            maps.text.extend_from_slice(blake3::hash(text.as_bytes()).as_bytes());
        }
        Ok(maps)
    }
}

/// What is done with one log.
pub trait Work: Sync {
    /// Who and when.
    ///
    /// # Errors
    /// The log cannot be read that far.
    fn identify(&self, path: &Path, maps: &[ChannelMap]) -> Result<Meta, ingest::Error>;

    /// Everything else.
    ///
    /// # Errors
    /// The log cannot be used.
    fn run(
        &self,
        input: &Input<'_>,
        bike: &Bike,
        pipeline: &Pipeline,
    ) -> Result<Outcome, Rejection>;
}

/// The real work: [`ingest::identify`] and [`pipeline::run`].
#[derive(Debug, Default)]
pub struct Stages;

impl Work for Stages {
    fn identify(&self, path: &Path, maps: &[ChannelMap]) -> Result<Meta, ingest::Error> {
        ingest::identify(path, maps)
    }

    fn run(
        &self,
        input: &Input<'_>,
        bike: &Bike,
        pipeline: &Pipeline,
    ) -> Result<Outcome, Rejection> {
        pipeline::run(input, bike, pipeline)
    }
}

/// Does something that may panic; a panic becomes a rejection, and the batch goes on.
pub(crate) fn guarded<T>(
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
