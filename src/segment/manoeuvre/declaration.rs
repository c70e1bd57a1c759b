//! What is declared of a kind of manoeuvre, by the file that finds it.

use serde::{Deserialize, Serialize};

/// Where a kind is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Terrain {
    /// In rides with a road pipeline.
    Road,
    /// In rides with an off-road pipeline.
    OffRoad,
    Both,
}

/// Course of the road during a manoeuvre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Course {
    /// Straight: its direction is [`Direction::Outbound`] or [`Direction::Inbound`].
    Straight,
    /// Corner: its direction is [`Direction::Left`] or [`Direction::Right`].
    Bend,
    /// Any, so without a direction.
    Any,
}

/// The figure that describes a manoeuvre in a list of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Peak {
    /// Forward acceleration of the largest magnitude, m/s².
    Acceleration,
    /// Roll angle of the largest magnitude, degrees.
    Roll,
    /// Time in the air, s, and the loads of the landing, kN.
    Flight,
}

/// All that is known of a kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Declaration {
    /// In the tables, snake case.
    pub name: &'static str,
    /// On pages and in the terminal.
    pub words: &'static str,
    /// A sentence for the reference.
    pub description: &'static str,
    /// On the time line, where there is room; empty: none.
    pub letter: &'static str,
    /// Letters of left and right manoeuvres, where they differ from one another.
    pub letter_by_side: Option<[&'static str; 2]>,
    /// Colour on light ground, `#rrggbb`, in static figures too.
    pub colour: &'static str,
    /// Colour on dark ground, `#rrggbb`.
    pub colour_dark: &'static str,
    /// Where it is looked for.
    pub terrain: Terrain,
    /// Course of the road.
    pub course: Course,
    /// Whether the front and the rear brake are on.
    pub brakes: [bool; 2],
    /// Its figure in a list of manoeuvres.
    pub peak: Peak,
    /// Place in the table of off-road forces, from 0; `None` has no row there.
    pub force_row: Option<usize>,
}

impl Declaration {
    /// Whether a brake is on.
    pub fn is_braking(&self) -> bool {
        self.brakes != [false; 2]
    }

    /// Whether the road is straight.
    pub fn is_straight(&self) -> bool {
        self.course == Course::Straight
    }
}

/// Side of a corner, or way along the road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// A left-hand corner.
    Left,
    /// A right-hand corner.
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
