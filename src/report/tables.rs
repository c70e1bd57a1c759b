//! The output tables, read back from a folder: Parquet in, rows out, in a fixed order.
//!
//! A table that is not there has no rows; a column that may be null may also be absent. What
//! is there but cannot be read is an error that names the file.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use arrow::array::{Array, ArrayRef, AsArray, RecordBatch};
use arrow::compute::cast;
use arrow::datatypes::{Float64Type, Int64Type};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use walkdir::WalkDir;

use crate::report::Error;
use crate::report::words;
use crate::tables::registry;
use crate::tables::rows::{
    Coefficient, ForceRow, Ident, Manoeuvre, PlotPoint, Provenance, Rejected, SessionRow, Status,
    WarningRow,
};

/// Every `sessions` row, by bike and session.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn sessions(out: &Path) -> Result<Vec<SessionRow>, Error> {
    let mut rows = collect(out, "sessions", |c, i| SessionRow {
        ident: c.ident(i),
        path: c.text("path", i),
        duration: c.number("duration", i),
        rate: c.number("rate", i),
        n_samples: c.integer("n_samples", i),
        distance: c.maybe("distance", i),
        channels: c.text("channels", i),
        n_manoeuvres: c.integer("n_manoeuvres", i),
        n_used: c.integer("n_used", i),
        n_coefficients_ok: c.integer("n_coefficients_ok", i),
        n_warnings: c.integer("n_warnings", i),
        tyre_front: c.maybe_text("tyre_front", i),
        tyre_rear: c.maybe_text("tyre_rear", i),
        site: c.maybe_text("site", i),
        rider_id: c.maybe_text("rider_id", i),
        provenance: c.provenance(i),
    })?;
    rows.sort_by(|a, b| key(&a.ident).cmp(&key(&b.ident)));
    Ok(rows)
}

/// Every `coefficients` row: by bike and session, then in the contract's order.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn coefficients(out: &Path) -> Result<Vec<Coefficient>, Error> {
    let mut rows = collect(out, "coefficients", |c, i| Coefficient {
        ident: c.ident(i),
        tyre: c.text("tyre", i),
        coefficient: c.text("coefficient", i),
        symbol: c.text("symbol", i),
        value: c.maybe("value", i),
        unit: c.text("unit", i),
        std_error: c.maybe("std_error", i),
        ci95_low: c.maybe("ci95_low", i),
        ci95_high: c.maybe("ci95_high", i),
        dispersion: c.maybe("dispersion", i),
        n_manoeuvres: c.integer("n_manoeuvres", i),
        n_samples: c.integer("n_samples", i),
        residual_scale: c.maybe("residual_scale", i),
        outlier_fraction: c.maybe("outlier_fraction", i),
        r_squared: c.maybe("r_squared", i),
        status: status(&c.text("status", i)),
        reason: c.maybe_text("reason", i),
        provenance: c.provenance(i),
    })?;
    rows.sort_by(|a, b| {
        (key(&a.ident), words::order(&a.tyre, &a.coefficient))
            .cmp(&(key(&b.ident), words::order(&b.tyre, &b.coefficient)))
    });
    Ok(rows)
}

/// One session's `manoeuvres` rows by number, from the files of [`session_files`].
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn manoeuvres(files: &[PathBuf], bike: &str, session: &str) -> Result<Vec<Manoeuvre>, Error> {
    let row = |c: &Columns, i: usize| Manoeuvre {
        ident: c.ident(i),
        manoeuvre_id: c.integer("manoeuvre_id", i),
        kind: c.text("kind", i),
        start: c.number("start", i),
        end: c.number("end", i),
        direction: c.maybe_text("direction", i),
        quality: c.number("quality", i),
        used: c.flag("used", i),
        reason: c.maybe_text("reason", i),
        speed_start: c.maybe("speed_start", i),
        speed_end: c.maybe("speed_end", i),
        speed_mean: c.maybe("speed_mean", i),
        acceleration_x_mean: c.maybe("acceleration_x_mean", i),
        acceleration_x_peak: c.maybe("acceleration_x_peak", i),
        acceleration_y_peak: c.maybe("acceleration_y_peak", i),
        roll_peak: c.maybe("roll_peak", i),
        slip_front_peak: c.maybe("slip_front_peak", i),
        slip_rear_peak: c.maybe("slip_rear_peak", i),
        flight_time: c.maybe("flight_time", i),
        landing_load_front: c.maybe("landing_load_front", i),
        landing_load_rear: c.maybe("landing_load_rear", i),
        load_transfer: c.maybe("load_transfer", i),
    };
    let mut rows = Vec::new();
    for path in files {
        for batch in read(path, None)? {
            let c = Columns::new(path, "manoeuvres", &batch, &[])?;
            let own =
                |i: &usize| c.str("session_id", *i) == session && c.str("bike_id", *i) == bike;
            rows.extend((0..batch.num_rows()).filter(own).map(|i| row(&c, i)));
        }
    }
    rows.sort_by_key(|m| m.manoeuvre_id);
    Ok(rows)
}

