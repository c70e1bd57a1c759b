//! The paper's tyre: forces and moments from slips, camber and load (eqs. 1-22).
//!
//! ```text
//! (2)  sigma_x = -s/(1+s)              sigma_y = -tan(alpha)/(1+s)
//! (3)  sigma_x* = sigma_x/sigma_x_max  sigma_y* = sigma_y/sigma_y_max
//! (4)  sigma* = sqrt(sigma_x*^2 + sigma_y*^2)
//! (8)  Fx = -cos(lambda) mu/mu0 Fx0* sign(sigma_x*)   Fy_alpha = sin(lambda) mu/mu0 Fy0*
//! (15) Fy_gamma = -C k_alpha(gamma) Fz gamma / (1 + c_Fy sigma_x*^2)
//! (18) Mx = -k_x Fz tan(gamma)
//! (20) Mz = -t_p Fy_alpha + Mz_gamma + k_x Fx tan(gamma)
//! ```
//!
//! Source: Bartolozzi et al. 2024, with these departures from the print:
//! - (6b) scales the slip angle by `mu0/mu`, as (6a) does the slip: friction similarity. Its stiffness is that at the
//!   camber itself: at `mu0/mu gamma`, as printed, it has a pole where that is a right angle;
//! - both forces together stay within the friction circle ([`Tyre::circle`]), which the print leaves open;
//! - (9a) uses the total normalised slip: how large the slip is decides, not its direction;
//! - (11) the friction scales the trail's slip argument once;
//! - (18) carries a minus: in a left corner the contact point moves inwards and rights the bike.
#![allow(non_snake_case)] // symbols keep the capitals of the source

use serde::{Deserialize, Serialize};

use super::magic_formula::MagicFormula;

/// Least road friction: ice has some.
const LEAST_FRICTION: f64 = 1e-3;
/// `1 + s` is kept above this: a locked wheel is a limit, not a division by zero.
const MIN_ROLLING: f64 = 1e-4;
/// A slip stiffness that falls with load does not fall below this share.
const LEAST_SLIP_STIFFNESS: f64 = 0.2;

/// Cornering stiffness per load over camber, as the two fitted functions give it (eq. 39).
///
/// ```text
/// (37) alpha(gamma) = c1 gamma + c3 gamma^3
/// (38) mu_y(gamma)  = ct tan(gamma)
/// (39) k_alpha = -mu_y / (alpha + C gamma);  k_alpha0 = -ct / (c1 + C)
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stiffness {
    /// Lateral friction over `tan(gamma)`, negative.
    pub ct: f64,
    /// Slip angle per camber.
    pub c1: f64,
    /// Slip angle per camber cubed, 1/rad².
    pub c3: f64,
}

impl Stiffness {
    /// `k_alpha(gamma)`, 1/rad. The denominator of (39) is kept above a fifth of its upright
    /// value, so that no camber makes the stiffness explode or change sign.
    pub fn k_alpha(&self, gamma: f64, C: f64) -> f64 {
        self.k_alpha_at(gamma, gamma.tan(), C)
    }

    /// The same where the tangent of the camber is known.
    fn k_alpha_at(&self, gamma: f64, tan_gamma: f64, C: f64) -> f64 {
        let upright = self.c1 + C;
        let per_camber = upright + self.c3 * gamma * gamma;
        let per_camber = if upright > 0.0 { per_camber.max(0.2 * upright) } else { per_camber };
        -self.ct * tan_per_camber(gamma, tan_gamma) / per_camber // (39), divided through by gamma
    }
}

/// `tan(gamma)/gamma`, 1 upright.
fn tan_per_camber(gamma: f64, tan_gamma: f64) -> f64 {
    if gamma.abs() < 1e-6 { 1.0 } else { tan_gamma / gamma }
}

/// One tyre. SI units, per-load stiffnesses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tyre {
    /// Longitudinal friction, eq. 28.
    pub friction: MagicFormula,
    /// Cornering stiffness over camber, eq. 39.
    pub stiffness: Stiffness,
    /// Camber-to-cornering stiffness ratio `C`, eq. 13.
    pub side_force_ratio: f64,
    /// `k_t`, m/rad, eq. 16.
    pub twisting_stiffness: f64,
    /// `k_x`, m, eq. 18.
    pub overturning_stiffness: f64,
    /// `R_rol`, m.
    pub rolling_radius: f64,
    /// `c_rol`, eq. 21.
    pub rolling_resistance: f64,
    /// `r_l`, m, eq. 1.
    pub relaxation_length: f64,
    /// `K_z`, N/m, eq. 12.
    pub vertical_stiffness: f64,
    /// `c_Fy_gamma`, eq. 15.
    pub camber_force_decay: f64,
    /// `c_Mz_gamma`, eq. 17.
    pub camber_moment_decay: f64,
    /// `mu0`: road friction when the tyre was characterised.
    pub reference_friction: f64,
    /// `sigma_x_max` = `sigma_y_max`.
    pub peak_slip: f64,
    /// Side force over load that the tyre has reached on that road, where it is more than the longitudinal peak: no
    /// friction circle is smaller; [`NO_LIMIT`] for a side force without a limit.
    #[serde(default)]
    pub lateral_peak: f64,
}

