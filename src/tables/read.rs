//! Rows of the output tables, read back: Parquet in, the structs of [`rows`](super::rows) out.
//!
//! A row's struct is the one declaration of what is read, as it is of what is written. A table that
//! is not there has no rows. A column that may be null may also be absent. A null where the struct
//! has no `Option` is an empty text, NaN, 0 or `false`; a number that is not finite is a null.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use arrow::array::{Array, ArrayRef, AsArray, RecordBatch};
use arrow::compute::cast;
use arrow::datatypes::{DataType, Float64Type, Int64Type};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use serde::de::value::{BorrowedStrDeserializer, Error as RowError};
use serde::de::{DeserializeOwned, DeserializeSeed, Deserializer, MapAccess, Visitor};
use serde::forward_to_deserialize_any;
use walkdir::WalkDir;

use crate::contract::schema::Table;

/// A table that is there but cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {path}: {message}")]
pub struct Error {
    /// The file.
    pub path: PathBuf,
    /// Why it cannot be read.
    pub message: String,
}

/// The columns that name a row's session.
const NAMES: [&str; 3] = ["session_id", "bike_id", "start_time"];

/// Every row of a table, in the order of the files' paths.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn rows<R: DeserializeOwned>(out: &Path, table: &str) -> Result<Vec<R>, Error> {
    let mut rows = Vec::new();
    for_each(out, table, |row| rows.push(row))?;
    Ok(rows)
}

/// Hands over every row of a table, in the order of the files' paths; one file is held at a time.
///
/// # Errors
/// As [`rows`].
pub fn for_each<R: DeserializeOwned>(
    out: &Path,
    table: &str,
    mut take: impl FnMut(R),
) -> Result<(), Error> {
    let schema = Table::embedded(table);
    for path in files(out, table)? {
        for batch in batches(&path, None)? {
            let columns = Columns::new(&path, &schema, &batch, |_| true)?;
            for i in 0..batch.num_rows() {
                take(columns.row(&path, i)?);
            }
        }
    }
    Ok(())
}

/// The files of a table that hold a session, by (bike, session).
pub type Files = BTreeMap<(String, String), Vec<PathBuf>>;

/// Which files of a table hold which session; of the columns only the two names are read.
///
/// # Errors
/// A file cannot be read.
pub fn session_files(out: &Path, table: &str) -> Result<Files, Error> {
    let schema = Table::embedded(table);
    let mut index = Files::new();
    for path in files(out, table)? {
        for batch in batches(&path, Some(&NAMES[..2]))? {
            let columns = Columns::new(&path, &schema, &batch, |c| NAMES[..2].contains(&c))?;
            let mut previous = None;
            for i in 0..batch.num_rows() {
                let key = columns.key(i);
                // rows of one session follow one another: ask the map only when the name changes
                if previous == Some(key) {
                    continue;
                }
                previous = Some(key);
                let entry = index.entry((key.0.to_owned(), key.1.to_owned())).or_default();
                if entry.last() != Some(&path) {
                    entry.push(path.clone());
                }
            }
        }
    }
    Ok(index)
}

/// One session's rows from the files of [`session_files`], in file order. The names of session and
/// bike, which the caller knows, are left empty: thousands of copies would be most of the memory.
///
/// # Errors
/// As [`rows`].
pub fn session_rows<R: DeserializeOwned>(
    files: &Files,
    table: &str,
    (bike, session): (&str, &str),
) -> Result<Vec<R>, Error> {
    let key = (bike.to_owned(), session.to_owned());
    let Some(files) = files.get(&key) else { return Ok(Vec::new()) };
    let schema = Table::embedded(table);
    let mut rows = Vec::new();
    for path in files {
        for batch in batches(path, None)? {
            let mut columns = Columns::new(path, &schema, &batch, |_| true)?;
            let own: Vec<usize> =
                (0..batch.num_rows()).filter(|i| columns.key(*i) == (bike, session)).collect();
            columns.forget(&NAMES);
            for i in own {
                rows.push(columns.row(path, i)?);
            }
        }
    }
    Ok(rows)
}

/// The Parquet files of a table, sorted by path; temporaries (leading dot) are left out.
fn files(out: &Path, table: &str) -> Result<Vec<PathBuf>, Error> {
    let root = out.join(table);
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

fn batches(path: &Path, only: Option<&[&str]>) -> Result<Vec<RecordBatch>, Error> {
    let fail = |message: String| Error { path: path.to_owned(), message };
    let file = File::open(path).map_err(|e| fail(e.to_string()))?;
    let mut builder =
        ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| fail(e.to_string()))?;
    if let Some(names) = only {
        let mask = ProjectionMask::columns(builder.parquet_schema(), names.iter().copied());
        builder = builder.with_projection(mask);
    }
    let reader = builder.build().map_err(|e| fail(e.to_string()))?;
    reader.map(|batch| batch.map_err(|e| fail(e.to_string()))).collect()
}

