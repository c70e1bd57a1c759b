//! Formulas in which several hooks meet: written once for residuals and simulators.

use super::ModelError;
use super::physics::Rolling;
use crate::contract::bike::Axle;
use crate::tyre::paper::{Output, Tyre};

/// State of a tyre for the correction of its output.
#[derive(Debug, Clone, Copy)]
pub struct Acting<'a> {
    pub tyre: &'a Tyre,
    /// Lagged slip angle, rad.
    pub slip_angle: f64,
    /// Camber against the road, rad.
    pub camber: f64,
    /// Load that the output is for, N; 1 where it is per load.
    pub load: f64,
    /// Load to which changes are relative, N.
    pub reference_load: f64,
    /// Load beyond that, over it.
    pub extra_load: f64,
}

/// Friction and stiffness that fall with load do not fall below this share: no load turns a force.
pub(crate) const LEAST_UNDER_LOAD: f64 = 0.2;

impl ModelError {
    /// Force of drag, N, `coefficient v²` on still air, riding `along` the first straight's heading (1)
    /// or back (-1).
    #[inline]
    pub fn drag(&self, coefficient: f64, speed: f64, along: f64) -> f64 {
        let air = self.air_speed(speed, along);
        coefficient * air * air.abs()
    }

    /// Rolling radius of a wheel, m, whose base value is given.
    #[inline]
    pub fn radius(&self, base: f64, rolling: Rolling) -> f64 {
        self.rolling_radius(base * self.relative_radius(1.0, rolling), rolling)
    }

    /// Puts into a tyre of one end the errors of its own numbers. Its cornering stiffness stays what it is.
    pub fn put_into(&self, tyre: &mut Tyre, axle: Axle) {
        let change = self.side_force_ratio(0.0, axle);
        tyre.side_force_ratio += change;
        tyre.stiffness.c1 -= change;
        tyre.twisting_stiffness = self.twisting_stiffness(tyre.twisting_stiffness);
        tyre.relaxation_length = self.relaxation_length(tyre.relaxation_length);
    }

    /// Whether it changes a tyre's own numbers.
    pub fn changes_numbers(&self, axle: Axle) -> bool {
        self.side_force_ratio(0.0, axle) != 0.0
            || self.twisting_stiffness(0.0) != 0.0
            || self.relaxation_length(1.0) != 1.0
    }

    /// A tyre's output with the errors that are not errors of its numbers.
    #[inline]
    pub fn tyre_output(&self, out: Output, acting: &Acting<'_>) -> Output {
        self.output(out, acting, f64::NEG_INFINITY)
    }

    /// The same of a tyre that stands alone, under any load: neither force turns round.
    #[inline]
    pub fn bounded_output(&self, out: Output, acting: &Acting<'_>) -> Output {
        self.output(out, acting, LEAST_UNDER_LOAD)
    }

    #[inline]
    fn output(&self, out: Output, acting: &Acting<'_>, least: f64) -> Output {
        let Acting { tyre, slip_angle, camber, load, reference_load, extra_load } = *acting;
        let mut changed = Output {
            force_x: out.force_x * self.relative_friction(1.0, extra_load).max(least),
            force_y: out.force_y * self.relative_stiffness(1.0, extra_load).max(least),
            ..out
        };
        let trail = self.relative_trail(0.0);
        if trail != 0.0 {
            let k_alpha = tyre.stiffness.k_alpha(camber, tyre.side_force_ratio);
            let by_slip = -k_alpha * slip_angle * load;
            let shrinks = (1.0 - k_alpha / 3.0 * slip_angle.tan().abs()).max(0.0);
            changed.moment_z -= trail * tyre.trail_0(reference_load) * shrinks * by_slip;
        }
        changed
    }
}
