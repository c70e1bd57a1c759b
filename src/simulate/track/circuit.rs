//! A closed track: its centre line, its hills, and the fastest way round within given accelerations.
//!
//! ```text
//! corners of a polygon, rounded by arcs -> smoothed round the loop -> heading, curvature every metre
//! ```
//!
//! The smoothing is of positions and goes round, so that the line closes by construction and its
//! curvature has no steps, as no road and no rider's line has.

use crate::statistics::angles::wrapped;
use std::f64::consts::TAU;

use crate::statistics::random::Random;

/// Distance between points of the line, m.
pub(crate) const SPACING: f64 = 1.0;
/// Distance between points while the line is smoothed, m.
const FINE: f64 = 0.1;
/// Usual width of the smoothing, standard deviation, m: corners keep an arc that is ridden at one speed. With three times as
/// much they are braked into and driven out of up to the apex.
pub(crate) const SMOOTHING: f64 = 9.0;

/// The corners of the built-in track: where the straights would meet, and the radius of the arc between them, m.
/// Anticlockwise from the start line; seven to the left and two to the right.
const CORNERS: [([f64; 2], f64); 9] = [
    ([640.0, 0.0], 62.0),
    ([520.0, 300.0], 55.0),
    ([880.0, 430.0], 75.0),
    ([610.0, 790.0], 95.0),
    ([90.0, 690.0], 48.0),
    ([40.0, 390.0], 70.0),
    ([-290.0, 300.0], 55.0),
    ([-520.0, 130.0], 60.0),
    ([-470.0, 0.0], 45.0),
];

/// A closed line, points a metre apart.
#[derive(Debug, Clone)]
pub struct Circuit {
    /// Points, m.
    pub points: Vec<[f64; 2]>,
    /// Without jumps over the lap, rad.
    pub heading: Vec<f64>,
    /// Positive to the left, 1/m.
    pub curvature: Vec<f64>,
    /// Rise over run.
    pub grade: Vec<f64>,
    /// Above the start line, m.
    pub altitude: Vec<f64>,
    /// The corner that comes next, counted from the start line.
    pub next_corner: Vec<usize>,
    /// Distance between points, m.
    pub spacing: f64,
    /// Once round, m.
    pub length: f64,
}

impl Circuit {
    /// The built-in track; its hills climb by at most `grade` (rise over run), twice up and down a lap.
    pub fn new(grade: f64, smoothing: f64) -> Self {
        Self::through(&CORNERS, grade, smoothing)
    }

