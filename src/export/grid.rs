//! The points at which an export is fitted, checked and tabulated: the ridden ranges.

use super::ranges::Ranges;
use super::tyre::Characterised;
use crate::model::tyre::Input;

/// What a ride without samples of a kind is given.
const SLIP: [f64; 2] = [-0.2, 0.0];
const ANGLE: f64 = 0.02;
const CAMBER: f64 = 0.5;

/// Ends of the ranges, as a property file states them: angles go both ways.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ends {
    /// Slip ratio.
    pub slip_ratio: [f64; 2],
    /// Slip angle, rad.
    pub slip_angle: f64,
    /// Camber, rad.
    pub camber: f64,
    /// Load, N.
    pub load: [f64; 2],
}

impl Ends {
    /// Of a tyre.
    pub fn of(tyre: &Characterised) -> Self {
        let ranges = &tyre.ranges;
        let [low, high] = ranges.slip_ratio.unwrap_or(SLIP);
        Ends {
            slip_ratio: [low.clamp(-0.95, 0.0), high.max(0.0)],
            slip_angle: Ranges::both_ways(ranges.slip_angle).unwrap_or(ANGLE).clamp(0.005, 0.5),
            camber: Ranges::both_ways(ranges.camber).unwrap_or(CAMBER).clamp(0.1, 1.2),
            load: tyre.loads,
        }
    }
}

/// Values from end to end, `n` of them.
pub fn steps([low, high]: [f64; 2], n: usize) -> Vec<f64> {
    (0..n).map(|i| low + (high - low) * i as f64 / (n - 1) as f64).collect()
}

/// Pure longitudinal slip, upright.
pub fn longitudinal(tyre: &Characterised, load: f64) -> Vec<Input> {
    let ends = Ends::of(tyre);
    steps(ends.slip_ratio, 81).into_iter().map(|s| tyre.input(s, 0.0, 0.0, load)).collect()
}

/// Slip angle and camber without slip ratio, where the side force does not exceed the ridden one:
/// a large angle beside a large camber was not ridden, and the model is linear there for ever.
pub fn lateral(tyre: &Characterised, load: f64) -> Vec<Input> {
    let ends = Ends::of(tyre);
    let (angle, camber) = (ends.slip_angle, ends.camber);
    let most = tyre.ridden_side() * load * (1.0 + 1e-9);
    let mut out = Vec::new();
    for g in steps([-camber, camber], 25) {
        for a in steps([-angle, angle], 17) {
            let input = tyre.input(0.0, a, g, load);
            if tyre.forces(&input).force_y.abs() <= most {
                out.push(input);
            }
        }
    }
    out
}

/// All three slips at once, within the ranges and the ridden side force.
pub fn combined(tyre: &Characterised, load: f64) -> Vec<Input> {
    let ends = Ends::of(tyre);
    let most = tyre.ridden_side() * load * (1.0 + 1e-9);
    let mut out = Vec::new();
    for s in steps(ends.slip_ratio, 13) {
        for g in steps([-ends.camber, ends.camber], 7) {
            for a in steps([-ends.slip_angle, ends.slip_angle], 7) {
                let pure = tyre.forces(&tyre.input(0.0, a, g, load));
                if pure.force_y.abs() <= most {
                    out.push(tyre.input(s, a, g, load));
                }
            }
        }
    }
    out
}
