//! MCAP: messages on topics, as robots and Foxglove log them.
//!
//! The numbers of a message become channels `topic/field.field`, on the clock of their topic: JSON,
//! and ROS 1 and ROS 2 (CDR) by the message definition in the file. Messages of other encodings
//! (protobuf, flatbuffer) are counted and said, not read. A ROS message's own stamp is taken where
//! it is of the same clock as the log's, the time of logging otherwise.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use self::fault::Fault;
use crate::contract::warning::Warning;
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::format::Format;
use crate::ingest::formats::format::Head;
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::ingest::raw::Column;
use crate::ingest::session_schema::session_meta;
use crate::ingest::warning::warning;
use crate::store::objects::Location;

mod fault;
mod json;
mod limits;
mod records;
mod ros;

use records::{Event, MAGIC, Scan};

pub(super) struct Mcap;

/// Messages of a topic that are looked at to learn its fields.
const LEARN: u64 = 20;
/// Most fields of a topic that become channels: those of no message of a logger are so many.
const MOST_FIELDS: usize = 4096;
/// A stamp that is as near to the time of logging is of the same clock, s.
const SAME_CLOCK: f64 = 10.0;

impl Format for Mcap {
    const NAME: &'static str = "mcap";
    const DESCRIPTION: &'static str =
        "MCAP with messages in JSON, ROS 1 or ROS 2 (CDR); not protobuf";
    const CHANNEL_NAMES: &'static str = "`topic/field.field`";
    const EXTENSIONS: &'static [&'static str] = &["mcap"];
    const MAPS: &'static [ShippedMap] = &[shipped_map!("session_mcap")];

    fn sniff(head: &Head<'_>) -> bool {
        head.bytes.starts_with(MAGIC)
    }

    fn list(log: &Location, _aids: &Aids) -> Result<Listing, Error> {
        let mut topics = Topics::default();
        let mut listing = Listing::default();
        let scan = records::each(log, &mut |event| match event {
            Event::Schema { .. } | Event::Channel { .. } => topics.define(event),
            Event::Metadata { name, entries } => {
                for (key, value) in entries {
                    if !session_meta(&mut listing.meta, &key, &value) {
                        listing.facts.push((format!("{name}: {key}"), value));
                    }
                }
            }
            Event::Message { channel, log_time, data } => topics.learn(channel, log_time, data),
        })?;
        if let Some(start) = topics.start {
            let stamp = jiff::Timestamp::from_nanosecond(i128::from(start));
            let start = stamp.ok().filter(|_| start > 1_000_000_000_000_000_000);
            listing.meta.start_time = start.map(|t| t.to_string()).or(listing.meta.start_time);
        }
        topics.list(&mut listing);
        listing.warnings.extend(damage(&scan));
        Ok(listing)
    }

    fn decode(log: &Location, _aids: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        let mut topics = Topics::default();
        let mut taken: HashMap<usize, Taken> = HashMap::new();
        for channel in wanted {
            let taken = taken.entry(channel.place[0]).or_default();
            let column = taken.values.len();
            if *taken.columns.entry(channel.name.clone()).or_insert(column) == column {
                taken.values.push(Vec::new());
            }
        }
        records::each(log, &mut |event| match event {
            Event::Message { channel, log_time, data } => {
                let start = *topics.start.get_or_insert(log_time);
                let (Some(taken), Some(topic)) =
                    (taken.get_mut(&usize::from(channel)), topics.topics.get(&channel))
                else {
                    return;
                };
                taken.message(&topic.decoder, log_time, start, data);
            }
            Event::Metadata { .. } => {}
            _ => topics.define(event),
        })?;
        let mut warnings = Vec::new();
        let mut series: HashMap<usize, (Arc<Vec<f64>>, Taken)> = HashMap::new();
        for (id, mut taken) in taken {
            if taken.bad > 0 {
                let topic = u16::try_from(id).ok().and_then(|id| topics.topics.get(&id));
                let name = topic.map_or("a topic", |t| t.name.as_str());
                let message =
                    format!("{name}: {} messages could not be read and are left out", taken.bad);
                warnings.push(warning("bad_message", None, taken.bad, None, message));
            }
            series.insert(id, (Arc::new(std::mem::take(&mut taken.time)), taken));
        }
        let column = |channel: &&SourceChannel| {
            let found = series.get(&channel.place[0]);
            let values = found.and_then(|(_, t)| Some(&t.values[*t.columns.get(&channel.name)?]));
            Column {
                name: channel.full(),
                time: found.map(|(time, _)| Arc::clone(time)).unwrap_or_default(),
                values: values.cloned().unwrap_or_default(),
            }
        };
        Ok(Decoded { columns: wanted.iter().map(column).collect(), warnings, ..Decoded::default() })
    }
}

fn damage(scan: &Scan) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if scan.bad_chunks > 0 {
        let message = format!(
            "{} blocks of messages are damaged and left out ({:.1} s in all)",
            scan.bad_chunks, scan.lost
        );
        warnings.push(warning("damaged", None, scan.bad_chunks, None, message));
    }
    if let Some(at) = scan.cut {
        let message = format!("the log is cut off or damaged at byte {at}; read up to there");
        warnings.push(warning("truncated", None, 1, None, message));
    }
    warnings
}

/// How the messages of a topic are read.
#[derive(Debug)]
enum Decoder {
    Json,
    Ros(ros::Definition),
    /// Not read, and why.
    None(String),
}

