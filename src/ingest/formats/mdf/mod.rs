//! ASAM MDF, versions 3 and 4: groups of channels, each on its group's clock.
//!
//! Of version 4 only the wanted channels are ever in memory, straight from the blocks ([`columns`])
//! or, where that is not possible, through the library a window of records at a time; version 3 is
//! read a group at a time. A file that was cut off or never closed is read up to
//! there ([`mend`]); samples whose invalidation bit is set are missing.

use std::sync::Arc;

use falcon_mdf::Mf4File;
use falcon_mdf::io::ByteSource;
use falcon_mdf::mdf3::Mdf3File;

use crate::contract::warning::Warning;
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::can::database::Database;
use crate::ingest::formats::format::Head;
use crate::ingest::formats::format::{Format, guarded};
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel, number_twins};
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::store::objects::{Location, source};

mod bus;
mod columns;
mod common;
mod field;
mod file;
mod patched;
mod repair;
mod unpack;
mod v3;
mod v4;

use file::Bytes;
use patched::Patched;

pub(super) struct Mdf;

impl Format for Mdf {
    const NAME: &'static str = "mdf";
    const DESCRIPTION: &'static str =
        "ASAM MDF 3 and 4: plain, deflated, zstd, LZ4; unsorted; invalidation bits";
    const CHANNEL_NAMES: &'static str = "`group/channel`";
    const EXTENSIONS: &'static [&'static str] = &["mf4", "mdf"];
    const MAPS: &'static [ShippedMap] = &[shipped_map!("session_mdf")];

    fn sniff(head: &Head<'_>) -> bool {
        head.bytes.starts_with(b"MDF     ") || head.bytes.starts_with(b"UnFinMF ")
    }

    fn list(log: &Location, aids: &Aids) -> Result<Listing, Error> {
        let database = Database::read(aids)?;
        let (file, warnings) = open(log)?;
        guarded(log, || {
            let mut listing = match &file {
                File::Four(file, _) => {
                    let mut listing = v4::list(file);
                    bus::list(file, &database, &mut listing);
                    listing
                }
                File::Three(file) => v3::list(file),
            };
            listing.warnings.extend(warnings);
            number_twins(&mut listing.channels);
            Ok(listing)
        })
    }

    fn decode(log: &Location, aids: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        let (file, _) = open(log)?;
        let (file, bytes) = match file {
            File::Three(file) => return guarded(log, || Ok(v3::decode(&file, wanted))),
            File::Four(file, bytes) => (file, bytes),
        };
        let (signals, stored): (Vec<&SourceChannel>, Vec<&SourceChannel>) =
            wanted.iter().partition(|channel| bus::is_signal(channel));
        if signals.is_empty() {
            return guarded(log, || Ok(v4::decode(&file, &*bytes, wanted)));
        }
        let database = Database::read(aids)?;
        guarded(log, || {
            let mut decoded = v4::decode(&file, &*bytes, &stored);
            let of_frames = bus::decode(&file, &database, &signals);
            decoded.warnings.extend(of_frames.warnings);
            let mut columns = decoded.columns.into_iter();
            let mut of_frames = of_frames.columns.into_iter();
            // back into the order asked for
            let next = |channel: &&SourceChannel| {
                if bus::is_signal(channel) { of_frames.next() } else { columns.next() }
            };
            let columns = wanted.iter().filter_map(next).collect();
            Ok(Decoded { columns, ..decoded })
        })
    }
}

enum File {
    Three(Box<Mdf3File>),
    /// And its bytes.
    Four(Box<Mf4File>, Arc<dyn Bytes>),
}

fn open(log: &Location) -> Result<(File, Vec<Warning>), Error> {
    let source = source::open(log).map_err(|e| Error::unreadable(log, &e))?;
    guarded(log, || {
        let bytes = file::bytes(source).map_err(|e| e.to_string())?;
        let id = bytes.read_bytes(0, 64).map_err(|_| "its first block is cut off".to_owned())?;
        let unfinished = id.starts_with(b"UnFinMF ") || id[60..62] != [0, 0];
        let version = u16::from_le_bytes([id[28], id[29]]);
        drop(id);
        if version < 400 {
            let file = Mdf3File::from_source(bytes).map_err(|e| e.to_string())?;
            return Ok((File::Three(Box::new(file)), Vec::new()));
        }
        if !unfinished && let Ok(file) = Mf4File::from_source(Arc::clone(&bytes) as _) {
            return Ok((File::Four(Box::new(file), bytes), Vec::new()));
        }
        let repaired = repair::repair(bytes.as_ref(), unfinished)?;
        let warnings = repaired.warnings(unfinished);
        let patches = repaired.patches.into_iter().collect();
        let patched: Arc<dyn Bytes> = Arc::new(Patched { bytes, patches });
        let file = Mf4File::from_source(Arc::clone(&patched) as _).map_err(|e| e.to_string())?;
        Ok((File::Four(Box::new(file), patched), warnings))
    })
}
