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

/// Positions are looked at for a jump over gaps longer than this, s: over less their error is an acceleration itself.
const GAP: f64 = 2.0;
/// Largest error of a position after a gap, m.
const REGAINED: f64 = 40.0;
/// Acceleration that no motorcycle has, in its direction or across, m/s^2.
const IMPOSSIBLE: f64 = 30.0;

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
    /// Rate, Hz.
    pub rate: f64,
    /// As logged, m.
    pub raw: Vec<Point>,
    /// Averaged over half a second, m.
    pub at: Vec<Point>,
    /// Speed, m/s; in gaps the one before.
    pub speed: Vec<f64>,
    /// Distance ridden since the start by the speed, m.
    pub ridden: Vec<f64>,
    /// Begin and end of gaps that no motorcycle rode through as the positions say, s: the log is put together from parts.
    pub jumps: Vec<[f64; 2]>,
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
        let jumps = jumps(&at, session.rate);
        Some(Ground { rate: session.rate, raw, at, speed, ridden, jumps, origin })
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

/// Gaps whose ends no motorcycle joins, s.
///
/// ```text
/// the cubic from place p0 and velocity v0 to p1 and v1 in the time T of the gap, d = p1 - p0:
/// acceleration at its ends  6 d / T^2 - (4 v0 + 2 v1) / T  and  (2 v0 + 4 v1) / T - 6 d / T^2
/// ```
/// It is 1.4 times that of a circle at most, and several times that of any road where a part begins elsewhere.
fn jumps(at: &[Point], rate: f64) -> Vec<[f64; 2]> {
    let second = rate.round() as usize;
    let known: Vec<usize> = (0..at.len()).filter(|&i| at[i][0].is_finite()).collect();
    let jump = |pair: &[usize]| {
        let (i, j) = (pair[0], pair[1]);
        let time = (j - i) as f64 / rate;
        let (before, after) = (i.checked_sub(second)?, *at.get(j + second)?);
        if second == 0 || time <= GAP {
            return None;
        }
        let velocity = |a: Point, b: Point| minus(b, a).map(|d| d * rate / second as f64);
        let (v0, v1) = (velocity(at[before], at[i]), velocity(at[j], after));
        let d = minus(at[j], at[i]).map(|d| 6.0 * d / time / time);
        let first = [0, 1].map(|k| d[k] - (4.0 * v0[k] + 2.0 * v1[k]) / time);
        let last = [0, 1].map(|k| (2.0 * v0[k] + 4.0 * v1[k]) / time - d[k]);
        let largest = first[0].hypot(first[1]).max(last[0].hypot(last[1]));
        // a velocity next to another gap is not known, and no number is larger than another
        let is_jump = largest > IMPOSSIBLE + 6.0 * REGAINED / time / time;
        is_jump.then(|| [i as f64 / rate, j as f64 / rate])
    };
    known.windows(2).filter_map(jump).collect()
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
