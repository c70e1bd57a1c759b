//! Logs that are packed as a whole (`ride.asc.gz`, `ride.csv.zst`): unpacked where they are opened, so that no reader
//! knows of it.

use std::cell::RefCell;
use std::io::{Cursor, Error, ErrorKind, Read, Result};
use std::time::SystemTime;

use bytes::Bytes;

use super::location::Location;
use super::stat::Stat;

/// Largest log after unpacking, bytes: it is kept in memory while it is read.
const LARGEST: u64 = 1 << 30;

#[derive(Debug, Clone)]
pub(crate) struct Unpacked {
    /// Its bytes, as far as they could be unpacked.
    pub bytes: Bytes,
    /// Why the rest could not.
    pub broken: Option<String>,
}

/// Where from and which version: what a thread unpacked last is of use for that alone.
type Key = (Location, u64, SystemTime);

thread_local! {
    static LAST: RefCell<Option<(Key, Unpacked)>> = const { RefCell::new(None) };
}

/// Lets go of what this thread unpacked last: it reads another log now.
pub(crate) fn forget() {
    LAST.set(None);
}

/// The whole log, unpacked; of one that is damaged or cut off what comes before.
///
/// # Errors
/// Nothing of it can be unpacked, or it is too large.
pub(crate) fn unpacked(log: &Location, stat: &Stat, packed: impl Read) -> Result<Unpacked> {
    let key = (log.clone(), stat.size, stat.modified);
    let known = LAST.with_borrow(|last| {
        last.as_ref().filter(|(of, _)| *of == key).map(|(_, unpacked)| unpacked.clone())
    });
    if let Some(known) = known {
        return Ok(known);
    }
    // not two of them at once
    forget();
    let mut packed = packed;
    let mut head = Vec::with_capacity(4);
    packed.by_ref().take(4).read_to_end(&mut head)?;
    let text =
        head.len() == 4 && !head.iter().any(|b| b.is_ascii_control() && !b"\t\r\n".contains(b));
    let (gz, zst) = (head.starts_with(&[0x1f, 0x8b]), head.starts_with(&[0x28, 0xb5, 0x2f, 0xfd]));
    let packed = Cursor::new(head).chain(packed);
    let unpacked = if text && !gz && !zst {
        // a download that was unpacked on its way and kept its name
        read(packed)?
    } else if log.is_named("gz") {
        // several members one after the other are one log: it was added to
        read(flate2::read::MultiGzDecoder::new(packed))?
    } else {
        read(zstd::stream::read::Decoder::new(packed)?)?
    };
    LAST.set(Some((key, unpacked.clone())));
    Ok(unpacked)
}

fn read(unpacking: impl Read) -> Result<Unpacked> {
    let mut bytes = Vec::new();
    let end = unpacking.take(LARGEST + 1).read_to_end(&mut bytes);
    if bytes.len() as u64 > LARGEST {
        let message =
            format!("it unpacks to more than {} MB; unpack it before the run", LARGEST >> 20);
        return Err(Error::new(ErrorKind::FileTooLarge, message));
    }
    let broken = match end {
        // the packed bytes were not given: what there is of them says nothing
        Err(e) if e.raw_os_error().is_some() => return Err(e),
        end => end.err().map(|e| e.to_string()),
    };
    match broken {
        Some(why) if bytes.is_empty() => {
            Err(Error::new(ErrorKind::InvalidData, format!("it cannot be unpacked: {why}")))
        }
        broken => Ok(Unpacked { bytes: bytes.into(), broken }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;
    use std::path::PathBuf;

    fn of(name: &str, packed: &[u8]) -> Result<Unpacked> {
        let stat = Stat { size: packed.len() as u64, modified: SystemTime::UNIX_EPOCH, etag: None };
        unpacked(&Location::from(PathBuf::from(name)), &stat, packed)
    }

    fn gz(bytes: &[u8]) -> Vec<u8> {
        let mut packing = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packing.write_all(bytes).expect("in memory");
        packing.finish().expect("in memory")
    }

    #[test]
    fn both_kinds_are_unpacked_and_what_is_cut_is_kept() {
        let text: Vec<u8> =
            (0..50_000_u32).flat_map(|i| i.wrapping_mul(2_654_435_761).to_le_bytes()).collect();
        let packed = gz(&text);
        let whole = of("a.csv.gz", &packed).expect("whole");
        assert_eq!((&whole.bytes[..], whole.broken.is_none()), (&text[..], true));
        let two = of("a2.csv.gz", &[packed.clone(), gz(b"more")].concat()).expect("two members");
        assert_eq!(two.bytes.len(), text.len() + 4);
        let cut = of("a3.csv.gz", &packed[..packed.len() / 2]).expect("a half");
        assert!(cut.broken.is_some() && text.starts_with(&cut.bytes) && cut.bytes.len() > 50_000);
        assert!(of("a4.csv.gz", b"\x1f\x8b").is_err());
        let plain = of("a5.csv.gz", b"time,velocity_x\n").expect("not packed in spite of its name");
        assert_eq!((&plain.bytes[..], plain.broken.is_none()), (&b"time,velocity_x\n"[..], true));
        assert!(of("a6.csv.gz", b"PK\x03\x04 and more").is_err());
        let zst = zstd::bulk::compress(&text, 1).expect("in memory");
        let whole = of("a.csv.zst", &zst).expect("whole");
        assert_eq!((&whole.bytes[..], whole.broken.is_none()), (&text[..], true));
    }
}