/// Every `forces` row, by bike, session and manoeuvre, then as the estimate wrote them; none where
/// nothing was ridden off-road.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn forces(out: &Path) -> Result<Vec<ForceRow>, Error> {
    let mut rows = collect(out, "forces", |c, i| ForceRow {
        ident: c.ident(i),
        manoeuvre_id: c.integer("manoeuvre_id", i),
        kind: c.text("kind", i),
        rider: c.text("rider", i),
        force: c.text("force", i),
        unit: c.text("unit", i),
        peak: c.maybe("peak", i),
        rms: c.maybe("rms", i),
        mean: c.maybe("mean", i),
        dispersion: c.maybe("dispersion", i),
        n_samples: c.integer("n_samples", i),
    })?;
    rows.sort_by(|a, b| key(&a.ident).cmp(&key(&b.ident)));
    Ok(rows)
}

/// Every `warnings` row, by bike and session, then as the stages wrote them.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn warnings(out: &Path) -> Result<Vec<WarningRow>, Error> {
    let mut rows = collect(out, "warnings", |c, i| WarningRow {
        ident: c.ident(i),
        stage: c.text("stage", i),
        code: c.text("code", i),
        channel: c.maybe_text("channel", i),
        count: c.integer("count", i),
        time: c.maybe("time", i),
        message: c.text("message", i),
    })?;
    rows.sort_by(|a, b| key(&a.ident).cmp(&key(&b.ident)));
    Ok(rows)
}

/// Every `rejected` row, by path.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn rejected(out: &Path) -> Result<Vec<Rejected>, Error> {
    let mut rows = collect(out, "rejected", |c, i| Rejected {
        path: c.text("path", i),
        session_id: c.maybe_text("session_id", i),
        bike_id: c.maybe_text("bike_id", i),
        stage: c.text("stage", i),
        code: c.text("code", i),
        message: c.text("message", i),
        input_hash: c.maybe_text("input_hash", i),
        version: c.text("version", i),
    })?;
    rows.sort_by(|a, b| (&a.path, &a.code).cmp(&(&b.path, &b.code)));
    Ok(rows)
}

/// The files of a table that hold a session, by (bike, session).
pub type Files = BTreeMap<(String, String), Vec<PathBuf>>;

/// Which files of a table hold which session; only the two names are read.
///
/// # Errors
/// A file cannot be read.
pub fn session_files(out: &Path, table: &str) -> Result<Files, Error> {
    let mut index = Files::new();
    for path in files(out, table)? {
        for batch in read(&path, Some(&["session_id", "bike_id"]))? {
            let columns = Columns::new(&path, table, &batch, &["session_id", "bike_id"])?;
            for i in 0..batch.num_rows() {
                let (session, bike) = (columns.str("session_id", i), columns.str("bike_id", i));
                // runs of one session: ask the map only when the name changes
                let known = i > 0
                    && columns.str("session_id", i - 1) == session
                    && columns.str("bike_id", i - 1) == bike;
                if !known {
                    let entry = index.entry((bike.to_owned(), session.to_owned())).or_default();
                    if entry.last() != Some(&path) {
                        entry.push(path.clone());
                    }
                }
            }
        }
    }
    Ok(index)
}

/// One session's `plots` rows, from the files of [`session_files`], in file order.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn plots(files: &[PathBuf], bike: &str, session: &str) -> Result<Vec<PlotPoint>, Error> {
    let mut rows = Vec::new();
    for path in files {
        for batch in read(path, None)? {
            let c = Columns::new(path, "plots", &batch, &[])?;
            for i in 0..batch.num_rows() {
                if c.str("session_id", i) != session || c.str("bike_id", i) != bike {
                    continue;
                }
                rows.push(PlotPoint {
                    session_id: String::new(), // the caller knows; thousands of copies help nobody
                    bike_id: String::new(),
                    plot: c.text("plot", i),
                    series: c.text("series", i),
                    x: c.number("x", i),
                    y: c.maybe("y", i),
                    y_low: c.maybe("y_low", i),
                    y_high: c.maybe("y_high", i),
                    weight: c.maybe("weight", i),
                    manoeuvre_id: c.maybe_integer("manoeuvre_id", i),
                    shade: c.maybe("shade", i),
                    n: c.maybe_integer("n", i),
                });
            }
        }
    }
    Ok(rows)
}

/// What orders sessions everywhere in the report.
pub fn key(ident: &Ident) -> (&str, &str) {
    (&ident.bike_id, &ident.session_id)
}

fn status(text: &str) -> Status {
    match text {
        "ok" => Status::Ok,
        "assumed" => Status::Assumed,
        "poorly_determined" => Status::PoorlyDetermined,
        _ => Status::NotAvailable,
    }
}

pub(super) fn collect<R>(
    out: &Path,
    table: &str,
    row: impl Fn(&Columns, usize) -> R,
) -> Result<Vec<R>, Error> {
    let mut rows = Vec::new();
    for_each_batch(out, table, |columns, n| rows.extend((0..n).map(|i| row(columns, i))))?;
    Ok(rows)
}

