//! Parquet to rows: the tables of an output folder, read back through their schemas.
//!
//! A table that is not there has no rows; a column that may be null may also be absent. What is
//! there but cannot be read is an error that names the file. Numbers that are not finite are read as
//! missing: `None`, or NaN where the column has no nulls.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::File;
use std::path::{Path, PathBuf};

use arrow::array::{Array, ArrayRef, AsArray, RecordBatch};
use arrow::datatypes::{DataType, Float64Type, Int64Type, TimestampMicrosecondType};
use bytes::Bytes;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReaderBuilder, RowSelection,
};
use parquet::file::metadata::PageIndexPolicy;
use parquet::file::reader::ChunkReader;
use rayon::prelude::*;
use serde::de::value::BorrowedStrDeserializer;
use serde::de::{self, DeserializeOwned, DeserializeSeed, Deserializer, MapAccess, Visitor};
use serde::forward_to_deserialize_any;
use walkdir::WalkDir;

use super::file;
use super::registry::{Row, TableSpec};
use crate::contract::instant;
use crate::store::objects::Location;
use crate::store::tables::mismatch::Mismatch;

/// A table's file cannot be read, or has not the columns of its schema.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {}: {message}", path.display())]
pub struct Error {
    /// Path of the file.
    pub path: PathBuf,
    /// Message: what is wrong with the file.
    pub message: String,
}

/// The rows of a table, file by file in order of path.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn rows<R: Row + DeserializeOwned + Send>(out: &Path) -> Result<Vec<R>, Error> {
    let parts: Result<Vec<Vec<R>>, Error> =
        files(out, R::spec())?.par_iter().map(|path| file_rows(path)).collect();
    let parts = parts?;
    let mut all = Vec::with_capacity(parts.iter().map(Vec::len).sum());
    parts.into_iter().for_each(|part| all.extend(part));
    Ok(all)
}

/// The rows of one file of a table.
///
/// # Errors
/// The file cannot be read or lacks a column.
pub fn file_rows<R: Row + DeserializeOwned>(path: &Path) -> Result<Vec<R>, Error> {
    rows_where(path, |_, _| true)
}

/// The rows of one file of a table that are wanted: `wanted` is asked before a row is made.
///
/// # Errors
/// The file cannot be read or lacks a column.
pub(crate) fn rows_where<R: Row + DeserializeOwned>(
    path: &Path,
    wanted: impl Fn(&Columns, usize) -> bool,
) -> Result<Vec<R>, Error> {
    let mut rows = Vec::new();
    for batch in batches(path, None)? {
        take(path, &batch, &wanted, &mut rows)?;
    }
    Ok(rows)
}

/// The rows of a file that is in memory; `at` is for messages.
///
/// # Errors
/// As [`file_rows`].
pub(crate) fn rows_of<R: Row + DeserializeOwned>(
    at: &Location,
    file: Vec<u8>,
) -> Result<Vec<R>, Error> {
    let path = PathBuf::from(at.to_string());
    let batches = batches_of(Bytes::from(file))
        .map_err(|e| Error { path: path.clone(), message: e.to_string() })?;
    let mut rows = Vec::new();
    for batch in batches {
        take(&path, &batch, &|_, _| true, &mut rows)?;
    }
    Ok(rows)
}

/// The schema of a table's file where it is a newer version than this roadbench has, `coefficients.v2`.
pub(crate) fn newer_schema(spec: &TableSpec, file: impl ChunkReader + 'static) -> Option<String> {
    let (schema, version) = schema_of(file)?;
    (version > spec.table().version).then_some(schema)
}

/// Whether a table's file is of an earlier version of its schema.
pub(crate) fn is_earlier(spec: &TableSpec, file: impl ChunkReader + 'static) -> bool {
    schema_of(file).is_some_and(|(_, version)| version < spec.table().version)
}

/// Name and version of a table's schema, as its file has them.
fn schema_of(file: impl ChunkReader + 'static) -> Option<(String, u32)> {
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).ok()?;
    let schema = builder.schema().metadata().get("roadbench.schema")?.clone();
    let version = schema.rsplit_once(".v")?.1.parse().ok()?;
    Some((schema, version))
}

