//! The samples of a group whose records are all laid out alike, column by column.
//!
//! Its blocks are unpacked and decoded side by side. Of each record only the fields of the wanted
//! channels are touched, and a transposed block need not be turned back for that. What is laid
//! out otherwise (records of several groups in turn, text, big-endian numbers) the library reads.

use std::ops::Range;

use falcon_mdf::blocks::common::BLOCK_HEADER_SIZE;
use falcon_mdf::{Channel, ChannelGroup, DataGroup, Mf4Error};
use rayon::prelude::*;

use super::field::{Field, Layout};
use super::file::Bytes;
use super::unpack::{Method, Unpacker};

/// Plain bytes that are decoded at a time: few enough to stay in the processor's cache.
const PIECE: u64 = 256 << 10;

/// A log that claims to be so many times as long as its file may be damaged: room for all of it
/// is not made before it is read.
const MOST_UNPACKED: u64 = 64;

/// The samples of some channels.
pub(super) struct Columns {
    /// One per channel, equally long.
    pub columns: Vec<Vec<f64>>,
    /// Error that ended them too early.
    pub broken: Option<Mf4Error>,
}

/// Bytes of a group's stream of records that are read at a time.
struct Piece {
    /// Where they begin in the stream.
    start: u64,
    /// Bytes in the stream.
    len: u64,
    /// Where they are in the file.
    at: u64,
    packed: Option<Packed>,
}

/// How a block is packed.
struct Packed {
    size: u64,
    method: Method,
    /// Length of the rows that were turned into columns, if they were.
    transposed: Option<usize>,
}

/// A piece and the places of its samples, channel by channel.
struct Task<'a> {
    piece: &'a Piece,
    out: Vec<&'a mut [f64]>,
}

/// Memory that a thread uses for one piece after the other.
#[derive(Default)]
struct Workplace {
    raw: Vec<u8>,
    unpacker: Unpacker,
}

/// The parts of records at a piece's ends whose other parts are in its neighbours.
#[derive(Default)]
struct Ends {
    head: Vec<u8>,
    tail: Vec<u8>,
}

/// The channels' samples; `None` if the group or one of them is for the library to read.
pub(super) fn read(
    bytes: &dyn Bytes,
    data: &DataGroup,
    group: &ChannelGroup,
    channels: &[&Channel],
) -> Option<Columns> {
    let record = group.record_size(data.rec_id_size());
    if data.is_unsorted() || data.channel_groups.len() != 1 || record == 0 {
        return None;
    }
    let id = usize::from(data.rec_id_size());
    let fields: Vec<Field<'_>> =
        channels.iter().map(|c| Field::of(c, group, id)).collect::<Option<_>>()?;
    let most = bytes.len().saturating_mul(MOST_UNPACKED);
    let pieces = pieces(data, record as u64, most)?;
    let stream = pieces.last().map_or(0, |p| p.start + p.len);
    let samples = group.sample_count.min(stream / record as u64) as usize;
    // not copies of one: fresh memory is zero already
    let mut columns: Vec<Vec<f64>> = fields.iter().map(|_| vec![0.0; samples]).collect();
    let ends: Vec<Result<Ends, Mf4Error>> = tasks(&pieces, record, &mut columns)
        .into_par_iter()
        .map_init(Workplace::default, |place, task| run(bytes, &fields, record, task, place))
        .collect();
    let (whole, broken) = join(&pieces, ends, &fields, record, &mut columns);
    columns.iter_mut().for_each(|column| column.truncate(whole));
    Some(Columns { columns, broken })
}

/// The pieces of a group's stream; `None` if one is not to be read here, or ends beyond `most` bytes.
fn pieces(data: &DataGroup, record: u64, most: u64) -> Option<Vec<Piece>> {
    let mut pieces = Vec::new();
    for (start, block) in data.block_index().iter() {
        // before it is cut up: a damaged length would be cut into more pieces than there is memory for
        start.checked_add(block.original_size).filter(|end| *end <= most)?;
        if block.invalidation_block.is_some() {
            return None;
        }
        let Some(packing) = &block.compression else {
            let at = block.offset + BLOCK_HEADER_SIZE as u64;
            let step = (PIECE / record).max(1) * record;
            let mut done = 0;
            while done < block.original_size {
                // they end where records do, wherever the block begins
                let len = (step - (start + done) % record).min(block.original_size - done);
                pieces.push(Piece { start: start + done, len, at: at + done, packed: None });
                done += len;
            }
            continue;
        };
        let (method, transposed) = Method::of(packing.algorithm)?;
        let transposed = transposed.then_some(packing.parameter as usize);
        let packed = Some(Packed { size: block.compressed_size, method, transposed });
        pieces.push(Piece { start, len: block.original_size, at: packing.data_offset, packed });
    }
    Some(pieces)
}

