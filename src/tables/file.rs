//! Rows to Parquet: every table is written through its schema, whole or not at all.

use std::sync::Arc;

use arrow::array::RecordBatch;
use arrow::json::ReaderBuilder;
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::file::properties::WriterProperties;
use serde::Serialize;

use crate::contract::schema::Table;
use crate::objects::Location;
pub use crate::objects::files::TEMPORARY;

/// Why a table could not be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system or the object store refuses.
    #[error("cannot write {path}: {source}")]
    Io {
        /// The file.
        path: Location,
        /// Why.
        source: std::io::Error,
    },
    /// The rows do not fit the schema: our own mistake.
    #[error("table `{table}`: {message}")]
    Encode {
        /// The table.
        table: String,
        /// What does not fit.
        message: String,
    },
}

/// Rows as one Arrow batch of the table's schema.
///
/// # Errors
/// A row has a field that the schema lacks, or lacks one that it requires.
pub fn batch<R: Serialize>(table: &Table, rows: &[R]) -> Result<RecordBatch, Error> {
    let fail = |e: arrow::error::ArrowError| Error::Encode {
        table: table.name.clone(),
        message: e.to_string(),
    };
    let schema = table.arrow();
    let mut decoder = ReaderBuilder::new(Arc::clone(&schema))
        .with_batch_size(rows.len().max(1))
        .with_strict_mode(true)
        .build_decoder()
        .map_err(fail)?;
    decoder.serialize(rows).map_err(fail)?;
    let batch = decoder.flush().map_err(fail)?;
    Ok(batch.unwrap_or_else(|| RecordBatch::new_empty(schema)))
}

/// Writes one batch as a Parquet file: a temporary beside it, then renamed.
///
/// # Errors
/// The folder cannot be made or the file not be written.
pub fn write_batch(to: impl Into<Location>, batch: &RecordBatch) -> Result<(), Error> {
    let to = to.into();
    let bytes =
        encode(batch).map_err(|message| Error::Encode { table: to.to_string(), message })?;
    write_bytes(to, &bytes)
}

/// Rows as the bytes of one Parquet file of the table.
///
/// # Errors
/// As [`batch`].
pub fn to_bytes<R: Serialize>(table: &Table, rows: &[R]) -> Result<Vec<u8>, Error> {
    batch_to_bytes(&table.name, &batch(table, rows)?)
}

/// One batch as the bytes of a Parquet file; `table` is for messages.
///
/// # Errors
/// Parquet cannot hold it: our own mistake.
pub fn batch_to_bytes(table: &str, batch: &RecordBatch) -> Result<Vec<u8>, Error> {
    encode(batch).map_err(|message| Error::Encode { table: table.to_owned(), message })
}

/// Writes rows as one Parquet file of the table, whole or not at all.
///
/// # Errors
/// As [`batch`] and [`write_batch`].
pub fn write<R: Serialize>(
    to: impl Into<Location>,
    table: &Table,
    rows: &[R],
) -> Result<(), Error> {
    write_batch(to, &batch(table, rows)?)
}

/// Writes bytes as a file, whole or not at all ([`Location::write`]).
///
/// # Errors
/// The folder cannot be made or the file not be written.
pub fn write_bytes(to: impl Into<Location>, bytes: &[u8]) -> Result<(), Error> {
    let to = to.into();
    to.write(bytes).map_err(|source| Error::Io { path: to, source })
}

