//! How a tyre depends on its load, in the form of property files: relative to their nominal load.
//!
//! ```text
//! x(Fz) = x_rest (1 + k (Fz/Fz_rest - 1)) = x_1 + x_2 dfz     dfz = Fz/FNOMIN - 1
//! ```
//!
//! `FNOMIN` need not be the load at rest, at which the coefficients hold.

use super::ends::{Ends, steps};
use super::tyre::Characterised;
use super::validity::Validity;
use crate::tyre::paper::slip_stiffness_under;

/// Quantities that change with load, each over its value under the load at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OverLoad {
    /// Friction at the nominal load, and what it gains with the nominal load once more.
    pub friction: [f64; 2],
    /// Slip stiffness per load without the friction, likewise.
    pub slip_stiffness: [f64; 2],
    /// Exponent of the friction's share in the slip stiffness, which a file has as `exp(PKX3 dfz)`: right at the
    /// nominal load, closest over the ridden ones.
    pub friction_exponent: f64,
    /// Side force per load at the nominal load, and what it gains with the nominal load once more.
    pub side_force: [f64; 2],
}

impl OverLoad {
    pub(crate) fn of(c: &Characterised) -> Self {
        let rest = c.tyre.nominal_load;
        let extra = |dfz: f64| c.load() * (1.0 + dfz) / rest - 1.0;
        let line = |value: &dyn Fn(f64) -> f64| {
            let at = value(extra(0.0));
            [at, value(extra(1.0)) - at]
        };
        let friction = |extra: f64| c.error.relative_friction(1.0, extra);
        let lines = line(&friction);
        let gain = c.tyre.slip_stiffness_load;
        let at = slip_stiffness_under(gain, extra(0.0));
        let (mut above, mut below) = (0.0, 0.0);
        if lines[1] != 0.0 {
            for load in steps(Ends::of(c).load, 21) {
                let dfz = load / c.load() - 1.0;
                above += dfz * (friction(extra(dfz)) / lines[0]).max(0.05).ln();
                below += dfz * dfz;
            }
        }
        OverLoad {
            friction: lines,
            slip_stiffness: [at, gain * c.load() / rest],
            friction_exponent: if below > 0.0 { above / below } else { 0.0 },
            side_force: line(&|extra| c.error.relative_stiffness(1.0, extra)),
        }
    }

    /// Relative gain of the side force per load when the load rises by the nominal load.
    pub(crate) fn side_force_gain(&self) -> f64 {
        self.side_force[1] / self.side_force[0]
    }

    /// Stiffness of a carcass over its load, `1 + a dfz + b dfz²`, with which a relaxation length is the same at every
    /// load: in proportion to a slip stiffness (of a load, N), closest over the loads of the file.
    pub(crate) fn carcass(c: &Characterised, stiffness: impl Fn(f64) -> f64) -> [f64; 2] {
        let nominal = stiffness(c.load());
        let [mut aa, mut ab, mut bb, mut ay, mut by] = [0.0; 5];
        for load in steps(Validity::of(c).ends.load, 59) {
            let (dfz, share) = (load / c.load() - 1.0, stiffness(load) / nominal);
            // of relative errors, as those of the length are
            let per = 1.0 / share.abs().max(0.05);
            let (a, b, y) = (dfz * per, dfz * dfz * per, (share - 1.0) * per);
            aa += a * a;
            ab += a * b;
            bb += b * b;
            ay += a * y;
            by += b * y;
        }
        let det = aa * bb - ab * ab;
        if det > 0.0 { [(ay * bb - by * ab) / det, (by * aa - ay * ab) / det] } else { [1.0, 0.0] }
    }

    /// `PKX1` and `PKX2` of a slip stiffness per load (the curve's own).
    pub(crate) fn slip_stiffness_of(&self, curve: f64) -> [f64; 2] {
        self.slip_stiffness.map(|share| curve * self.friction[0] * share)
    }
}
