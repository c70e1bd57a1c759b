//! The Magic Formula turned round: slip of a longitudinal friction, under lean.
//!
//! ```text
//! w = sqrt(1 - (tan phi / mu_y)^2),  D' = w D,  K' = w^p K,  B = K' / (C D')
//! y = tan(asin(mu / D') / C),   x - E (x - atan x) = y,   s = sign(mu) x / B
//! ```
//! Beyond 0.95 of the peak the slip goes on as the tangent there: a measured friction may exceed the peak.

/// Share of the peak up to which the formula is inverted.
const INVERTED: f64 = 0.95;
/// Least `w²`: lean beyond the lateral limit leaves this much.
const LEAST_LEFT: f64 = 0.05;
/// Largest curvature: at 1 the formula has no inverse far out.
const MOST_CURVATURE: f64 = 0.9;

/// A tyre's friction curve upright, and how lean takes from it.
#[derive(Debug, Clone, Copy)]
pub struct Curve {
    /// Slip stiffness over load, `b c d`.
    pub stiffness: f64,
    /// Peak friction.
    pub peak: f64,
    pub shape: f64,
    pub curvature: f64,
    /// How the stiffness falls with what lean leaves: `p`.
    pub exponent: f64,
    /// Lateral limit.
    pub lateral: f64,
}

/// Slip at a friction.
#[derive(Debug, Clone, Copy)]
pub struct Slip {
    pub value: f64,
    /// Its derivative by the friction.
    pub slope: f64,
    /// Share of the friction under lean, `w`.
    pub left: f64,
    /// Slope of the curve there over that at vanishing slip.
    pub steepness: f64,
}

impl Slip {
    /// That of a tyre whose slip stiffness is so many times the curve's; its peak is the same.
    pub fn of_stiffer(self, times: f64) -> Slip {
        Slip { value: self.value / times, slope: self.slope / times, ..self }
    }
}

impl Curve {
    pub fn left(&self, tan_lean: f64) -> f64 {
        (1.0 - (tan_lean / self.lateral).powi(2)).max(LEAST_LEFT).sqrt()
    }

    /// The slip that gives a friction (signed) at a lean.
    pub fn slip(&self, friction: f64, tan_lean: f64) -> Slip {
        let left = self.left(tan_lean);
        let peak = left * self.peak;
        let stiffness = left.powf(self.exponent) * self.stiffness;
        let b = stiffness / (self.shape * peak);
        let e = self.curvature.min(MOST_CURVATURE);
        let wanted = friction.abs() / peak;
        let q = wanted.min(INVERTED);
        let y = (q.asin() / self.shape).tan();
        let mut x = y;
        for _ in 0..8 {
            let f = x - e * (x - x.atan()) - y;
            x = (x - f / (1.0 - e * x * x / (1.0 + x * x))).max(0.0);
        }
        let by_q =
            (1.0 + y * y) / (self.shape * (1.0 - q * q).sqrt()) / (1.0 - e * x * x / (1.0 + x * x));
        let slope = by_q / (b * peak);
        Slip {
            value: friction.signum() * (x / b + slope * (wanted - q) * peak),
            slope,
            left,
            steepness: 1.0 / (slope * stiffness),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tyre::magic_formula::MagicFormula;

    #[test]
    fn the_slip_of_the_forward_formula_comes_back_on_both_sides() {
        for (shape, curvature) in [(1.55, 0.0), (1.4, 0.5), (1.7, -0.7), (1.9, -2.0)] {
            let curve = Curve {
                stiffness: 22.0,
                peak: 1.3,
                shape,
                curvature,
                exponent: 0.7,
                lateral: 1.45,
            };
            let b = curve.stiffness / (shape * curve.peak);
            let forward = MagicFormula { b, c: shape, d: curve.peak, e1: curvature, e2: 0.0 };
            for k in 1..400 {
                let s = 0.0005 * f64::from(k);
                let mu = forward.value(s);
                if mu > 0.94 * curve.peak {
                    break; // to the peak: beyond it is the tangent
                }
                let (up, down) = (curve.slip(mu, 0.0), curve.slip(-mu, 0.0));
                assert!((up.value - s).abs() < 1e-8, "{shape} {curvature} {s} {}", up.value);
                assert!((down.value + s).abs() < 1e-8);
                assert!((up.slope * forward.slope(s) - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn lean_takes_friction_and_stiffness() {
        let curve = Curve {
            stiffness: 22.0,
            peak: 1.3,
            shape: 1.55,
            curvature: 0.0,
            exponent: 0.7,
            lateral: 1.45,
        };
        let tan = 40_f64.to_radians().tan();
        let left = (1.0 - (tan / 1.45).powi(2)).sqrt();
        let small = curve.slip(1e-6, tan);
        assert!((1.0 / small.slope - left.powf(0.7) * 22.0).abs() < 1e-3);
        assert!(curve.slip(0.5, tan).value > curve.slip(0.5, 0.0).value);
        assert!(curve.slip(3.0, 0.0).value.is_finite());
    }
}
