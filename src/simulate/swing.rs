//! Leans to both sides that the rider knows beforehand: slalom passes and lane changes.
//!
//! ```text
//! slalom        lean * ramp(t) * sin(2 pi frequency t)     ramp: quintic, one period at either end
//! lane change   lean * 8/(3 sqrt 3) * sin(2 pi x) sin(pi x)^2,   x = t / duration
//! ```
//!
//! Both begin and end upright, without roll rate and roll acceleration, and turn as far to one side as to
//! the other: the heading at the end is that of the beginning.

use std::f64::consts::TAU;

use super::path::quintic;
use crate::segment::manoeuvre::Direction;

/// A lean over time: up, held, down; smooth to the second derivative.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Lean {
    /// Angle, rad.
    pub angle: f64,
    /// Rate, rad/s.
    pub rate: f64,
    /// Acceleration, rad/s².
    pub acceleration: f64,
}

/// Fewest periods of a slalom pass: one to build up, one to die away.
const MIN_PERIODS: f64 = 2.0;

/// A lean over time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swing {
    /// Side of the first lean.
    pub first: Direction,
    /// Largest lean, rad, positive number.
    pub lean: f64,
    /// Time from upright to upright, s; of a slalom, about this long.
    pub duration: f64,
    pub form: Form,
}

/// Form of a [`Swing`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Form {
    /// From side to side, a whole number of periods.
    Slalom {
        /// Frequency, Hz.
        frequency: f64,
    },
    /// Once to one side and once to the other: over to the next lane.
    LaneChange,
}

impl Swing {
    /// How long it takes, s.
    pub fn length(&self) -> f64 {
        match self.form {
            Form::Slalom { frequency } => {
                (self.duration * frequency).round().max(MIN_PERIODS) / frequency
            }
            Form::LaneChange => self.duration,
        }
    }

    /// The lean at `t` s after its beginning.
    pub(crate) fn at(&self, t: f64) -> Lean {
        let length = self.length();
        if t <= 0.0 || t >= length {
            return Lean::default();
        }
        let of_unit = match self.form {
            Form::Slalom { frequency } => slalom(frequency, length, t),
            Form::LaneChange => lane_change(length, t),
        };
        let sign = if self.first == Direction::Left { -1.0 } else { 1.0 };
        let [angle, rate, acceleration] = of_unit.map(|x| sign * self.lean * x);
        Lean { angle, rate, acceleration }
    }
}

/// Lean, rate and acceleration of a slalom of unit lean.
fn slalom(frequency: f64, length: f64, t: f64) -> [f64; 3] {
    // builds up in the first period, dies away in the last
    let (side, x) = if t < 0.5 * length { (1.0, t) } else { (-1.0, length - t) };
    let (ramp, ramp_rate, ramp_acceleration) = quintic(x * frequency);
    let (ramp_rate, ramp_acceleration) =
        (side * frequency * ramp_rate, frequency * frequency * ramp_acceleration);
    let w = TAU * frequency;
    let (sin, cos) = (w * t).sin_cos();
    [
        ramp * sin,
        ramp_rate * sin + ramp * w * cos,
        ramp_acceleration * sin + 2.0 * ramp_rate * w * cos - ramp * w * w * sin,
    ]
}

/// Lean, rate and acceleration of a lane change of unit lean: `sin(2 pi x) sin(pi x)^2`, as a sum of two sines.
fn lane_change(length: f64, t: f64) -> [f64; 3] {
    let largest = 8.0 / 27_f64.sqrt() * 0.5;
    let w = TAU / length;
    let (sin, cos) = (w * t).sin_cos();
    let (sin_2, cos_2) = (2.0 * w * t).sin_cos();
    [
        largest * (sin - 0.5 * sin_2),
        largest * w * (cos - cos_2),
        largest * w * w * (2.0 * sin_2 - sin),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SWINGS: [Swing; 3] = [
        Swing {
            first: Direction::Left,
            lean: 0.35,
            duration: 15.0,
            form: Form::Slalom { frequency: 0.27 },
        },
        Swing {
            first: Direction::Right,
            lean: 0.18,
            duration: 1.0,
            form: Form::Slalom { frequency: 0.7 },
        },
        Swing { first: Direction::Right, lean: 0.3, duration: 2.5, form: Form::LaneChange },
    ];

    #[test]
    fn rates_are_the_derivatives_and_both_ends_are_upright() {
        for swing in SWINGS {
            let (h, length) = (1e-4, swing.length());
            let steps = 400;
            for k in 1..steps {
                let t = length * f64::from(k) / f64::from(steps);
                let [before, now, after] = [t - h, t, t + h].map(|t| swing.at(t));
                let rate = (after.angle - before.angle) / (2.0 * h);
                let acceleration = (after.rate - before.rate) / (2.0 * h);
                assert!((rate - now.rate).abs() < 1e-5, "{swing:?} {t}");
                assert!((acceleration - now.acceleration).abs() < 1e-3, "{swing:?} {t}");
            }
            for t in [0.0, 1e-6, length - 1e-6, length] {
                let Lean { angle, rate, acceleration } = swing.at(t);
                assert!(angle.abs() < 1e-9 && rate.abs() < 1e-6 && acceleration.abs() < 1e-3);
            }
        }
    }

    #[test]
    fn it_leans_as_far_as_asked_first_to_its_side_and_keeps_the_heading() {
        for swing in SWINGS {
            let steps = 20_000;
            let dt = swing.length() / f64::from(steps);
            let leans: Vec<f64> =
                (0..steps).map(|k| swing.at((f64::from(k) + 0.5) * dt).angle).collect();
            let largest = leans.iter().copied().fold(0.0, |most: f64, x: f64| most.max(x.abs()));
            let sum: f64 = leans.iter().sum();
            assert!(sum.abs() * dt < 1e-9, "{swing:?}: {sum}");
            // two periods are ramps only
            if swing.duration > 1.0 {
                assert!((largest / swing.lean - 1.0).abs() < 1e-3, "{swing:?}: {largest}");
            }
            let first = leans.iter().find(|x| x.abs() > 0.01).copied().unwrap_or(0.0);
            assert_eq!(first < 0.0, swing.first == Direction::Left);
        }
        assert!((SWINGS[0].length() - 4.0 / 0.27).abs() < 1e-12);
    }
}
