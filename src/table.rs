//! Rows to Parquet: every table is written through its schema, whole or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow::array::RecordBatch;
use arrow::json::ReaderBuilder;
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::file::properties::WriterProperties;
use serde::Serialize;

use crate::schema::Table;

/// Why a table could not be written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system said no.
    #[error("cannot write {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
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
pub fn write_batch(path: &Path, batch: &RecordBatch) -> Result<(), Error> {
    let bytes = encode(batch)
        .map_err(|message| Error::Encode { table: path.display().to_string(), message })?;
    write_bytes(path, &bytes)
}

/// Writes rows as one Parquet file of the table, whole or not at all.
///
/// # Errors
/// As [`batch`] and [`write_batch`].
pub fn write<R: Serialize>(path: &Path, table: &Table, rows: &[R]) -> Result<(), Error> {
    write_batch(path, &batch(table, rows)?)
}

/// Writes bytes as a file, whole or not at all, making its folder.
///
/// # Errors
/// The folder cannot be made or the file not be written.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let io = |source| Error::Io { path: path.to_owned(), source };
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(io)?;
    let mut file = tempfile::Builder::new()
        .prefix(".roadbench-")
        .suffix(".tmp")
        .tempfile_in(folder)
        .map_err(io)?;
    file.write_all(bytes).map_err(io)?;
    file.as_file().sync_all().map_err(io)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = std::fs::Permissions::from_mode(0o644);
        file.as_file().set_permissions(mode).map_err(io)?;
    }
    file.persist(path).map_err(|e| io(e.error))?;
    Ok(())
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
