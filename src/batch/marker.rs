//! The commit marker of a session: the table whose row says that the session is done, and from what.

use arrow::array::{Array, AsArray, RecordBatch};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ArrowReaderOptions, ParquetRecordBatchReaderBuilder};
use parquet::file::reader::ChunkReader;
use serde::{Deserialize, Serialize};

use crate::objects::Location;
use crate::tables::names::file_name;

/// A session whose tables are in the output.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Committed {
    /// The session.
    pub session_id: String,
    /// Its bike: the hive partition.
    pub bike_id: String,
    /// The input as it was named then.
    pub path: String,
    /// Hash of the input's bytes.
    pub input_hash: String,
    /// Hash of everything else that the tables were made from.
    pub pipeline_hash: String,
    /// The roadbench that made them.
    pub version: String,
}

/// Columns of a commit marker that are read.
const COLUMNS: [&str; 6] =
    ["session_id", "bike_id", "path", "input_hash", "pipeline_hash", "version"];

/// The row of a commit marker; `None` where it is no such file, or its row belongs elsewhere. There are
/// tens of thousands: only what is needed is decoded.
pub fn row(at: &Location, file: impl ChunkReader + 'static) -> Option<Committed> {
    let plain = ArrowReaderOptions::new().with_skip_arrow_metadata(true);
    let builder = ParquetRecordBatchReaderBuilder::try_new_with_options(file, plain).ok()?;
    let wanted = ProjectionMask::columns(builder.parquet_schema(), COLUMNS);
    let reader = builder.with_projection(wanted).build().ok()?;
    let batch: RecordBatch = reader.into_iter().next()?.ok()?;
    let text = |name: &str| {
        let column = batch.column_by_name(name)?.as_string_opt::<i32>()?;
        (!column.is_empty()).then(|| column.value(0).to_owned())
    };
    let row = Committed {
        session_id: text("session_id")?,
        bike_id: text("bike_id")?,
        path: text("path")?,
        input_hash: text("input_hash")?,
        pipeline_hash: text("pipeline_hash")?,
        version: text("version")?,
    };
    // the row must be where its own words put it: nothing outside is ever removed on its account
    let folder = at.parent()?;
    let is_in_place = folder.file_name().strip_prefix("bike=") == Some(row.bike_id.as_str())
        && at.file_stem() == file_name(&row.session_id);
    is_in_place.then_some(row)
}