impl Piece {
    /// The records that are whole in it.
    fn records(&self, record: usize, samples: usize) -> Range<usize> {
        let record = record as u64;
        let first = self.start.div_ceil(record).min(samples as u64) as usize;
        let last = ((self.start + self.len) / record).min(samples as u64) as usize;
        first..last.max(first)
    }
}

/// Every piece with its own part of the columns.
fn tasks<'a>(pieces: &'a [Piece], record: usize, columns: &'a mut [Vec<f64>]) -> Vec<Task<'a>> {
    let samples = columns.first().map_or(0, Vec::len);
    let mut rests: Vec<&mut [f64]> = columns.iter_mut().map(|c| &mut c[..]).collect();
    let mut done = 0;
    let mut task = |piece: &'a Piece| {
        let records = piece.records(record, samples);
        let own = |rest: &mut &'a mut [f64]| {
            let (_, after) = std::mem::take(rest).split_at_mut(records.start - done);
            let (own, after) = after.split_at_mut(records.len());
            *rest = after;
            own
        };
        let out = rests.iter_mut().map(own).collect();
        done = records.end;
        Task { piece, out }
    };
    pieces.iter().map(&mut task).collect()
}

fn run(
    bytes: &dyn Bytes,
    fields: &[Field],
    record: usize,
    task: Task<'_>,
    Workplace { raw, unpacker }: &mut Workplace,
) -> Result<Ends, Mf4Error> {
    let Task { piece, out } = task;
    let stored = piece.packed.as_ref().map_or(piece.len, |p| p.size);
    bytes.read_into(piece.at, stored as usize, raw)?;
    let len = piece.len as usize;
    let data = match &piece.packed {
        None => &raw[..],
        Some(packed) => unpacker.unpack(packed.method, raw, len)?,
    };
    let before = (piece.start % record as u64) as usize;
    let data = match piece.packed.as_ref().and_then(|p| p.transposed) {
        Some(columns) if columns == record && before == 0 => {
            let lines = len / record;
            let layout = Layout::Columns { bytes: data, lines };
            fields.iter().zip(out).for_each(|(field, out)| field.decode(&layout, out));
            return Ok(Ends { head: Vec::new(), tail: data[lines * record..].to_vec() });
        }
        Some(columns) => &turned_back(data, columns)?[..],
        None => data,
    };
    let (head, rest) = data.split_at(((record - before) % record).min(data.len()));
    let (whole, tail) = rest.split_at(rest.len() / record * record);
    let layout = Layout::Records { bytes: whole, record };
    fields.iter().zip(out).for_each(|(field, out)| field.decode(&layout, out));
    Ok(Ends { head: head.to_vec(), tail: tail.to_vec() })
}

/// Rows again of what was stored column by column; what does not fill a row comes last.
fn turned_back(data: &[u8], columns: usize) -> Result<Vec<u8>, Mf4Error> {
    if columns == 0 {
        return Err(Mf4Error::Decompression("a transposed block without columns".into()));
    }
    let lines = data.len() / columns;
    let mut rows = data.to_vec();
    for (line, row) in rows.chunks_exact_mut(columns).enumerate() {
        for (column, byte) in row.iter_mut().enumerate() {
            *byte = data[column * lines + line];
        }
    }
    Ok(rows)
}

