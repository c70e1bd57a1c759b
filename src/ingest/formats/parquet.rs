//! Parquet: `session.v1` as it is, or any other table with a clock through a channel map.
//!
//! Only the columns that mean something are decoded, each in one piece; a float64 column's
//! buffer becomes the track's without a copy.

use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use ::parquet::arrow::ProjectionMask;
use ::parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReaderBuilder,
};
use ::parquet::basic::Compression;
use ::parquet::file::metadata::ParquetMetaData;
use arrow::array::{Array, ArrayRef, AsArray};
use arrow::compute::cast;
use arrow::datatypes::{DataType, Field, Float32Type, Float64Type, Schema, TimeUnit};

use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::contract::schema;
use crate::contract::session::Meta;
use crate::ingest::error::Error;
use crate::ingest::formats::format::{Head, LogFormat};
use crate::ingest::ident;
use crate::ingest::maps::units;
use crate::ingest::maps::units::Conversion;
use crate::ingest::maps::{ChannelMap, Maps, TimeSource};
use crate::ingest::raw::{Column, Identified, Raw, Track};
use crate::ingest::session_schema::with_metadata;
use crate::ingest::warning::warning;
use crate::store::objects::Location;
use crate::store::objects::source;
use crate::store::objects::source::Source;

pub(crate) const FORMAT: LogFormat = LogFormat {
    name: "parquet",
    description: "session.v1, and other tables with a clock",
    channel_names: "column",
    extensions: &["parquet"],
    maps: &[],
    own_clock: false,
    sniff,
    identify,
    read,
    map,
    decoder: None,
};

const MAGIC: &[u8] = b"PAR1";

/// Bytes of a log in an object store that are fetched first, from its end: the footer is in it, mostly.
const TAIL: u64 = 64 << 10;

/// Most rows of one session: five hours at 1 kHz.
const MAX_ROWS: i64 = 20_000_000;

fn sniff(head: &Head<'_>) -> bool {
    head.bytes.starts_with(MAGIC) || head.has_extension("parquet")
}

fn identify(log: &Location, maps: Maps<'_>) -> Result<Identified, Error> {
    let (_, metadata) = open(log)?;
    let map = choose(&names_of(&metadata), maps).map(|map| map.name);
    Ok(Identified { meta: meta_of(log, metadata.metadata()), map })
}

fn map(log: &Location, maps: Maps<'_>) -> Result<Option<ChannelMap>, Error> {
    let (_, metadata) = open(log)?;
    Ok(choose(&names_of(&metadata), maps))
}

fn names_of(metadata: &ArrowReaderMetadata) -> Vec<String> {
    metadata.schema().fields().iter().map(|f| f.name().to_owned()).collect()
}

/// The map for a table with these columns, if it is not the contract's.
fn choose(names: &[String], maps: Maps<'_>) -> Option<ChannelMap> {
    maps.of_format("parquet").into_iter().find(|m| m.detects(names)).map(|m| m.fitted(names))
}

fn read(log: &Location, maps: Maps<'_>) -> Result<Raw, Error> {
    let (file, metadata) = open(log)?;
    let meta = meta_of(log, metadata.metadata());
    let names = names_of(&metadata);
    match choose(&names, maps) {
        Some(map) => read_mapped(log, file, metadata, &names, meta, &map),
        None => {
            let schema = Arc::clone(metadata.schema());
            let pairs = metadata.metadata().file_metadata().key_value_metadata().cloned();
            let own = |key: &str| pairs.as_ref()?.iter().find(|p| p.key == key)?.value.clone();
            let raw =
                read_contract(log, &schema, meta, |wanted| decode(log, file, metadata, wanted))?;
            Ok(with_metadata(raw, own))
        }
    }
}

/// The contract's own columns; `decode` gives those at the given places as float64.
pub(crate) fn read_contract(
    log: &Location,
    schema: &Schema,
    meta: Meta,
    decode: impl FnOnce(&[usize]) -> Result<Vec<Vec<f64>>, Error>,
) -> Result<Raw, Error> {
    let table = schema::session();
    let mut wanted = Vec::new();
    let mut plans: Vec<(Option<Channel>, Conversion)> = Vec::new();
    let mut unknown = Vec::new();
    for (i, field) in schema.fields().iter().enumerate() {
        let Some(column) = table.column(field.name()) else {
            unknown.push(field.name().as_str());
            continue;
        };
        wanted.push(i);
        let unit = column.unit.as_deref().unwrap_or("1");
        plans.push((Channel::from_name(field.name()), field_conversion(log, field, unit)?));
    }
    if !plans.iter().any(|(channel, _)| channel.is_none()) {
        return Err(no_time(log, "time", &unknown));
    }
    let mut warnings = Vec::new();
    if !unknown.is_empty() {
        let message = format!("not columns of session.v1, ignored: {}", unknown.join(", "));
        warnings.push(warning("unknown_column", None, unknown.len(), None, message));
    }
    let decoded = decode(&wanted)?;
    let mut time = Vec::new();
    let mut channels = Vec::with_capacity(decoded.len());
    for ((channel, conversion), mut values) in plans.into_iter().zip(decoded) {
        if !conversion.is_identity() {
            let Conversion { factor, offset } = conversion;
            values.iter_mut().for_each(|x| *x = *x * factor + offset);
        }
        match channel {
            None => time = values,
            Some(channel) => channels.push((channel, values)),
        }
    }
    let time = Arc::new(time);
    let tracks = channels
        .into_iter()
        .map(|(channel, values)| Track { channel, time: Arc::clone(&time), values })
        .collect();
    Ok(Raw { meta, tracks, warnings, ..Raw::default() })
}

