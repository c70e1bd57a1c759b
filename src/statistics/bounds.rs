//! A smooth change of variables that keeps parameters within bounds.
//!
//! ```text
//! low and high:  theta = low + (high - low) (1 + sin z) / 2
//! low only:      theta = low - 1 + sqrt(1 + z²)
//! high only:     theta = high + 1 - sqrt(1 + z²)
//! ```
//! Source: F. James, M. Roos, "Minuit" (1975), Computer Physics Communications 10.

/// Share of the range, or distance from a single bound, that a start keeps from it: on the
/// bound itself the slope is zero and nothing would move.
const MARGIN: f64 = 1e-3;

/// Bounds of each parameter; infinite ones are none.
#[derive(Debug, Clone)]
pub(crate) struct Bounds(Vec<(f64, f64)>);

impl Bounds {
    /// Of `p` parameters; `None` where they exclude everything or are too few.
    pub(crate) fn new(p: usize, bounds: Option<&[(f64, f64)]>) -> Option<Self> {
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let bounds = bounds.map_or_else(|| vec![free; p], <[(f64, f64)]>::to_vec);
        let sound = bounds.len() == p && bounds.iter().all(|(low, high)| low < high);
        sound.then_some(Bounds(bounds))
    }

    /// Those of parameter `j`.
    pub(crate) fn of(&self, j: usize) -> (f64, f64) {
        self.0[j]
    }

    /// Free variables of parameters, which are moved inside first.
    pub(crate) fn inner(&self, theta: &[f64]) -> Vec<f64> {
        let above = |distance: f64| ((distance.max(MARGIN) + 1.0).powi(2) - 1.0).sqrt();
        let one =
            |(&t, &(low, high)): (&f64, &(f64, f64))| match (low.is_finite(), high.is_finite()) {
                (true, true) => {
                    let share = (t - low) / (high - low);
                    (2.0 * share.clamp(MARGIN, 1.0 - MARGIN) - 1.0).asin()
                }
                (true, false) => above(t - low),
                (false, true) => above(high - t),
                (false, false) => t,
            };
        theta.iter().zip(&self.0).map(one).collect()
    }

    /// Parameters of free variables.
    pub(crate) fn outer(&self, z: &[f64]) -> Vec<f64> {
        let mut theta = vec![0.0; z.len()];
        self.outer_into(z, &mut theta);
        theta
    }

    /// As [`Self::outer`], in place.
    pub(crate) fn outer_into(&self, z: &[f64], theta: &mut [f64]) {
        for (t, (&z, &(low, high))) in theta.iter_mut().zip(z.iter().zip(&self.0)) {
            *t = match (low.is_finite(), high.is_finite()) {
                (true, true) => low + 0.5 * (high - low) * (1.0 + z.sin()),
                (true, false) => low - 1.0 + z.hypot(1.0),
                (false, true) => high + 1.0 - z.hypot(1.0),
                (false, false) => z,
            };
        }
    }

    /// Derivative of parameter `j` by its free variable.
    pub(crate) fn slope(&self, j: usize, z: f64) -> f64 {
        let (low, high) = self.0[j];
        match (low.is_finite(), high.is_finite()) {
            (true, true) => 0.5 * (high - low) * z.cos(),
            (true, false) => z / z.hypot(1.0),
            (false, true) => -z / z.hypot(1.0),
            (false, false) => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_inside_and_never_outside() {
        let inf = f64::INFINITY;
        let limits = [(-1.0, 3.0), (2.0, inf), (-inf, 5.0), (-inf, inf)];
        let Some(bounds) = Bounds::new(4, Some(&limits)) else { panic!("sound bounds") };
        let theta = [0.5, 2.7, -4.0, 7.0];
        let z = bounds.inner(&theta);
        for (a, b) in bounds.outer(&z).iter().zip(&theta) {
            assert!((a - b).abs() < 1e-12);
        }
        for k in -50..50 {
            let there = bounds.outer(&[f64::from(k); 4]);
            for (t, (low, high)) in there.iter().zip(limits) {
                assert!((low..=high).contains(t));
            }
        }
        let h = 1e-6;
        for j in 0..4 {
            let mut up = z.clone();
            up[j] += h;
            let slope = (bounds.outer(&up)[j] - bounds.outer(&z)[j]) / h;
            assert!((slope - bounds.slope(j, z[j])).abs() < 1e-4, "{j}");
        }
        // a start outside comes in, and not to rest on the bound
        let z = bounds.inner(&[9.0, 0.0, 9.0, 0.0]);
        assert!((0..3).all(|j| bounds.slope(j, z[j]).abs() > 1e-3));
        assert!(Bounds::new(1, Some(&[(1.0, 1.0)])).is_none());
        assert!(Bounds::new(2, Some(&[(0.0, 1.0)])).is_none());
    }
}
