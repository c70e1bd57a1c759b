//! What formats with several sensors have in common: streams of channels that were sampled together, each on its own
//! clock. A format makes [`Streams`] of a log; what it lists and what it decodes follows.

use crate::contract::session::Meta;
use crate::contract::warning::Warning;
use crate::ingest::formats::csv::{clocks, start_time};
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::motion::track;
use crate::ingest::warning::warning;

/// The name of the speed that is computed where none was recorded.
pub(super) const COMPUTED: &str = "speed_from_positions";
/// Half the span of the computed speed, s: enough for 25 Hz whose positions are rounded to 1 cm.
const SPAN: f64 = 0.25;
/// Between positions that are further apart nothing was recorded, s.
const PAUSE: f64 = 5.0;
/// Streams of a log at most, and channels of a stream.
pub(super) const MAX_STREAMS: usize = 200;

/// A channel of a stream.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Line {
    /// As the log calls it.
    pub name: String,
    /// Unit of the numbers, where it is known.
    pub unit: Option<String>,
    /// As many as the stream's stamps; NaN where there is none.
    pub values: Vec<f64>,
}

/// Channels that were sampled together.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Stream {
    /// The sensor, message or sentence; empty where a log has only one.
    pub group: String,
    /// Stamps, s.
    pub time: Vec<f64>,
    pub lines: Vec<Line>,
}

/// A log as streams.
#[derive(Debug, Clone, Default)]
pub(super) struct Streams {
    /// In the order in which they are listed.
    pub all: Vec<Stream>,
    /// Session, bike and start time, as far as the log tells them.
    pub meta: Meta,
    pub facts: Vec<(String, String)>,
    /// Damage and doubts.
    pub warnings: Vec<Warning>,
}

impl Stream {
    /// A stream without channels.
    pub(super) fn new(group: &str) -> Self {
        Stream { group: group.to_owned(), ..Stream::default() }
    }

    /// The numbers of a channel, where it has one of this name.
    pub(super) fn get(&self, name: &str) -> Option<&[f64]> {
        self.lines.iter().find(|l| l.name == name).map(|l| l.values.as_slice())
    }

    /// Begins a row; its numbers follow by [`set`](Self::set).
    pub(super) fn begin(&mut self, time: f64) {
        self.time.push(time);
        self.lines.iter_mut().for_each(|l| l.values.push(f64::NAN));
    }

    /// A number of the last row. A channel that is new has none in the rows before; beyond [`MAX_STREAMS`] there are no new ones.
    pub(super) fn set(&mut self, name: &str, unit: Option<&str>, value: f64) {
        let rows = self.time.len();
        let at = self.lines.iter().position(|l| l.name == name).or_else(|| {
            (self.lines.len() < MAX_STREAMS).then(|| {
                let values = vec![f64::NAN; rows];
                self.lines.push(Line {
                    name: name.to_owned(),
                    unit: unit.map(str::to_owned),
                    values,
                });
                self.lines.len() - 1
            })
        });
        if let (Some(at), Some(row)) = (at, rows.checked_sub(1)) {
            self.lines[at].values[row] = value;
        }
    }

    /// Adds the speed along the positions (degrees, `north` and `east` by name), m/s, where no channel of `speeds` has a
    /// number; over pauses it does not reach.
    pub(super) fn add_speed(&mut self, [north, east]: [&str; 2], speeds: &[&str]) {
        let is_known =
            |name: &&str| self.get(name).is_some_and(|v| v.iter().any(|x| x.is_finite()));
        if speeds.iter().any(is_known) {
            return;
        }
        let (Some(north), Some(east)) = (self.get(north), self.get(east)) else { return };
        let (mut north, mut east) = (north.to_vec(), east.to_vec());
        track::without_fix(&mut north, &mut east);
        let fixed = |i: &usize| north[*i].is_finite() && east[*i].is_finite();
        let there: Vec<usize> = (0..self.time.len()).filter(fixed).collect();
        let mut values = vec![f64::NAN; self.time.len()];
        let near = |a: &usize, b: &usize| {
            let step = self.time[*b] - self.time[*a];
            step > 0.0 && step < PAUSE
        };
        for part in there.chunk_by(near) {
            let of = |from: &[f64]| part.iter().map(|i| from[*i]).collect::<Vec<f64>>();
            let speed = track::speed(&of(&self.time), [&of(&north), &of(&east)], SPAN);
            part.iter().zip(speed).for_each(|(i, v)| values[*i] = v);
        }
        self.lines.push(Line { name: COMPUTED.to_owned(), unit: Some("m/s".to_owned()), values });
    }
}

impl Streams {
    /// The stream of a group, made where there is none; the last of all where there would be too many.
    pub(super) fn group(&mut self, group: &str) -> &mut Stream {
        let at = self.all.iter().position(|s| s.group == group).unwrap_or_else(|| {
            if self.all.len() < MAX_STREAMS {
                self.all.push(Stream::new(group));
            }
            self.all.len() - 1
        });
        &mut self.all[at]
    }

