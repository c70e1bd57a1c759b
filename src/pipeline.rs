//! The stages in their order, for one session.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::bike::Bike;
use crate::rows;
use crate::{filter, ingest, segment};

/// The resolved settings of every stage: one file of `pipelines/`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pipeline {
    /// Its name.
    pub name: String,
    /// Ingest.
    #[serde(default)]
    pub ingest: ingest::Config,
    /// Filter.
    #[serde(default)]
    pub filter: filter::Config,
    /// Segment.
    #[serde(default)]
    pub segment: segment::Config,
}

impl Pipeline {
    /// The built-in `pipelines/onroad.toml`.
    pub fn onroad() -> Self {
        Self::parse(include_str!("../pipelines/onroad.toml"), "pipelines/onroad.toml")
            .unwrap_or_else(|e| panic!("built-in pipeline: {e}"))
    }

    /// Reads and checks a pipeline file.
    ///
    /// # Errors
    /// A sentence that names the file and the key.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(path)
            .map_err(|e| format!("cannot read pipeline {}: {e}", path.display()))?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Checks a pipeline file's text; `name` is for messages.
    ///
    /// # Errors
    /// A sentence that names the file and the key.
    pub fn parse(text: &str, name: &str) -> Result<Self, String> {
        toml::from_str(text).map_err(|e| format!("pipeline {name}: {e}"))
    }
}

/// Everything one session gives to the tables.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Its row in `sessions`.
    pub session: rows::SessionRow,
    /// Its segments.
    pub manoeuvres: Vec<rows::Manoeuvre>,
    /// Its coefficients.
    pub coefficients: Vec<rows::Coefficient>,
    /// What the stages noticed.
    pub warnings: Vec<rows::WarningRow>,
    /// What the report draws.
    pub plots: Vec<rows::PlotPoint>,
    /// Estimated time series, if asked for.
    pub signals: Option<arrow::array::RecordBatch>,
}

/// Why a session could not be used: what `rejected` says of it.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{stage}: {message}")]
pub struct Rejection {
    /// Where.
    pub stage: &'static str,
    /// Short stable name.
    pub code: &'static str,
    /// For people.
    pub message: String,
}

/// What the caller knows of an input.
#[derive(Debug, Clone)]
pub struct Input<'a> {
    /// The file.
    pub path: &'a Path,
    /// Channel maps to choose from; none means those that come with the program.
    pub maps: &'a [ingest::map::ChannelMap],
    /// BLAKE3 of its bytes.
    pub input_hash: String,
    /// BLAKE3 of the resolved pipeline and the bike file.
    pub pipeline_hash: String,
    /// Whether to keep the estimated time series.
    pub signals: bool,
}

/// One log through every stage.
///
/// # Errors
/// The first stage that cannot go on says why.
pub fn run(_input: &Input<'_>, _bike: &Bike, _pipeline: &Pipeline) -> Result<Outcome, Rejection> {
    Err(Rejection { stage: "ingest", code: "unknown_format", message: String::new() })
}
