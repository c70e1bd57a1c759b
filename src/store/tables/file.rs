//! Rows to Parquet: every table is written through its schema, whole or not at all.

use std::sync::Arc;

use arrow::array::{
    Array, ArrayRef, AsArray, RecordBatch, TimestampMicrosecondArray, new_null_array,
};
use arrow::compute::{cast, concat_batches};
use arrow::datatypes::{DataType, SchemaRef, TimeUnit, TimestampMicrosecondType};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::file::properties::WriterProperties;
use parquet::schema::types::ColumnPath;
use serde::Serialize;

use crate::contract::instant;
use crate::contract::schema::{Column, Table};
use crate::store::objects::Location;
pub(crate) use crate::store::objects::replace::TEMPORARY;
use crate::store::tables::columns;
use crate::store::tables::mismatch::Mismatch;
use crate::store::tables::registry::Row;

/// Why a table could not be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system or the object store refuses.
    #[error("cannot write {path}: {source}")]
    Io {
        /// Path or URL of the file.
        path: Location,
        /// Error of the operating system or the object store.
        source: std::io::Error,
    },
    /// The rows do not fit the schema: our own mistake.
    #[error("table `{table}`: {source}")]
    Encode {
        /// Name of the table.
        table: String,
        /// Difference from the schema.
        source: Mismatch,
    },
}

/// Rows as one Arrow batch of their table's schema.
///
/// # Errors
/// A row has a field that the schema lacks, or lacks one that it requires.
pub fn batch<R: Row>(rows: &[R]) -> Result<RecordBatch, Error> {
    batch_of(R::spec().table(), rows)
}

fn batch_of<R: Serialize>(table: &Table, rows: &[R]) -> Result<RecordBatch, Error> {
    columns::batch(table, rows)
        .map_err(|source| Error::Encode { table: table.name.clone(), source })
}

/// The column as a batch has it: by its name, or by the former one where an earlier version of the table was written.
pub(super) fn stored<'b>(column: &Column, batch: &'b RecordBatch) -> Option<&'b ArrayRef> {
    let by = |name: &str| batch.column_by_name(name);
    by(&column.name).or_else(|| by(column.former.as_deref()?))
}

/// A batch in the types of its table's schema: of one whose instants are texts, or that an earlier roadbench wrote, whose
/// ids are dictionaries or whose columns have former names. A column that may be null may be missing; one that the schema
/// has not is left out.
///
/// # Errors
/// A column is missing or of another type.
pub(crate) fn typed(table: &Table, batch: &RecordBatch) -> Result<RecordBatch, Mismatch> {
    let columns: Vec<ArrayRef> = table
        .columns
        .iter()
        .map(|column| match stored(column, batch) {
            Some(array) => conform_column(&column.name, array, &column.data_type()),
            None if column.nullable => Ok(new_null_array(&column.data_type(), batch.num_rows())),
            None => Err(Mismatch::from(format!("it has no column `{}`", column.name))),
        })
        .collect::<Result<_, Mismatch>>()?;
    RecordBatch::try_new(table.arrow(), columns).map_err(|e| Mismatch::from(e.to_string()))
}

/// A column in a type of its table. No cast of arrow's puts a zone on an instant or takes its text with one: that would
/// need a list of all zones, which is compiled in by some features only.
pub(super) fn conform_column(
    name: &str,
    array: &ArrayRef,
    to: &DataType,
) -> Result<ArrayRef, Mismatch> {
    if array.data_type() == to {
        return Ok(Arc::clone(array));
    }
    let cast = |array: &ArrayRef, to: &DataType| {
        cast(array, to).map_err(|e| Mismatch::from(format!("column `{name}`: {e}")))
    };
    match (array.data_type(), to) {
        // a text that is no time is no reason to lose the row
        (kind, DataType::Timestamp(..)) if is_text(kind) => {
            let texts = cast(array, &DataType::Utf8)?;
            let at = texts.as_string::<i32>().iter();
            let at = at.map(|text| text.and_then(instant::microseconds));
            Ok(Arc::new(TimestampMicrosecondArray::from_iter(at).with_timezone("UTC")))
        }
        (_, DataType::Timestamp(..)) => {
            let local = cast(array, &INSTANT)?;
            let at = local.as_primitive::<TimestampMicrosecondType>().clone();
            Ok(Arc::new(at.with_timezone("UTC")))
        }
        (DataType::Timestamp(..), _) => cast(&cast(array, &INSTANT)?, to),
        _ => cast(array, to),
    }
}

/// An instant without its zone.
const INSTANT: DataType = DataType::Timestamp(TimeUnit::Microsecond, None);

