//! A session cut into manoeuvres.

use serde::{Deserialize, Serialize};

use crate::bike::Bike;
use crate::session::Session;

/// Settings of the stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Below this speed nothing is segmented, m/s.
    pub min_speed: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config { min_speed: 2.0 }
    }
}

/// What the rider was doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// In neutral, no brake, straight.
    Coasting,
    /// Front brake only, straight.
    FrontBraking,
    /// Rear brake only, straight.
    RearBraking,
    /// Both brakes, straight.
    CombinedBraking,
    /// Under engine power, straight.
    Driving,
    /// Leaning steadily in a bend.
    Cornering,
    /// Anything else, standing included.
    Other,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Kind; 7] = [
        Kind::Coasting,
        Kind::FrontBraking,
        Kind::RearBraking,
        Kind::CombinedBraking,
        Kind::Driving,
        Kind::Cornering,
        Kind::Other,
    ];

    /// As in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Coasting => "coasting",
            Kind::FrontBraking => "front_braking",
            Kind::RearBraking => "rear_braking",
            Kind::CombinedBraking => "combined_braking",
            Kind::Driving => "driving",
            Kind::Cornering => "cornering",
            Kind::Other => "other",
        }
    }
}

/// Which way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// A left-hand bend.
    Left,
    /// A right-hand bend.
    Right,
    /// Straight, along the session's first straight heading.
    Outbound,
    /// Straight, the other way.
    Inbound,
}

impl Direction {
    /// As in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Direction::Left => "left",
            Direction::Right => "right",
            Direction::Outbound => "outbound",
            Direction::Inbound => "inbound",
        }
    }
}

/// One manoeuvre: samples `start..end` of the session.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// What.
    pub kind: Kind,
    /// First sample.
    pub start: usize,
    /// One past the last sample.
    pub end: usize,
    /// Which way, where it can be told.
    pub direction: Option<Direction>,
    /// 0 (unusable) to 1.
    pub quality: f64,
    /// Whether estimation may use it.
    pub used: bool,
    /// Why not.
    pub reason: Option<String>,
}

/// Cuts a filtered session into segments, in time order, none overlapping.
pub fn run(_session: &Session, _bike: &Bike, _config: &Config) -> Vec<Segment> {
    Vec::new()
}