fn encode(batch: &RecordBatch) -> Result<Vec<u8>, String> {
    let level = ZstdLevel::try_new(3).map_err(|e| e.to_string())?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(level))
        .set_created_by(format!("roadbench {}", crate::VERSION))
        .build();
    let mut bytes = Vec::new();
    let mut writer = ArrowWriter::try_new(&mut bytes, batch.schema(), Some(properties))
        .map_err(|e| e.to_string())?;
    writer.write(batch).map_err(|e| e.to_string())?;
    writer.close().map_err(|e| e.to_string())?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::rows;

    fn ident() -> rows::Ident {
        rows::Ident { session_id: "s".into(), bike_id: "b".into(), start_time: None }
    }

    fn provenance() -> rows::Provenance {
        rows::Provenance {
            input_hash: "0".into(),
            pipeline_hash: "1".into(),
            version: crate::VERSION.into(),
        }
    }

    /// One row of each struct goes through its schema: names, kinds and nulls agree.
    #[test]
    fn every_row_struct_fits_its_schema() {
        fn fits<R: Serialize>(name: &str, row: &R) {
            let table = Table::embedded(name);
            let rows = std::slice::from_ref(row);
            let batch = batch(&table, rows).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(batch.num_rows(), 1);
            let json = serde_json::to_value(row).expect("json");
            let fields: Vec<&String> = json.as_object().expect("object").keys().collect();
            for column in &table.columns {
                assert!(fields.contains(&&column.name), "{name}: no field {}", column.name);
            }
        }
        fits(
            "coefficients",
            &rows::Coefficient {
                ident: ident(),
                tyre: "front".into(),
                coefficient: "mf_b".into(),
                symbol: "B".into(),
                value: Some(1.5),
                unit: "1".into(),
                std_error: None,
                ci95_low: None,
                ci95_high: None,
                dispersion: None,
                n_manoeuvres: 3,
                n_samples: 4,
                residual_scale: None,
                outlier_fraction: None,
                r_squared: None,
                status: rows::Status::PoorlyDetermined,
                reason: Some("brake harder".into()),
                provenance: provenance(),
            },
        );
        fits(
            "warnings",
            &rows::WarningRow {
                ident: ident(),
                stage: "ingest".into(),
                code: "gap".into(),
                channel: None,
                count: 1,
                time: Some(0.5),
                message: "m".into(),
            },
        );
        fits(
            "rejected",
            &rows::Rejected {
                path: "p".into(),
                session_id: None,
                bike_id: None,
                stage: "ingest".into(),
                code: "truncated".into(),
                message: "m".into(),
                input_hash: None,
                version: "v".into(),
            },
        );
        fits(
            "plots",
            &rows::PlotPoint {
                session_id: "s".into(),
                bike_id: "b".into(),
                plot: "p".into(),
                series: "data".into(),
                x: 0.0,
                y: None,
                y_low: None,
                y_high: None,
                weight: None,
                manoeuvre_id: Some(1),
                shade: None,
                n: None,
            },
        );
        fits(
            "manoeuvres",
            &rows::Manoeuvre {
                ident: ident(),
                manoeuvre_id: 0,
                kind: "coasting".into(),
                start: 0.0,
                end: 1.0,
                direction: None,
                quality: Some(1.0),
                used: true,
                reason: None,
                speed_start: None,
                speed_end: None,
                speed_mean: None,
                acceleration_x_mean: None,
                acceleration_x_peak: None,
                acceleration_y_peak: None,
                roll_peak: None,
                slip_front_peak: None,
                slip_rear_peak: None,
                ..rows::Manoeuvre::default()
            },
        );
        fits("forces", &rows::ForceRow::default());
        fits("causes", &rows::CauseRow::default());
        fits("discrepancies", &rows::DiscrepancyRow::default());
        fits("replays", &rows::ReplaySample::default());
        fits("truth_offroad", &rows::TruthOffroad::default());
        fits(
            "sessions",
            &rows::SessionRow {
                ident: ident(),
                path: "p".into(),
                duration: 1.0,
                rate: 100.0,
                n_samples: 100,
                distance: None,
                channels: "roll".into(),
                n_manoeuvres: 0,
                n_used: 0,
                n_coefficients_ok: 0,
                n_warnings: 0,
                tyre_front: None,
                tyre_rear: None,
                site: None,
                rider_id: None,
                provenance: provenance(),
            },
        );
    }

    #[test]
    fn unit_and_description_survive_in_the_file() {
        use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("deep/er/sessions.parquet");
        write::<rows::SessionRow>(&path, &Table::embedded("sessions"), &[]).expect("written");
        let file = std::fs::File::open(&path).expect("open");
        let reader = ParquetRecordBatchReaderBuilder::try_new(file).expect("parquet");
        let field = reader.schema().field_with_name("duration").expect("field").clone();
        assert_eq!(field.metadata().get("unit").map(String::as_str), Some("s"));
        assert!(field.metadata().contains_key("description"));
        let left = std::fs::read_dir(path.parent().expect("parent")).expect("list").count();
        assert_eq!(left, 1, "no temporary stays");
    }

    #[test]
    fn a_path_under_a_file_is_an_error_that_names_it() {
        let file = tempfile::NamedTempFile::new().expect("file");
        let path = file.path().join("x/y.parquet");
        let e = write_bytes(&path, b"z").expect_err("no folder below a file");
        assert!(e.to_string().contains("y.parquet"), "{e}");
    }
}