fn is_text(kind: &DataType) -> bool {
    match kind {
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View => true,
        DataType::Dictionary(_, values) => is_text(values),
        _ => false,
    }
}

/// Writes one batch as a Parquet file: a temporary beside it, then renamed.
///
/// # Errors
/// The folder cannot be made or the file not be written.
pub fn write_batch(to: impl Into<Location>, batch: &RecordBatch) -> Result<(), Error> {
    let to = to.into();
    let bytes = batch_to_bytes(&to.to_string(), batch)?;
    write_bytes(to, &bytes)
}

/// Rows as the bytes of one Parquet file of their table.
///
/// # Errors
/// As [`batch`].
pub fn to_bytes<R: Row>(rows: &[R]) -> Result<Vec<u8>, Error> {
    batch_to_bytes(R::spec().name, &batch(rows)?)
}

/// One batch as the bytes of a Parquet file; `table` is for messages.
///
/// # Errors
/// Parquet cannot hold it: our own mistake.
pub fn batch_to_bytes(table: &str, batch: &RecordBatch) -> Result<Vec<u8>, Error> {
    encode(batch.schema(), [Ok(batch.clone())])
        .map_err(|source| Error::Encode { table: table.to_owned(), source })
}

/// Batches one after the other, as the bytes of one Parquet file of their table.
///
/// # Errors
/// A batch does not fit the table.
pub(crate) fn batches_to_bytes(table: &Table, batches: &[RecordBatch]) -> Result<Vec<u8>, Error> {
    // what follows another is put together first, as far as it is small: a batch of one row costs as much as one of many
    let chunks = batches.chunk_by(|_, next| next.num_rows() < SMALL);
    let schema = table.arrow();
    let whole = chunks
        .flat_map(|some| some.chunks(TOGETHER))
        .map(|some| concat_batches(&schema, some).map_err(|e| Mismatch::from(e.to_string())));
    encode(Arc::clone(&schema), whole)
        .map_err(|source| Error::Encode { table: table.name.clone(), source })
}

/// Writes rows as one Parquet file of their table, whole or not at all.
///
/// # Errors
/// As [`batch`] and [`write_batch`].
pub fn write<R: Row>(to: impl Into<Location>, rows: &[R]) -> Result<(), Error> {
    write_batch(to, &batch(rows)?)
}

/// Writes bytes as a file, whole or not at all ([`Location::write`]).
///
/// # Errors
/// The folder cannot be made or the file not be written.
pub fn write_bytes(to: impl Into<Location>, bytes: &[u8]) -> Result<(), Error> {
    let to = to.into();
    to.write(bytes).map_err(|source| Error::Io { path: to, source })
}

/// Rows from which a batch is written by itself.
const SMALL: usize = 4096;
/// Most small batches that are put together.
const TOGETHER: usize = 256;
/// Rows of a page: so many are decoded at least where one session is looked up in a month's file.
const PAGE_ROWS: usize = 4096;
/// Rows of a row group: fewer make the footer a large part of the file, more the least that is read.
const GROUP_ROWS: usize = 1 << 17;

