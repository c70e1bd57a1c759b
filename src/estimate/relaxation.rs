//! Slip angles that lag behind the kinematic ones by the tyres' relaxation (1).

use super::samples::Samples;

/// The slip angles behind the kinematic ones by the relaxation of each tyre (1).
pub(crate) struct SlipLag {
    /// Rate of the samples, Hz.
    rate: f64,
    /// Relaxation lengths, m.
    relaxation: [f64; 2],
    lagged: [f64; 2],
    previous: [f64; 2],
}

impl SlipLag {
    /// `relaxation` in m, `rate` of the samples in Hz.
    pub(crate) fn new(relaxation: [f64; 2], rate: f64) -> Self {
        SlipLag { rate, relaxation, lagged: [0.0; 2], previous: [0.0; 2] }
    }

    /// The slip angles of sample `i` at a speed; each stretch of samples starts without lag.
    pub(crate) fn next(
        &mut self,
        x: &Samples,
        i: usize,
        speed: f64,
        kinematic: [f64; 2],
    ) -> [f64; 2] {
        let first = i == 0
            || x.segment[i] != x.segment[i - 1]
            || (x.time[i] - x.time[i - 1]) * self.rate > 1.5;
        for k in 0..2 {
            self.lagged[k] = if first || self.lagged[k].is_nan() {
                kinematic[k]
            } else {
                let span = (speed / self.relaxation[k] / self.rate).max(1e-6);
                hold(self.lagged[k], self.previous[k], kinematic[k], span) // (1)
            };
        }
        self.previous = kinematic;
        self.lagged
    }
}

/// Exact step of the first-order lag (1) for an input that runs straight from one sample to
/// the next; `span` is the distance travelled over the relaxation length.
fn hold(state: f64, from: f64, to: f64, span: f64) -> f64 {
    let keep = (-span).exp();
    let mean = (1.0 - keep) / span;
    keep * state + (1.0 - mean) * to + (mean - keep) * from
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lag_is_exact_for_a_ramp() {
        // x' = (u - x)/T with u = t: x = t - T (1 - exp(-t/T))
        let (mut x, step, lag) = (0.0, 0.3, 0.5_f64);
        for i in 0..10 {
            x = hold(x, step * f64::from(i), step * f64::from(i + 1), step / lag);
        }
        let t = 3.0;
        assert!((x - (t - lag * (1.0 - (-t / lag).exp()))).abs() < 1e-12);
    }
}
