//! CAN logs: Vector BLF and ASC, and candump's text. What the frames mean is told by CAN
//! databases (DBC), which the channel map names.
//!
//! Channels are `Message/Signal` (or `Message.Signal`), each message on its own clock, each
//! multiplexed signal too. A message that came over several buses is `Message@1`, `Message@2`.
//! The readers are our own because a log with broken frames must be read on behind them, from
//! wherever it is, and its claims of length must not be believed.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use crate::ingest::foreign::{Aids, Decoded, Format, Listing, SourceChannel};
use crate::ingest::map::Column;
use crate::ingest::{Error, Head, warning};
use crate::objects::Location;

mod bits;
mod blf;
pub(super) mod database;
mod frames;
mod text;

use database::Database;
pub use frames::Frame;

/// The format.
pub struct Can;

impl Format for Can {
    const NAME: &'static str = "can";

    fn sniff(head: &Head<'_>) -> bool {
        frames::kind(head.bytes).is_some()
    }

    fn list(log: &Location, aids: &Aids) -> Result<Listing, Error> {
        let database = Database::read(aids)?;
        let mut census = Census::default();
        let scan = frames::each(log, &mut |frame| census.count(frame))?;
        let mut listing = census.listing(&database);
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
        Ok(Decoded { columns: collector.columns(wanted), warnings: Vec::new() })
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

/// How often each identifier came, and when.
#[derive(Debug, Default)]
pub struct Census {
    seen: BTreeMap<(u32, bool, u16), Seen>,
}

#[derive(Debug)]
struct Seen {
    count: u64,
    first: f64,
    last: f64,
    length: usize,
}

impl Census {
    /// One more frame.
    pub fn count(&mut self, frame: &Frame<'_>) {
        let key = (frame.id, frame.extended, frame.bus);
        let new = Seen { count: 0, first: frame.time, last: frame.time, length: 0 };
        let seen = self.seen.entry(key).or_insert(new);
        seen.count += 1;
        seen.last = frame.time;
        seen.length = seen.length.max(frame.data.len());
    }

    /// The channels that the databases see in what was counted.
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
                    shown(id, extended),
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
fn shown(id: u32, extended: bool) -> String {
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
    /// Of channels as [`Census::listing`] gave them.
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