/// Slips, camber and load of a tyre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Input {
    /// Slip ratio `s`, positive driving.
    pub slip_ratio: f64,
    /// Lagged slip angle `alpha`, rad.
    pub slip_angle: f64,
    /// Camber `gamma`, rad.
    pub camber: f64,
    /// Load `Fz`, N.
    pub load: f64,
    /// Road friction `mu`.
    pub friction: f64,
}

/// Response of the tyre: forces in the wheel's frame at the contact of a thin disk.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Output {
    /// Longitudinal slip force, N. Rolling resistance comes on top.
    pub force_x: f64,
    /// Lateral force, N.
    pub force_y: f64,
    /// Overturning moment, N m.
    pub moment_x: f64,
    /// Yaw moment, N m.
    pub moment_z: f64,
}

impl Output {
    /// Share of a force of this size (N) that a friction circle (N) leaves.
    #[inline]
    fn share(force_x: f64, force_y: f64, circle: f64) -> f64 {
        let square = force_x * force_x + force_y * force_y;
        if square > circle * circle { circle / square.sqrt() } else { 1.0 }
    }

    /// Both forces shortened to a friction circle (N) where they leave it; the moments stay.
    #[inline]
    pub fn within(self, circle: f64) -> Self {
        let share = Self::share(self.force_x, self.force_y, circle);
        Output { force_x: share * self.force_x, force_y: share * self.force_y, ..self }
    }
}

/// `sign` of the paper: zero at zero.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// A [`lateral_peak`](Tyre::lateral_peak) that limits nothing; a number, so that tyre files can hold it.
pub(crate) const NO_LIMIT: f64 = 1e9;

impl Tyre {
    /// Pneumatic trail at vanishing slip, m, eq. 12.
    ///
    /// The unloaded radius is taken as the rolling radius plus a third of the deflection, the
    /// usual relation between the two.
    pub fn trail_0(&self, Fz: f64) -> f64 {
        trail_0(self.rolling_radius, self.vertical_stiffness, Fz)
    }

    /// Radius of the friction circle over load on a road: the larger of the longitudinal peak and of what the side force
    /// has reached, in proportion to the friction.
    #[inline]
    pub fn circle(&self, mu: f64) -> f64 {
        self.friction.d.abs().max(self.lateral_peak) * mu.max(LEAST_FRICTION)
            / self.reference_friction
    }

    /// Rolling resistance force, N, eq. 21.
    pub fn rolling_force(&self, Fz: f64) -> f64 {
        -self.rolling_resistance * Fz // (21)
    }

    /// Rate of the lagged slip angle, rad/s, eq. 1. At standstill it is zero.
    pub fn slip_angle_rate(&self, omega: f64, alpha_kin: f64, alpha: f64) -> f64 {
        let v_tan = self.rolling_radius * omega.abs();
        v_tan / self.relaxation_length * (alpha_kin - alpha) // (1)
    }

    /// Forces and moments, eqs. 2-20.
    pub fn forces(&self, input: &Input) -> Output {
        self.forces_at(input, input.camber.tan())
    }

