//! A log as read, before anything is repaired.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::contract::channel::Channel;
use crate::contract::session::{Markers, Meta};
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

/// Whose log it is, and by which channel map.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Identified {
    /// Session, bike, start time.
    pub meta: Meta,
    /// Name of the channel map that is taken for it; none where it is `session.v1` already.
    pub map: Option<String>,
}

/// A log as read: units are SI, the clocks are still the source's.
#[derive(Debug, Clone, Default)]
pub struct Raw {
    /// Session, bike, start time.
    pub meta: Meta,
    /// Name of the channel map that it was read by; none where it is `session.v1` already.
    pub map: Option<String>,
    /// Channels in SI units, each on its own clock.
    pub tracks: Vec<Track>,
    /// Damage and doubts that the reader found.
    pub warnings: Vec<Warning>,
    /// Whether velocities, accelerations and yaw are along the Euler yaw instead of the
    /// frame's trace on the road.
    pub euler_yaw: bool,
    /// Known properties of an inertial unit that is fixed to the frame.
    pub imu: Imu,
    /// How far the scales of the wheel speeds, front and rear, may be off: a share, one standard deviation.
    pub wheel_scale_sd: [f64; 2],
    /// Time between two measured samples of the forward velocity, s, where the log was interpolated before; 0 where
    /// it was not, or nothing is known.
    pub velocity_spacing: f64,
    /// The stamp at which the log's start time holds, s on the clock of the tracks, where that is known.
    pub zero: Option<f64>,
    /// The logger's own laps, s on the clock of the tracks' stamps.
    pub markers: Markers,
}

/// Settings of a channel map for an inertial unit that is fixed to the frame any way round, and of the satellite
/// receiver beside it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Imu {
    /// From the unit to the centre of mass, forward, left and up on the upright motorcycle, m.
    pub arm: Option<[f64; 3]>,
    /// Standard deviation of each part, m.
    pub arm_sd: Option<f64>,
    /// How late the receiver's stamps are after the unit's, s, where it is known; else it is looked for.
    pub delay: Option<f64>,
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
