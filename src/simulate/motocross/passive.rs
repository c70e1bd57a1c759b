//! The rider of the simulated bike as the estimate's riders B and C have him: no body, a law.
//!
//! ```text
//! L_z = m (g - z_C''),  A_x = -m x_C'',  z_C'', x_C'' = low-pass of z_s'', x_s''
//! y'' + sqrt(2) w y' + w^2 y = w^2 z_s'',  y = z_C'',  w = 2 pi cut-off
//! ```
//! A vertical cut-off of zero and no horizontal one (`x_C'' = x_s''`) are rider B. The low-pass is
//! causal, as a body is; the estimate's rider C with `zero_phase = false` is this one. He lets go as the tyres unload: nothing acts in flight.
//!
//! Source: book, Off the road, section 9, after Vasquez et al. 2019, eq. 9.

use std::f64::consts::{SQRT_2, TAU};

use crate::GRAVITY;

/// Sum of the tyre loads below which he begins to let go, N.
const LIGHT: f64 = 300.0;

/// A rider without a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passive {
    /// Mass, kg.
    pub mass: f64,
    /// Below this he follows the chassis up and down, Hz; zero: never.
    pub cut_off: f64,
    /// Below this he follows it fore and aft, Hz; absent: always.
    pub horizontal: Option<f64>,
}

impl Passive {
    /// How far he holds on, 0 to 1, from the sum of the tyre loads, N.
    pub fn hold(&self, load: f64) -> f64 {
        (load / LIGHT).clamp(0.0, 1.0)
    }

    /// Push on the pegs, down, N, from his own vertical acceleration (down, m/s²); legs do not pull.
    pub fn push(&self, own: f64) -> f64 {
        (self.mass * (GRAVITY - own)).max(0.0)
    }
}

/// Second rate of his own acceleration from that of the chassis; the cut-off in Hz.
pub(crate) fn follow(cut_off: f64, own: f64, own_rate: f64, chassis: f64) -> f64 {
    let w = TAU * cut_off;
    w * w * (chassis - own) - SQRT_2 * w * own_rate
}
