//! Columns of the tables that the figures are drawn from.

use std::fs::File;
use std::path::{Path, PathBuf};

use arrow::array::{ArrayRef, AsArray, RecordBatch};
use arrow::compute::cast;
use arrow::datatypes::{DataType, Float64Type};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

/// The outputs of `run` and `diagnose`, the log and the simulated truth.
pub struct Tables {
    pub run: PathBuf,
    pub causes: PathBuf,
    pub ride: PathBuf,
    pub truth: PathBuf,
}

/// The rows of one table.
pub struct Table(Vec<RecordBatch>);

impl Table {
    /// All Parquet files below a file or folder.
    pub fn read(path: &Path) -> Self {
        let files = walkdir::WalkDir::new(path).sort_by_file_name().into_iter();
        let files = files.map(|entry| entry.expect("entry").into_path());
        let mut batches = Vec::new();
        for path in files.filter(|p| p.extension().is_some_and(|e| e == "parquet")) {
            let file = File::open(&path).expect("a table");
            let reader = ParquetRecordBatchReaderBuilder::try_new(file).expect("Parquet");
            let own = reader.build().expect("Parquet").map(|batch| batch.expect("rows"));
            batches.extend(own.filter(|batch| batch.num_rows() > 0));
        }
        Table(batches)
    }

    fn column(&self, name: &str, kind: &DataType) -> Vec<ArrayRef> {
        let of = |batch: &RecordBatch| {
            let column = batch.column_by_name(name).unwrap_or_else(|| panic!("no column {name}"));
            cast(column, kind).expect("castable")
        };
        self.0.iter().map(of).collect()
    }

    /// A column as numbers, NaN where null.
    pub fn numbers(&self, name: &str) -> Vec<f64> {
        let columns = self.column(name, &DataType::Float64);
        let values = |a: &ArrayRef| {
            let a = a.as_primitive::<Float64Type>();
            a.iter().map(|x| x.unwrap_or(f64::NAN)).collect::<Vec<_>>()
        };
        columns.iter().flat_map(values).collect()
    }

    /// A column as text, empty where null.
    pub fn texts(&self, name: &str) -> Vec<String> {
        let columns = self.column(name, &DataType::Utf8);
        let values = |a: &ArrayRef| {
            let a = a.as_string::<i32>();
            a.iter().map(|x| x.unwrap_or_default().to_owned()).collect::<Vec<_>>()
        };
        columns.iter().flat_map(values).collect()
    }

    /// The places of rows whose text columns have these values.
    pub fn places(&self, wanted: &[(&str, &str)]) -> Vec<usize> {
        let columns: Vec<_> =
            wanted.iter().map(|(name, value)| (self.texts(name), value)).collect();
        let len = columns.first().map_or(0, |(column, _)| column.len());
        (0..len).filter(|i| columns.iter().all(|(column, value)| column[*i] == **value)).collect()
    }

    /// A number column at some places.
    pub fn at(&self, name: &str, places: &[usize]) -> Vec<f64> {
        let all = self.numbers(name);
        places.iter().map(|i| all[*i]).collect()
    }
}

impl Tables {
    /// A table of `run`.
    pub fn of_run(&self, name: &str) -> Table {
        Table::read(&self.run.join(name))
    }

    /// A table of `diagnose`.
    pub fn of_diagnose(&self, name: &str) -> Table {
        Table::read(&self.causes.join(name))
    }

    /// Value and ends of the 95 % interval of a coefficient.
    pub fn coefficient(&self, tyre: &str, name: &str) -> [f64; 3] {
        let table = self.of_run("coefficients");
        let row = table.places(&[("tyre", tyre), ("coefficient", name)]);
        ["value", "ci95_low", "ci95_high"].map(|column| table.at(column, &row)[0])
    }

    /// Start and end of each used manoeuvre of a kind, s.
    pub fn manoeuvres(&self, kind: &str) -> Vec<[f64; 2]> {
        let table = self.of_run("manoeuvres");
        let places = table.places(&[("kind", kind), ("used", "true")]);
        let (start, end) = (table.at("start", &places), table.at("end", &places));
        start.into_iter().zip(end).map(|(a, b)| [a, b]).collect()
    }
}
