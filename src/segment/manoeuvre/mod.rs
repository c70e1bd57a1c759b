//! Kinds of manoeuvre: what each is, and what finds it in a ride.
//!
//! A kind is a file and its lines here. The file holds its [`Declaration`] (name in the tables, words,
//! letter and colours on the pages, what the stages have to know of it), its thresholds and what finds it:
//! on the road a [`Detector`], which looks at a few signals on a coarse clock ([`features`]), off the road
//! a function of 50 Hz means ([`means`]). Here it stands in the list of kinds, with its thresholds in
//! [`Config`] and at its place in the order of claims ([`Config::detectors`], [`OFF_ROAD`]). Whatever lists
//! kinds (segments, pages, figures, the terminal, the book) reads the list;
//! [`segment`](crate::segment) cuts the ride by the claims.

use serde::{Deserialize, Serialize};

use detector::{Claim, Detector};
use means::Means;

pub(crate) mod airborne;
pub(crate) mod braking;
mod changing_lean;
pub(crate) mod coasting;
pub(crate) mod cornering;
mod corners;
mod course;
pub(crate) mod declaration;
pub(crate) mod detector;
pub(crate) mod driving;
pub(crate) mod engine;
pub(crate) mod features;
mod mask;
pub(crate) mod means;
pub(crate) mod offroad;
pub(crate) mod rolling;
pub(crate) mod slip;
pub(crate) mod standing;
mod straights;
mod whoops;

pub(crate) use declaration::{Course, Declaration, Direction, Peak, Terrain};

macro_rules! kinds {
    ($($variant:ident: $file:ident::$declaration:ident,)+) => {
        /// Manoeuvre of the rider.
        #[derive(
            Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
        )]
        #[serde(rename_all = "snake_case")]
        pub enum ManoeuvreKind {
            $(
                #[doc = concat!("As `src/segment/manoeuvre/", stringify!($file), ".rs` declares it.")]
                $variant,
            )+
        }

        impl ManoeuvreKind {
            /// Every kind, in the order of the list.
            pub const ALL: &'static [ManoeuvreKind] = &[$(ManoeuvreKind::$variant),+];
        }

        /// Every declaration, in the order of [`ManoeuvreKind::ALL`].
        static DECLARATIONS: &[&Declaration] = &[$(&$file::$declaration),+];
    };
}

kinds! {
    Coasting: coasting::COASTING,
    FrontBraking: braking::FRONT_BRAKING,
    RearBraking: braking::REAR_BRAKING,
    CombinedBraking: braking::COMBINED_BRAKING,
    Driving: driving::DRIVING,
    Cornering: cornering::CORNERING,
    Airborne: airborne::AIRBORNE,
    Whoops: whoops::WHOOPS,
    ChangingLean: changing_lean::CHANGING_LEAN,
    Other: standing::OTHER,
}

/// Thresholds of every kind: settings of the stage [`segment`](crate::segment).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Below this speed nothing begins, m/s.
    pub min_speed: f64,
    /// Below this speed everything ends, m/s.
    pub end_speed: f64,
    pub cornering: cornering::Config,
    pub braking: braking::Config,
    pub coasting: coasting::Config,
    pub driving: driving::Config,
    /// Off-road manoeuvres.
    pub offroad: offroad::Config,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            min_speed: 2.0,
            end_speed: 0.5,
            cornering: cornering::Config::default(),
            braking: braking::Config::default(),
            coasting: coasting::Config::default(),
            driving: driving::Config::default(),
            offroad: offroad::Config::default(),
        }
    }
}

impl Config {
    /// Detectors of manoeuvres on the road, the strongest claim first; the last claims all that is left.
    pub fn detectors(&self) -> Vec<Box<dyn Detector + '_>> {
        let Config { min_speed, end_speed, cornering, braking, coasting, driving, .. } = self;
        vec![
            Box::new(standing::NoVelocity),
            Box::new(standing::Standing { min_speed: *min_speed, end_speed: *end_speed }),
            Box::new(cornering.clone()),
            Box::new(rolling::Rolling(cornering)),
            Box::new(braking.clone()),
            Box::new(coasting.clone()),
            Box::new(driving.clone()),
        ]
    }
}

/// Finds claims on the means of an off-road ride.
pub(crate) type Detect = fn(&Means, &offroad::Config) -> Vec<Claim>;

/// Detectors of manoeuvres off the road, the weakest claim first; flights ([`airborne`]) come after
/// them, exact to the sample.
pub(crate) const OFF_ROAD: &[Detect] =
    &[straights::driving, straights::braking, corners::corners, |means, _| {
        whoops::whoops(&means.waves)
    }];

impl ManoeuvreKind {
    /// Declaration of the kind: name, colour, detector and figures.
    pub fn declaration(self) -> &'static Declaration {
        DECLARATIONS[self as usize]
    }

    /// The kind of a declaration; [`ManoeuvreKind::Other`] for one that is not in the list.
    pub fn of(declaration: &Declaration) -> Self {
        Self::from_name(declaration.name).unwrap_or(ManoeuvreKind::Other)
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
        self.declaration().is_braking()
    }

    /// Whether the road is straight.
    pub fn is_straight(self) -> bool {
        self.declaration().is_straight()
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_declaration_is_at_its_kind_and_unlike_the_others() {
        let (mut names, mut colours) = (BTreeSet::new(), BTreeSet::new());
        for (i, kind) in ManoeuvreKind::ALL.iter().enumerate() {
            let d = kind.declaration();
            assert_eq!((*kind as usize, ManoeuvreKind::of(d)), (i, *kind));
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
