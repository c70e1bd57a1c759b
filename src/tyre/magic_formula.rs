//! The asymmetric Magic Formula of the longitudinal friction (eq. 28) and its peak.

use crate::statistics::search::minimum;

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

/// One point of the curve and how it moves with `b, c, d, e1, e2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    pub value: f64,
    /// Its derivative by the slip ratio.
    pub slope: f64,
    /// Derivatives of the value by the coefficients.
    pub value_by: [f64; 5],
    /// Derivatives of the slope by the coefficients.
    pub slope_by: [f64; 5],
}

/// The slip ratio of braking, `kappa`, of a normalised slip `sigma = kappa / (1 - kappa)` as in eq. 3.
pub(crate) fn slip_ratio(sigma: f64) -> f64 {
    sigma / (1.0 + sigma)
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

    /// Value, slope and curvature at once.
    pub fn value_slope_and_curvature(&self, s: f64) -> [f64; 3] {
        let Self { b, c, d, .. } = *self;
        let e = self.e1 + self.e2 * s.signum();
        let x = b * s;
        let q = 1.0 / (1.0 + x * x);
        // as in `point`: mu' = d c cos(c atan u) w v,  v = b (1 - e (1 - q)),  q' = -2 b x q^2
        let u = x - e * (x - x.atan());
        let (v, w) = (b * (1.0 - e * (1.0 - q)), 1.0 / (1.0 + u * u));
        let (sin, cos) = (c * u.atan()).sin_cos();
        let (by_u, bent) = (d * c * cos * w, -2.0 * e * b * b * x * q * q);
        let curvature = by_u * bent - d * c * v * v * w * w * (c * sin + 2.0 * u * cos);
        [d * sin, by_u * v, curvature]
    }

    /// Value and slope with their derivatives by the coefficients.
    pub fn point(&self, s: f64) -> Point {
        let Self { b, c, d, .. } = *self;
        let sign = s.signum();
        let e = self.e1 + self.e2 * sign;
        let x = b * s;
        let (arc, q) = (x.atan(), 1.0 / (1.0 + x * x));
        // mu = d sin(c atan u),  mu' = d c cos(c atan u) w v  with  v = du/ds, w = 1/(1 + u^2)
        let u = x - e * (x - arc);
        let tilt = 1.0 - e * (1.0 - q);
        let v = b * tilt;
        let (outer, w) = (u.atan(), 1.0 / (1.0 + u * u));
        let (sin, cos) = (c * outer).sin_cos();
        let by_u = d * c * cos * w;
        let slope_by_u = -d * c * v * w * w * (c * sin + 2.0 * u * cos);
        let (u_b, v_b) = (s * tilt, tilt - 2.0 * e * x * x * q * q);
        let (u_e, v_e) = (arc - x, -b * (1.0 - q));
        let slope_by_e = slope_by_u * u_e + by_u * v_e;
        Point {
            value: d * sin,
            slope: by_u * v,
            value_by: [by_u * u_b, d * outer * cos, sin, by_u * u_e, sign * by_u * u_e],
            slope_by: [
                slope_by_u * u_b + by_u * v_b,
                d * w * v * (cos - c * outer * sin),
                c * cos * w * v,
                slope_by_e,
                sign * slope_by_e,
            ],
        }
    }

    /// Slip stiffness at vanishing slip, `b c d`.
    pub fn stiffness(&self) -> f64 {
        self.b * self.c * self.d
    }

    /// Largest slope. It is that at vanishing slip unless the curvature is below `-(1 + c²/2)`: then the
    /// curve, flat at first, is steepest halfway to its peak.
    pub fn steepest(&self) -> f64 {
        let curvature = self.e1 - self.e2.abs();
        if curvature >= -(1.0 + 0.5 * self.c * self.c) {
            return self.stiffness();
        }
        let slope = |sign: f64| {
            let at = |k: u32| self.slope(sign * 0.05 * f64::from(k) / self.b);
            (0..=40).map(at).fold(0.0, f64::max)
        };
        slope(1.0).max(slope(-1.0))
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
    fn derivatives_are_those_of_differences() {
        let theta = [12.0, 1.5, 1.05, 0.3, -0.1];
        let of = |t: [f64; 5]| MagicFormula { b: t[0], c: t[1], d: t[2], e1: t[3], e2: t[4] };
        for s in [-0.4, -0.08, -0.003, 0.02, 0.15] {
            let point = of(theta).point(s);
            let (value, slope) = of(theta).value_and_slope(s);
            assert!((point.value - value).abs() < 1e-14 && (point.slope - slope).abs() < 1e-12);
            for j in 0..5 {
                let at = |sign: f64| {
                    let mut moved = theta;
                    moved[j] += sign * 1e-5;
                    of(moved).value_and_slope(s)
                };
                let (up, down) = (at(1.0), at(-1.0));
                let near = |a: f64, b: f64| (a - b).abs() < 1e-8 * (1.0 + b.abs());
                assert!(near(point.value_by[j], (up.0 - down.0) / 2e-5), "{s} {j}");
                assert!(near(point.slope_by[j], (up.1 - down.1) / 2e-5), "{s} {j}");
            }
        }
    }

    #[test]
    fn curvature_is_that_of_differences() {
        for mf in [MF, MagicFormula { e1: -2.0, e2: 0.3, ..MF }] {
            for s in [-0.4, -0.08, -0.003, 0.02, 0.15] {
                let [value, slope, curvature] = mf.value_slope_and_curvature(s);
                let known = mf.value_and_slope(s);
                assert!((value - known.0).abs() < 1e-14 && (slope - known.1).abs() < 1e-12);
                let numeric = (mf.slope(s + 1e-6) - mf.slope(s - 1e-6)) / 2e-6;
                assert!((curvature - numeric).abs() < 1e-6 * (1.0 + numeric.abs()), "{s}");
            }
        }
    }

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