/// The batches of a file that is in memory.
///
/// # Errors
/// It cannot be read.
pub fn batches_of(file: Bytes) -> Result<Vec<RecordBatch>, Mismatch> {
    let reader = ParquetRecordBatchReaderBuilder::try_new(file)
        .and_then(ParquetRecordBatchReaderBuilder::build)
        .map_err(|e| Mismatch::from(e.to_string()))?;
    reader.map(|batch| batch.map_err(|e| Mismatch::from(e.to_string()))).collect()
}

/// Adds the wanted rows of a batch.
pub(super) fn take<R: Row + DeserializeOwned>(
    path: &Path,
    batch: &RecordBatch,
    wanted: &impl Fn(&Columns, usize) -> bool,
    rows: &mut Vec<R>,
) -> Result<(), Error> {
    let columns = Columns::new(path, R::spec(), batch, &[])?;
    for i in (0..batch.num_rows()).filter(|i| wanted(&columns, *i)) {
        let row = R::deserialize(RowReader { columns: &columns, row: i })
            .map_err(|e| Error { path: path.to_owned(), message: e.to_string() })?;
        rows.push(row);
    }
    Ok(())
}

/// The Parquet files of a table, sorted by path; temporaries (leading dot) are passed by.
///
/// # Errors
/// The folder is there but cannot be listed.
pub fn files(out: &Path, spec: &TableSpec) -> Result<Vec<PathBuf>, Error> {
    let root = out.join(spec.name);
    if !root.is_dir() {
        return Ok(Vec::new());
    }
    let mut paths = Vec::new();
    for entry in WalkDir::new(&root).sort_by_file_name() {
        let entry = entry.map_err(|e| Error { path: root.clone(), message: e.to_string() })?;
        let hidden = entry.file_name().to_string_lossy().starts_with('.');
        let parquet = entry.path().extension().is_some_and(|e| e == "parquet");
        if entry.file_type().is_file() && parquet && !hidden {
            paths.push(entry.into_path());
        }
    }
    Ok(paths)
}

/// The batches of a Parquet file; `only` limits the columns that are decoded.
///
/// # Errors
/// The file cannot be read.
pub(crate) fn batches(path: &Path, only: Option<&[&str]>) -> Result<Vec<RecordBatch>, Error> {
    selected(path, &about(path)?, only, None)
}

/// Metadata of a Parquet file, with its page index.
///
/// # Errors
/// The file cannot be read.
pub(super) fn about(path: &Path) -> Result<ArrowReaderMetadata, Error> {
    let fail = |message: String| Error { path: path.to_owned(), message };
    let file = File::open(path).map_err(|e| fail(e.to_string()))?;
    let options = ArrowReaderOptions::new().with_page_index_policy(PageIndexPolicy::Optional);
    ArrowReaderMetadata::load(&file, options).map_err(|e| fail(e.to_string()))
}

/// The batches of some rows of a Parquet file; pages without any are not read.
///
/// # Errors
/// The file cannot be read.
pub(super) fn selected(
    path: &Path,
    about: &ArrowReaderMetadata,
    only: Option<&[&str]>,
    rows: Option<RowSelection>,
) -> Result<Vec<RecordBatch>, Error> {
    let fail = |message: String| Error { path: path.to_owned(), message };
    let file = File::open(path).map_err(|e| fail(e.to_string()))?;
    let mut builder = ParquetRecordBatchReaderBuilder::new_with_metadata(file, about.clone());
    if let Some(names) = only {
        let mask = ProjectionMask::columns(builder.parquet_schema(), names.iter().copied());
        builder = builder.with_projection(mask);
    }
    if let Some(rows) = rows {
        builder = builder.with_row_selection(rows);
    }
    let reader = builder.build().map_err(|e| fail(e.to_string()))?;
    reader.map(|batch| batch.map_err(|e| fail(e.to_string()))).collect()
}

