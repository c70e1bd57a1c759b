//! Rider C: B with the slow part of the chassis' vertical motion (book, Off the road, section 9,
//! after the paper's last remark in section 4).
//!
//! `L_z = m_r (g - z_C'')`, `z_C''` the chassis' vertical acceleration through a second-order
//! Butterworth low-pass: the rider moves with the jump, not with the bump. The cut-off towards
//! zero is B, towards infinity a rider who is part of the chassis.
//!
//! With a `horizontal_cut_off` the rider moves fore and aft likewise: `A_x = -m_r x_C''`. There the
//! cut-off towards infinity is B.

use std::f64::consts::{PI, SQRT_2};

use super::types::{Base, Config, Forces, hold};
use crate::GRAVITY;

/// Coefficients `b` and `a` of the low-pass, bilinear with the cut-off pre-warped.
pub fn butterworth(cut_off: f64, rate: f64) -> ([f64; 3], [f64; 3]) {
    let k = (PI * cut_off / rate).tan();
    let n = 1.0 / (1.0 + SQRT_2 * k + k * k);
    let b = n * k * k;
    ([b, 2.0 * b, b], [1.0, 2.0 * n * (k * k - 1.0), n * (1.0 - SQRT_2 * k + k * k)])
}

/// Second-order filter, transposed direct form II, from rest.
#[derive(Debug, Clone, Copy)]
pub struct Biquad {
    b: [f64; 3],
    a: [f64; 3],
    state: [f64; 2],
}

impl Biquad {
    /// A filter at rest.
    pub fn new((b, a): ([f64; 3], [f64; 3])) -> Self {
        Biquad { b, a, state: [0.0; 2] }
    }

    #[inline]
    pub fn next(&mut self, x: f64) -> f64 {
        let y = self.b[0] * x + self.state[0];
        self.state[0] = self.b[1] * x - self.a[1] * y + self.state[1];
        self.state[1] = self.b[2] * x - self.a[2] * y;
        y
    }
}

/// `z_C''` of a session from `z_s''` (or `x_C''` from `x_s''`), m/s²; missing samples start the filter
/// afresh. `cut_off` in Hz, `rate` in samples per second.
pub(crate) fn low_passed(chassis: &[f64], rate: f64, cut_off: f64, zero_phase: bool) -> Vec<f64> {
    let coefficients = butterworth(cut_off.min(0.45 * rate), rate);
    let mut out = chassis.to_vec();
    let pass = |x: &mut dyn Iterator<Item = &mut f64>| {
        let mut filter = Biquad::new(coefficients);
        for v in x {
            if v.is_finite() {
                *v = filter.next(*v);
            } else {
                filter = Biquad::new(coefficients);
            }
        }
    };
    pass(&mut out.iter_mut());
    if zero_phase {
        pass(&mut out.iter_mut().rev());
    }
    out
}

/// The forces over a session. Legs push, they do not pull.
pub(crate) fn forces(mass: f64, base: &Base<'_>, config: &Config) -> Forces {
    let mut out = Forces::zeros(base.mu.len());
    let hold = hold(base, config.crossfade);
    let vertical = low_passed(base.zdd, base.rate, config.cut_off, config.zero_phase);
    let horizontal = config
        .horizontal_cut_off
        .map(|cut_off| low_passed(base.xdd, base.rate, cut_off, config.zero_phase));
    let forward = horizontal.as_deref().unwrap_or(base.xdd);
    for i in 0..base.mu.len() {
        let push = mass * (GRAVITY - vertical[i]);
        out.lz[i] = hold[i] * if push < 0.0 { 0.0 } else { push };
        let inertia = -hold[i] * mass * forward[i];
        out.ax[i] = config.arms * inertia;
        out.lx[i] = (1.0 - config.arms) * inertia;
    }
    out
}
