//! The points at which an export is fitted, checked and tabulated: the ridden ranges, and how far a file goes beyond.

use super::ends::{Ends, steps};
use super::tyre::Characterised;
use super::validity::Validity;
use crate::tyre::paper::Input;

/// The points of some ranges at which a tyre is compared.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid {
    pub ends: Ends,
    /// Largest side force over load; points with more are left out.
    pub side: f64,
    /// Slip angles and cambers per direction.
    pub lateral: [usize; 2],
}

impl Grid {
    /// Ridden ranges. The side force is part of it: a large angle beside a large camber was not ridden, and the
    /// model is linear there for ever.
    pub(crate) fn ridden(tyre: &Characterised) -> Self {
        Grid { ends: Ends::of(tyre), side: tyre.ridden_side() * (1.0 + 1e-9), lateral: [17, 25] }
    }

    /// All that a file's ranges hold, as far as the estimated tyre's side force is believed.
    pub(crate) fn extended(tyre: &Characterised) -> Self {
        let validity = Validity::of(tyre);
        Grid { ends: validity.ends, side: validity.peak, lateral: [29, 21] }
    }

    /// All that a file's ranges hold.
    pub(crate) fn whole(tyre: &Characterised) -> Self {
        Grid { side: f64::INFINITY, lateral: [17, 13], ..Grid::extended(tyre) }
    }

    /// Pure longitudinal slip, upright.
    pub(crate) fn longitudinal(&self, tyre: &Characterised, load: f64) -> Vec<Input> {
        let slips = steps(self.ends.slip_ratio, 81);
        slips.into_iter().map(|s| tyre.input(s, 0.0, 0.0, load)).collect()
    }

    /// Slip angle and camber without slip ratio.
    pub(crate) fn lateral(&self, tyre: &Characterised, load: f64) -> Vec<Input> {
        let (angle, camber) = (self.ends.slip_angle, self.ends.camber);
        let most = self.side * load;
        let mut out = Vec::new();
        for g in steps([-camber, camber], self.lateral[1]) {
            for a in steps([-angle, angle], self.lateral[0]) {
                let input = tyre.input(0.0, a, g, load);
                if tyre.free_forces(&input).force_y.abs() <= most {
                    out.push(input);
                }
            }
        }
        out
    }

    /// All three slips at once.
    pub(crate) fn combined(&self, tyre: &Characterised, load: f64) -> Vec<Input> {
        let (angle, camber) = (self.ends.slip_angle, self.ends.camber);
        let most = self.side * load;
        let mut out = Vec::new();
        for s in steps(self.ends.slip_ratio, 13) {
            for g in steps([-camber, camber], 7) {
                for a in steps([-angle, angle], 7) {
                    let pure = tyre.free_forces(&tyre.input(0.0, a, g, load));
                    if pure.force_y.abs() <= most {
                        out.push(tyre.input(s, a, g, load));
                    }
                }
            }
        }
        out
    }
}

/// Ridden points of pure longitudinal slip.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn longitudinal(tyre: &Characterised, load: f64) -> Vec<Input> {
    Grid::ridden(tyre).longitudinal(tyre, load)
}