impl Decoder {
    /// Every number of a message by its path.
    fn numbers(&self, data: &[u8], take: &mut dyn FnMut(&str, f64)) -> Result<(), Fault> {
        match self {
            Decoder::Json => json::numbers(data, take),
            Decoder::Ros(definition) => definition.numbers(data, take),
            Decoder::None(_) => Ok(()),
        }
    }
}

#[derive(Debug)]
struct Topic {
    name: String,
    schema: String,
    decoder: Decoder,
    messages: u64,
    first: u64,
    last: u64,
    /// Paths of its numbers, as they came up first.
    fields: Vec<String>,
}

#[derive(Debug, Default)]
struct Topics {
    schemas: HashMap<u16, (String, String, Vec<u8>)>,
    topics: BTreeMap<u16, Topic>,
    /// Of the first message, ns.
    start: Option<u64>,
}

impl Topics {
    fn define(&mut self, event: Event<'_>) {
        match event {
            Event::Schema { id, name, encoding, data } => {
                self.schemas.insert(id, (name, encoding, data.to_vec()));
            }
            // every block of messages names its topics again
            Event::Channel { id, .. } if self.topics.contains_key(&id) => {}
            Event::Channel { id, topic, encoding, schema } => {
                let known = self.schemas.get(&schema);
                let decoder = decoder(&encoding, known);
                let schema = known.map(|(name, _, _)| name.clone()).unwrap_or_default();
                let topic = Topic {
                    name: topic,
                    schema,
                    decoder,
                    messages: 0,
                    first: 0,
                    last: 0,
                    fields: Vec::new(),
                };
                self.topics.insert(id, topic);
            }
            Event::Message { .. } | Event::Metadata { .. } => {}
        }
    }

    fn learn(&mut self, channel: u16, log_time: u64, data: &[u8]) {
        self.start.get_or_insert(log_time);
        let Some(topic) = self.topics.get_mut(&channel) else { return };
        if topic.messages == 0 {
            topic.first = log_time;
        }
        topic.last = log_time;
        topic.messages += 1;
        if topic.messages <= LEARN {
            let fields = &mut topic.fields;
            // what comes before the damage of a bad message counts
            let _ = topic.decoder.numbers(data, &mut |path, _| {
                if fields.len() < MOST_FIELDS && !fields.iter().any(|f| f == path) {
                    fields.push(path.to_owned());
                }
            });
        }
    }

    fn list(self, listing: &mut Listing) {
        for (id, topic) in self.topics {
            if let Decoder::None(why) = &topic.decoder {
                let text = format!("{} messages, {why}", topic.messages);
                listing.facts.push((topic.name, text));
                continue;
            }
            let span = topic.last.saturating_sub(topic.first) as f64 * 1e-9;
            let rate = (span > 0.0).then(|| (topic.messages - 1) as f64 / span);
            for field in topic.fields {
                listing.channels.push(SourceChannel {
                    group: topic.name.clone(),
                    unit: ros::unit(&topic.schema, &field).map(str::to_owned),
                    name: field,
                    samples: Some(topic.messages),
                    rate,
                    place: [usize::from(id), 0, 0],
                    twin: 0,
                });
            }
        }
    }
}

fn decoder(encoding: &str, schema: Option<&(String, String, Vec<u8>)>) -> Decoder {
    let definition = |wire| match schema {
        Some((name, _, text)) => match ros::Definition::parse(name, text, wire) {
            Ok(definition) => Decoder::Ros(definition),
            Err(e) => Decoder::None(format!("whose definition cannot be read: {e}")),
        },
        None => Decoder::None("without a definition".into()),
    };
    match (encoding, schema.map(|s| s.1.as_str())) {
        ("json", _) => Decoder::Json,
        ("cdr", Some("ros2msg")) => definition(ros::Wire::Cdr),
        ("ros1", Some("ros1msg")) => definition(ros::Wire::Ros1),
        (other, _) => Decoder::None(format!("in {other}, which roadbench does not read")),
    }
}

/// The wanted fields of one topic.
#[derive(Default)]
struct Taken {
    columns: HashMap<String, usize>,
    time: Vec<f64>,
    values: Vec<Vec<f64>>,
    bad: usize,
}

impl Taken {
    fn message(&mut self, decoder: &Decoder, log_time: u64, start: u64, data: &[u8]) {
        let row = self.time.len();
        let (columns, values) = (&self.columns, &mut self.values);
        let (mut seconds, mut nanoseconds) = (f64::NAN, 0.0);
        let read = decoder.numbers(data, &mut |path, value| {
            match path {
                "header.stamp.sec" => seconds = value,
                "header.stamp.nanosec" | "header.stamp.nsec" => nanoseconds = value,
                _ => {}
            }
            if let Some(column) = columns.get(path) {
                values[*column].resize(row, f64::NAN);
                values[*column].push(value);
            }
        });
        if read.is_err() {
            values.iter_mut().for_each(|v| v.truncate(row));
            self.bad += 1;
            return;
        }
        values.iter_mut().for_each(|v| v.resize(row + 1, f64::NAN));
        let logged = (i128::from(log_time) - i128::from(start)) as f64 * 1e-9;
        // whole seconds first: the sum would leave a double 0.2 us only
        let begin = (start / 1_000_000_000) as f64;
        let stamped = seconds - begin + (nanoseconds - (start % 1_000_000_000) as f64) * 1e-9;
        let same = (stamped - logged).abs() < SAME_CLOCK;
        self.time.push(if same { stamped } else { logged });
    }
}
