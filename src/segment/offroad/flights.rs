//! Flights: both wheels off the ground, exact to the sample.

use std::ops::Range;

use super::config::Config;
use super::means::{Means, Ride};
use crate::segment::mask::runs;

/// Flights that are long enough and do not begin in whoops, in samples.
pub fn flights(ride: &Ride<'_>, means: &Means, config: &Config) -> Vec<Range<usize>> {
    let least = config.shortest_flight * ride.rate;
    let counts =
        |at: &Range<usize>| at.len() as f64 >= least && !means.waves[at.start / means.step];
    runs(ride.airborne).into_iter().filter(counts).collect()
}