/// Another table's columns through a map.
fn read_mapped(
    log: &Location,
    file: Source,
    metadata: ArrowReaderMetadata,
    names: &[String],
    meta: Meta,
    map: &ChannelMap,
) -> Result<Raw, Error> {
    let needed = map.needed();
    let mut wanted = needed
        .iter()
        .map(|name| names.iter().position(|n| n == name).ok_or_else(|| map.missing(name, names)))
        .collect::<Result<Vec<usize>, Error>>()?;
    wanted.sort_unstable();
    let mut decoded = decode(log, file, metadata, &wanted)?;
    let time = match &map.time {
        TimeSource::Column { name, factor, .. } => {
            let at = wanted.iter().position(|&i| &names[i] == name);
            let at = at.ok_or_else(|| map.missing(name, names))?;
            wanted.remove(at);
            let mut stamps = decoded.remove(at);
            stamps.iter_mut().for_each(|t| *t *= factor);
            stamps
        }
        TimeSource::Rate(rate) => {
            (0..decoded.first().map_or(0, Vec::len)).map(|i| i as f64 / rate).collect()
        }
        TimeSource::Own => return Err(no_time(log, "time", &[])),
    };
    let time = Arc::new(time);
    let columns: Vec<Column> = wanted
        .iter()
        .zip(decoded)
        .map(|(&i, values)| Column { name: names[i].clone(), time: Arc::clone(&time), values })
        .collect();
    Ok(Raw {
        meta: ident::or(meta, map.meta.clone()),
        tracks: map.apply(columns)?,
        warnings: Vec::new(),
        euler_yaw: map.euler_yaw,
        wheel_scale_sd: map.wheel_scale_sd(),
        imu: map.imu,
        map: Some(map.name.clone()),
        ..Raw::default()
    })
}

fn no_time(log: &Location, name: &str, columns: &[&str]) -> Error {
    let near = schema::closest(name, columns.iter().copied())
        .map(|near| format!("; is it `{near}`?"))
        .unwrap_or_default();
    Error::new(
        RejectionCode::MissingColumn,
        format!("{log}: column `{name}` (s since the start) is missing{near}"),
    )
}

/// How a column becomes SI, from the unit in its own metadata; without one it is SI.
fn field_conversion(log: &Location, field: &Field, unit: &str) -> Result<Conversion, Error> {
    let stamp = match field.data_type() {
        DataType::Timestamp(TimeUnit::Second, _) => Some("s"),
        DataType::Timestamp(TimeUnit::Millisecond, _) => Some("ms"),
        DataType::Timestamp(TimeUnit::Microsecond, _) => Some("us"),
        DataType::Timestamp(TimeUnit::Nanosecond, _) => Some("ns"),
        _ => None,
    };
    let Some(own) = stamp.or(field.metadata().get("unit").map(String::as_str)) else {
        return Ok(Conversion::IDENTITY);
    };
    units::conversion(own, unit).map_err(|e| {
        Error::new(RejectionCode::UnknownUnit, format!("{log}: column `{}`: {e}", field.name()))
    })
}