    /// The same where the tangent of the camber is known.
    pub(crate) fn forces_at(&self, input: &Input, tan_gamma: f64) -> Output {
        let Input { slip_ratio: s, slip_angle: alpha, camber: gamma, load: Fz, friction: mu } =
            *input;
        if Fz <= 0.0 {
            return Output::default(); // off the ground
        }
        let (mu, mu0) = (mu.max(LEAST_FRICTION), self.reference_friction);
        let sigma_max = self.peak_slip; // of both directions
        let C = self.side_force_ratio;
        let k_x = self.overturning_stiffness;

        let rolling = (1.0 + s).max(MIN_ROLLING);
        let s = rolling - 1.0;
        let sigma_x = -s / rolling; // (2a)
        let sigma_y = -alpha.tan() / rolling; // (2b)
        let sigma_xn = sigma_x / sigma_max; // (3a)
        let sigma_yn = sigma_y / sigma_max; // (3b)
        let sigma_n = (sigma_xn * sigma_xn + sigma_yn * sigma_yn).sqrt(); // (4)

        let signed_x = sigma_n * sigma_max * sign(sigma_x);
        let s_eq = -signed_x / (1.0 + signed_x).max(MIN_ROLLING); // (5a)
        let tan_alpha_eq = if sigma_y == 0.0 { 0.0 } else { sigma_n * sigma_max }; // (5b), size

        let similarity = mu0 / mu;
        let Fx0 = self.friction.value(similarity * s_eq).abs() * Fz; // (6a)
        let k_alpha = self.stiffness.k_alpha_at(gamma, tan_gamma, C);
        let Fy0 = k_alpha * Fz * (similarity * tan_alpha_eq.atan()).abs(); // (6b), corrected

        // with one peak slip for both directions eta (9b) and theta (9c) are one angle, and lambda (9a)
        // is it whatever q1
        let (cos_lambda, sin_lambda) = match sigma_n > 0.0 {
            true => (sigma_xn.abs() / sigma_n, sigma_yn / sigma_n),
            false => (1.0, 0.0),
        };
        let Gamma = sigma_n.min(1.0);
        let Fx0_basic = Fx0 - Gamma * (Fx0 - Fy0) * sin_lambda * sin_lambda; // (7a)
        let Fy0_basic = Fy0 - Gamma * (Fy0 - Fx0) * cos_lambda * cos_lambda; // (7b)
        let Fx = -cos_lambda / similarity * Fx0_basic * sign(sigma_xn); // (8a)
        let Fy_alpha = sin_lambda / similarity * Fy0_basic; // (8b)

        let Fy_gamma = -C * k_alpha * Fz * gamma // (13), (14)
            / (1.0 + self.camber_force_decay * sigma_xn * sigma_xn); // (15)

        // both forces end at the friction circle, in the direction that they have
        let share = Output::share(Fx, Fy_alpha + Fy_gamma, self.circle(mu) * Fz);
        let (Fx, Fy_alpha, Fy_gamma) = (share * Fx, share * Fy_alpha, share * Fy_gamma);

        let k_alpha0 = self.stiffness.k_alpha_at(0.0, 0.0, C);
        let relative_trail = (1.0 - k_alpha0 / (3.0 * mu) * tan_alpha_eq).max(0.0);
        let t_p = self.trail_0(Fz) * relative_trail; // (11), friction once
        let Mz_alpha = -t_p * Fy_alpha; // (10)
        let Mz_gamma = -self.twisting_stiffness * Fz * gamma // (16)
            / (1.0 + self.camber_moment_decay * sigma_n * sigma_n); // (17)
        let Mx = -k_x * Fz * tan_gamma; // (18), corrected
        let Mz_offset = k_x * Fx * tan_gamma; // (19)
        Output {
            force_x: Fx,
            force_y: Fy_alpha + Fy_gamma,
            moment_x: Mx,
            moment_z: Mz_alpha + Mz_gamma + Mz_offset, // (20)
        }
    }
}

/// Slip stiffness per load over that under the load at rest: a slip counts as so many times itself, which leaves the
/// peak of the friction where it is.
///
/// `per_load` is what is gained with the load at rest once more, `extra_load` the load beyond it over it. The paper's
/// form has none of it.
#[inline(always)]
pub fn slip_stiffness_under(per_load: f64, extra_load: f64) -> f64 {
    (1.0 + per_load * extra_load).max(LEAST_SLIP_STIFFNESS)
}

