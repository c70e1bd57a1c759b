//! CAN frames in an MDF 4 file, as bus loggers write them; decoded with databases (DBC).

use falcon_mdf::Mf4File;

use super::common::broken;
use crate::ingest::formats::can::Frame;
use crate::ingest::formats::can::database::Database;
use crate::ingest::formats::can::signals::{Collector, FrameCounts};
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};

/// Mark of channels from frames: no group has as many channels.
const FRAMES: usize = 1 << 30;

/// Whether a channel is a signal of frames.
pub(super) fn is_signal(channel: &SourceChannel) -> bool {
    channel.place[2] >= FRAMES
}

/// Adds the signals that the databases define for the file's frames.
pub(super) fn list(file: &Mf4File, database: &Database, listing: &mut Listing) {
    let mut counts = FrameCounts::default();
    let mut warnings = Vec::new();
    each(file, &mut |frame| counts.count(frame), &mut warnings);
    listing.warnings.extend(warnings);
    let found = counts.listing(database);
    listing.facts.extend(found.facts);
    listing.channels.extend(found.channels.into_iter().map(|mut channel| {
        channel.place[2] += FRAMES;
        channel
    }));
}

pub(super) fn decode(file: &Mf4File, database: &Database, wanted: &[&SourceChannel]) -> Decoded {
    let places: Vec<SourceChannel> = wanted
        .iter()
        .map(|channel| {
            let mut channel = (*channel).clone();
            channel.place[2] -= FRAMES;
            channel
        })
        .collect();
    let places: Vec<&SourceChannel> = places.iter().collect();
    let mut collector = Collector::new(database, &places);
    // `list` has given the warnings already
    each(file, &mut |frame| collector.take(frame), &mut Vec::new());
    Decoded { columns: collector.columns(&places), ..Decoded::default() }
}

fn each(
    file: &Mf4File,
    take: &mut dyn FnMut(&Frame<'_>),
    warnings: &mut Vec<crate::contract::warning::Warning>,
) {
    for group in file.can_frame_groups() {
        match file.can_frames(group) {
            Ok(frames) => {
                for frame in frames.iter() {
                    // some loggers mark the extended ones in the identifier only by its size
                    let extended = frame.extended.unwrap_or(frame.id > 0x7FF);
                    take(&Frame {
                        time: frame.timestamp,
                        bus: u16::from(frame.bus_channel),
                        id: frame.id,
                        extended,
                        data: frame.data,
                    });
                }
            }
            Err(e) => warnings.push(broken("CAN frames", 0, None, &e)),
        }
    }
}
