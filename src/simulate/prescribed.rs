//! A ride of prescribed heading and speed: nothing is solved, the motorcycle leans as it must, so that a test of
//! what measures motion needs no motorcycle.

use nalgebra::{Matrix3, Vector3};

use super::imu::Motion;
use crate::GRAVITY;
use crate::simulate::multibody::state::rotation;

/// A change that begins and ends softly: at what time, over how long (s), by how much.
pub(crate) type Change = [f64; 3];

/// Changes of heading (rad, positive to the left) and of speed (m/s).
#[derive(Debug, Clone, Default)]
pub struct Prescribed {
    pub turns: Vec<Change>,
    pub speeds: Vec<Change>,
    /// At the start, m/s.
    pub start: f64,
    /// Length, s.
    pub length: f64,
    /// Side slip angle per lean, of the centre of mass: positive outwards at the rear, as on tyres.
    pub slip: f64,
}

/// Half a step of differences, s.
const STEP: f64 = 2e-3;

impl Prescribed {
    /// Corners to both sides with braking before and driving out of them, `bends` of 12 s each after a straight.
    pub fn road(bends: usize) -> Self {
        let mut out = Prescribed { start: 16.0, slip: 0.03, ..Prescribed::default() };
        let mut time = 14.0;
        out.speeds.extend([[5.0, 2.0, 8.0], [9.0, 2.0, -7.0]]);
        for i in 0..bends {
            let angle = [1.4, -1.1, -1.6, 0.9, 1.7, -1.3][i % 6];
            out.turns.push([time + 3.0, 2.6 + 0.4 * (i % 3) as f64, angle]);
            out.speeds.extend([
                [time, 1.2, -3.0 - (i % 2) as f64],
                [time + 8.0, 2.0, 3.0 + (i % 2) as f64],
            ]);
            time += 12.0;
        }
        out.length = time + 8.0;
        out
    }

    fn sum(changes: &[Change], t: f64) -> f64 {
        // a hyperbolic tangent has all its change within two and a half of its widths
        changes.iter().map(|[at, over, by]| 0.5 * by * (1.0 + (4.0 * (t - at) / over).tanh())).sum()
    }

    fn speed(&self, t: f64) -> f64 {
        (self.start + Self::sum(&self.speeds, t)).max(0.0)
    }

    fn heading(&self, t: f64) -> f64 {
        Self::sum(&self.turns, t)
    }

    fn slope(of: impl Fn(f64) -> f64, t: f64) -> f64 {
        (of(t + STEP) - of(t - STEP)) / (2.0 * STEP)
    }

    fn roll(&self, t: f64) -> f64 {
        -1.07 * (self.speed(t) * Self::slope(|t| self.heading(t), t) / GRAVITY).atan()
    }

    fn rotation(&self, t: f64) -> Matrix3<f64> {
        let pitch = -0.006 * Self::slope(|t| self.speed(t), t);
        rotation(&[self.heading(t), self.roll(t), pitch])
    }

    fn velocity(&self, t: f64) -> Vector3<f64> {
        let (sin, cos) = self.heading(t).sin_cos();
        let (x, y) = (self.speed(t), self.slip * self.roll(t) * self.speed(t));
        Vector3::new(x * cos - y * sin, x * sin + y * cos, 0.0)
    }

    /// Spin in frame axes.
    fn spin(&self, t: f64) -> Vector3<f64> {
        let change = (self.rotation(t + STEP) - self.rotation(t - STEP)) / (2.0 * STEP);
        let m = self.rotation(t).transpose() * change;
        0.5 * Vector3::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)])
    }

    /// The motion at `rate` Hz.
    pub fn motions(&self, rate: f64) -> Vec<Motion> {
        let at = |i: usize| {
            let t = i as f64 / rate;
            Motion {
                rotation: self.rotation(t),
                spin: self.spin(t),
                spin_rate: (self.spin(t + STEP) - self.spin(t - STEP)) / (2.0 * STEP),
                velocity: self.velocity(t),
                acceleration: (self.velocity(t + STEP) - self.velocity(t - STEP)) / (2.0 * STEP),
                gravity: Vector3::new(0.0, 0.0, -GRAVITY),
            }
        };
        (0..(self.length * rate) as usize).map(at).collect()
    }
}