/// The columns of one batch, in the types of the schema.
struct Columns(Vec<Column>);

struct Column {
    name: String,
    nullable: bool,
    kind: DataType,
    /// `None` where the batch lacks the column.
    array: Option<ArrayRef>,
}

impl Columns {
    /// Checks a batch against its schema, as far as the columns are `wanted`.
    fn new(
        path: &Path,
        schema: &Table,
        batch: &RecordBatch,
        wanted: impl Fn(&str) -> bool,
    ) -> Result<Self, Error> {
        let fail = |message: String| Error { path: path.to_owned(), message };
        let mut columns = Vec::new();
        for column in schema.columns.iter().filter(|c| wanted(&c.name)) {
            let kind = column.arrow().data_type().clone();
            let array = match batch.column_by_name(&column.name) {
                Some(array) => Some(
                    cast(array, &kind)
                        .map_err(|e| fail(format!("column `{}`: {e}", column.name)))?,
                ),
                None if column.nullable => None,
                None => return Err(fail(format!("it has no column `{}`", column.name))),
            };
            let (name, nullable) = (column.name.clone(), column.nullable);
            columns.push(Column { name, nullable, kind, array });
        }
        Ok(Columns(columns))
    }

    /// Bike and session of a row.
    fn key(&self, i: usize) -> (&str, &str) {
        let text = |name: &str| {
            let column = self.0.iter().find(|c| c.name == name);
            column.and_then(|c| c.cell(i).text()).unwrap_or_default()
        };
        (text("bike_id"), text("session_id"))
    }

    /// Makes every value of some columns a null.
    fn forget(&mut self, names: &[&str]) {
        for column in self.0.iter_mut().filter(|c| names.contains(&c.name.as_str())) {
            column.array = None;
        }
    }

    fn row<R: DeserializeOwned>(&self, path: &Path, i: usize) -> Result<R, Error> {
        let row = Row { columns: self.0.iter(), next: None, i };
        R::deserialize(row)
            .map_err(|e| Error { path: path.to_owned(), message: format!("row {i}: {e}") })
    }
}

impl Column {
    fn cell(&self, i: usize) -> Cell<'_> {
        let array = self.array.as_ref().filter(|array| array.is_valid(i));
        Cell { column: self, array, i }
    }
}

/// One row, as a map of its columns.
struct Row<'a> {
    columns: std::slice::Iter<'a, Column>,
    /// The cell whose name was handed over last.
    next: Option<Cell<'a>>,
    i: usize,
}

impl<'de> Deserializer<'de> for Row<'de> {
    type Error = RowError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, RowError> {
        visitor.visit_map(self)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option
        unit unit_struct newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

impl<'de> MapAccess<'de> for Row<'de> {
    type Error = RowError;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, RowError> {
        let Some(column) = self.columns.next() else { return Ok(None) };
        self.next = Some(column.cell(self.i));
        seed.deserialize(BorrowedStrDeserializer::new(&column.name)).map(Some)
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, RowError> {
        let cell = self.next.take().ok_or_else(|| {
            <RowError as serde::de::Error>::custom("a value was asked for before its name")
        })?;
        seed.deserialize(cell)
    }
}

/// One value.
struct Cell<'a> {
    column: &'a Column,
    /// `None` where the value is null.
    array: Option<&'a ArrayRef>,
    i: usize,
}

impl<'a> Cell<'a> {
    fn text(&self) -> Option<&'a str> {
        self.array.map(|a| a.as_string::<i32>().value(self.i))
    }

    fn number(&self) -> Option<f64> {
        let number = self.array.map(|a| a.as_primitive::<Float64Type>().value(self.i));
        number.filter(|x| x.is_finite())
    }

    fn integer(&self) -> Option<i64> {
        self.array.map(|a| a.as_primitive::<Int64Type>().value(self.i))
    }

    fn flag(&self) -> Option<bool> {
        self.array.map(|a| a.as_boolean().value(self.i))
    }

    fn is_null(&self) -> bool {
        match self.column.kind {
            DataType::Float64 => self.number().is_none(),
            _ => self.array.is_none(),
        }
    }

    /// The value, or what stands for a null.
    fn visit<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, RowError> {
        match self.column.kind {
            DataType::Float64 => visitor.visit_f64(self.number().unwrap_or(f64::NAN)),
            DataType::Int64 => visitor.visit_i64(self.integer().unwrap_or(0)),
            DataType::Boolean => visitor.visit_bool(self.flag().unwrap_or(false)),
            _ => visitor.visit_borrowed_str(self.text().unwrap_or_default()),
        }
    }
}