    /// A track like it: larger or smaller, half of them mirrored, every corner elsewhere and of another radius. The
    /// start line's straight stays where it is.
    pub fn drawn(grade: f64, smoothing: f64, random: &mut Random) -> Self {
        let side = if random.between(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
        let size = random.between(0.9, 1.2);
        let corners = CORNERS.map(|([x, y], radius)| {
            let mut moved = |by: f64| random.between(-by, by);
            let [x, y] = [x + moved(18.0), if y == 0.0 { 0.0 } else { y + moved(18.0) }];
            ([size * x, side * size * y], size * radius * (1.0 + moved(0.12)))
        });
        Self::through(&corners, grade, smoothing)
    }

    fn through(corners: &[([f64; 2], f64)], grade: f64, smoothing: f64) -> Self {
        let rough = rounded(corners);
        // finely before it is thinned out, else the chords show in the curvature
        let even = evenly(&rough, FINE);
        let smooth = evenly(&smoothed(&even, smoothing / FINE), SPACING);
        let n = smooth.len();
        let at = |i: isize| smooth[i.rem_euclid(n as isize) as usize];
        let spacing = distance(smooth[0], smooth[1]);
        let (mut heading, mut curvature) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let mut last = 0.0;
        for i in 0..n as isize {
            let ([x0, y0], [x1, y1], [x2, y2]) = (at(i - 1), at(i), at(i + 1));
            let direct = (y2 - y0).atan2(x2 - x0);
            last += wrapped(direct - last);
            heading.push(last);
            let (dx, dy) = (0.5 * (x2 - x0), 0.5 * (y2 - y0));
            let (ddx, ddy) = (x2 - 2.0 * x1 + x0, y2 - 2.0 * y1 + y0);
            curvature.push((dx * ddy - dy * ddx) / (dx * dx + dy * dy).powf(1.5));
        }
        let length = spacing * n as f64;
        // two waves a lap of other heights: their slopes add up to nothing round the lap
        let phase = |i: usize| TAU * i as f64 / n as f64;
        let slope = |p: f64| grade * (0.6 * (p + 0.7).sin() + 0.4 * (2.0 * p).cos());
        let grades: Vec<f64> = (0..n).map(|i| slope(phase(i))).collect();
        let mut altitude = Vec::with_capacity(n);
        let mut height = 0.0;
        for g in &grades {
            altitude.push(height);
            height += g * spacing;
        }
        let next_corner = nearest_ahead(corners, &smooth);
        Circuit {
            points: smooth,
            heading,
            curvature,
            grade: grades,
            altitude,
            next_corner,
            spacing,
            length,
        }
    }

    /// Points of a lap.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Corners of a lap.
    pub fn corners(&self) -> usize {
        CORNERS.len()
    }

    /// A value round the lap at a distance from the start line, m.
    pub fn value(&self, of: &[f64], along: f64) -> f64 {
        let place = along.rem_euclid(self.length) / self.spacing;
        let (i, part) = (place as usize % of.len(), place.fract());
        of[i] + part * (of[(i + 1) % of.len()] - of[i])
    }

    /// The index of the point at a distance from the start line.
    pub fn index(&self, along: f64) -> usize {
        (along.rem_euclid(self.length) / self.spacing) as usize % self.len()
    }

    /// Heading of the line, rad, by laps without jumps.
    pub fn heading_at(&self, along: f64) -> f64 {
        let n = self.len();
        let place = along.rem_euclid(self.length) / self.spacing;
        let (i, part) = (place as usize % n, place.fract());
        let here = self.heading[i];
        here + part * wrapped(self.heading[(i + 1) % n] - here)
    }

    /// How far along and how far to the left of the line a point is that was `near` before, m.
    pub fn place(&self, p: [f64; 2], near: f64) -> (f64, f64) {
        let n = self.len() as isize;
        let from = (near / self.spacing).floor() as isize;
        let squared = |i: isize| {
            let q = self.points[i.rem_euclid(n) as usize];
            (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2)
        };
        let best =
            (from - 3..from + 6).min_by(|a, b| squared(*a).total_cmp(&squared(*b))).unwrap_or(from);
        let k = best.rem_euclid(n) as usize;
        let (sin, cos) = self.heading[k].sin_cos();
        let (dx, dy) = (p[0] - self.points[k][0], p[1] - self.points[k][1]);
        (best as f64 * self.spacing + dx * cos + dy * sin, dy * cos - dx * sin)
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// A polygon with arcs for corners, points about half a metre apart, from the start line at the origin.
fn rounded(corners: &[([f64; 2], f64)]) -> Vec<[f64; 2]> {
    let n = corners.len();
    let mut points = vec![[0.0, 0.0]];
    let straight = |points: &mut Vec<[f64; 2]>, to: [f64; 2]| {
        let from = points[points.len() - 1];
        let steps = (distance(from, to) / 0.5).ceil().max(1.0) as usize;
        for k in 1..=steps {
            let part = k as f64 / steps as f64;
            points.push([from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])]);
        }
    };
    for k in 0..n {
        let (corner, radius) = corners[k];
        let (before, after) = (corners[(k + n - 1) % n].0, corners[(k + 1) % n].0);
        let coming = (corner[1] - before[1]).atan2(corner[0] - before[0]);
        let going = (after[1] - corner[1]).atan2(after[0] - corner[0]);
        let turn = wrapped(going - coming);
        let reach = radius * (0.5 * turn.abs()).tan();
        let begin = [corner[0] - reach * coming.cos(), corner[1] - reach * coming.sin()];
        straight(&mut points, begin);
        let side = turn.signum();
        let centre =
            [begin[0] - side * radius * coming.sin(), begin[1] + side * radius * coming.cos()];
        let steps = (radius * turn.abs() / 0.5).ceil() as usize;
        for i in 1..=steps {
            let angle = coming + turn * i as f64 / steps as f64;
            points.push([
                centre[0] + side * radius * angle.sin(),
                centre[1] - side * radius * angle.cos(),
            ]);
        }
    }
    straight(&mut points, [0.0, 0.0]);
    points.pop();
    points
}

/// Points of a closed line at even distances of about `spacing`.
fn evenly(points: &[[f64; 2]], spacing: f64) -> Vec<[f64; 2]> {
    let n = points.len();
    let mut along = vec![0.0];
    for i in 0..n {
        along.push(along[i] + distance(points[i], points[(i + 1) % n]));
    }
    let count = (along[n] / spacing).round() as usize;
    let step = along[n] / count as f64;
    let mut k = 0;
    (0..count)
        .map(|i| {
            let s = i as f64 * step;
            while k + 1 < n && along[k + 1] <= s {
                k += 1;
            }
            let part = (s - along[k]) / (along[k + 1] - along[k]).max(1e-12);
            let (a, b) = (points[k], points[(k + 1) % n]);
            [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])]
        })
        .collect()
}

/// A closed line smoothed by a bell of the given width in points.
fn smoothed(points: &[[f64; 2]], width: f64) -> Vec<[f64; 2]> {
    let n = points.len() as isize;
    let reach = (4.0 * width).ceil() as isize;
    let weight: Vec<f64> =
        (-reach..=reach).map(|k| (-0.5 * (k as f64 / width).powi(2)).exp()).collect();
    let total: f64 = weight.iter().sum();
    (0..n)
        .map(|i| {
            let mut sum = [0.0; 2];
            for (k, w) in (-reach..=reach).zip(&weight) {
                let p = points[(i + k).rem_euclid(n) as usize];
                sum[0] += w * p[0];
                sum[1] += w * p[1];
            }
            [sum[0] / total, sum[1] / total]
        })
        .collect()
}

