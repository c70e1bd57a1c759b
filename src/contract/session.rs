//! One riding session in memory: who, when, on what, and its channels on one clock.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::channel::Channel;

/// Identity of a session; written to every table.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// Unique name of the session.
    pub session_id: String,
    /// Names the bike file `<bikes>/<bike_id>.toml`.
    pub bike_id: String,
    /// RFC 3339, as the source gives it.
    pub start_time: Option<String>,
    /// Tyre model on the front wheel, where known.
    pub tyre_front: Option<String>,
    /// Tyre model on the rear wheel, where known.
    pub tyre_rear: Option<String>,
    /// Where it was ridden.
    pub site: Option<String>,
    /// Id of the rider.
    pub rider_id: Option<String>,
}

/// The logger's own laps.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Markers {
    /// When it passed its start line, s, in the order of the log, as recorded: they may lie outside of the ride, be
    /// doubled or belong to another line. In a log as read they are on the clock of its stamps, in a session they count
    /// from its start. A logger writes them to a millisecond or to its sample; what they are worth is not in the log.
    pub times: Vec<f64>,
    /// Its start line from one end to the other, latitude and longitude, degrees.
    pub line: Option<[[f64; 2]; 2]>,
}

/// Channels on one uniform clock. A missing sample is NaN; an absent channel is `None`. A clone shares its channels with
/// the original until one of the two changes them.
#[derive(Debug, Clone)]
pub struct Session {
    /// Who, when, on what.
    pub meta: Meta,
    /// Sampling rate, Hz.
    pub rate: f64,
    /// Number of samples; sample `i` is at `i / rate` seconds.
    pub len: usize,
    /// How far the scales of the wheel speeds, front and rear, may be off: a share, one standard deviation. Zero where
    /// the log measures turns.
    pub wheel_scale_sd: [f64; 2],
    /// Time between two measured samples of the forward velocity, s: samples between them are interpolated. 0 where
    /// that is not known.
    pub velocity_spacing: f64,
    /// The logger's own laps, s since the start.
    pub markers: Markers,
    /// Channels that other channels contradict and that stay all the same, with what was seen: no coefficient that
    /// depends on one of them is determined.
    pub contradicted: Vec<(Channel, String)>,
    columns: Vec<Option<Arc<Vec<f64>>>>,
}

impl Session {
    /// An empty session of `len` samples at `rate` Hz.
    pub fn new(meta: Meta, rate: f64, len: usize) -> Self {
        Session {
            meta,
            rate,
            len,
            wheel_scale_sd: [0.0; 2],
            velocity_spacing: 0.0,
            markers: Markers::default(),
            contradicted: Vec::new(),
            columns: vec![None; Channel::COUNT],
        }
    }

    /// Whether the forward velocity was measured less often than the session has samples.
    pub fn velocity_is_interpolated(&self) -> bool {
        self.velocity_spacing * self.rate > 1.5
    }

    /// The samples of a channel, SI units, NaN where there is none.
    pub fn get(&self, channel: Channel) -> Option<&[f64]> {
        self.columns[channel as usize].as_deref().map(Vec::as_slice)
    }

    /// The samples of a channel, to change them in place.
    pub fn get_mut(&mut self, channel: Channel) -> Option<&mut Vec<f64>> {
        self.columns[channel as usize].as_mut().map(Arc::make_mut)
    }

    /// Whether the session has the channel at all.
    pub fn has(&self, channel: Channel) -> bool {
        self.columns[channel as usize].is_some()
    }

    /// Puts a channel in.
    ///
    /// # Panics
    /// If `samples` is not `len` long: a caller's mistake, never the input's.
    pub fn set(&mut self, channel: Channel, samples: Vec<f64>) {
        assert_eq!(samples.len(), self.len, "channel {channel}: wrong length");
        self.columns[channel as usize] = Some(Arc::new(samples));
    }

    /// Takes a channel out.
    pub fn remove(&mut self, channel: Channel) -> Option<Vec<f64>> {
        self.columns[channel as usize].take().map(Arc::unwrap_or_clone)
    }

    /// The channels that are there, in schema order.
    pub fn channels(&self) -> impl Iterator<Item = Channel> + '_ {
        Channel::ALL.iter().copied().filter(|&c| self.has(c))
    }

    /// Time of sample `i` since the start, s.
    pub fn time(&self, i: usize) -> f64 {
        i as f64 / self.rate
    }

    /// Length of the session, s.
    pub fn duration(&self) -> f64 {
        self.len as f64 / self.rate
    }
}
