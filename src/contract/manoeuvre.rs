//! Kinds of manoeuvre and directions of riding.

use serde::{Deserialize, Serialize};

/// What the rider was doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ManoeuvreKind {
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
    /// Both wheels off the ground.
    Airborne,
    /// Over waves close together.
    Whoops,
    /// Anything else, standing included.
    Other,
}

impl ManoeuvreKind {
    /// Every kind.
    pub const ALL: [ManoeuvreKind; 9] = [
        ManoeuvreKind::Coasting,
        ManoeuvreKind::FrontBraking,
        ManoeuvreKind::RearBraking,
        ManoeuvreKind::CombinedBraking,
        ManoeuvreKind::Driving,
        ManoeuvreKind::Cornering,
        ManoeuvreKind::Airborne,
        ManoeuvreKind::Whoops,
        ManoeuvreKind::Other,
    ];

    /// As in the tables.
    pub fn name(self) -> &'static str {
        match self {
            ManoeuvreKind::Coasting => "coasting",
            ManoeuvreKind::FrontBraking => "front_braking",
            ManoeuvreKind::RearBraking => "rear_braking",
            ManoeuvreKind::CombinedBraking => "combined_braking",
            ManoeuvreKind::Driving => "driving",
            ManoeuvreKind::Cornering => "cornering",
            ManoeuvreKind::Airborne => "airborne",
            ManoeuvreKind::Whoops => "whoops",
            ManoeuvreKind::Other => "other",
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
