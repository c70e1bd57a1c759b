//! CAN logs: Vector BLF and ASC, candump's text and PEAK traces. Frames are decoded with CAN
//! databases (DBC), which the channel map names.
//!
//! Channels are `Message/Signal` (or `Message.Signal`), each message on its own clock, each
//! multiplexed signal too. A message that came over several buses is `Message@1`, `Message@2`; one of J1939 that
//! several sources sent is `Message from 0`, `Message from 3`.
//! The readers are our own because a log with broken frames must be read on after them, from
//! wherever it is, and the lengths in it must not be trusted.

use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::format::Format;
use crate::ingest::formats::format::Head;
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::ingest::warning::warning;
use crate::store::objects::Location;

mod bits;
mod blf;
pub(crate) mod database;
mod frame;
mod frames;
pub(crate) mod signals;
mod text;
mod trc;

use database::Database;
pub(crate) use frame::Frame;
use signals::{Collector, FrameCounts};

pub(super) struct Can;

impl Format for Can {
    const NAME: &'static str = "can";
    const DESCRIPTION: &'static str = "CAN frames in BLF, ASC, TRC or candump, decoded with a DBC file: `dbc = \"my.dbc\"` in the map, or `--dbc`";
    const CHANNEL_NAMES: &'static str = "`Message/Signal`";
    const EXTENSIONS: &'static [&'static str] = &["blf", "asc", "log", "trc"];
    const MAPS: &'static [ShippedMap] = &[shipped_map!("session_can")];

    fn sniff(head: &Head<'_>) -> bool {
        frames::kind(head.bytes).is_some()
    }

    fn list(log: &Location, aids: &Aids) -> Result<Listing, Error> {
        let database = Database::read(aids)?;
        let mut counts = FrameCounts::default();
        let scan = frames::each(log, &mut |frame| counts.count(frame))?;
        let mut listing = counts.listing(&database);
        listing.meta.start_time = scan.start;
        listing.layout = layout(aids);
        if scan.bad > 0 {
            let message = format!(
                "{} frames are damaged and left out, the first {}",
                scan.bad, scan.first_bad
            );
            listing.warnings.push(warning("bad_frame", None, scan.bad, None, message));
        }
        if scan.cut {
            let message = "the log is cut off; read up to there".to_owned();
            listing.warnings.push(warning("truncated", None, 1, None, message));
        }
        Ok(listing)
    }

    fn decode(log: &Location, aids: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        let database = Database::read(aids)?;
        let mut collector = Collector::new(&database, wanted);
        frames::each(log, &mut |frame| collector.take(frame))?;
        Ok(Decoded { columns: collector.columns(wanted), ..Decoded::default() })
    }
}

/// Which databases the draft of a map names.
fn layout(aids: &Aids) -> String {
    if aids.names.is_empty() {
        return "# what the frames mean; without it there are no channels\n# dbc = \"...\"".into();
    }
    let names = aids.names.iter().map(|n| toml::Value::String(n.clone())).collect();
    format!("dbc = {} # relative to this file", toml::Value::Array(names))
}
