//! A session on the track, as it was ridden.

use super::rider::Hands;
use super::scenario::Entry;
use crate::contract::geodesy::metres_per_degree;
use crate::simulate::ride::MultibodyRide;

/// The start line: latitude and longitude, degrees.
pub const ORIGIN: [f64; 2] = [44.3439, 11.7167];
/// Lean from which it is a corner, rad.
pub(crate) const CORNER: f64 = 0.21;

/// A session on the track with everything known about it.
#[derive(Debug, Clone)]
pub struct TrackRide {
    /// Machine and settings of the ride.
    pub entry: Entry,
    /// Log, labels and samples.
    pub ride: MultibodyRide,
    /// Levers, engine and place by sample.
    pub hands: Vec<Hands>,
    /// Times at which the start line was crossed, s.
    pub crossings: Vec<f64>,
    /// Why attempts before it failed.
    pub failed: Vec<String>,
}

/// Latitude and longitude of a point of the road, degrees; x points east and y north.
pub fn position(p: [f64; 2]) -> [f64; 2] {
    let [north, east] = metres_per_degree(ORIGIN[0]);
    [ORIGIN[0] + p[1] / north, ORIGIN[1] + p[0] / east]
}
