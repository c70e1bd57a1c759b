//! A session as a `session.v1` Parquet file.

use crate::contract::schema;
use std::sync::Arc;

use ::parquet::arrow::ArrowWriter;
use ::parquet::arrow::arrow_writer::{ArrowColumnWriter, compute_leaves};
use ::parquet::basic::{Compression, Encoding, ZstdLevel};
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::KeyValue;
use ::parquet::file::properties::{EnabledStatistics, WriterProperties};
use arrow::array::{ArrayRef, Float32Array, Float64Array, RecordBatch};
use arrow::buffer::NullBuffer;
use arrow::datatypes::{DataType, Schema};
use rayon::prelude::*;

use crate::contract::session::Session;
use crate::ingest::session_schema::{VELOCITY_SPACING, WHEEL_SCALE_SD, marker_pairs};
use crate::store::objects::Location;
use crate::store::tables::file;
use crate::store::tables::mismatch::Mismatch;

/// Writes a session as one Parquet file, whole or not at all: units and descriptions with
/// every field, who and when in the file's key-value metadata, NaN as null.
///
/// `float32` halves the samples (7 digits); time stays float64.
///
/// # Errors
/// The folder cannot be made or the file not be written.
pub fn write_session(
    to: impl Into<Location>,
    session: &Session,
    float32: bool,
) -> Result<(), file::Error> {
    file::write_bytes(to, &session_bytes(session, float32)?)
}

/// A session as the bytes of one Parquet file, as [`write_session`] writes it.
///
/// # Errors
/// The channels do not fit together: our own mistake.
pub fn session_bytes(session: &Session, float32: bool) -> Result<Vec<u8>, file::Error> {
    encode(session, float32)
        .map_err(|source| file::Error::Encode { table: "session".to_owned(), source })
}

/// A session as one Arrow batch of `session.v1`, as [`write_session`] writes it; who and when in
/// the schema's metadata.
///
/// # Errors
/// The channels do not fit together: our own mistake.
pub fn session_batch(session: &Session, float32: bool) -> Result<RecordBatch, file::Error> {
    let fail = |source: Mismatch| file::Error::Encode { table: "session".to_owned(), source };
    let batch = to_batch(session, float32).map_err(fail)?;
    let mut metadata = batch.schema().metadata().clone();
    metadata.extend(pairs(session).into_iter().filter_map(|p| Some((p.key, p.value?))));
    let schema = Arc::new(Schema::new_with_metadata(batch.schema().fields().clone(), metadata));
    batch.with_schema(schema).map_err(|e| fail(e.to_string().into()))
}

fn to_batch(session: &Session, float32: bool) -> Result<RecordBatch, Mismatch> {
    let table = schema::session();
    let full = table.arrow();
    let time: Vec<f64> = (0..session.len).map(|i| session.time(i)).collect();
    let mut fields = vec![full.field(0).clone()];
    let mut arrays: Vec<ArrayRef> = vec![Arc::new(Float64Array::from(time))];
    for channel in session.channels() {
        let (Some(values), Some(column)) = (session.get(channel), table.column(channel.name()))
        else {
            continue;
        };
        let mut field = column.arrow();
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
    RecordBatch::try_new(schema, arrays).map_err(|e| Mismatch::from(e.to_string()))
}

fn encode(session: &Session, float32: bool) -> Result<Vec<u8>, Mismatch> {
    let batch = to_batch(session, float32)?;
    // of a ride's noise a higher level makes no more, only slower
    let level = ZstdLevel::try_new(3).map_err(|e| Mismatch::from(e.to_string()))?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(level))
        .set_created_by(format!("roadbench {}", crate::VERSION))
        .set_key_value_metadata(Some(pairs(session)))
        .set_statistics_enabled(EnabledStatistics::Chunk)
        // the bytes of floats compress as streams of their own, better than by a dictionary even
        // where a sensor has few values
        .set_dictionary_enabled(false)
        .set_encoding(Encoding::BYTE_STREAM_SPLIT)
        .set_max_row_group_row_count(None);
    let mut bytes = Vec::new();
    write(&mut bytes, &batch, properties.build()).map_err(|e| Mismatch::from(e.to_string()))?;
    Ok(bytes)
}

