//! Where the motorcycle was: positions in metres about the middle of the ride, and the distance ridden.

use crate::contract::channel::Channel;
use crate::contract::geodesy::metres_per_degree;
use crate::contract::session::Session;
use crate::statistics::order::median_of_finite;

/// Half the time over which positions are averaged, s.
const HALF: f64 = 0.25;
/// Half the time over which a direction is taken, s.
const DIRECTION: f64 = 0.5;
/// Slower than this is standing or pushing, m/s.
pub(crate) const MOVING: f64 = 3.0;

/// A point of the plane: metres east and north.
pub(crate) type Point = [f64; 2];

/// Difference of two points.
pub(crate) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

/// Scalar product.
pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The positions of a ride, by sample; NaN in gaps.
#[derive(Debug, Clone)]
pub struct Ground {
    /// Hz.
    pub rate: f64,
    /// As logged, m.
    pub raw: Vec<Point>,
    /// Averaged over half a second, m.
    pub at: Vec<Point>,
    /// Speed, m/s; in gaps the one before.
    pub speed: Vec<f64>,
    /// Distance ridden since the start by the speed, m.
    pub ridden: Vec<f64>,
    /// Latitude and longitude of the origin, degrees.
    origin: Point,
}

impl Ground {
    /// `None` where the ride has no speed, or hardly any position and no markers of laps either.
    pub fn new(session: &Session) -> Option<Self> {
        let (raw, origin) = match places(session) {
            Some(places) => places,
            None if session.markers.times.is_empty() => return None,
            None => (vec![[f64::NAN; 2]; session.len], [f64::NAN; 2]),
        };
        let speed = held(session.get(Channel::VelocityX)?);
        let mut sum = 0.0;
        let ridden = speed
            .iter()
            .map(|v| {
                sum += v / session.rate;
                sum - 0.5 * v / session.rate
            })
            .collect();
        let at = averaged(&raw, (HALF * session.rate).round() as usize);
        Some(Ground { rate: session.rate, raw, at, speed, ridden, origin })
    }

    /// A latitude and longitude (degrees) as a point.
    pub fn point(&self, place: Point) -> Point {
        metres(self.origin, place)
    }

    /// A point as latitude and longitude, degrees.
    pub fn place(&self, p: Point) -> Point {
        let [north, east] = metres_per_degree(self.origin[0]);
        [self.origin[0] + p[1] / north, self.origin[1] + p[0] / east]
    }

    /// How many samples there are.
    pub fn samples(&self) -> usize {
        self.raw.len()
    }

    /// Whether the position of a sample is known.
    pub fn known(&self, i: usize) -> bool {
        self.at[i][0].is_finite()
    }

    /// Direction of travel of a sample, a unit vector.
    pub fn direction(&self, i: usize) -> Option<Point> {
        let reach = (DIRECTION * self.rate).ceil() as usize;
        let (a, b) = (i.saturating_sub(reach), (i + reach).min(self.samples() - 1));
        unit(minus(self.at[b], self.at[a])).filter(|_| self.speed[i] > MOVING)
    }

    /// Distance ridden at a time (s, between samples), m.
    pub fn ridden_at(&self, time: f64) -> f64 {
        interpolated(&self.ridden, time * self.rate)
    }
}

/// Positions, m, and their origin, degrees; `None` where there are hardly any.
fn places(session: &Session) -> Option<(Vec<Point>, Point)> {
    let (latitude, longitude) = (session.get(Channel::Latitude)?, session.get(Channel::Longitude)?);
    // a damaged log has places that are not on Earth
    let known = |(a, b): (&f64, &f64)| a.abs() <= 90.0 && b.abs() <= 360.0;
    let finite = latitude.iter().zip(longitude).filter(|&(a, b)| known((a, b))).count();
    if 2 * finite < session.len {
        return None;
    }
    let origin = [median_of_finite(latitude)?, median_of_finite(longitude)?];
    let point = |(a, b)| match known((a, b)) {
        true => metres(origin, [*a, *b]),
        false => [f64::NAN; 2],
    };
    Some((latitude.iter().zip(longitude).map(point).collect(), origin))
}

/// A vector of length one; none of a vector shorter than a decimetre.
pub(crate) fn unit(v: Point) -> Option<Point> {
    let length = v[0].hypot(v[1]);
    (length > 0.1).then(|| [v[0] / length, v[1] / length])
}

/// A column between its samples.
pub(crate) fn interpolated(x: &[f64], place: f64) -> f64 {
    let place = place.clamp(0.0, (x.len() - 1) as f64);
    let i = (place as usize).min(x.len().saturating_sub(2));
    let next = x[(i + 1).min(x.len() - 1)];
    x[i] + (place - i as f64) * (next - x[i])
}

fn metres(origin: Point, place: Point) -> Point {
    let [north, east] = metres_per_degree(origin[0]);
    [(place[1] - origin[1]) * east, (place[0] - origin[0]) * north]
}

/// Missing speeds are those before, and never below zero: a gap is ridden through.
fn held(x: &[f64]) -> Vec<f64> {
    let mut last = 0.0;
    let hold = |v: &f64| {
        if v.is_finite() {
            last = v.max(0.0);
        }
        last
    };
    x.iter().map(hold).collect()
}

/// Means over `half` samples to each side; a missing sample stays missing.
fn averaged(x: &[Point], half: usize) -> Vec<Point> {
    let mut sums = vec![[0.0; 3]];
    for p in x {
        let mut next = sums[sums.len() - 1];
        if p[0].is_finite() && p[1].is_finite() {
            next = [next[0] + p[0], next[1] + p[1], next[2] + 1.0];
        }
        sums.push(next);
    }
    let mean = |i: usize| {
        if !(x[i][0].is_finite() && x[i][1].is_finite()) {
            return [f64::NAN; 2];
        }
        // as far to one side as to the other: no point is pulled along
        let half = half.min(i).min(x.len() - 1 - i);
        let (a, b) = (sums[i - half], sums[i + half + 1]);
        let n = b[2] - a[2];
        [(b[0] - a[0]) / n, (b[1] - a[1]) / n]
    };
    (0..x.len()).map(mean).collect()
}
