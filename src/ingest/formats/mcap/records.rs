//! The records of an MCAP file, chunks unpacked.
//!
//! The file is read from its start, so that one without an end is read as far as it goes; every
//! length is checked against the bytes that are there. A chunk whose checksum is wrong is left out.

use std::io::{BufReader, Read};

use mcap::records::{Record, op};

use crate::ingest::error::Error;
use crate::store::objects::{Location, source};

/// First and last bytes of a file.
pub(super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Largest chunk after unpacking, bytes; usual are a few million.
const LARGEST: u64 = 256 << 20;
/// Largest size of all unpacked chunks, bytes, and per byte of the file: recordings pack to a tenth, rarely to a hundredth.
const UNPACKED: (u64, u64) = (256 << 20, 1000);

/// A record of the file.
pub(super) enum Event<'a> {
    /// How messages are built.
    Schema { id: u16, name: String, encoding: String, data: &'a [u8] },
    Channel {
        id: u16,
        topic: String,
        /// How its messages are written.
        encoding: String,
        schema: u16,
    },
    Message {
        /// Number of its topic.
        channel: u16,
        /// Log time, ns.
        log_time: u64,
        data: &'a [u8],
    },
    /// Words about the log.
    Metadata {
        /// Topic.
        name: String,
        entries: Vec<(String, String)>,
    },
}

/// Data known at the end.
#[derive(Debug, Default)]
pub(super) struct Scan {
    /// Chunks that could not be used.
    pub bad_chunks: usize,
    /// Time in them, s.
    pub lost: f64,
    /// Where the file ends or makes no sense, if it does before its end.
    pub cut: Option<u64>,
}

/// Everything that is said before the summary, in turn.
pub(super) fn each(log: &Location, take: &mut dyn FnMut(Event<'_>)) -> Result<Scan, Error> {
    let fail = |e: std::io::Error| Error::unreadable(log, &e);
    let file = source::open(log).map_err(fail)?;
    let size = file.size().map_err(fail)?;
    let mut file = BufReader::with_capacity(1 << 18, file);
    let mut scan = Scan::default();
    let mut at = MAGIC.len() as u64;
    std::io::copy(&mut file.by_ref().take(at), &mut std::io::sink()).map_err(fail)?;
    let mut body = Vec::new();
    let mut may_unpack = UNPACKED.0.saturating_add(size.saturating_mul(UNPACKED.1));
    loop {
        let left = size.saturating_sub(at);
        let mut head = [0; 9];
        if left < 9 {
            scan.cut = Some(at);
            break;
        }
        file.read_exact(&mut head).map_err(fail)?;
        let length = u64::from_le_bytes(head[1..].try_into().unwrap_or_default());
        if length > left - 9 {
            scan.cut = Some(at);
            // a chunk that was being written is of use as far as it goes, if it is not packed
            if head[0] == op::CHUNK {
                body.clear();
                file.by_ref().take(left).read_to_end(&mut body).map_err(fail)?;
                torn_chunk(&body, take);
            }
            break;
        }
        body.clear();
        file.by_ref().take(length).read_to_end(&mut body).map_err(fail)?;
        match head[0] {
            op::CHUNK => {
                let unpacked = chunk(&body, &mut scan, take);
                match may_unpack.checked_sub(unpacked) {
                    Some(rest) => may_unpack = rest,
                    // no recording grows like this
                    None => {
                        scan.cut = Some(at);
                        break;
                    }
                }
            }
            // after it is the summary
            op::DATA_END | op::FOOTER => break,
            0 => {
                scan.cut = Some(at);
                break;
            }
            code => record(code, &body, take),
        }
        at += 9 + length;
    }
    Ok(scan)
}

/// A record that stands by itself; what is not of interest or makes no sense is passed over.
fn record(code: u8, body: &[u8], take: &mut dyn FnMut(Event<'_>)) {
    if code == op::MESSAGE {
        // channel 2, sequence 4, log time 8, publish time 8
        let (Some(channel), Some(time), Some(data)) =
            (body.get(..2), body.get(6..14), body.get(22..))
        else {
            return;
        };
        take(Event::Message {
            channel: u16::from_le_bytes(channel.try_into().unwrap_or_default()),
            log_time: u64::from_le_bytes(time.try_into().unwrap_or_default()),
            data,
        });
        return;
    }
    // the library makes room for what a length claims before it looks
    let claims: &[Field] = match code {
        op::SCHEMA => &[Field::Skip(2), Field::Long, Field::Long, Field::Long],
        op::CHANNEL => &[Field::Skip(4), Field::Long, Field::Long, Field::Pairs],
        op::METADATA => &[Field::Long, Field::Pairs],
        _ => return,
    };
    if !holds(body, claims) {
        return;
    }
    match mcap::parse_record(code, body) {
        Ok(Record::Schema { header, data }) => take(Event::Schema {
            id: header.id,
            name: header.name,
            encoding: header.encoding,
            data: &data,
        }),
        Ok(Record::Channel(channel)) => take(Event::Channel {
            id: channel.id,
            topic: channel.topic,
            encoding: channel.message_encoding,
            schema: channel.schema_id,
        }),
        Ok(Record::Metadata(words)) => {
            take(Event::Metadata {
                name: words.name,
                entries: words.metadata.into_iter().collect(),
            });
        }
        _ => {}
    }
}

/// A part of a record.
enum Field {
    /// So many bytes.
    Skip(usize),
    /// A length of four bytes, and as many bytes as it says.
    Long,
    /// The same, full of such parts.
    Pairs,
}

/// Whether a record holds what its lengths claim.
fn holds(mut body: &[u8], fields: &[Field]) -> bool {
    /// Bytes of a claimed length, taken from the front.
    fn long<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
        let (length, after) = rest.split_first_chunk::<4>()?;
        let (claimed, after) = after.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        *rest = after;
        Some(claimed)
    }
    fields.iter().all(|field| match field {
        Field::Skip(bytes) => {
            let rest = body.get(*bytes..);
            body = rest.unwrap_or_default();
            rest.is_some()
        }
        Field::Long => long(&mut body).is_some(),
        Field::Pairs => long(&mut body).is_some_and(|mut pairs| {
            while !pairs.is_empty() {
                if long(&mut pairs).is_none() {
                    return false;
                }
            }
            true
        }),
    })
}

/// The records of a chunk; gives back how many bytes it was unpacked.
fn chunk(body: &[u8], scan: &mut Scan, take: &mut dyn FnMut(Event<'_>)) -> u64 {
    // start 8, end 8, size 8, checksum 4, name of the compression; then the records, whose length is checked against the body
    let claims = [Field::Skip(28), Field::Long];
    if !holds(body, &claims) {
        scan.bad_chunks += 1;
        return 0;
    }
    let Ok(Record::Chunk { header, data }) = mcap::parse_record(op::CHUNK, body) else {
        scan.bad_chunks += 1;
        return 0;
    };
    let mut unpacked = Vec::new();
    let is_whole = unpack(&header.compression, &data, &mut unpacked).is_some()
        && unpacked.len() as u64 <= LARGEST
        && [0, crc32fast::hash(&unpacked)].contains(&header.uncompressed_crc);
    match is_whole {
        true => within(&unpacked, take),
        false => {
            scan.bad_chunks += 1;
            let span = header.message_end_time.saturating_sub(header.message_start_time);
            scan.lost += span as f64 * 1e-9;
        }
    }
    unpacked.len() as u64
}

/// Unpacks the records of a chunk, as far as they go.
fn unpack(compression: &str, data: &[u8], out: &mut Vec<u8>) -> Option<()> {
    match compression {
        "" => out.extend_from_slice(data),
        "zstd" => {
            let decoder = zstd::stream::read::Decoder::new(data).ok()?;
            decoder.take(LARGEST + 1).read_to_end(out).ok()?;
        }
        "lz4" => {
            let decoder = lz4_flex::frame::FrameDecoder::new(data);
            decoder.take(LARGEST + 1).read_to_end(out).ok()?;
        }
        _ => return None,
    }
    Some(())
}

/// The records of a chunk.
fn within(mut rest: &[u8], take: &mut dyn FnMut(Event<'_>)) {
    while let Some((head, more)) = rest.split_at_checked(9) {
        let length = u64::from_le_bytes(head[1..].try_into().unwrap_or_default());
        let Some((body, after)) =
            usize::try_from(length).ok().and_then(|length| more.split_at_checked(length))
        else {
            return;
        };
        record(head[0], body, take);
        rest = after;
    }
}

/// Readable part of a chunk that has no end.
fn torn_chunk(body: &[u8], take: &mut dyn FnMut(Event<'_>)) {
    // start 8, end 8, size 8, checksum 4, length of the name of the compression 4
    let Some(length) = body.get(28..32) else { return };
    let length = u32::from_le_bytes(length.try_into().unwrap_or_default()) as usize;
    let Some(name) = length.checked_add(32).and_then(|end| body.get(32..end)) else { return };
    let Some(data) = body.get(32 + length + 8..) else { return };
    let mut out = Vec::new();
    // what was unpacked before the end is in `out`
    let _ = match name {
        b"" => {
            out.extend_from_slice(data);
            Ok(0)
        }
        b"zstd" => match zstd::stream::read::Decoder::new(data) {
            Ok(decoder) => decoder.take(LARGEST).read_to_end(&mut out),
            Err(e) => Err(e),
        },
        b"lz4" => lz4_flex::frame::FrameDecoder::new(data).take(LARGEST).read_to_end(&mut out),
        _ => return,
    };
    within(&out, take);
}
