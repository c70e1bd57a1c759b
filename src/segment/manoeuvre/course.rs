//! Rate of turn where no gyro tells it: from the heading, or from the track over ground.

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
    let mut east = slope(longitude, rate, half);
    east.iter_mut().zip(latitude).for_each(|(e, lat)| *e *= lat.to_radians().cos());
    let (mut course, mut last) = (Vec::with_capacity(north.len()), f64::NAN);
    for (n, e) in north.iter().zip(&east) {
        let mut now = n.atan2(*e);
        if last.is_finite() && now.is_finite() {
            now -= std::f64::consts::TAU * ((now - last) / std::f64::consts::TAU).round();
        }
        last = if now.is_finite() { now } else { last };
        course.push(now);
    }
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
