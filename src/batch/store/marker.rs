//! The commit markers of sessions: the table whose rows say that a session is done, and from what.

use arrow::array::{Array, ArrayRef, AsArray, Int64Array};
use arrow::compute::cast;
use arrow::datatypes::{DataType, Int64Type, TimeUnit};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::reader::ChunkReader;
use serde::{Deserialize, Serialize};

use crate::contract::instant;
use crate::store::objects::Location;

/// Key of a session: two motorcycles may each have one with the same id.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key {
    pub bike_id: String,
    /// Id of the session, unique per motorcycle.
    pub session_id: String,
}

impl Key {
    /// Key of a motorcycle's session.
    pub fn new(bike_id: &str, session_id: &str) -> Self {
        Key { bike_id: bike_id.to_owned(), session_id: session_id.to_owned() }
    }
}

/// A session whose tables are in the output.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Committed {
    /// Id of the session, unique per motorcycle.
    pub session_id: String,
    /// Its bike: the hive partition.
    pub bike_id: String,
    /// Name, without extension, of the files under its bike that have its rows: see
    /// [`parts`](super::parts).
    pub part: String,
    /// The input as the user gave it.
    pub path: String,
    /// Hash of the input's bytes.
    pub input_hash: String,
    /// Hash of everything else that the tables were made from.
    pub pipeline_hash: String,
    /// The roadbench that made them.
    pub version: String,
    /// When the ride began, microseconds since 1970; none where it does not say.
    #[serde(default)]
    pub start: Option<i64>,
    /// Whether the file is of a roadbench that had one per session, with ids as plain texts.
    #[serde(default)]
    pub is_old: bool,
}

impl Committed {
    /// Bike and id of the session.
    pub fn key(&self) -> Key {
        Key::new(&self.bike_id, &self.session_id)
    }

    /// Whether this is another ride than one that began at `start`: loggers use their file names again.
    pub fn is_other_ride(&self, start: Option<i64>) -> bool {
        let Some((own, other)) = self.start.zip(start) else { return false };
        // midnight is what a log has of which only the day is known, in an unknown time zone
        let is_day = |at: i64| at.rem_euclid(DAY) == 0;
        let same = if is_day(own) || is_day(other) { SAME_DAY } else { SAME_RIDE };
        own.abs_diff(other) > same
    }
}

/// Microseconds of a day.
const DAY: i64 = 86_400_000_000;
/// Starts that are no farther apart are those of one ride that was cut or exported again, microseconds.
const SAME_RIDE: u64 = 600_000_000;
/// The same where of one of them only the day is known.
const SAME_DAY: u64 = 129_600_000_000;

/// Columns of a commit marker that are read.
const COLUMNS: [&str; 6] =
    ["session_id", "bike_id", "path", "input_hash", "pipeline_hash", "version"];
/// Read where the file has it.
const START: &str = "start_time";

/// The rows of a commit marker; `None` where it is no such file, or a row belongs elsewhere. There are tens of
/// thousands: only what is needed is decoded.
pub(crate) fn rows(at: &Location, file: impl ChunkReader + 'static) -> Option<Vec<Committed>> {
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).ok()?;
    let names = COLUMNS.into_iter().chain([START]);
    let wanted = ProjectionMask::columns(builder.parquet_schema(), names);
    let reader = builder.with_projection(wanted).build().ok()?;
    // the row must be where its own words put it: nothing outside is ever removed on its account
    let folder = at.parent()?;
    let bike_id = folder.file_name().strip_prefix("bike=")?.to_owned();
    let part = at.file_stem().into_owned();
    let mut rows = Vec::new();
    for batch in reader {
        let batch = batch.ok()?;
        let is_old = batch.column_by_name(START).is_none_or(|c| *c.data_type() == DataType::Utf8);
        let mut texts = Vec::with_capacity(COLUMNS.len());
        for name in COLUMNS {
            texts.push(cast(batch.column_by_name(name)?, &DataType::Utf8).ok()?);
        }
        let starts = batch.column_by_name(START).and_then(instants);
        for i in 0..batch.num_rows() {
            let start = starts.as_ref().filter(|all| all.is_valid(i)).map(|all| all.value(i));
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
                start,
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

/// Instants as microseconds since 1970; earlier versions wrote texts.
fn instants(column: &ArrayRef) -> Option<Int64Array> {
    if matches!(column.data_type(), DataType::Timestamp(..)) {
        let micros = cast(column, &DataType::Timestamp(TimeUnit::Microsecond, None)).ok()?;
        let numbers = cast(&micros, &DataType::Int64).ok()?;
        return Some(numbers.as_primitive::<Int64Type>().clone());
    }
    let texts = cast(column, &DataType::Utf8).ok()?;
    let texts = texts.as_string_opt::<i32>()?;
    Some(texts.iter().map(|text| instant::microseconds(text?)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_ride_began_at_another_time_or_on_another_day() {
        let at = |text: &str| instant::microseconds(text);
        let ride = Committed { start: at("2026-05-01T10:00:00Z"), ..Committed::default() };
        let other = |text: &str| ride.is_other_ride(at(text));
        assert!(!other("2026-05-01T10:05:00Z") && other("2026-05-01T11:00:00Z"));
        assert!(!other("2026-05-01") && !other("2026-05-02") && other("2026-05-03"));
        assert!(!other("some day"), "it does not say");
    }
}