fn encode(
    schema: SchemaRef,
    batches: impl IntoIterator<Item = Result<RecordBatch, Mismatch>>,
) -> Result<Vec<u8>, Mismatch> {
    let level = ZstdLevel::try_new(3).map_err(|e| Mismatch::from(e.to_string()))?;
    // measured numbers hardly ever repeat: a dictionary of them is slower to make, and larger
    let measured = schema.fields().iter().filter(|field| *field.data_type() == DataType::Float64);
    let properties = measured
        .map(|field| ColumnPath::from(field.name().as_str()))
        .fold(WriterProperties::builder(), |all, column| {
            all.set_column_dictionary_enabled(column, false)
        })
        .set_compression(Compression::ZSTD(level))
        .set_created_by(format!("roadbench {}", crate::VERSION))
        .set_data_page_row_count_limit(PAGE_ROWS)
        .set_write_batch_size(PAGE_ROWS)
        .set_max_row_group_row_count(Some(GROUP_ROWS))
        .build();
    let mut bytes = Vec::new();
    let mut writer = ArrowWriter::try_new(&mut bytes, schema, Some(properties))
        .map_err(|e| Mismatch::from(e.to_string()))?;
    for batch in batches {
        writer.write(&batch?).map_err(|e| Mismatch::from(e.to_string()))?;
    }
    writer.close().map_err(|e| Mismatch::from(e.to_string()))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tables::{registry, rows};

    /// A row of every table goes through its schema, once with every field that may be missing left
    /// out and once with all of them: names, types and nulls agree.
    #[test]
    fn a_row_of_every_table_can_be_written() {
        for spec in registry::ALL {
            let Some(example) = spec.example else { continue };
            let mut row = example();
            for _ in 0..2 {
                let batch = batch_of(spec.table(), &[&row]).unwrap_or_else(|e| panic!("{e}"));
                assert_eq!(batch.num_rows(), 1);
                batch_to_bytes(spec.name, &batch).expect("Parquet");
                for column in spec.table().columns.iter().filter(|c| c.nullable) {
                    row[&column.name] = match column.kind.as_str() {
                        "float64" => 1.5.into(),
                        "int64" => 2.into(),
                        "bool" => true.into(),
                        _ => "text".into(),
                    };
                }
            }
        }
    }

    /// A batch under the names of the table's earlier version.
    fn earlier(table: &Table, batch: &RecordBatch) -> RecordBatch {
        let fields = batch.schema();
        let fields = fields.fields().iter().zip(&table.columns).map(|(field, column)| {
            let name = column.former.as_ref().unwrap_or(&column.name);
            field.as_ref().clone().with_name(name)
        });
        let schema = arrow::datatypes::Schema::new(fields.collect::<Vec<_>>());
        RecordBatch::try_new(Arc::new(schema), batch.columns().to_vec()).expect("the same columns")
    }

    /// Every renamed column of every table is read by its former name.
    #[test]
    fn a_table_of_the_earlier_version_becomes_one_of_this() {
        let mut seen = Vec::new();
        for spec in registry::ALL {
            let table = spec.table();
            if table.columns.iter().all(|column| column.former.is_none()) {
                continue;
            }
            let row = spec.example.expect("its rows are structs")();
            let now = batch_of(table, &[&row]).expect("a row");
            let former = earlier(table, &now);
            assert!(former.schema() != now.schema(), "{}", spec.name);
            assert_eq!(typed(table, &former).expect("read"), now, "{}", spec.name);
            seen.push(spec.name);
        }
        assert_eq!(seen, ["manoeuvres", "evidence", "bikes", "replays", "replay"]);
        // the numbers of version 1 are whether a wheel is on the ground
        let [front, _] = ["contact_front", "contact_rear"].map(|name| {
            let numbers: ArrayRef =
                Arc::new(arrow::array::Float64Array::from(vec![Some(1.0), Some(0.0), None]));
            let column = registry::SIGNALS.table().column(name).expect("a column");
            conform_column(name, &numbers, &column.data_type()).expect("a number")
        });
        let front: Vec<Option<bool>> = front.as_boolean().iter().collect();
        assert_eq!(front, [Some(true), Some(false), None]);
    }

    #[test]
    fn unit_and_description_survive_in_the_file() {
        use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("deep/er/sessions.parquet");
        write::<rows::SessionRow>(&path, &[]).expect("written");
        let file = std::fs::File::open(&path).expect("open");
        let reader = ParquetRecordBatchReaderBuilder::try_new(file).expect("parquet");
        let field = reader.schema().field_with_name("duration").expect("field").clone();
        assert_eq!(field.metadata().get("unit").map(String::as_str), Some("s"));
        assert!(field.metadata().contains_key("description"));
        let left = std::fs::read_dir(path.parent().expect("parent")).expect("list").count();
        assert_eq!(left, 1, "no temporary stays");
    }

    #[test]
    fn names_have_dictionaries_and_numbers_none() {
        use parquet::file::reader::{FileReader, SerializedFileReader};
        let rows: Vec<rows::PlotPoint> = (0..100).map(|_| rows::PlotPoint::default()).collect();
        let bytes = bytes::Bytes::from(to_bytes(&rows).expect("Parquet"));
        let reader = SerializedFileReader::new(bytes).expect("parquet");
        let columns = reader.metadata().row_group(0).columns();
        let with: Vec<&str> = columns
            .iter()
            .filter(|c| c.dictionary_page_offset().is_some())
            .map(|c| c.column_path().parts()[0].as_str())
            .collect();
        assert!(["session_id", "plot", "series"].iter().all(|c| with.contains(c)), "{with:?}");
        assert!(!["x", "y", "weight"].iter().any(|c| with.contains(c)), "{with:?}");
    }

    #[test]
    fn a_path_under_a_file_is_an_error_that_names_it() {
        let file = tempfile::NamedTempFile::new().expect("file");
        let path = file.path().join("x/y.parquet");
        let e = write_bytes(&path, b"z").expect_err("no folder below a file");
        assert!(e.to_string().contains("y.parquet"), "{e}");
    }
}