/// The batch as one row group, its columns encoded side by side.
fn write(
    bytes: &mut Vec<u8>,
    batch: &RecordBatch,
    properties: WriterProperties,
) -> Result<(), ParquetError> {
    let writer = ArrowWriter::try_new(bytes, batch.schema(), Some(properties))?;
    let (mut writer, factory) = writer.into_serialized_writer()?;
    let encode = |(i, mut column): (usize, ArrowColumnWriter)| {
        for leaf in compute_leaves(batch.schema().field(i), batch.column(i))? {
            column.write(&leaf)?;
        }
        column.close()
    };
    let columns = factory.create_column_writers(0)?;
    let encoded: Vec<_> = columns.into_par_iter().enumerate().map(encode).collect();
    let mut group = writer.next_row_group()?;
    for column in encoded {
        column?.append_to_row_group(&mut group)?;
    }
    group.close()?;
    writer.close()?;
    Ok(())
}

fn pairs(session: &Session) -> Vec<KeyValue> {
    let meta = &session.meta;
    let scale = session.wheel_scale_sd.iter().any(|sd| *sd > 0.0);
    let scale = scale.then(|| session.wheel_scale_sd.map(|sd| sd.to_string()).join(" "));
    let spacing = session.velocity_spacing;
    let spacing = session.velocity_is_interpolated().then(|| spacing.to_string());
    let required = [("session_id", &meta.session_id), ("bike_id", &meta.bike_id)];
    let optional = [
        ("start_time", &meta.start_time),
        ("tyre_front", &meta.tyre_front),
        ("tyre_rear", &meta.tyre_rear),
        ("site", &meta.site),
        ("rider_id", &meta.rider_id),
        (WHEEL_SCALE_SD, &scale),
        (VELOCITY_SPACING, &spacing),
    ];
    let of_laps = marker_pairs(&session.markers);
    let pair = |key: &str, value: &str| KeyValue::new(key.to_owned(), value.to_owned());
    required
        .into_iter()
        .filter(|(_, v)| !v.is_empty())
        .map(|(k, v)| pair(k, v))
        .chain(optional.into_iter().filter_map(|(k, v)| v.as_deref().map(|v| pair(k, v))))
        .chain(of_laps.iter().filter_map(|(k, v)| v.as_deref().map(|v| pair(k, v))))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::channel::Channel;
    use crate::contract::session::Meta;
    use crate::ingest::session_schema::{markers, velocity_spacing, wheel_scale_sd};
    use ::parquet::file::reader::{FileReader, SerializedFileReader};

    /// Ten minutes of fourteen channels with 12 bits of sensor noise each.
    #[test]
    fn a_ride_is_small_and_says_what_it_holds() {
        let meta = Meta { session_id: "s".into(), bike_id: "b".into(), ..Meta::default() };
        let n = 60_000;
        let mut session = Session::new(meta, 100.0, n);
        let mut state = 1_u32;
        for &channel in &Channel::ALL[..14] {
            let mut value = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(state >> 28)
            };
            let wave = |i: usize| (1000.0 * (i as f64 / 700.0).sin()).round();
            session.set(channel, (0..n).map(|i| (wave(i) + value()) / 1024.0).collect());
        }
        session.wheel_scale_sd = [0.02, 0.0];
        session.velocity_spacing = 1.0;
        session.markers.times = vec![12.345, 99.5];
        session.markers.line = Some([[48.1, -0.2], [48.2, 1e-7]]);
        let bytes = encode(&session, true).expect("encoded");
        // 4 random bits a sample cannot be compressed: 0.42 MB of the 3.36 MB raw
        assert!(bytes.len() < 1_100_000, "{}", bytes.len());
        let mut file = tempfile::tempfile().expect("a file");
        std::io::Write::write_all(&mut file, &bytes).expect("written");
        let file = SerializedFileReader::new(file).expect("Parquet");
        let pairs = file.metadata().file_metadata().key_value_metadata().expect("pairs");
        let of = |key: &str| pairs.iter().find(|p| p.key == key).and_then(|p| p.value.clone());
        assert_eq!(of("session_id").as_deref(), Some("s"));
        // a converted log still says how well its wheels' radii are known
        assert_eq!(wheel_scale_sd(of), [0.02, 0.0]);
        assert_eq!(velocity_spacing(of), 1.0);
        assert_eq!(velocity_spacing(|_| Some("-inf".into())), 0.0);
        assert_eq!(markers(of), session.markers);
        let damaged = markers(|_| Some("1 x nan 2".into()));
        assert_eq!((damaged.times, damaged.line), (vec![1.0, 2.0], None));
        assert_eq!(wheel_scale_sd(|_| Some("nan -1".into())), [0.0, 0.0]);
    }
}
