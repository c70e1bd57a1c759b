//! Rider B: algebraic (Vasquez et al. 2019, eq. 9).
//!
//! `f_r = [0, m_r g, -m_r x_s'', 0]`: the weight on the pegs, the horizontal inertia at the bar;
//! nothing while both wheels are off.

use super::types::{Base, Config, Forces, hold};
use crate::GRAVITY;

/// One sample of eq. 9.
pub fn force(mass: f64, xdd: f64, airborne: bool) -> [f64; 4] {
    if airborne { [0.0; 4] } else { [0.0, mass * GRAVITY, -mass * xdd, 0.0] }
}

/// The forces over a session.
pub(crate) fn forces(mass: f64, base: &Base<'_>, config: &Config) -> Forces {
    let mut out = Forces::zeros(base.mu.len());
    let hold = hold(base, config.crossfade);
    for (i, (xdd, hold)) in base.xdd.iter().zip(hold).enumerate() {
        let [_, lz, ax, _] = force(mass, *xdd, false);
        out.lz[i] = hold * lz;
        out.ax[i] = hold * config.arms * ax;
        out.lx[i] = hold * (1.0 - config.arms) * ax;
    }
    out
}
