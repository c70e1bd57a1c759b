//! From frames to signals, by the CAN databases.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::database::Database;
use super::frame::Frame;
use crate::ingest::formats::listing::{Listing, SourceChannel};
use crate::ingest::raw::Column;

/// How often each identifier came, and when.
#[derive(Debug, Default)]
pub(crate) struct FrameCounts {
    seen: BTreeMap<(u32, bool, u16), FrameCount>,
}

#[derive(Debug, Clone)]
struct FrameCount {
    count: u64,
    first: f64,
    last: f64,
    length: usize,
}

impl FrameCounts {
    pub(crate) fn count(&mut self, frame: &Frame<'_>) {
        let key = (frame.id, frame.extended, frame.bus);
        let new = FrameCount { count: 0, first: frame.time, last: frame.time, length: 0 };
        let seen = self.seen.entry(key).or_insert(new);
        seen.count += 1;
        seen.last = frame.time;
        seen.length = seen.length.max(frame.data.len());
    }

    /// The signals that the databases define for the counted frames.
    pub(crate) fn listing(&self, database: &Database) -> Listing {
        let mut listing = Listing::default();
        let (mut unknown, mut guessed) = (Vec::new(), Vec::new());
        // messages by who sent them and over which bus, in the order of their identifiers
        let mut streams: Vec<(usize, Option<u8>, u16, FrameCount)> = Vec::new();
        for (&(id, extended, bus), seen) in &self.seen {
            let Some(found) = database.find(id, extended) else {
                let rate = seen.rate().map(|r| format!(" at {r:.1} Hz")).unwrap_or_default();
                unknown.push(format!(
                    "{} ({} frames{rate}, {} bytes)",
                    hex_id(id, extended),
                    seen.count,
                    seen.length
                ));
                continue;
            };
            let name = &database.messages[found.message].name;
            if !found.said {
                guessed.push(format!("{} as {name}", hex_id(id, extended)));
            }
            let (message, source) = (found.message, found.source);
            match streams.iter_mut().find(|s| (s.0, s.1, s.2) == (message, source, bus)) {
                Some((.., known)) => known.add(seen),
                None => streams.push((message, source, bus, seen.clone())),
            }
        }
        for &(at, source, bus, ref seen) in &streams {
            let message = &database.messages[at];
            let others = || streams.iter().filter(|s| s.0 == at);
            let mut group = message.name.clone();
            if let Some(source) = source.filter(|_| others().any(|s| s.1 != source)) {
                group += &format!(" from {source}");
            }
            if others().any(|s| s.1 == source && s.2 != bus) {
                group += &format!("@{bus}");
            }
            for (i, signal) in message.signals.iter().enumerate() {
                let always = !signal.is_multiplexed();
                listing.channels.push(SourceChannel {
                    group: group.clone(),
                    name: signal.name.clone(),
                    unit: signal.unit.clone(),
                    samples: Some(seen.count),
                    rate: seen.rate().filter(|_| always),
                    place: [at, i, stream(source, bus)],
                    twin: 0,
                });
            }
        }
        for (what, mut ids) in
            [("in no database", unknown), ("taken for J1939, by the parameter group", guessed)]
        {
            if !ids.is_empty() {
                let more = ids.len().saturating_sub(40);
                ids.truncate(40);
                let more = if more > 0 { format!(" and {more} more") } else { String::new() };
                listing.facts.push((what.into(), ids.join(", ") + &more));
            }
        }
        listing
    }
}

impl FrameCount {
    /// Hz, if there is more than one.
    fn rate(&self) -> Option<f64> {
        let span = self.last - self.first;
        (span > 0.0).then(|| (self.count - 1) as f64 / span)
    }

    fn add(&mut self, other: &FrameCount) {
        self.count += other.count;
        self.first = self.first.min(other.first);
        self.last = self.last.max(other.last);
        self.length = self.length.max(other.length);
    }
}

/// Bus and source in a number: the source counts from 1, and 0 is none.
fn stream(source: Option<u8>, bus: u16) -> usize {
    usize::from(bus) + source.map_or(0, |s| (usize::from(s) + 1) << 20)
}

/// An identifier as people write it.
fn hex_id(id: u32, extended: bool) -> String {
    if extended { format!("0x{id:08X}") } else { format!("0x{id:03X}") }
}

/// The wanted signals of the frames that come by.
pub(crate) struct Collector<'a> {
    database: &'a Database,
    /// By message and [`stream`].
    wanted: HashMap<(usize, usize), Gathered>,
}

/// Wanted signals of one message.
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
    pub(crate) fn new(database: &'a Database, wanted: &[&SourceChannel]) -> Self {
        let mut of: HashMap<(usize, usize), Gathered> = HashMap::new();
        for channel in wanted {
            let [message, signal, stream] = channel.place;
            let Some(known) = database.messages.get(message).and_then(|m| m.signals.get(signal))
            else {
                continue;
            };
            let gathered = of.entry((message, stream)).or_default();
            if known.is_multiplexed() {
                gathered.multiplexed.push((signal, Vec::new(), Vec::new()));
            } else {
                gathered.always.push((signal, Vec::new()));
            }
        }
        Collector { database, wanted: of }
    }

    pub(crate) fn take(&mut self, frame: &Frame<'_>) {
        let Some(found) = self.database.find(frame.id, frame.extended) else { return };
        let key = (found.message, stream(found.source, frame.bus));
        let Some(gathered) = self.wanted.get_mut(&key) else { return };
        let message = &self.database.messages[found.message];
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
    pub(crate) fn columns(self, wanted: &[&SourceChannel]) -> Vec<Column> {
        type Series = (Arc<Vec<f64>>, Vec<f64>);
        let mut series: HashMap<[usize; 3], Series> = HashMap::new();
        for ((message, stream), gathered) in self.wanted {
            let place = |signal| [message, signal, stream];
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
