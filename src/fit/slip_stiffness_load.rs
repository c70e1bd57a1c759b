//! How a tyre's slip stiffness goes with its load, from a tyre that was braked and driven.
//!
//! METHOD: braking takes load off the rear wheel, driving puts it on. A tyre whose slip stiffness per load rises with
//! the load is therefore softer in braking than in driving, and a curve without that needs an odd curvature `e2` to
//! say so. Tyres themselves hardly know the direction: with the bike file's gain `k_0 +- s_k` and an odd curvature of
//! `0 +- s_e`, the fit's `e2(k)` tells the gain,
//!
//! ```text
//! k = argmin ((k - k_0)/s_k)^2 + (e2(k))^2/(s_e^2 + se^2),   e2(k) = e2(k_0) + e2' (k - k_0)
//! ```
//!
//! A front tyre is never driven: of it the bike file's stays.

use super::friction::{E2, Friction, Rows};
use crate::contract::coefficient::Coefficient;

/// Standard deviation of the odd curvature of motorcycle tyres: 0.00 to 0.03 in the sets of Sharp et al. (2004), 0.30
/// and 0.36 in a vendor's sample set.
const ODD_CURVATURE: f64 = 0.3;
/// Change of the gain for a difference.
pub(crate) const STEP: f64 = 0.1;

/// Relative gain of the slip stiffness per load when the load rises by the load at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gain {
    pub value: f64,
    pub sd: f64,
}

/// The gain after a fit with `before`; `moved` are the same samples with [`STEP`] more of it. `None` where the tyre was
/// not both braked and driven.
pub(crate) fn after(before: Gain, fit: &Friction, moved: &Rows) -> Option<Gain> {
    let odd = *fit.theta.get(E2)?;
    let slope = (fit.refit_with_fixed_weights(moved).get(E2)? - odd) / STEP;
    let own = fit.uncertainty(Coefficient::MfE2)?.variance;
    let odd_weight = 1.0 / (ODD_CURVATURE * ODD_CURVATURE + own);
    let prior = 1.0 / (before.sd * before.sd);
    let information = prior + slope * slope * odd_weight;
    let value = before.value - slope * odd * odd_weight / information;
    let sd = information.recip().sqrt();
    (value.is_finite() && sd.is_finite()).then_some(Gain { value, sd })
}
