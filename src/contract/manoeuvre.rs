//! Kinds of manoeuvre and directions of riding.
//!
//! Each kind is declared once, in the list below: its name in the tables, its words, letter and
//! colours on the pages, and what the stages have to know of it. Whatever lists kinds (segments,
//! pages, figures, the terminal, the book) reads the list; what finds them is in
//! [`segment`](crate::segment).

use serde::{Deserialize, Serialize};

/// Where a kind is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Terrain {
    /// In rides with a road pipeline.
    Road,
    /// In rides with an off-road pipeline.
    OffRoad,
    /// In both.
    Both,
}

/// Course of the road during a manoeuvre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Course {
    /// Straight: its direction is [`Direction::Outbound`] or [`Direction::Inbound`].
    Straight,
    /// Bend: its direction is [`Direction::Left`] or [`Direction::Right`].
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
    /// The kind.
    pub kind: ManoeuvreKind,
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

macro_rules! kinds {
    ($($(#[doc = $description:literal])+ $variant:ident { $($field:ident: $value:expr),* $(,)? })*) => {
        /// What the rider was doing.
        #[derive(
            Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
        )]
        #[serde(rename_all = "snake_case")]
        pub enum ManoeuvreKind {
            $($(#[doc = $description])+ $variant),*
        }

        impl ManoeuvreKind {
            /// Every kind, in the order of the declarations.
            pub const ALL: &'static [ManoeuvreKind] = &[$(ManoeuvreKind::$variant),*];
        }

        /// Every declaration, in the order of [`ManoeuvreKind::ALL`].
        static DECLARATIONS: &[Declaration] = &[$(Declaration {
            kind: ManoeuvreKind::$variant,
            description: concat!($($description),+).trim_ascii(),
            $($field: $value),*
        }),*];
    };
}

kinds! {
    /// In neutral, no brake, straight.
    Coasting {
        name: "coasting",
        words: "coasting",
        letter: "C",
        letter_by_side: None,
        colour: "#6b7f93",
        colour_dark: "#8fa3b8",
        terrain: Terrain::Road,
        course: Course::Straight,
        brakes: [false, false],
        peak: Peak::Acceleration,
        force_row: None,
    }
    /// Front brake only, straight.
    FrontBraking {
        name: "front_braking",
        words: "front braking",
        letter: "F",
        letter_by_side: None,
        colour: "#c0392b",
        colour_dark: "#e2695c",
        terrain: Terrain::Both,
        course: Course::Straight,
        brakes: [true, false],
        peak: Peak::Acceleration,
        force_row: Some(3),
    }
    /// Rear brake only, straight.
    RearBraking {
        name: "rear_braking",
        words: "rear braking",
        letter: "R",
        letter_by_side: None,
        colour: "#d98324",
        colour_dark: "#e8a555",
        terrain: Terrain::Both,
        course: Course::Straight,
        brakes: [false, true],
        peak: Peak::Acceleration,
        force_row: Some(4),
    }
    /// Both brakes, straight.
    CombinedBraking {
        name: "combined_braking",
        words: "combined braking",
        letter: "FR",
        letter_by_side: None,
        colour: "#8e44ad",
        colour_dark: "#b27fd0",
        terrain: Terrain::Both,
        course: Course::Straight,
        brakes: [true, true],
        peak: Peak::Acceleration,
        force_row: Some(5),
    }
    /// Under engine power, straight.
    Driving {
        name: "driving",
        words: "driving",
        letter: "D",
        letter_by_side: None,
        colour: "#2e8b57",
        colour_dark: "#5fb98a",
        terrain: Terrain::Both,
        course: Course::Straight,
        brakes: [false, false],
        peak: Peak::Acceleration,
        force_row: Some(6),
    }
    /// Leaning steadily in a bend; off-road from the braking before its slowest point to the end
    /// of the drive after it.
    Cornering {
        name: "cornering",
        words: "cornering",
        letter: "\u{21b6}\u{21b7}",
        letter_by_side: Some(["\u{21b6}", "\u{21b7}"]),
        colour: "#2472b3",
        colour_dark: "#5aa3de",
        terrain: Terrain::Both,
        course: Course::Bend,
        brakes: [false, false],
        peak: Peak::Roll,
        force_row: Some(2),
    }
    /// Both wheels off the ground.
    Airborne {
        name: "airborne",
        words: "airborne",
        letter: "A",
        letter_by_side: None,
        colour: "#0f8b8d",
        colour_dark: "#45b5b7",
        terrain: Terrain::OffRoad,
        course: Course::Any,
        brakes: [false, false],
        peak: Peak::Flight,
        force_row: Some(0),
    }
    /// Over waves close together.
    Whoops {
        name: "whoops",
        words: "whoops",
        letter: "W",
        letter_by_side: None,
        colour: "#8d6e4b",
        colour_dark: "#b8977a",
        terrain: Terrain::OffRoad,
        course: Course::Any,
        brakes: [false, false],
        peak: Peak::Acceleration,
        force_row: Some(1),
    }
    /// Anything else, standing included.
    Other {
        name: "other",
        words: "other",
        letter: "",
        letter_by_side: None,
        colour: "#b4bac1",
        colour_dark: "#5b6470",
        terrain: Terrain::Both,
        course: Course::Any,
        brakes: [false, false],
        peak: Peak::Acceleration,
        force_row: None,
    }
}

impl ManoeuvreKind {
    /// What is declared of it.
    pub fn declaration(self) -> &'static Declaration {
        &DECLARATIONS[self as usize]
    }

    /// As in the tables.
    pub fn name(self) -> &'static str {
        self.declaration().name
    }

    /// The kind of that name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|k| k.name() == name)
    }

    /// Whether a brake is on.
    pub fn is_braking(self) -> bool {
        self.declaration().brakes != [false; 2]
    }

    /// Whether the road is straight.
    pub fn is_straight(self) -> bool {
        self.declaration().course == Course::Straight
    }

    /// Whether it is looked for on the road, [`ManoeuvreKind::Other`] included.
    pub fn is_on_road(self) -> bool {
        self.declaration().terrain != Terrain::OffRoad
    }

    /// Whether it is looked for off the road, [`ManoeuvreKind::Other`] included.
    pub fn is_off_road(self) -> bool {
        self.declaration().terrain != Terrain::Road
    }
}

/// Side of a bend, or way along the road.
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_declaration_is_at_its_kind_and_unlike_the_others() {
        let (mut names, mut colours) = (BTreeSet::new(), BTreeSet::new());
        for (i, kind) in ManoeuvreKind::ALL.iter().enumerate() {
            let d = kind.declaration();
            assert_eq!((d.kind, *kind as usize), (*kind, i));
            assert_eq!(serde_json::to_string(kind).ok(), Some(format!("{:?}", d.name)));
            assert_eq!(ManoeuvreKind::from_name(d.name), Some(*kind));
            assert!(names.insert(d.name) && !d.words.is_empty() && d.description.ends_with('.'));
            for colour in [d.colour, d.colour_dark] {
                let digits = colour.strip_prefix('#').expect("a colour");
                assert!(digits.len() == 6 && u32::from_str_radix(digits, 16).is_ok(), "{colour}");
            }
            assert!(colours.insert((0, d.colour)) && colours.insert((1, d.colour_dark)));
        }
        let mut rows: Vec<usize> =
            ManoeuvreKind::ALL.iter().filter_map(|k| k.declaration().force_row).collect();
        rows.sort_unstable();
        assert_eq!(rows, (0..rows.len()).collect::<Vec<_>>());
    }
}
