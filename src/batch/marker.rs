//! The commit markers of sessions: the table whose rows say that a session is done, and from what.

use arrow::array::{Array, AsArray};
use arrow::compute::cast;
use arrow::datatypes::DataType;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::reader::ChunkReader;
use serde::{Deserialize, Serialize};

use crate::objects::Location;

/// Who a session is: two motorcycles may each have one of the same id.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key {
    /// Its motorcycle.
    pub bike_id: String,
    /// Its id.
    pub session_id: String,
}

impl Key {
    /// From both.
    pub fn new(bike_id: &str, session_id: &str) -> Self {
        Key { bike_id: bike_id.to_owned(), session_id: session_id.to_owned() }
    }
}

/// A session whose tables are in the output.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Committed {
    /// The session.
    pub session_id: String,
    /// Its bike: the hive partition.
    pub bike_id: String,
    /// Name, without extension, of the files under its bike that have its rows: see
    /// [`parts`](super::parts).
    pub part: String,
    /// The input as it was named then.
    pub path: String,
    /// Hash of the input's bytes.
    pub input_hash: String,
    /// Hash of everything else that the tables were made from.
    pub pipeline_hash: String,
    /// The roadbench that made them.
    pub version: String,
    /// Whether the file is of a roadbench that had one per session, with ids as plain texts.
    #[serde(default)]
    pub is_old: bool,
}

impl Committed {
    /// Who it is.
    pub fn key(&self) -> Key {
        Key::new(&self.bike_id, &self.session_id)
    }
}

/// Columns of a commit marker that are read.
const COLUMNS: [&str; 6] =
    ["session_id", "bike_id", "path", "input_hash", "pipeline_hash", "version"];

/// The rows of a commit marker; `None` where it is no such file, or a row belongs elsewhere. There are tens of
/// thousands: only what is needed is decoded.
pub fn rows(at: &Location, file: impl ChunkReader + 'static) -> Option<Vec<Committed>> {
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).ok()?;
    let wanted = ProjectionMask::columns(builder.parquet_schema(), COLUMNS);
    let reader = builder.with_projection(wanted).build().ok()?;
    // the row must be where its own words put it: nothing outside is ever removed on its account
    let folder = at.parent()?;
    let bike_id = folder.file_name().strip_prefix("bike=")?.to_owned();
    let part = at.file_stem().into_owned();
    let mut rows = Vec::new();
    for batch in reader {
        let batch = batch.ok()?;
        let is_old = *batch.column_by_name(COLUMNS[0])?.data_type() == DataType::Utf8;
        let mut texts = Vec::with_capacity(COLUMNS.len());
        for name in COLUMNS {
            texts.push(cast(batch.column_by_name(name)?, &DataType::Utf8).ok()?);
        }
        for i in 0..batch.num_rows() {
            let text = |k: usize| {
                let column = texts[k].as_string_opt::<i32>()?;
                column.is_valid(i).then(|| column.value(i).to_owned())
            };
            let row = Committed {
                session_id: text(0)?,
                bike_id: text(1)?,
                part: part.clone(),
                path: text(2)?,
                input_hash: text(3)?,
                pipeline_hash: text(4)?,
                version: text(5)?,
                is_old,
            };
            if row.bike_id != bike_id {
                return None;
            }
            rows.push(row);
        }
    }
    if rows.len() != 1 {
        rows.iter_mut().for_each(|row| row.is_old = false);
    }
    Some(rows)
}
