//! Flights: both wheels off the ground, exact to the sample.

use std::ops::Range;

use super::declaration::{Course, Declaration, Peak, Terrain};
use super::mask::runs;
use super::means::{Means, Ride};
use super::offroad::Config;

pub(super) static AIRBORNE: Declaration = Declaration {
    name: "airborne",
    words: "airborne",
    description: "Both wheels off the ground.",
    letter: "A",
    letter_by_side: None,
    colour: "#0f8b8d",
    colour_dark: "#45b5b7",
    terrain: Terrain::OffRoad,
    course: Course::Any,
    brakes: [false, false],
    peak: Peak::Flight,
    force_row: Some(0),
};

/// Flights that are long enough and do not begin in whoops, in samples.
pub(crate) fn flights(ride: &Ride<'_>, means: &Means, config: &Config) -> Vec<Range<usize>> {
    let least = config.shortest_flight * ride.rate;
    let counts =
        |at: &Range<usize>| at.len() as f64 >= least && !means.waves[at.start / means.step];
    runs(ride.airborne).into_iter().filter(counts).collect()
}