/// The columns of one batch by name, in the types of files; rows get instants as texts.
#[derive(Debug)]
pub(crate) struct Columns(BTreeMap<&'static str, ArrayRef>);

impl Columns {
    /// Checks a batch of the file `path` against its schema; `only` limits the columns looked for
    /// (empty: all).
    ///
    /// # Errors
    /// A column is missing or has another type.
    pub(crate) fn new(
        path: &Path,
        spec: &'static TableSpec,
        batch: &RecordBatch,
        only: &[&str],
    ) -> Result<Self, Error> {
        let mut columns = BTreeMap::new();
        for column in &spec.table().columns {
            if !only.is_empty() && !only.contains(&column.name.as_str()) {
                continue;
            }
            let fail = |message: String| Error { path: path.to_owned(), message };
            match file::stored(column, batch) {
                Some(array) => {
                    let array = file::conform_column(&column.name, array, &column.data_type())
                        .map_err(|e| fail(e.to_string()))?;
                    columns.insert(column.name.as_str(), array);
                }
                None if column.nullable => {}
                None => return Err(fail(format!("it has no column `{}`", column.name))),
            }
        }
        Ok(Columns(columns))
    }

    fn valid(&self, name: &str, i: usize) -> Option<&ArrayRef> {
        self.0.get(name).filter(|array| array.is_valid(i))
    }

    /// A text; empty where there is none.
    pub(crate) fn text(&self, name: &str, i: usize) -> &str {
        self.valid(name, i).map_or("", |a| a.as_string::<i32>().value(i))
    }

    /// A number; NaN where there is none that is finite.
    pub(crate) fn number(&self, name: &str, i: usize) -> f64 {
        let value = self.valid(name, i).map(|a| a.as_primitive::<Float64Type>().value(i));
        value.filter(|x| x.is_finite()).unwrap_or(f64::NAN)
    }

    /// An instant, microseconds since 1970 in UTC.
    pub(crate) fn instant(&self, name: &str, i: usize) -> Option<i64> {
        let array = self.valid(name, i)?;
        Some(array.as_primitive::<TimestampMicrosecondType>().value(i))
    }
}

/// One row of a batch, as serde reads it.
struct RowReader<'a> {
    columns: &'a Columns,
    row: usize,
}

/// Message of serde about a row that it cannot read.
#[derive(Debug)]
struct RowError(String);

impl fmt::Display for RowError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for RowError {}

impl de::Error for RowError {
    fn custom<T: fmt::Display>(message: T) -> Self {
        RowError(message.to_string())
    }
}

impl<'de> Deserializer<'de> for RowReader<'de> {
    type Error = RowError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, RowError> {
        let columns = self.columns.0.iter();
        visitor.visit_map(Cells { columns, row: self.row, next: None })
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

struct Cells<'a, I> {
    columns: I,
    row: usize,
    next: Option<&'a ArrayRef>,
}

impl<'a, I: Iterator<Item = (&'a &'static str, &'a ArrayRef)>> MapAccess<'a> for Cells<'a, I> {
    type Error = RowError;

    fn next_key_seed<K: DeserializeSeed<'a>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, RowError> {
        let Some((name, array)) = self.columns.next() else { return Ok(None) };
        self.next = Some(array);
        seed.deserialize(BorrowedStrDeserializer::new(name)).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'a>>(&mut self, seed: V) -> Result<V::Value, RowError> {
        let array = self.next.take().ok_or_else(|| RowError("no column".to_owned()))?;
        seed.deserialize(Cell { array, row: self.row })
    }
}

/// One value of a row.
struct Cell<'a> {
    array: &'a ArrayRef,
    row: usize,
}

impl Cell<'_> {
    fn number(&self) -> f64 {
        self.array.as_primitive::<Float64Type>().value(self.row)
    }

    fn instant(&self) -> i64 {
        self.array.as_primitive::<TimestampMicrosecondType>().value(self.row)
    }

    fn is_missing(&self) -> bool {
        let float = || matches!(self.array.data_type(), DataType::Float64);
        self.array.is_null(self.row) || (float() && !self.number().is_finite())
    }
}

