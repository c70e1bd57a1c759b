//! How an output keeps account of the sessions of a command. Two commands may share an output: each
//! has its own tables, its own commit marker and its own marks.

use crate::contract::rejection::Stage;
use crate::store::tables::registry;
use crate::store::tables::registry::{Command, Presence, TableSpec};
use crate::store::tables::rows::Rejected;

/// Folder of the rows of `causes` that several sessions share, below the output.
pub(crate) const SHARED: &str = "causes/bike=_pooled";
/// The file in it.
pub(crate) const SHARED_TABLE: &str = "pooled.parquet";
/// Model of shared causes for `run --model`, below the output.
pub(crate) const SHARED_MODEL: &str = "models/pooled.toml";
/// Table of changes between a motorcycle's sessions, below the output.
pub(crate) const CHANGES: &str = "changes";
/// Paths of the results of `diagnose` over all sessions, below the output.
pub(crate) const SHARED_PLACES: [&str; 3] = [SHARED, SHARED_MODEL, CHANGES];

/// How an output keeps account of a command's sessions.
#[derive(Debug)]
pub struct Kind {
    /// The command, which says what tables there are per session.
    pub command: Command,
    /// The table whose row says that a session is done; it is written last.
    pub marker: &'static TableSpec,
    /// Folders of other files per session, with their extension.
    pub other_files: &'static [(&'static str, &'static str)],
    /// Folder of sessions that wait to be taken into the tables.
    pub staged: &'static str,
    /// Folder of the marks of sessions that an earlier version was writing.
    pub writing: &'static str,
    /// There while what is made over all sessions is older than the sessions.
    pub behind: &'static str,
    /// There from when the tables are replaced until those that are made over all sessions fit them.
    pub switched: &'static str,
    /// Files that are made over all sessions at the end of every batch, below the output.
    pub over_all: &'static [&'static str],
    /// Stage of a rejection that comes from no stage of its own: a panic.
    pub stage: Stage,
    /// Stages that reject for another command only: a success of this one does not remove their rows.
    pub foreign_stages: &'static [Stage],
}

impl Kind {
    /// Whether a rejection is another command's: a success of this one does not remove it.
    pub fn is_foreign(&self, row: &Rejected) -> bool {
        Stage::parse(&row.stage).is_some_and(|stage| self.foreign_stages.contains(&stage))
    }

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

    /// Folders and files below the output that are made over all sessions.
    pub fn derived(&self) -> Vec<&'static str> {
        match self.command {
            Command::Diagnose => SHARED_PLACES.to_vec(),
            _ => registry::of_fleet().map(|spec| spec.name).collect(),
        }
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

/// Of `roadbench run`.
pub static RUN: Kind = Kind {
    command: Command::Run,
    marker: &registry::SESSIONS,
    other_files: &[],
    staged: ".roadbench/staged/run",
    writing: ".roadbench/writing",
    behind: ".roadbench/behind",
    switched: ".roadbench/switched",
    over_all: &["report/index.html", "fleet/fleet.parquet"],
    stage: Stage::Pipeline,
    foreign_stages: &[Stage::Diagnose],
};

/// Of `roadbench diagnose`.
pub static DIAGNOSE: Kind = Kind {
    command: Command::Diagnose,
    marker: &registry::DIAGNOSES,
    other_files: &[("models", "toml")],
    staged: ".roadbench/staged/diagnose",
    writing: ".roadbench/diagnosing",
    behind: ".roadbench/behind_diagnose",
    switched: ".roadbench/switched_diagnose",
    over_all: &["report/index.html"],
    stage: Stage::Diagnose,
    foreign_stages: &[Stage::Pipeline, Stage::Estimate],
};
