//! Derivatives by the errors, by central differences: exact to 1e-8 for rows and outputs as smooth as
//! these, and no second place that must agree with a formula.

use super::state::{Errors, State};

/// Half a step; rad, m, m/s, s.
const STEP: f64 = 1e-4;

/// Derivatives of a number by the errors in `parts`; zero by all others.
pub(super) fn gradient(h: &dyn Fn(&State) -> f64, state: &State, parts: &[usize]) -> Errors {
    let mut out = Errors::zeros();
    let mut errors = Errors::zeros();
    for &i in parts {
        errors[i] = STEP;
        let above = h(&state.corrected(&errors));
        errors[i] = -STEP;
        let below = h(&state.corrected(&errors));
        errors[i] = 0.0;
        out[i] = (above - below) / (2.0 * STEP);
    }
    out
}

/// Derivatives of several numbers by the errors in `parts`.
pub(super) fn gradients<const M: usize>(
    h: &dyn Fn(&State) -> [f64; M],
    state: &State,
    parts: &[usize],
) -> [Errors; M] {
    let mut out = [Errors::zeros(); M];
    let mut errors = Errors::zeros();
    for &i in parts {
        errors[i] = STEP;
        let above = h(&state.corrected(&errors));
        errors[i] = -STEP;
        let below = h(&state.corrected(&errors));
        errors[i] = 0.0;
        for (k, row) in out.iter_mut().enumerate() {
            row[i] = (above[k] - below[k]) / (2.0 * STEP);
        }
    }
    out
}
