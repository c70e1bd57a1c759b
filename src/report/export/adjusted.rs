//! Slip over camber as it is exported: adjusted to the cornering stiffness that was fitted, and what that costs.
//!
//! `c1, c3` (eq. 37) and `ct` (eq. 38) are fits of their own. Their quotient misses the cornering stiffness that was
//! fitted to all three at once (eq. 39): by 8 % at the front of the bundled archive. A tyre has one quotient, so `c1`
//! and `c3` are chosen to give the fitted stiffness upright and at the largest camber. At the slip angles of eq. 37 the
//! side force is then another than eq. 38's; every exported file says by how much.

use super::ranges::Ranges;
use crate::statistics::number_format::short;
use crate::tyre::paper::{Stiffness, Tyre};

/// Points over the ridden camber.
const POINTS: usize = 51;
/// Least camber that is looked at, rad: upright there is no side force to be off from.
const LEAST_CAMBER: f64 = 0.01;

/// Changes by the adjustment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adjusted {
    /// `c1` and `c3` as they were fitted, and as the tyre has them.
    pub slip_over_camber: [[f64; 2]; 2],
    /// Cambers at which the tyre has the fitted stiffness, rad: upright, and the largest where there is one.
    camber: Option<f64>,
    /// Camber that was ridden, of either sign, rad.
    ridden: [f64; 2],
    /// Side force at the fitted slip angle over the fitted side force, less 1: least and largest over that camber.
    pub side_force: [f64; 2],
}

impl Adjusted {
    /// Makes the stiffness function give the fitted stiffness (1/rad): `upright`, and at the largest camber
    /// `leant` (rad, 1/rad).
    pub(crate) fn adjust(
        tyre: &mut Tyre,
        upright: f64,
        leant: Option<[f64; 2]>,
        ranges: &Ranges,
    ) -> Self {
        let fitted = tyre.stiffness;
        let s = &mut tyre.stiffness;
        let compliance = 1.0 / upright;
        s.c1 = -s.ct * compliance - tyre.side_force_ratio;
        let leant = leant.filter(|[g, k]| *g > 0.05 && *k > 0.0);
        if let Some([g, k]) = leant {
            s.c3 = -s.ct * (g.tan() / (g * k) - compliance) / (g * g);
        }
        let ridden = ridden(ranges);
        Adjusted {
            slip_over_camber: [[fitted.c1, fitted.c3], [s.c1, s.c3]],
            camber: leant.map(|[g, _]| g),
            ridden,
            side_force: side_force(tyre, &fitted, ridden),
        }
    }

    /// As lines of a comment; `axle` is whose they are.
    pub(crate) fn lines(&self, axle: &str) -> Vec<String> {
        let [[c1, c3], [now_1, now_3]] = self.slip_over_camber.map(|of| of.map(short));
        let at = self.camber.map(|g| format!(" and at a camber of {g:.2} rad")).unwrap_or_default();
        let [low, high] = self.side_force.map(|share| format!("{:+.1}", 100.0 * share));
        let [from, to] = self.ridden;
        vec![
            format!(
                "{axle}: slip_camber_c1 and slip_camber_c3 are adjusted, from {c1} and {c3} (fitted, eq. 37) to {now_1} \
                 and {now_3},"
            ),
            format!("so that the tyre has the fitted cornering stiffness (eq. 39), upright{at}."),
            format!(
                "At the fitted slip angles its side force is {low} to {high} % off the fitted one \
                 (lateral_friction_ct)"
            ),
            format!("over the camber that was ridden, {from:.2} to {to:.2} rad."),
        ]
    }
}

/// Least and largest size of the camber that was ridden.
fn ridden(ranges: &Ranges) -> [f64; 2] {
    let [low, high] = ranges.camber.unwrap_or([0.0, 0.5]);
    let least = if low < 0.0 && high > 0.0 { 0.0 } else { low.abs().min(high.abs()) };
    [least.max(LEAST_CAMBER), low.abs().max(high.abs()).max(LEAST_CAMBER)]
}

/// The adjusted tyre's side force at the slip angles of eq. 37 over that of eq. 38, less 1: least and largest.
fn side_force(tyre: &Tyre, fitted: &Stiffness, ridden: [f64; 2]) -> [f64; 2] {
    let ratio = tyre.side_force_ratio;
    let off = |g: f64| {
        let slip_angle = (fitted.c1 + fitted.c3 * g * g) * g; // (37)
        let force = -tyre.stiffness.k_alpha(g, ratio) * (slip_angle + ratio * g); // (13)
        force / (fitted.ct * g.tan()) - 1.0 // (38)
    };
    let [from, to] = ridden;
    let share = |i: usize| i as f64 / (POINTS - 1) as f64;
    let all = (0..POINTS).map(|i| off(from + share(i) * (to - from)));
    all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::scenario::Scenario;

    fn tyre() -> Tyre {
        let mut tyre = Scenario::builtin("perfect").expect("scenario").nominal_plant().tyres[0];
        tyre.stiffness = Stiffness { ct: -0.773, c1: -0.0142, c3: 0.0361 };
        tyre.side_force_ratio = 0.095;
        tyre
    }

    #[test]
    fn lines_say_from_what_to_what_and_how_far_the_side_force_is_off() {
        let ranges = Ranges { camber: Some([-0.736, -0.2]), ..Ranges::default() };
        let mut tyre = tyre();
        let adjusted = Adjusted::adjust(&mut tyre, 8.873, None, &ranges);
        let s = tyre.stiffness;
        assert_eq!(adjusted.slip_over_camber, [[-0.0142, 0.0361], [s.c1, s.c3]]);
        assert!((s.k_alpha(0.0, 0.095) / 8.873 - 1.0).abs() < 1e-12);
        // at the least camber: slip angle and C of (37) over those that the tyre has
        let share = |c1: f64, c3: f64| c1 + c3 * 0.04 + 0.095;
        let least = share(-0.0142, 0.0361) / share(s.c1, s.c3) - 1.0;
        assert!((adjusted.side_force[0] - least).abs() < 1e-9, "{adjusted:?}");
        let text = adjusted.lines("front").join(" ");
        for says in [
            "from -0.01420 and 0.03610 (fitted, eq. 37) to -0.0078",
            &format!("its side force is {:+.1} to", 100.0 * least),
            "camber that was ridden, 0.20 to 0.74 rad",
        ] {
            assert!(text.contains(says), "{says}: {text}");
        }
    }

    #[test]
    fn a_tyre_that_has_the_fitted_stiffness_is_not_off() {
        let ranges = Ranges { camber: Some([-0.7, 0.6]), ..Ranges::default() };
        let mut tyre = tyre();
        let k = |g: f64| tyre.stiffness.k_alpha(g, tyre.side_force_ratio);
        let (upright, leant) = (k(0.0), [0.7, k(0.7)]);
        let adjusted = Adjusted::adjust(&mut tyre, upright, Some(leant), &ranges);
        assert!(adjusted.side_force.iter().all(|x| x.abs() < 1e-9), "{adjusted:?}");
    }
}
