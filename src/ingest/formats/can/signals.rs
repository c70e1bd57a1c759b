//! From frames to signals, by the CAN databases.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::database::Database;
use super::frame::Frame;
use crate::ingest::listing::{Listing, SourceChannel};
use crate::ingest::raw::Column;

/// How often each identifier came, and when.
#[derive(Debug, Default)]
pub struct FrameCounts {
    seen: BTreeMap<(u32, bool, u16), FrameCount>,
}

#[derive(Debug)]
struct FrameCount {
    count: u64,
    first: f64,
    last: f64,
    length: usize,
}

impl FrameCounts {
    /// One more frame.
    pub fn count(&mut self, frame: &Frame<'_>) {
        let key = (frame.id, frame.extended, frame.bus);
        let new = FrameCount { count: 0, first: frame.time, last: frame.time, length: 0 };
        let seen = self.seen.entry(key).or_insert(new);
        seen.count += 1;
        seen.last = frame.time;
        seen.length = seen.length.max(frame.data.len());
    }

    /// The signals that the databases define for the counted frames.
    pub fn listing(&self, database: &Database) -> Listing {
        let mut listing = Listing::default();
        let mut unknown = Vec::new();
        for (&(id, extended, bus), seen) in &self.seen {
            let span = seen.last - seen.first;
            let rate = (span > 0.0).then(|| (seen.count - 1) as f64 / span);
            let Some(at) = database.find(id, extended) else {
                let rate = rate.map(|r| format!(" at {r:.1} Hz")).unwrap_or_default();
                unknown.push(format!(
                    "{} ({} frames{rate}, {} bytes)",
                    hex_id(id, extended),
                    seen.count,
                    seen.length
                ));
                continue;
            };
            let message = &database.messages[at];
            let mut buses = self.seen.range((id, extended, 0)..=(id, extended, u16::MAX));
            let group = match buses.nth(1) {
                None => message.name.clone(),
                Some(_) => format!("{}@{bus}", message.name),
            };
            for (i, signal) in message.signals.iter().enumerate() {
                let always = !signal.is_multiplexed();
                listing.channels.push(SourceChannel {
                    group: group.clone(),
                    name: signal.name.clone(),
                    unit: signal.unit.clone(),
                    samples: Some(seen.count),
                    rate: rate.filter(|_| always),
                    place: [at, i, usize::from(bus)],
                });
            }
        }
        if !unknown.is_empty() {
            let more = unknown.len().saturating_sub(40);
            unknown.truncate(40);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            listing.facts.push(("in no database".into(), unknown.join(", ") + &more));
        }
        listing
    }
}

/// An identifier as people write it.
fn hex_id(id: u32, extended: bool) -> String {
    if extended { format!("0x{id:08X}") } else { format!("0x{id:03X}") }
}

/// The wanted signals of the frames that come by.
pub struct Collector<'a> {
    database: &'a Database,
    /// By message and bus.
    wanted: HashMap<(usize, u16), Gathered>,
}

/// What of one message is wanted.
#[derive(Default)]
struct Gathered {
    /// One for all signals that are in every frame.
    time: Vec<f64>,
    always: Vec<(usize, Vec<f64>)>,
    /// Signals that come by turns.
    multiplexed: Vec<(usize, Vec<f64>, Vec<f64>)>,
}

impl<'a> Collector<'a> {
    /// Of channels as [`FrameCounts::listing`] gave them.
    pub fn new(database: &'a Database, wanted: &[&SourceChannel]) -> Self {
        let mut of: HashMap<(usize, u16), Gathered> = HashMap::new();
        for channel in wanted {
            let [message, signal, bus] = channel.place;
            let Some(known) = database.messages.get(message).and_then(|m| m.signals.get(signal))
            else {
                continue;
            };
            let gathered = of.entry((message, bus as u16)).or_default();
            if known.is_multiplexed() {
                gathered.multiplexed.push((signal, Vec::new(), Vec::new()));
            } else {
                gathered.always.push((signal, Vec::new()));
            }
        }
        Collector { database, wanted: of }
    }

    /// One more frame.
    pub fn take(&mut self, frame: &Frame<'_>) {
        let Some(at) = self.database.find(frame.id, frame.extended) else { return };
        let Some(gathered) = self.wanted.get_mut(&(at, frame.bus)) else { return };
        let message = &self.database.messages[at];
        if !gathered.always.is_empty() {
            gathered.time.push(frame.time);
        }
        for (signal, values) in &mut gathered.always {
            values.push(message.value(*signal, frame.data).unwrap_or(f64::NAN));
        }
        for (signal, time, values) in &mut gathered.multiplexed {
            if let Some(value) = message.value(*signal, frame.data) {
                time.push(frame.time);
                values.push(value);
            }
        }
    }

    /// All that came, in the order of the channels asked for.
    pub fn columns(self, wanted: &[&SourceChannel]) -> Vec<Column> {
        type Series = (Arc<Vec<f64>>, Vec<f64>);
        let mut series: HashMap<[usize; 3], Series> = HashMap::new();
        for ((message, bus), gathered) in self.wanted {
            let place = |signal| [message, signal, usize::from(bus)];
            let time = Arc::new(gathered.time);
            for (signal, values) in gathered.always {
                series.insert(place(signal), (Arc::clone(&time), values));
            }
            for (signal, time, values) in gathered.multiplexed {
                series.insert(place(signal), (Arc::new(time), values));
            }
        }
        let column = |channel: &&SourceChannel| {
            let (time, values) = series.remove(&channel.place).unwrap_or_default();
            Column { name: channel.full(), time, values }
        };
        wanted.iter().map(column).collect()
    }
}
