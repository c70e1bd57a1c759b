//! The common clock, and how a channel is read between its samples.

use crate::contract::channel::Channel;

/// Largest distance from the clock that needs no interpolation, as a share of its period.
pub(crate) const ON_CLOCK: f64 = 0.02;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    /// Its first point, s.
    pub start: f64,
    /// Rate, Hz.
    pub rate: f64,
    pub len: usize,
}

/// How a channel is read between its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Interpolation {
    /// The nearest sample's: whole numbers.
    Nearest,
    /// A straight line: bounded quantities that step, where a cubic would overshoot.
    Linear,
    Cubic,
}

impl Interpolation {
    pub(crate) fn of(channel: Channel) -> Self {
        match channel {
            Channel::Gear | Channel::LapNumber => Interpolation::Nearest,
            Channel::Throttle | Channel::BrakePressureFront | Channel::BrakePressureRear => {
                Interpolation::Linear
            }
            _ => Interpolation::Cubic,
        }
    }
}

/// Value at `t` between samples `left` and `left + 1`.
pub(crate) fn between(
    times: &[f64],
    samples: &[f64],
    left: usize,
    t: f64,
    limit: f64,
    kind: Interpolation,
) -> f64 {
    let (t0, t1) = (times[left], times[left + 1]);
    let (y0, y1) = (samples[left], samples[left + 1]);
    let step = t1 - t0;
    let u = (t - t0) / step;
    match kind {
        Interpolation::Nearest => return if u < 0.5 { y0 } else { y1 },
        Interpolation::Linear => return y0 + u * (y1 - y0),
        Interpolation::Cubic => {}
    }
    let secant = (y1 - y0) / step;
    // slope of the parabola through three samples; across a gap, of the straight line
    let slope = |near: usize, far: Option<usize>| {
        let Some(far) = far.filter(|&f| f < times.len()) else { return secant };
        let other = times[near] - times[far];
        if other.abs() > limit || !samples[far].is_finite() {
            return secant;
        }
        let outer = (samples[near] - samples[far]) / other;
        let other = other.abs();
        (secant * other + outer * step) / (step + other)
    };
    let m0 = slope(left, left.checked_sub(1)) * step;
    let m1 = slope(left + 1, Some(left + 2)) * step;
    let (u2, u3) = (u * u, u * u * u);
    (2.0 * u3 - 3.0 * u2 + 1.0) * y0
        + (u3 - 2.0 * u2 + u) * m0
        + (3.0 * u2 - 2.0 * u3) * y1
        + (u3 - u2) * m1
}
