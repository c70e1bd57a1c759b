//! Rate of turn where no gyro tells it: from the heading, or from the track over ground.

use crate::contract::geodesy::metres_per_degree;
use crate::statistics::angles::unwrap;

/// Half the time over which a heading's change is taken, s: positions are rough.
const HALF: f64 = 0.8;

/// Rate of turn from a heading (rad, running on), rad/s.
pub(super) fn of_heading(heading: &[f64], rate: f64) -> Vec<f64> {
    slope(heading, rate, ((0.3 * rate).round() as usize).max(2))
}

/// Rate of turn from positions in degrees, rad/s, left positive.
pub(super) fn of_track(latitude: &[f64], longitude: &[f64], rate: f64) -> Vec<f64> {
    let half = ((HALF * rate).round() as usize).max(2);
    let north = slope(latitude, rate, half);
    let east = slope(longitude, rate, half);
    let known = latitude.iter().copied().find(|x| x.is_finite());
    let metres = metres_per_degree(known.unwrap_or_default());
    let mut course: Vec<f64> =
        north.iter().zip(&east).map(|(n, e)| (n * metres[0]).atan2(e * metres[1])).collect();
    unwrap(&mut course);
    slope(&course, rate, half)
}

/// Slope of the least-squares line through `half` neighbours on each side, per second.
pub(super) fn slope(x: &[f64], rate: f64, half: usize) -> Vec<f64> {
    let n = x.len();
    let norm: f64 = (1..=half).map(|k| 2.0 * (k * k) as f64).sum();
    (0..n)
        .map(|i| {
            let sum: f64 = (1..=half)
                .map(|k| k as f64 * (x[(i + k).min(n - 1)] - x[i.saturating_sub(k)]))
                .sum();
            sum / norm * rate
        })
        .collect()
}