impl<'de> Deserializer<'de> for Cell<'de> {
    type Error = RowError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, RowError> {
        let missing = self.is_missing();
        match self.array.data_type() {
            DataType::Float64 if missing => visitor.visit_f64(f64::NAN),
            DataType::Float64 => visitor.visit_f64(self.number()),
            _ if missing => visitor.visit_unit(),
            DataType::Int64 => {
                visitor.visit_i64(self.array.as_primitive::<Int64Type>().value(self.row))
            }
            DataType::Boolean => visitor.visit_bool(self.array.as_boolean().value(self.row)),
            DataType::Timestamp(..) => match instant::text(self.instant()) {
                Some(text) => visitor.visit_string(text),
                None => visitor.visit_unit(),
            },
            _ => visitor.visit_borrowed_str(self.array.as_string::<i32>().value(self.row)),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, RowError> {
        match self.is_missing() {
            true => visitor.visit_none(),
            false => visitor.visit_some(self),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, RowError> {
        let text =
            if self.is_missing() { "" } else { self.array.as_string::<i32>().value(self.row) };
        visitor.visit_enum(BorrowedStrDeserializer::new(text))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf unit unit_struct
        newtype_struct seq tuple tuple_struct map struct identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::store::tables::file;
    use crate::store::tables::rows::{
        Coefficient, EvidenceRow, Ident, Rejected, SessionRow, Status,
    };

    #[test]
    fn rows_come_back_as_they_were_written() {
        let out = tempfile::tempdir().expect("folder");
        let row = Coefficient {
            ident: Ident {
                session_id: "s".into(),
                bike_id: "b".into(),
                start_time: Some("2026-05-01T10:00:00Z".into()),
            },
            value: Some(0.1 + 0.2),
            std_error: Some(f64::INFINITY),
            n_samples: 7,
            status: Status::PoorlyDetermined,
            ..Coefficient::default()
        };
        let path = out.path().join("coefficients/bike=b/s.parquet");
        file::write(&path, &[row.clone(), Coefficient::default()]).expect("written");
        file::write::<Coefficient>(&path.with_file_name(".roadbench-x.parquet"), &[]).expect("two");
        let read: Vec<Coefficient> = rows(out.path()).expect("read");
        assert_eq!(read.len(), 2);
        assert_eq!(read[0].ident, row.ident);
        assert_eq!(read[0].value, row.value);
        assert_eq!(read[0].std_error, None, "infinite is missing");
        assert_eq!((read[0].n_samples, read[0].status), (7, Status::PoorlyDetermined));
        assert_eq!(
            (read[1].ident.start_time.as_ref(), read[1].status),
            (None, Status::NotAvailable)
        );
        assert!(rows::<SessionRow>(out.path()).expect("none").is_empty());
    }

    /// As an earlier roadbench wrote it, by hand: two names of then, and none of today.
    #[test]
    fn a_row_of_the_earlier_version_is_read_by_its_former_names() {
        use arrow::array::{BooleanArray, Float64Array, StringArray};
        let text = |x: &str| Arc::new(StringArray::from(vec![x])) as ArrayRef;
        let number = |x: f64| Arc::new(Float64Array::from(vec![x])) as ArrayRef;
        let columns = [
            ("session_id", text("s")),
            ("bike_id", text("b")),
            ("tyre", text("front")),
            ("coefficient", text("mf_d")),
            ("unit", text("1")),
            ("status", text("ok")),
            ("value", number(1.1)),
            ("source", text("mass")),
            ("shared", Arc::new(BooleanArray::from(vec![true])) as ArrayRef),
            ("shift", number(0.02)),
            ("source_value", number(250.0)),
            ("source_sd", number(4.0)),
        ];
        let batch = RecordBatch::try_from_iter(columns).expect("a batch");
        let out = tempfile::tempdir().expect("folder");
        file::write_batch(out.path().join("evidence/bike=b/2026-05.parquet"), &batch).expect("it");
        let read = rows::<EvidenceRow>(out.path()).expect("read");
        let [row] = read.as_slice() else { panic!("{read:?}") };
        let number = (row.sensitivity, row.source_value, row.source_std_error);
        assert_eq!(number, (0.02, Some(250.0), Some(4.0)));
    }

    #[test]
    fn a_file_of_another_table_is_an_error_that_names_it() {
        let out = tempfile::tempdir().expect("folder");
        let path = out.path().join("sessions/x.parquet");
        file::write::<Rejected>(&path, &[]).expect("written");
        // without rows there is nothing to read
        assert!(rows::<SessionRow>(out.path()).expect("empty").is_empty());
        file::write(&path, &[Rejected::default()]).expect("written");
        let e = rows::<SessionRow>(out.path()).expect_err("not a sessions table").to_string();
        assert!(
            e.contains("x.parquet") && e.contains("start_time") | e.contains("duration"),
            "{e}"
        );
    }
}