/// Hands every batch of a table over, with its number of rows; one file is held at a time.
pub(super) fn for_each_batch(
    out: &Path,
    table: &str,
    mut take: impl FnMut(&Columns, usize),
) -> Result<(), Error> {
    for path in files(out, table)? {
        for batch in read(&path, None)? {
            take(&Columns::new(&path, table, &batch, &[])?, batch.num_rows());
        }
    }
    Ok(())
}

/// The Parquet files of a table, sorted by path; temporaries (leading dot) are left alone.
fn files(out: &Path, table: &str) -> Result<Vec<PathBuf>, Error> {
    let root = out.join(table);
    if !root.is_dir() {
        return Ok(Vec::new());
    }
    let mut paths = Vec::new();
    for entry in WalkDir::new(&root).sort_by_file_name() {
        let entry =
            entry.map_err(|e| Error::Read { path: root.clone(), message: e.to_string() })?;
        let hidden = entry.file_name().to_string_lossy().starts_with('.');
        let parquet = entry.path().extension().is_some_and(|e| e == "parquet");
        if entry.file_type().is_file() && parquet && !hidden {
            paths.push(entry.into_path());
        }
    }
    Ok(paths)
}

pub(super) fn read(path: &Path, only: Option<&[&str]>) -> Result<Vec<RecordBatch>, Error> {
    let fail = |message: String| Error::Read { path: path.to_owned(), message };
    let file = File::open(path).map_err(|e| fail(e.to_string()))?;
    let mut builder =
        ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| fail(e.to_string()))?;
    if let Some(names) = only {
        let mask = parquet::arrow::ProjectionMask::columns(
            builder.parquet_schema(),
            names.iter().copied(),
        );
        builder = builder.with_projection(mask);
    }
    let reader = builder.build().map_err(|e| fail(e.to_string()))?;
    reader.map(|batch| batch.map_err(|e| fail(e.to_string()))).collect()
}

/// The columns of one batch by name, in the types of the schema.
pub(super) struct Columns(BTreeMap<String, ArrayRef>);

impl Columns {
    /// Checks a batch against its schema; `only` limits the columns looked for (empty: all).
    pub(super) fn new(
        path: &Path,
        table: &str,
        batch: &RecordBatch,
        only: &[&str],
    ) -> Result<Self, Error> {
        let mut columns = BTreeMap::new();
        let unknown =
            || Error::Read { path: path.to_owned(), message: format!("no table {table}") };
        for column in registry::find(table).ok_or_else(unknown)?.table().columns.clone() {
            if !only.is_empty() && !only.contains(&column.name.as_str()) {
                continue;
            }
            let fail = |message: String| Error::Read { path: path.to_owned(), message };
            let wanted = column.arrow();
            match batch.column_by_name(&column.name) {
                Some(array) => {
                    let array = cast(array, wanted.data_type())
                        .map_err(|e| fail(format!("column `{}`: {e}", column.name)))?;
                    columns.insert(column.name, array);
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

    pub(super) fn str(&self, name: &str, i: usize) -> &str {
        self.valid(name, i).map_or("", |a| a.as_string::<i32>().value(i))
    }

    pub(super) fn text(&self, name: &str, i: usize) -> String {
        self.str(name, i).to_owned()
    }

    pub(super) fn maybe_text(&self, name: &str, i: usize) -> Option<String> {
        self.valid(name, i).map(|a| a.as_string::<i32>().value(i).to_owned())
    }

    /// A number; nulls and numbers that are not finite are `None`.
    pub(super) fn maybe(&self, name: &str, i: usize) -> Option<f64> {
        let array = self.valid(name, i)?;
        Some(array.as_primitive::<Float64Type>().value(i)).filter(|x| x.is_finite())
    }

    pub(super) fn number(&self, name: &str, i: usize) -> f64 {
        self.maybe(name, i).unwrap_or(f64::NAN)
    }

    fn maybe_integer(&self, name: &str, i: usize) -> Option<i64> {
        self.valid(name, i).map(|a| a.as_primitive::<Int64Type>().value(i))
    }

    pub(super) fn integer(&self, name: &str, i: usize) -> i64 {
        self.maybe_integer(name, i).unwrap_or(0)
    }

    pub(super) fn flag(&self, name: &str, i: usize) -> bool {
        self.valid(name, i).is_some_and(|a| a.as_boolean().value(i))
    }

    pub(super) fn ident(&self, i: usize) -> Ident {
        Ident {
            session_id: self.text("session_id", i),
            bike_id: self.text("bike_id", i),
            start_time: self.maybe_text("start_time", i),
        }
    }

    fn provenance(&self, i: usize) -> Provenance {
        Provenance {
            input_hash: self.text("input_hash", i),
            pipeline_hash: self.text("pipeline_hash", i),
            version: self.text("version", i),
        }
    }
}
