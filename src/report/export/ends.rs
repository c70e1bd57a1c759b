//! Where ranges end, and values from end to end.

use super::ranges::Ranges;
use super::tyre::Characterised;
use crate::tyre::paper::Input;

/// Range for a ride without samples of a kind.
const SLIP: [f64; 2] = [-0.2, 0.0];
const ANGLE: f64 = 0.02;
const CAMBER: f64 = 0.5;

/// Ends of the ranges, as a property file states them: angles go both ways.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ends {
    pub slip_ratio: [f64; 2],
    /// Slip angle, rad.
    pub slip_angle: f64,
    /// Camber, rad.
    pub camber: f64,
    /// Load, N.
    pub load: [f64; 2],
}

impl Ends {
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

/// Share of its peak up to which a slip counts as none beside another.
const PURE: f64 = 0.05;

impl Characterised {
    /// Whether all of it was ridden, as the C header says it: on the road of the ride, within its ranges, and not both
    /// slips at once.
    pub fn ridden(&self, input: &Input) -> bool {
        let (t, ends) = (&self.tyre.tyre, Ends::of(self));
        let k_alpha = t.stiffness.k_alpha(input.camber, t.side_force_ratio);
        let side = (k_alpha * (input.slip_angle + t.side_force_ratio * input.camber)).abs();
        let most = self.ridden_side();
        let along = input.slip_ratio.abs() > PURE * t.peak_slip;
        (input.friction / t.reference_friction - 1.0).abs() <= 1e-6
            && !(along && side > PURE * most)
            && (ends.slip_ratio[0]..=ends.slip_ratio[1]).contains(&input.slip_ratio)
            && input.slip_angle.abs() <= ends.slip_angle
            && input.camber.abs() <= ends.camber
            && (ends.load[0]..=ends.load[1]).contains(&input.load)
            && side <= most * (1.0 + 1e-9)
    }
}

/// Values from end to end, `n` of them.
pub(crate) fn steps([low, high]: [f64; 2], n: usize) -> Vec<f64> {
    (0..n).map(|i| low + (high - low) * i as f64 / (n - 1) as f64).collect()
}
