//! A log as read, before anything is repaired.

use std::sync::Arc;

use crate::contract::channel::Channel;
use crate::contract::session::Meta;
use crate::contract::warning::Warning;

/// One channel as recorded, on its own clock.
#[derive(Debug, Clone)]
pub struct Track {
    /// The channel of `session.v1`.
    pub channel: Channel,
    /// Stamps as recorded, s: may repeat, jump back or jitter. Channels that were logged
    /// together share one clock.
    pub time: Arc<Vec<f64>>,
    /// SI values, NaN where there is none; as many as stamps.
    pub values: Vec<f64>,
}

/// A log as read: units are SI, the clocks are still the source's.
#[derive(Debug, Clone, Default)]
pub struct Raw {
    /// Session, bike, start time.
    pub meta: Meta,
    /// The channels.
    pub tracks: Vec<Track>,
    /// Damage and doubts that the reader found.
    pub warnings: Vec<Warning>,
    /// Whether velocities, accelerations and yaw are along the Euler yaw instead of the
    /// frame's trace on the road.
    pub euler_yaw: bool,
}

/// A column of a source as decoded, before any map.
#[derive(Debug, Clone)]
pub struct Column {
    /// Its name in the source.
    pub name: String,
    /// Its stamps, s.
    pub time: Arc<Vec<f64>>,
    /// Its numbers, NaN where there is none.
    pub values: Vec<f64>,
}