/// Pneumatic trail at vanishing slip, m, eq. 12: a third of the half contact length.
///
/// The unloaded radius of (12b) is the rolling radius plus a third of the deflection.
pub(crate) fn trail_0(R_rol: f64, K_z: f64, Fz: f64) -> f64 {
    let deflection = (Fz / K_z).max(0.0);
    let R_unl = R_rol + deflection / 3.0;
    let R_loa = R_unl - deflection; // (12b)
    (R_unl * R_unl - R_loa * R_loa).max(0.0).sqrt() / 3.0 // (12a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tyre() -> Tyre {
        Tyre {
            friction: MagicFormula { b: 12.0, c: 1.6, d: 1.1, e1: 0.1, e2: 0.1 },
            stiffness: Stiffness { ct: -0.885, c1: -0.0107, c3: 0.02 },
            side_force_ratio: 0.078,
            twisting_stiffness: 0.039,
            overturning_stiffness: 0.07,
            rolling_radius: 0.31,
            rolling_resistance: 0.015,
            relaxation_length: 0.31,
            vertical_stiffness: 141e3,
            camber_force_decay: 1.0,
            camber_moment_decay: 1.0,
            reference_friction: 1.0,
            peak_slip: 0.12,
            lateral_peak: 0.0,
        }
    }

    fn input(s: f64, alpha: f64, gamma: f64) -> Input {
        Input { slip_ratio: s, slip_angle: alpha, camber: gamma, load: 1300.0, friction: 1.0 }
    }

    #[test]
    fn papers_upright_stiffnesses() {
        // book, Estimation, section 1: front 12.5, C 0.095 -> 1.19, c1 -0.0279 -> ct about -0.84;
        // rear 13.2, 0.078 -> 1.03, c1 -0.0107 -> about -0.885
        for (k, c, c1, ct, k_gamma) in
            [(12.5, 0.095, -0.0279, -0.84, 1.19), (13.2, 0.078, -0.0107, -0.885, 1.03)]
        {
            let stiffness = Stiffness { ct, c1, c3: 0.0 };
            let found = stiffness.k_alpha(0.0, c);
            assert!((found - k).abs() < 0.06, "{found} {k}");
            assert!((found * c - k_gamma).abs() < 0.01, "{}", found * c);
        }
    }

    #[test]
    fn uncombined_reduces_to_eq_22() {
        let t = tyre();
        let C = t.side_force_ratio;
        for gamma in [-0.6, -0.2, 0.0, 0.3] {
            for alpha in [-0.03, -0.005, 0.0, 0.01] {
                let out = t.forces(&input(0.0, alpha, gamma));
                let k = t.stiffness.k_alpha(gamma, C);
                let expected = -k * 1300.0 * (alpha + C * gamma); // (22b)
                assert!((out.force_y - expected).abs() < 1e-9 * 1300.0, "{gamma} {alpha}");
                assert_eq!(out.force_x, 0.0);
                assert!((out.moment_x + 0.07 * 1300.0 * gamma.tan()).abs() < 1e-9);
            }
        }
        for s in [-0.3, -0.05, 0.0, 0.08] {
            let out = t.forces(&input(s, 0.0, 0.0));
            assert!((out.force_x - t.friction.value(s) * 1300.0).abs() < 1e-9 * 1300.0, "{s}"); // (22a)
            assert_eq!(out.force_y, 0.0);
        }
    }

    #[test]
    fn limits_are_finite_and_locked_wheel_slides_against_its_motion() {
        let t = tyre();
        for (s, alpha) in [(-1.0, 0.0), (-1.0, 0.2), (-1.5, -0.1), (5.0, 0.3), (0.0, 0.0)] {
            let out = t.forces(&input(s, alpha, -0.3));
            for x in [out.force_x, out.force_y, out.moment_x, out.moment_z] {
                assert!(x.is_finite(), "{s} {alpha}: {out:?}");
            }
        }
        let out = t.forces(&input(-1.0, 0.2, 0.0));
        // force direction of a sliding wheel is that of its velocity: tan(lambda) = tan(alpha)
        assert!((out.force_y / out.force_x - 0.2_f64.tan()).abs() < 0.02, "{out:?}");
    }

    #[test]
    fn friction_similarity_keeps_slopes_and_scales_the_peak() {
        let t = tyre();
        let wet = |s, alpha| t.forces(&Input { friction: 0.5, ..input(s, alpha, 0.0) });
        let dry = |s, alpha| t.forces(&input(s, alpha, 0.0));
        let (a, b) = (wet(-1e-4, 0.0).force_x, dry(-1e-4, 0.0).force_x);
        assert!((a / b - 1.0).abs() < 1e-3);
        let (a, b) = (wet(0.0, 1e-4).force_y, dry(0.0, 1e-4).force_y);
        assert!((a / b - 1.0).abs() < 1e-3);
        let peak = (1..400).map(|i| -wet(-0.001 * f64::from(i), 0.0).force_x / 1300.0);
        let peak = peak.fold(0.0, f64::max);
        assert!((peak - 0.5 * t.friction.d).abs() < 1e-3, "{peak}");
    }

    #[test]
    fn a_left_corner_rights_the_machine_and_pulls_inwards() {
        let out = tyre().forces(&input(0.0, -0.005, -0.5));
        assert!(out.force_y > 0.0 && out.moment_x > 0.0);
    }

    #[test]
    fn trail_never_turns_negative() {
        let t = tyre();
        for alpha in [0.05, 0.2, 0.6] {
            let out = t.forces(&input(0.0, alpha, 0.0));
            assert!(out.moment_z >= 0.0, "{alpha}: {out:?}");
        }
    }
}
