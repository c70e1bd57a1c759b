//! Paths with their speed profile.

use serde::{Deserialize, Serialize};

/// A lane change: over to the side within a transition, ridden as fast as an ellipse of
/// accelerations allows.
///
/// ```text
/// y(x) = offset * quintic(x / length)
/// (a_x / limit_x)^2 + (a_y / limit_y)^2 <= 1,  limit_x = drive or brake,  a_y = curvature v^2
/// ```
///
/// The manoeuvre of Bartolozzi et al. 2024 (3 m over 20 m; 2.5, 5 and 6 m/s²).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaneChange {
    /// To the left, m.
    pub offset: f64,
    /// Length of the transition, m.
    pub length: f64,
    /// Speed at which it is approached, m/s.
    pub entry: f64,
    /// Largest driving acceleration, m/s².
    pub drive: f64,
    /// Largest braking deceleration, m/s².
    pub brake: f64,
    /// Largest lateral acceleration, m/s².
    pub lateral: f64,
    /// Share of the front brake.
    pub front_share: f64,
}

/// Quintic step from 0 to 1 over unit time, with its derivatives.
pub(crate) fn quintic(x: f64) -> (f64, f64, f64) {
    if x <= 0.0 {
        (0.0, 0.0, 0.0)
    } else if x >= 1.0 {
        (1.0, 0.0, 0.0)
    } else {
        (
            x * x * x * (10.0 - 15.0 * x + 6.0 * x * x),
            30.0 * x * x * (1.0 - x) * (1.0 - x),
            60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
        )
    }
}

/// Spacing of the speed profile, m.
const SPACING: f64 = 0.25;
/// How far before and after the transition the profile is kept, m.
const REACH: f64 = 60.0;
/// Points of the profile.
const POINTS: usize = 1 + ((2.0 * REACH + 40.0) / SPACING) as usize;

impl LaneChange {
    /// Offset and slope at a distance along, m.
    pub fn offset_at(&self, x: f64) -> (f64, f64) {
        let (step, slope, _) = quintic(x / self.length);
        (self.offset * step, self.offset * slope / self.length)
    }

    /// Curvature, 1/m.
    pub fn curvature(&self, x: f64) -> f64 {
        let (_, slope, bend) = quintic(x / self.length);
        let (y1, y2) =
            (self.offset * slope / self.length, self.offset * bend / self.length.powi(2));
        y2 / (1.0 + y1 * y1).powf(1.5)
    }

    /// The part of a longitudinal limit, m/s², that the lateral acceleration of a speed leaves.
    fn remaining(&self, limit: f64, x: f64, speed: f64) -> f64 {
        let used = self.curvature(x) * speed * speed / self.lateral;
        limit * (1.0 - used * used).max(0.0).sqrt()
    }

    /// The fastest profile: speeds every quarter of a metre from 60 m before the transition, m/s.
    pub fn profile(&self) -> Vec<f64> {
        let at = |i: usize| i as f64 * SPACING - REACH;
        let tightest = (0..POINTS).map(|i| self.curvature(at(i)).abs()).fold(0.0, f64::max);
        let slowest = (self.lateral / tightest.max(1e-6)).sqrt();
        let mut v: Vec<f64> = (0..POINTS)
            .map(|i| {
                // through the transition the speed of its tightest corner is kept: nobody goes on
                // the throttle and back on the brake between the two corners
                if (0.0..self.length).contains(&at(i)) { slowest } else { 100.0 }
            })
            .collect();
        v[0] = v[0].min(self.entry);
        let reach = |from: f64, a: f64| (from * from + 2.0 * a * SPACING).max(0.0).sqrt();
        for i in 1..POINTS {
            // no faster than the entry before the transition
            let cap = if at(i) < 0.0 { self.entry } else { f64::INFINITY };
            v[i] =
                v[i].min(reach(v[i - 1], self.remaining(self.drive, at(i - 1), v[i - 1]))).min(cap);
        }
        for i in (0..POINTS - 1).rev() {
            v[i] = v[i].min(reach(v[i + 1], self.remaining(self.brake, at(i + 1), v[i + 1])));
        }
        v
    }

    /// Acceleration at a distance along and a speed: the profile's own, and back to it.
    pub fn acceleration(&self, profile: &[f64], x: f64, speed: f64) -> f64 {
        let v = profile;
        let place = ((x + REACH) / SPACING).clamp(0.0, (POINTS - 2) as f64);
        let (i, part) = (place as usize, place.fract());
        let wanted = v[i] + part * (v[i + 1] - v[i]);
        let slope = (v[i + 1] - v[i]) / SPACING;
        (slope * wanted + 2.0 * (wanted - speed)).clamp(-self.brake, self.drive)
    }
}

/// A path laid on the road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Course {
    /// Where it begins, m.
    pub origin: [f64; 2],
    /// Its heading there, rad.
    pub heading: f64,
    /// Offsets and limits along it.
    pub shape: LaneChange,
}

impl Course {
    /// Distance of a point along the course, m.
    pub(crate) fn along(&self, p: [f64; 2]) -> f64 {
        let (sin, cos) = self.heading.sin_cos();
        (p[0] - self.origin[0]) * cos + (p[1] - self.origin[1]) * sin
    }

    /// Road position of a point given along and to the left.
    pub(crate) fn point(&self, along: f64, left: f64) -> [f64; 2] {
        let (sin, cos) = self.heading.sin_cos();
        [self.origin[0] + along * cos - left * sin, self.origin[1] + along * sin + left * cos]
    }

    /// Road position of the path itself.
    pub(crate) fn path(&self, along: f64) -> [f64; 2] {
        self.point(along, self.shape.offset_at(along).0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_stays_inside_the_ellipse_and_touches_it() {
        let lane = LaneChange {
            offset: 3.0,
            length: 20.0,
            entry: 17.0,
            drive: 2.5,
            brake: 5.0,
            lateral: 6.0,
            front_share: 0.6,
        };
        let v = lane.profile();
        let mut most: f64 = 0.0;
        for i in 0..v.len() - 1 {
            let x = (i as f64 + 0.5) * SPACING - REACH;
            let a = (v[i + 1] * v[i + 1] - v[i] * v[i]) / (2.0 * SPACING);
            let speed = 0.5 * (v[i] + v[i + 1]);
            let limit = if a > 0.0 { lane.drive } else { lane.brake };
            let use_of_it =
                (a / limit).powi(2) + (lane.curvature(x) * speed * speed / lane.lateral).powi(2);
            most = most.max(use_of_it);
        }
        assert!((0.98..1.06).contains(&most), "{most}");
        let slowest = v.iter().copied().fold(f64::INFINITY, f64::min);
        // 3 m over 20 m corners with 0.0433 1/m at most
        assert!((slowest - (6.0_f64 / 0.0433).sqrt()).abs() < 0.2, "{slowest}");
    }
}