/// Decodes the records that lie across pieces; how many records there are before the first piece
/// that could not be read, and why it could not.
fn join(
    pieces: &[Piece],
    ends: Vec<Result<Ends, Mf4Error>>,
    fields: &[Field],
    record: usize,
    columns: &mut [Vec<f64>],
) -> (usize, Option<Mf4Error>) {
    let samples = columns.first().map_or(0, Vec::len);
    let mut begun: Vec<u8> = Vec::new();
    for (piece, ends) in pieces.iter().zip(ends) {
        let row = (piece.start / record as u64) as usize;
        let Ends { head, tail } = match ends {
            Ok(ends) => ends,
            Err(e) => return (row.min(samples), Some(e)),
        };
        begun.extend(head);
        if begun.len() == record {
            let layout = Layout::Records { bytes: &begun, record };
            for (field, column) in fields.iter().zip(&mut *columns) {
                if let Some(value) = column.get_mut(row) {
                    field.decode(&layout, std::slice::from_mut(value));
                }
            }
            begun.clear();
        }
        begun.extend(tail);
    }
    (samples, None)
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;
    use std::sync::Arc;

    use super::*;
    use falcon_mdf::Mf4File;
    use falcon_mdf::io::ByteSource;
    use falcon_mdf::io::memory::MemorySource;

    impl Bytes for MemorySource {}

    fn sample(name: &str) -> Vec<u8> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/formats/");
        std::fs::read(format!("{folder}{name}")).expect("bundled")
    }

    fn open(bytes: Vec<u8>) -> (Arc<dyn Bytes>, Mf4File) {
        let bytes: Arc<dyn Bytes> = Arc::new(MemorySource::new(bytes));
        let source: Arc<dyn ByteSource> = Arc::clone(&bytes) as _;
        let file = Mf4File::from_source(source).expect("MDF");
        (bytes, file)
    }

    fn same(a: &[f64], b: &[f64]) -> bool {
        let equal = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
        a.len() == b.len() && a.iter().zip(b).all(equal)
    }

    /// Values of a channel by the library.
    fn by_library(file: &Mf4File, channel: &Channel) -> Vec<f64> {
        let signal = file.signal(channel).expect("readable");
        let mut values = signal.values_f64().expect("numbers");
        for (value, valid) in values.iter_mut().zip(signal.validity().unwrap_or_default()) {
            *value = if valid { *value } else { f64::NAN };
        }
        values
    }

    /// Reads everything both ways; samples, and how many of them are missing.
    fn compare(bytes: Vec<u8>, what: &str) -> (usize, usize) {
        let (bytes, file) = open(bytes);
        let (mut samples, mut missing) = (0, 0);
        for data in file.data_groups() {
            let group = &data.channel_groups[0];
            let channels: Vec<&Channel> = group.channels.iter().collect();
            let got = read(&*bytes, data, group, &channels).expect(what);
            assert!(got.broken.is_none(), "{what}: {:?}", got.broken);
            for (channel, got) in channels.iter().zip(&got.columns) {
                assert!(same(got, &by_library(&file, channel)), "{what}: {}", channel.name);
                samples += got.len();
                missing += got.iter().filter(|v| v.is_nan()).count();
            }
        }
        (samples, missing)
    }

    #[test]
    fn samples_are_those_that_the_library_reads() {
        for (name, rows, missing) in
            [("ride.mf4", 1000, 50), ("ride_420.mf4", 1000, 0), ("ride_logger.mf4", 600, 50)]
        {
            let (samples, lost) = compare(sample(name), name);
            assert!(samples > 10 * rows && lost == missing, "{name}: {samples}, {lost}");
        }
    }

    /// A block of that kind, its links and its data.
    fn block(id: &[u8; 4], links: &[u64], data: &[u8]) -> Vec<u8> {
        let mut out = id.to_vec();
        out.extend([0; 4]);
        out.extend((24 + 8 * links.len() as u64 + data.len() as u64).to_le_bytes());
        out.extend((links.len() as u64).to_le_bytes());
        links.iter().for_each(|link| out.extend(link.to_le_bytes()));
        out.extend(data);
        out.resize(out.len().next_multiple_of(8), 0);
        out
    }

    /// A packed block; `method` as the format numbers them, `columns` for transposed ones.
    fn packed(data: &[u8], method: u8, columns: usize) -> Vec<u8> {
        let mut rows = data.to_vec();
        if method % 2 == 1 {
            let lines = data.len() / columns;
            for (i, byte) in data[..lines * columns].iter().enumerate() {
                rows[i % columns * lines + i / columns] = *byte;
            }
        }
        let bytes = match method {
            0 | 1 => {
                let level = flate2::Compression::default();
                let mut writer = flate2::write::ZlibEncoder::new(Vec::new(), level);
                writer.write_all(&rows).and_then(|()| writer.finish()).expect("packed")
            }
            2 | 3 => zstd::bulk::compress(&rows, 3).expect("packed"),
            _ => {
                let mut writer = lz4_flex::frame::FrameEncoder::new(Vec::new());
                writer.write_all(&rows).expect("packed");
                writer.finish().expect("packed")
            }
        };
        let mut out = vec![b'D', b'T', method, 0];
        out.extend((columns as u32).to_le_bytes());
        out.extend((data.len() as u64).to_le_bytes());
        out.extend((bytes.len() as u64).to_le_bytes());
        out.extend(bytes);
        block(b"##DZ", &[], &out)
    }

    /// The sample of a logger with its streams of records cut into blocks of `size` bytes or
    /// records, which `pack` makes of them and the length of a record.
    fn cut(size: Result<usize, usize>, pack: impl Fn(&[u8], usize) -> Vec<u8>) -> Vec<u8> {
        let whole = sample("ride_logger.mf4");
        let (_, file) = open(whole.clone());
        let mut out = whole.clone();
        for data in file.data_groups() {
            let record = data.channel_groups[0].record_size(0);
            let stream = &data.block_index().blocks()[0];
            let from = stream.offset as usize + BLOCK_HEADER_SIZE;
            let stream = &whole[from..from + stream.original_size as usize];
            let (mut links, mut offsets) = (vec![0], Vec::new());
            for part in stream.chunks(size.unwrap_or_else(|records| records * record)) {
                links.push(out.len() as u64);
                let before = offsets.len() * size.unwrap_or_else(|records| records * record);
                offsets.push(before as u64);
                out.extend(pack(part, record));
            }
            let mut list = vec![0; 4];
            list.extend((offsets.len() as u32).to_le_bytes());
            offsets.iter().for_each(|offset| list.extend(offset.to_le_bytes()));
            let at = data.block_offset() as usize + 24 + 16;
            let place = (out.len() as u64).to_le_bytes();
            out[at..at + 8].copy_from_slice(&place);
            out.extend(block(b"##DL", &links, &list));
        }
        out
    }

    #[test]
    fn blocks_may_end_anywhere_and_be_packed_in_any_way() {
        let whole = compare(sample("ride_logger.mf4"), "whole");
        for size in [Err(50), Err(1000), Ok(1000), Ok(777), Ok(5)] {
            let plain = cut(size, |data, _| block(b"##DT", &[], data));
            assert_eq!(compare(plain, &format!("plain, {size:?}")), whole);
            for method in 0..6 {
                for columns in [None, Some(7)] {
                    let pack =
                        |data: &[u8], record| packed(data, method, columns.unwrap_or(record));
                    let what = format!("method {method}, {size:?}, {columns:?}");
                    assert_eq!(compare(cut(size, pack), &what), whole);
                }
            }
        }
    }

    #[test]
    fn what_is_before_a_damaged_block_is_read() {
        let mut bytes = cut(Err(50), |data, record| packed(data, 1, record));
        let (_, file) = open(bytes.clone());
        let block = &file.data_groups()[0].block_index().blocks()[2];
        let at = block.compression.as_ref().expect("packed").data_offset as usize;
        bytes[at + 40..at + 60].fill(b'~');
        let (bytes, damaged) = open(bytes);
        let data = &damaged.data_groups()[0];
        let group = &data.channel_groups[0];
        let channels: Vec<&Channel> = group.channels.iter().collect();
        let got = read(&*bytes, data, group, &channels).expect("plain numbers");
        assert!(got.broken.is_some());
        for (channel, got) in channels.iter().zip(&got.columns) {
            let (_, whole) = open(sample("ride_logger.mf4"));
            assert!(same(got, &by_library(&whole, channel)[..100]), "{}", channel.name);
        }
    }

    /// Where a file has its blocks of that kind.
    fn places(bytes: &[u8], id: &[u8; 4]) -> Vec<usize> {
        (0..bytes.len()).step_by(8).filter(|at| bytes[*at..].starts_with(id)).collect()
    }

    /// How many groups a damaged file still has; of none of them anything is read here.
    fn left_alone(bytes: Vec<u8>, what: &str) -> usize {
        let bytes: Arc<dyn Bytes> = Arc::new(MemorySource::new(bytes));
        let Ok(file) = Mf4File::from_source(Arc::clone(&bytes) as _) else { return 0 };
        for data in file.data_groups() {
            let group = &data.channel_groups[0];
            for channel in &group.channels {
                let read = read(&*bytes, data, group, &[channel]);
                assert!(read.is_none(), "{what}: {}", channel.name);
            }
        }
        file.data_groups().len()
    }

    #[test]
    fn impossible_bit_counts_are_left_to_the_library() {
        let whole = sample("ride_logger.mf4");
        let channels = places(&whole, b"##CN");
        assert!(channels.len() > 16);
        for count in [0, 65, 1 << 20, u32::MAX - 6, u32::MAX] {
            for shift in [0, 1, 7, 64, 255] {
                let mut bytes = whole.clone();
                for at in &channels {
                    let links = usize::from(whole[at + 16]);
                    let data = at + BLOCK_HEADER_SIZE + 8 * links;
                    bytes[data + 3] = shift;
                    bytes[data + 8..data + 12].copy_from_slice(&count.to_le_bytes());
                }
                assert_eq!(left_alone(bytes, &format!("{count} bits from {shift} on")), 4);
            }
        }
    }

    #[test]
    fn impossible_lengths_of_plain_blocks_are_refused_or_left_to_the_library() {
        let whole = sample("ride_logger.mf4");
        let streams = places(&whole, b"##DT");
        assert_eq!(streams.len(), 4);
        // one that is cut into pieces before it is checked against the file takes memory until there is none
        for length in [whole.len() as u64 * (MOST_UNPACKED + 1), 1 << 45, u64::MAX - 7, u64::MAX] {
            let mut bytes = whole.clone();
            for at in &streams {
                bytes[at + 8..at + 16].copy_from_slice(&length.to_le_bytes());
            }
            let groups = left_alone(bytes, &format!("{length} bytes"));
            assert!(matches!(groups, 0 | 4), "{length} bytes: {groups} groups");
        }
    }
}
