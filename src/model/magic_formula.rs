//! The asymmetric Magic Formula of the longitudinal friction (eq. 28) and its peak.

use crate::fit::search::minimum;

/// Coefficients of eq. 28.
///
/// ```text
/// (28) mu_x(s) = d sin{ c atan[ b s - (e1 + e2 sign s)(b s - atan(b s)) ] }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MagicFormula {
    /// Stiffness factor.
    pub b: f64,
    /// Shape factor.
    pub c: f64,
    /// Peak factor.
    pub d: f64,
    /// Curvature, both signs.
    pub e1: f64,
    /// Curvature, odd part.
    pub e2: f64,
}

impl MagicFormula {
    /// Engaged longitudinal friction over slip ratio, eq. 28.
    pub fn value(&self, s: f64) -> f64 {
        let bs = self.b * s;
        let e = self.e1 + self.e2 * s.signum();
        self.d * (self.c * (bs - e * (bs - bs.atan())).atan()).sin() // (28)
    }

    /// Derivative of [`MagicFormula::value`] with respect to the slip ratio.
    pub fn slope(&self, s: f64) -> f64 {
        self.value_and_slope(s).1
    }

    /// Value and derivative at once: the costly arc tangents are shared.
    pub fn value_and_slope(&self, s: f64) -> (f64, f64) {
        let bs = self.b * s;
        let e = self.e1 + self.e2 * s.signum();
        let inner = bs - e * (bs - bs.atan());
        let inner_slope = self.b * (1.0 - e * (1.0 - 1.0 / (1.0 + bs * bs)));
        let (sin, cos) = (self.c * inner.atan()).sin_cos();
        (self.d * sin, self.d * self.c * cos / (1.0 + inner * inner) * inner_slope)
    }

    /// Slip stiffness at vanishing slip, `b c d`.
    pub fn stiffness(&self) -> f64 {
        self.b * self.c * self.d
    }

    /// `sigma_x_max`: theoretical slip `-s/(1+s)` of the friction peak under braking, eq. 28
    /// restated in `sigma_x`. `None` where the curve has no peak before the wheel locks.
    pub fn peak_slip(&self) -> Option<f64> {
        const GRID: usize = 200;
        let friction = |sigma: f64| -self.value(-sigma / (1.0 + sigma));
        // s from 0 to -0.97 in even steps of log(sigma)
        let at = |i: usize| 0.005 * (30.0_f64 / 0.005).powf(i as f64 / GRID as f64);
        let best = (0..=GRID).max_by(|&i, &j| friction(at(i)).total_cmp(&friction(at(j))))?;
        if best == 0 || best == GRID {
            return None;
        }
        minimum(|sigma| -friction(sigma), at(best - 1), at(best + 1), 1e-10).map(|(sigma, _)| sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MF: MagicFormula = MagicFormula { b: 12.0, c: 1.6, d: 1.1, e1: 0.2, e2: -0.1 };

    #[test]
    fn slope_matches_differences() {
        for s in [-0.4, -0.1, -0.01, 0.02, 0.2] {
            let h = 1e-6;
            let numeric = (MF.value(s + h) - MF.value(s - h)) / (2.0 * h);
            assert!((MF.slope(s) - numeric).abs() < 1e-6 * MF.stiffness(), "at {s}");
        }
        assert!((MF.slope(1e-9) - MF.stiffness()).abs() < 1e-6);
    }

    #[test]
    fn peak_without_curvature_is_known_in_closed_form() {
        // e = 0: sin(c atan(b s)) peaks where c atan(b s) = pi/2
        let mf = MagicFormula { e1: 0.0, e2: 0.0, ..MF };
        let s = -(std::f64::consts::PI / (2.0 * mf.c)).tan() / mf.b;
        let sigma = -s / (1.0 + s);
        let found = mf.peak_slip().expect("a peak");
        assert!((found - sigma).abs() < 1e-6, "{found} {sigma}");
        assert!((mf.value(s) + mf.d).abs() < 1e-12);
    }

    #[test]
    fn no_peak_is_said() {
        assert_eq!(MagicFormula { c: 0.9, e1: 0.0, e2: 0.0, ..MF }.peak_slip(), None);
    }
}