    /// Whether no channel has a number.
    pub(super) fn is_empty(&self) -> bool {
        let mut values = self.all.iter().flat_map(|s| &s.lines).flat_map(|l| &l.values);
        !values.any(|v| v.is_finite())
    }

    /// The time at which the first sample was taken, where stamps count from 1970.
    pub(super) fn start_by_stamps(&mut self) {
        let stamps = self.all.iter().flat_map(|s| s.time.iter().copied());
        let first = stamps.filter(|t| t.is_finite()).fold(f64::INFINITY, f64::min);
        if let Some(start) = start_time(first) {
            self.meta.start_time.get_or_insert(start);
        }
    }

    /// A warning of something that was left out or is doubtful; nothing where `count` is 0.
    pub(super) fn warn(&mut self, code: &'static str, count: usize, message: String) {
        if count > 0 {
            self.warnings.push(warning(code, None, count, None, message));
        }
    }

    /// Contents of the log. Channels without any number are not listed.
    pub(super) fn listing(&self) -> Listing {
        let mut channels = Vec::new();
        for (at, stream) in self.all.iter().enumerate() {
            for (place, line) in stream.lines.iter().enumerate() {
                let samples = line.values.iter().filter(|v| v.is_finite()).count();
                if samples > 0 {
                    channels.push(SourceChannel {
                        group: stream.group.clone(),
                        name: line.name.clone(),
                        unit: line.unit.clone(),
                        samples: Some(samples as u64),
                        place: [at, place, 0],
                        ..SourceChannel::default()
                    });
                }
            }
        }
        Listing {
            channels,
            meta: self.meta.clone(),
            facts: self.facts.clone(),
            warnings: self.warnings.clone(),
            ..Listing::default()
        }
    }

    /// The wanted channels. What a stream has more seldom than its rows is on a clock of its own.
    pub(super) fn decoded(mut self, wanted: &[&SourceChannel]) -> Decoded {
        let mut columns = Vec::with_capacity(wanted.len());
        for (at, stream) in self.all.iter_mut().enumerate() {
            let of_stream = wanted.iter().enumerate().filter(|(_, c)| c.place[0] == at);
            let (places, lines): (Vec<usize>, Vec<(String, Vec<f64>)>) = of_stream
                .filter_map(|(k, c)| {
                    Some((k, (c.full(), stream.lines.get(c.place[1])?.values.clone())))
                })
                .unzip();
            let time = std::mem::take(&mut stream.time);
            columns.extend(places.into_iter().zip(clocks::separate(time, lines, |_, _| false)));
        }
        columns.sort_by_key(|(k, _)| *k);
        Decoded { columns: columns.into_iter().map(|(_, c)| c).collect(), ..Decoded::default() }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    fn stream() -> Stream {
        let mut stream = Stream::new("gps");
        for i in 0..40 {
            stream.begin(f64::from(i));
            stream.set("lat", Some("deg"), 45.0 + 1e-4 * f64::from(i));
            stream.set("lon", Some("deg"), 9.0);
            if i % 4 == 0 {
                stream.set("seldom", None, f64::from(i));
            }
        }
        stream
    }

    #[test]
    fn channels_keep_their_clocks() {
        let mut streams =
            Streams { all: vec![stream(), Stream::new("empty")], ..Streams::default() };
        streams.group("other").begin(0.5);
        streams.group("other").set("x", None, 2.0);
        let listing = streams.listing();
        let names: Vec<String> = listing.channels.iter().map(SourceChannel::full).collect();
        assert_eq!(names, ["gps/lat", "gps/lon", "gps/seldom", "other/x"]);
        let wanted = [3, 2, 0, 1].map(|i| &listing.channels[i]);
        let columns = streams.decoded(&wanted).columns;
        let names: Vec<&str> = columns.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["other/x", "gps/seldom", "gps/lat", "gps/lon"]);
        assert_eq!(
            (columns[1].time.len(), columns[1].values[1], columns[0].time[0]),
            (10, 4.0, 0.5)
        );
        assert!(Arc::ptr_eq(&columns[2].time, &columns[3].time));
    }

    #[test]
    fn a_speed_is_computed_where_none_was_recorded_and_not_over_a_pause() {
        let mut ride = stream();
        ride.time.iter_mut().skip(20).for_each(|t| *t += 600.0);
        ride.lines[0].values[30] = 0.0;
        ride.lines[1].values[30] = 0.0;
        ride.add_speed(["lat", "lon"], &["speed"]);
        let speed = ride.get(COMPUTED).expect("computed");
        for (i, v) in speed.iter().enumerate() {
            let far = (v - 11.11).abs() > 0.05;
            assert!(v.is_nan() == (i == 30) && !far, "{i}: {v}");
        }
        let mut ride = stream();
        ride.set("speed", Some("m/s"), 3.0);
        ride.add_speed(["lat", "lon"], &["speed"]);
        assert_eq!(ride.get(COMPUTED), None);
    }
}