/// The footer, after its claims have been checked against the file's size.
fn open(log: &Location) -> Result<(Source, ArrowReaderMetadata), Error> {
    let fail = |e: std::io::Error| Error::unreadable(log, &e);
    let mut file = source::open(log).map_err(fail)?;
    let size = file.size().map_err(fail)?;
    file.prepare(&[0..4, size.saturating_sub(TAIL)..size]).map_err(fail)?;
    let mut head = [0; 4];
    let mut tail = [0; 8];
    if size < 12 || file.read_exact(&mut head).is_err() || head != MAGIC {
        let what = if size < 12 { "is too short to be" } else { "does not begin as" };
        return Err(Error::new(RejectionCode::NotParquet, format!("{log} {what} Parquet")));
    }
    file.seek(SeekFrom::End(-8)).and_then(|_| file.read_exact(&mut tail)).map_err(fail)?;
    if &tail[4..] != MAGIC {
        let message = format!(
            "{} does not end as Parquet: it was cut off while being written or copied; copy it \
             again",
            log
        );
        return Err(Error::new(RejectionCode::Truncated, message));
    }
    let footer = u64::from(u32::from_le_bytes([tail[0], tail[1], tail[2], tail[3]]));
    if footer > size - 12 {
        return Err(bad_claim(log, &format!("claims {footer} bytes of footer"), size));
    }
    file.prepare(std::slice::from_ref(&(size - 8 - footer..size))).map_err(fail)?;
    file.rewind().map_err(fail)?;
    let metadata = guarded(log, || {
        ArrowReaderMetadata::load(&file, ArrowReaderOptions::new()).map_err(|e| e.to_string())
    })?;
    check_claims(log, metadata.metadata(), size)?;
    Ok((file, metadata))
}

fn check_claims(log: &Location, metadata: &ParquetMetaData, size: u64) -> Result<(), Error> {
    let rows = metadata.file_metadata().num_rows();
    let of_groups = metadata
        .row_groups()
        .iter()
        .try_fold(0_i64, |sum, g| sum.checked_add(g.num_rows()).filter(|_| g.num_rows() >= 0));
    if of_groups != Some(rows) {
        return Err(bad_claim(log, &format!("claims {rows} rows, its parts do not"), size));
    }
    if rows > MAX_ROWS {
        let message = format!(
            "{} claims {rows} rows, more than {MAX_ROWS} for one session; split the log",
            log
        );
        return Err(Error::new(RejectionCode::FileTooLarge, message));
    }
    for group in metadata.row_groups() {
        for chunk in group.columns() {
            let (start, length) = chunk.byte_range_checked(size);
            let unpacked = chunk.uncompressed_size();
            // no encoding of ours or others' spends more than a few bytes per value
            let limit = 64 * rows.max(0) + (1 << 20);
            if start.checked_add(length).is_none_or(|end| end > size)
                || !(0..=limit.max(1 << 26)).contains(&unpacked)
            {
                let name = chunk.column_path().string();
                let claim = format!("claims {length} bytes ({unpacked} unpacked) for `{name}`");
                return Err(bad_claim(log, &claim, size));
            }
        }
    }
    Ok(())
}

/// The chunk's bytes as `(start, length)`, without the panics of `byte_range`.
trait ByteRange {
    fn byte_range_checked(&self, size: u64) -> (u64, u64);
}

impl ByteRange for ::parquet::file::metadata::ColumnChunkMetaData {
    fn byte_range_checked(&self, size: u64) -> (u64, u64) {
        let start = self.dictionary_page_offset().unwrap_or(self.data_page_offset());
        let outside = size.saturating_add(1);
        let start = u64::try_from(start).unwrap_or(outside);
        (start, u64::try_from(self.compressed_size()).unwrap_or(outside))
    }
}

fn bad_claim(log: &Location, claim: &str, size: u64) -> Error {
    let message =
        format!("{} {claim} but the file has {size} bytes: it is damaged; copy it again", log);
    Error::new(RejectionCode::Truncated, message)
}

/// Damaged files can make the decoder panic; that is an unreadable file, not our end.
fn guarded<T>(log: &Location, work: impl FnOnce() -> Result<T, String>) -> Result<T, Error> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(done)) => Ok(done),
        Ok(Err(message)) => {
            Err(Error::new(RejectionCode::Damaged, format!("{log} is damaged: {message}")))
        }
        Err(_) => {
            let message = format!("{log} is damaged: its pages cannot be decoded");
            Err(Error::new(RejectionCode::Damaged, message))
        }
    }
}

/// The wanted top-level columns (ascending) as float64, NaN for null.
fn decode(
    log: &Location,
    file: Source,
    metadata: ArrowReaderMetadata,
    wanted: &[usize],
) -> Result<Vec<Vec<f64>>, Error> {
    let rows = usize::try_from(metadata.metadata().file_metadata().num_rows()).unwrap_or(0);
    check_kinds(log, metadata.schema(), wanted)?;
    check_packing(log, metadata.metadata(), wanted)?;
    file.prepare(&chunks(metadata.metadata(), wanted)).map_err(|e| Error::unreadable(log, &e))?;
    guarded(log, || {
        let mask = ProjectionMask::roots(metadata.parquet_schema(), wanted.iter().copied());
        let reader = ParquetRecordBatchReaderBuilder::new_with_metadata(file, metadata)
            .with_projection(mask)
            .with_batch_size(rows.max(1))
            .build()
            .map_err(|e| e.to_string())?;
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); wanted.len()];
        for batch in reader {
            let (_, arrays, _) = batch.map_err(|e| e.to_string())?.into_parts();
            for (column, array) in columns.iter_mut().zip(arrays) {
                append(column, array)?;
            }
        }
        Ok(columns)
    })
}