/// Of every point, the number of the corner whose middle is the next one ahead.
fn nearest_ahead(corners: &[([f64; 2], f64)], points: &[[f64; 2]]) -> Vec<usize> {
    let nearest = |c: [f64; 2]| {
        let of = |i: &usize| distance(points[*i], c);
        (0..points.len()).min_by(|a, b| of(a).total_cmp(&of(b))).unwrap_or(0)
    };
    let middles: Vec<usize> = corners.iter().map(|(c, _)| nearest(*c)).collect();
    (0..points.len()).map(|i| middles.iter().position(|m| *m >= i).unwrap_or(0)).collect()
}

/// Limits of the rider, by the point of the whole ride.
#[derive(Debug, Clone)]
pub(crate) struct Limits {
    /// Lateral acceleration in corners, m/s².
    pub lateral: Vec<f64>,
    /// Deceleration, m/s².
    pub brake: Vec<f64>,
    /// Where the throttle is shut and the brakes are left alone.
    pub rolled: Vec<bool>,
    /// Acceleration, m/s²; the engine limits it too.
    pub drive: Vec<f64>,
    /// Lateral acceleration at which nothing is left for braking or driving, over that of the corners.
    pub reserve: f64,
    /// Fastest, m/s.
    pub fastest: f64,
}

/// The fastest speeds over some laps from a start speed (m/s): no more than an ellipse of accelerations and the
/// engine's acceleration at a speed (`engine`, m/s²) allow; `closed` is the deceleration of a closed throttle.
pub(crate) fn profile(
    circuit: &Circuit,
    limits: &Limits,
    start: f64,
    engine: impl Fn(f64) -> f64,
    closed: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let count = limits.lateral.len();
    let bend = |i: usize| circuit.curvature[i % circuit.len()].abs();
    let mut v: Vec<f64> = (0..count)
        .map(|i| (limits.lateral[i] / bend(i).max(1e-6)).sqrt().min(limits.fastest))
        .collect();
    let remaining = |i: usize, speed: f64| {
        let used = bend(i) * speed * speed / (limits.lateral[i] * limits.reserve);
        (1.0 - used * used).max(0.0).sqrt()
    };
    let ds = circuit.spacing;
    for i in (0..count - 1).rev() {
        let braked = limits.brake[i + 1] * remaining(i + 1, v[i + 1]);
        // a little more than the closed throttle gives, so that it is closed indeed
        let rolling = closed(v[i + 1]) + 0.3;
        let a = if limits.rolled[i + 1] { rolling.min(limits.brake[i + 1]) } else { braked };
        v[i] = v[i].min((v[i + 1] * v[i + 1] + 2.0 * a * ds).sqrt());
    }
    v[0] = v[0].min(start);
    for i in 1..count {
        let a = engine(v[i - 1]).min(limits.drive[i - 1]) * remaining(i - 1, v[i - 1]);
        v[i] = v[i].min((v[i - 1] * v[i - 1] + 2.0 * a * ds).max(1.0).sqrt());
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_closes_turns_once_and_its_hills_end_where_they_began() {
        let c = Circuit::new(0.02, SMOOTHING);
        let n = c.len();
        let gap = distance(c.points[n - 1], c.points[0]);
        assert!((gap - c.spacing).abs() < 0.02, "{gap}");
        assert!((2800.0..4200.0).contains(&c.length), "{}", c.length);
        let turned: f64 = c.curvature.iter().sum::<f64>() * c.spacing;
        assert!((turned - TAU).abs() < 0.01, "{turned}");
        // as tight as a track's corners, both ways
        let (most, least) =
            c.curvature.iter().fold((0.0, 0.0), |(a, b): (f64, f64), k| (a.max(*k), b.min(*k)));
        assert!((1.0 / 60.0..1.0 / 35.0).contains(&most), "{most}");
        assert!((-1.0 / 40.0..-1.0 / 90.0).contains(&least), "{least}");
        let rise = c.altitude[n - 1] + c.grade[n - 1] * c.spacing;
        assert!(rise.abs() < 0.05, "{rise}");
        let steepest = c.grade.iter().fold(0.0_f64, |a, g| a.max(g.abs()));
        assert!((0.012..=0.02).contains(&steepest), "{steepest}");
        assert!(c.next_corner.iter().all(|k| *k < c.corners()));
    }

    #[test]
    fn a_place_beside_the_line_is_found_again() {
        let c = Circuit::new(0.0, SMOOTHING);
        for i in (0..c.len()).step_by(37) {
            let (sin, cos) = c.heading[i].sin_cos();
            let p = [c.points[i][0] - 1.5 * sin, c.points[i][1] + 1.5 * cos];
            let along = i as f64 * c.spacing;
            let (s, left) = c.place(p, along - 2.0);
            assert!(
                (s - along).abs() < 0.1 && (left - 1.5).abs() < 0.05,
                "{i}: {s} {along} {left}"
            );
        }
    }
}
