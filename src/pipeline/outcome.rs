//! What goes into the stages and what comes out of them.

use arrow::array::RecordBatch;
use serde::{Deserialize, Serialize};

use crate::contract::rejection::{RejectionCode, Stage};
use crate::ingest;
use crate::segment::laps::Laps;
use crate::store::objects::Location;
use crate::store::tables::registry;
use crate::store::tables::registry::{Row, TableSpec};
use crate::store::tables::{file, rows};

/// Everything one session gives to the tables.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Outcome {
    /// Its row in `sessions`.
    pub session: rows::SessionRow,
    /// Rows of `manoeuvres`, in order of time.
    pub manoeuvres: Vec<rows::Manoeuvre>,
    /// Off-road: the forces of its segments.
    pub forces: Vec<rows::ForceRow>,
    /// Rows of `coefficients`.
    pub coefficients: Vec<rows::Coefficient>,
    /// Evidence on each coefficient, error by error; none off-road.
    #[serde(skip)] // what is shown of a session does without
    pub evidence: Vec<rows::EvidenceRow>,
    /// Warnings of the stages.
    pub warnings: Vec<rows::WarningRow>,
    /// Its laps; none where it is not on a track.
    pub laps: Laps,
    /// Points of the plots.
    #[serde(skip)]
    pub plots: Vec<rows::PlotPoint>,
    /// Estimated time series, if asked for.
    #[serde(skip)]
    pub signals: Option<RecordBatch>,
    /// Costs of numbers that the bike file lacks, a line each; in no table.
    pub costs: Vec<String>,
    /// Tables that no later stage looks at (`pipeline::outcome::table`).
    #[serde(skip)]
    pub other_tables: Vec<(&'static TableSpec, RecordBatch)>,
}

/// Rows as one of an outcome's tables.
///
/// # Errors
/// A row does not fit its schema: our own mistake.
pub(super) fn table<R: Row>(rows: &[R]) -> Result<(&'static TableSpec, RecordBatch), file::Error> {
    Ok((R::spec(), file::batch(rows)?))
}

impl Outcome {
    /// Its tables: `forces` off-road, those of laps on a track, `signals` if asked for. `sessions`, whose row says that the
    /// session is done, comes last.
    ///
    /// # Errors
    /// A row does not fit its schema: our own mistake.
    pub fn tables(&self) -> Result<Vec<(&'static TableSpec, RecordBatch)>, file::Error> {
        let mut tables = vec![
            table(&self.coefficients)?,
            table(&self.evidence)?,
            table(&self.manoeuvres)?,
            table(&self.warnings)?,
            table(&self.plots)?,
        ];
        if !self.forces.is_empty() {
            tables.push(table(&self.forces)?);
        }
        if !self.laps.laps.is_empty() {
            tables.push(table(&self.laps.laps)?);
            tables.push(table(&self.laps.corners)?);
            tables.push(table(&self.laps.points)?);
        }
        if !self.laps.trends.is_empty() {
            tables.push(table(&self.laps.coefficients)?);
            tables.push(table(&self.laps.trends)?);
        }
        if let Some(signals) = &self.signals {
            tables.push((&registry::SIGNALS, signals.clone()));
        }
        tables.extend(self.other_tables.iter().cloned());
        tables.push(table(std::slice::from_ref(&self.session))?);
        Ok(tables)
    }
}

/// Why a session could not be used: what `rejected` says of it.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{stage}: {message}")]
pub struct Rejection {
    /// Stage that rejected the log.
    pub stage: Stage,
    /// Code of the rejection; it stays the same in later versions.
    pub code: RejectionCode,
    /// Message: what was wrong, where, and what to do.
    pub message: String,
    /// Limits of the log's worker, where one of them ended it.
    pub limits: Option<String>,
}

impl From<ingest::Error> for Rejection {
    fn from(e: ingest::Error) -> Self {
        Rejection { stage: Stage::Ingest, code: e.code, message: e.message, limits: None }
    }
}

impl Rejection {
    /// Of a table that does not fit its schema: our own mistake.
    pub fn unwritable(e: &file::Error) -> Self {
        let message = format!("{e}; this is a mistake in roadbench, please report it");
        Rejection { stage: Stage::Write, code: RejectionCode::InternalError, message, limits: None }
    }
}

/// Properties of an input that the caller knows.
#[derive(Debug, Clone)]
pub struct Input<'a> {
    /// Path or URL of the log.
    pub log: Location,
    /// Channel maps to choose from; none means those that come with the program.
    pub maps: &'a [ingest::maps::ChannelMap],
    /// BLAKE3 of its bytes.
    pub input_hash: String,
    /// BLAKE3 of the resolved pipeline, the bike file and what else its tables are made from.
    pub pipeline_hash: String,
    /// Whether to keep the estimated time series.
    pub signals: bool,
}