/// The wanted columns hold numbers.
pub(crate) fn check_kinds(log: &Location, schema: &Schema, wanted: &[usize]) -> Result<(), Error> {
    for &i in wanted {
        let field = schema.field(i);
        let kind = field.data_type();
        if !(kind.is_numeric() || matches!(kind, DataType::Boolean | DataType::Timestamp(..))) {
            let message = format!("{log}: column `{}` holds {kind}, not numbers", field.name());
            return Err(Error::new(RejectionCode::WrongType, message));
        }
    }
    Ok(())
}

/// The wanted columns are packed in a way that is read.
fn check_packing(
    log: &Location,
    metadata: &ParquetMetaData,
    wanted: &[usize],
) -> Result<(), Error> {
    let schema = metadata.file_metadata().schema_descr();
    for (leaf, chunk) in metadata.row_groups().iter().flat_map(|g| g.columns().iter().enumerate()) {
        use Compression::{GZIP, SNAPPY, UNCOMPRESSED, ZSTD};
        let packing = chunk.compression();
        let is_read = matches!(packing, UNCOMPRESSED | SNAPPY | ZSTD(_) | GZIP(_));
        if !is_read && wanted.contains(&schema.get_column_root_idx(leaf)) {
            let name = packing.to_string();
            let name = name.split('(').next().unwrap_or_default();
            let message = format!(
                "{log}: column `{}` is compressed by {name}, which is not read; write the file anew with zstd, snappy or gzip, as \
                 with pyarrow: `pq.write_table(pq.read_table(OLD), NEW, compression=\"zstd\")`",
                chunk.column_path().string()
            );
            return Err(Error::new(RejectionCode::UnknownCompression, message));
        }
    }
    Ok(())
}

/// Where the wanted top-level columns are in the file.
fn chunks(metadata: &ParquetMetaData, wanted: &[usize]) -> Vec<Range<u64>> {
    let schema = metadata.file_metadata().schema_descr();
    let groups = metadata.row_groups().iter().flat_map(|g| g.columns().iter().enumerate());
    groups
        .filter(|(leaf, _)| wanted.contains(&schema.get_column_root_idx(*leaf)))
        .map(|(_, chunk)| {
            let (start, length) = chunk.byte_range_checked(u64::MAX - 1);
            start..start.saturating_add(length)
        })
        .collect()
}

/// Adds an array's numbers to a column, moving its buffer where that is possible.
pub(crate) fn append(column: &mut Vec<f64>, array: ArrayRef) -> Result<(), String> {
    let start = column.len();
    let nulls = array.logical_nulls().filter(|n| n.null_count() > 0);
    match array.data_type() {
        DataType::Float64 => {
            let (_, values, _) = array.as_primitive::<Float64Type>().clone().into_parts();
            drop(array);
            if start == 0 {
                let owned = values.into_inner().into_vec::<f64>();
                *column = owned.unwrap_or_else(|shared| shared.typed_data::<f64>().to_vec());
            } else {
                column.extend_from_slice(&values);
            }
        }
        DataType::Float32 => {
            let values = array.as_primitive::<Float32Type>().values();
            column.extend(values.iter().map(|&x| f64::from(x)));
        }
        kind => {
            let wide = match kind {
                DataType::Timestamp(..) => cast(&array, &DataType::Int64),
                _ => Ok(array),
            };
            let wide =
                wide.and_then(|a| cast(&a, &DataType::Float64)).map_err(|e| e.to_string())?;
            column.extend_from_slice(wide.as_primitive::<Float64Type>().values());
        }
    }
    if let Some(nulls) = nulls {
        for (value, present) in column[start..].iter_mut().zip(nulls.iter()) {
            if !present {
                *value = f64::NAN;
            }
        }
    }
    Ok(())
}

fn meta_of(log: &Location, metadata: &ParquetMetaData) -> Meta {
    let pairs = metadata.file_metadata().key_value_metadata();
    let own = meta_from(|key| pairs?.iter().find(|p| p.key == key)?.value.clone());
    ident::or(own, ident::from_path(log))
}

/// Session metadata by key.
pub(crate) fn meta_from(get: impl Fn(&str) -> Option<String>) -> Meta {
    let get = |key: &str| get(key).filter(|v| !v.is_empty());
    Meta {
        session_id: get("session_id").unwrap_or_default(),
        bike_id: get("bike_id").unwrap_or_default(),
        start_time: get("start_time"),
        tyre_front: get("tyre_front"),
        tyre_rear: get("tyre_rear"),
        site: get("site"),
        rider_id: get("rider_id"),
    }
}