macro_rules! typed {
    ($($name:ident)*) => {
        $(fn $name<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, RowError> {
            self.visit(visitor)
        })*
    };
}

impl<'de> Deserializer<'de> for Cell<'de> {
    type Error = RowError;

    /// What a flattened struct asks for, which does not say yet whether it has an `Option`.
    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, RowError> {
        match self.column.nullable && self.is_null() {
            true => visitor.visit_none(),
            false => self.visit(visitor),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, RowError> {
        match self.is_null() {
            true => visitor.visit_none(),
            false => visitor.visit_some(self),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, RowError> {
        let text = self.text().unwrap_or_default();
        BorrowedStrDeserializer::new(text).deserialize_enum(name, variants, visitor)
    }

    typed! { deserialize_bool deserialize_i64 deserialize_f64 deserialize_str deserialize_string }

    forward_to_deserialize_any! {
        i8 i16 i32 i128 u8 u16 u32 u64 u128 f32 char bytes byte_buf unit unit_struct newtype_struct
        seq tuple tuple_struct map struct identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use serde::Serialize;

    use super::*;
    use crate::tables::file;
    use crate::tables::rows::{Coefficient, Ident, Manoeuvre, PlotPoint, Provenance, Status};

    fn ident(session: &str) -> Ident {
        Ident { session_id: session.into(), bike_id: "b".into(), start_time: None }
    }

    fn put<R: Serialize>(out: &Path, table: &str, name: &str, rows: &[R]) {
        let path = out.join(table).join(name);
        file::write(&path, &Table::embedded(table), rows).expect("written");
    }

    #[test]
    fn rows_come_back_as_they_were_written() {
        let out = tempfile::tempdir().expect("folder");
        let row = Coefficient {
            ident: Ident { start_time: Some("2024-05-03T10:11:12Z".into()), ..ident("s") },
            tyre: "front".into(),
            coefficient: "mf_d".into(),
            symbol: "d".into(),
            value: Some(1.25),
            unit: "1".into(),
            std_error: None,
            ci95_low: Some(1.0),
            ci95_high: Some(1.5),
            dispersion: None,
            n_manoeuvres: 4,
            n_samples: 400,
            residual_scale: None,
            outlier_fraction: Some(0.0),
            r_squared: None,
            status: Status::PoorlyDetermined,
            reason: Some("few".into()),
            provenance: Provenance { input_hash: "i".into(), ..Provenance::default() },
        };
        put(out.path(), "coefficients", "a.parquet", std::slice::from_ref(&row));
        put(out.path(), "coefficients", ".torn.parquet", &[row.clone()]);
        let found: Vec<Coefficient> = rows(out.path(), "coefficients").expect("read");
        assert_eq!(found.len(), 1);
        assert_eq!(format!("{:?}", found[0]), format!("{row:?}"));
        let none: Vec<Coefficient> = rows(out.path(), "sessions").expect("no such table");
        assert!(none.is_empty());
    }

    #[test]
    fn a_session_is_found_in_its_files_and_its_names_are_left_out() {
        let out = tempfile::tempdir().expect("folder");
        let of = |session: &str, id| Manoeuvre {
            ident: ident(session),
            manoeuvre_id: id,
            kind: "cornering".into(),
            used: true,
            ..Manoeuvre::default()
        };
        put(out.path(), "manoeuvres", "a.parquet", &[of("s", 1), of("t", 2), of("s", 3)]);
        put(out.path(), "manoeuvres", "b.parquet", &[of("t", 4)]);
        let files = session_files(out.path(), "manoeuvres").expect("index");
        let found: Vec<Manoeuvre> = session_rows(&files, "manoeuvres", ("b", "s")).expect("rows");
        let ids: Vec<i64> = found.iter().map(|m| m.manoeuvre_id).collect();
        assert_eq!(ids, [1, 3]);
        assert!(found[0].used && found[0].ident.session_id.is_empty());
        assert!(found[0].quality.is_none());
        let none: Vec<PlotPoint> = session_rows(&files, "plots", ("b", "u")).expect("no files");
        assert!(none.is_empty());
    }

    #[test]
    fn a_missing_column_is_named() {
        let out = tempfile::tempdir().expect("folder");
        let wrong = out.path().join("coefficients/a.parquet");
        file::write(&wrong, &Table::embedded("manoeuvres"), &[Manoeuvre::default()])
            .expect("written");
        let message = rows::<Coefficient>(out.path(), "coefficients").expect_err("no column");
        assert!(message.to_string().contains("it has no column `tyre`"), "{message}");
    }
}
