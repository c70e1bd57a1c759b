//! A session as a `session.v1` Parquet file.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use ::parquet::arrow::ArrowWriter;
use ::parquet::basic::{Compression, Encoding, ZstdLevel};
use ::parquet::file::metadata::KeyValue;
use ::parquet::file::properties::{EnabledStatistics, WriterProperties};
use ::parquet::schema::types::ColumnPath;
use arrow::array::{ArrayRef, Float32Array, Float64Array, RecordBatch};
use arrow::buffer::NullBuffer;
use arrow::datatypes::{DataType, Schema};

use crate::schema::Table;
use crate::session::{Meta, Session};
use crate::table;

/// Columns with at most so many different values are coded by a dictionary; the others by
/// splitting their bytes into streams, which is what makes floats compress.
const DICTIONARY: usize = 4096;

/// Writes a session as one Parquet file, whole or not at all: units and descriptions with
/// every field, who and when in the file's key-value metadata, NaN as null.
///
/// `float32` halves the samples (7 digits); time stays float64.
///
/// # Errors
/// The folder cannot be made or the file not be written.
pub fn write_session(path: &Path, session: &Session, float32: bool) -> Result<(), table::Error> {
    let bytes = encode(session, float32)
        .map_err(|message| table::Error::Encode { table: path.display().to_string(), message })?;
    table::write_bytes(path, &bytes)
}

fn encode(session: &Session, float32: bool) -> Result<Vec<u8>, String> {
    let table = Table::embedded("session");
    let full = table.arrow();
    let time: Vec<f64> = (0..session.len).map(|i| session.time(i)).collect();
    let mut fields = vec![full.field(0).clone()];
    let mut arrays: Vec<ArrayRef> = vec![Arc::new(Float64Array::from(time))];
    let level = ZstdLevel::try_new(6).map_err(|e| e.to_string())?;
    let mut properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(level))
        .set_created_by(format!("roadbench {}", crate::VERSION))
        .set_key_value_metadata(Some(pairs(&session.meta)))
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_dictionary_enabled(false)
        .set_encoding(Encoding::BYTE_STREAM_SPLIT)
        .set_max_row_group_row_count(None);
    for channel in session.channels() {
        let (Some(values), Some(column)) = (session.get(channel), table.column(channel.name()))
        else {
            continue;
        };
        let mut field = column.arrow();
        if few_values(values, float32) {
            let path = ColumnPath::from(channel.name());
            properties = properties.set_column_dictionary_enabled(path, true);
        }
        let nulls = values
            .iter()
            .any(|v| v.is_nan())
            .then(|| values.iter().map(|v| !v.is_nan()).collect::<NullBuffer>());
        if float32 {
            field = field.with_data_type(DataType::Float32);
            let narrow = values.iter().map(|&v| v as f32).collect::<Vec<f32>>();
            arrays.push(Arc::new(Float32Array::new(narrow.into(), nulls)));
        } else {
            arrays.push(Arc::new(Float64Array::new(values.to_vec().into(), nulls)));
        }
        fields.push(field);
    }
    let schema = Arc::new(Schema::new_with_metadata(fields, full.metadata().clone()));
    let batch = RecordBatch::try_new(Arc::clone(&schema), arrays).map_err(|e| e.to_string())?;
    let mut bytes = Vec::new();
    let mut writer = ArrowWriter::try_new(&mut bytes, schema, Some(properties.build()))
        .map_err(|e| e.to_string())?;
    writer.write(&batch).map_err(|e| e.to_string())?;
    writer.close().map_err(|e| e.to_string())?;
    Ok(bytes)
}

/// Whether a column is worth a dictionary.
fn few_values(values: &[f64], float32: bool) -> bool {
    let mut seen = HashSet::new();
    let limit = DICTIONARY.min(values.len() / 8);
    for &v in values {
        seen.insert(if float32 { u64::from((v as f32).to_bits()) } else { v.to_bits() });
        if seen.len() > limit {
            return false;
        }
    }
    true
}

fn pairs(meta: &Meta) -> Vec<KeyValue> {
    let required = [("session_id", &meta.session_id), ("bike_id", &meta.bike_id)];
    let optional = [
        ("start_time", &meta.start_time),
        ("tyre_front", &meta.tyre_front),
        ("tyre_rear", &meta.tyre_rear),
        ("site", &meta.site),
        ("rider_id", &meta.rider_id),
    ];
    let pair = |key: &str, value: &str| KeyValue::new(key.to_owned(), value.to_owned());
    required
        .into_iter()
        .filter(|(_, v)| !v.is_empty())
        .map(|(k, v)| pair(k, v))
        .chain(optional.into_iter().filter_map(|(k, v)| v.as_deref().map(|v| pair(k, v))))
        .collect()
}
