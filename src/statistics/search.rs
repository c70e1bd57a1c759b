//! One-dimensional helpers: the lowest point and the root of a function on an interval.
//!
//! Both are argmin's Brent solvers; a function that is not finite somewhere counts as high
//! there (minimum) or ends the search (root).

use argmin::core::{CostFunction, Executor, State};
use argmin::solver::brent::{BrentOpt, BrentRoot};

/// A closure as argmin wants it.
struct Cost<F>(F);

impl<F: Fn(f64) -> f64> CostFunction for Cost<F> {
    type Param = f64;
    type Output = f64;

    fn cost(&self, x: &f64) -> Result<f64, argmin::core::Error> {
        let value = (self.0)(*x);
        Ok(if value.is_nan() { f64::INFINITY } else { value })
    }
}

/// Lowest point of `f` on `low..high`: `(x, f(x))`, to `tolerance` relative in x.
///
/// Golden sections and parabolas; where `f` has several valleys it finds one of them. `None`
/// for an empty or infinite interval.
pub(crate) fn minimum(
    f: impl Fn(f64) -> f64,
    low: f64,
    high: f64,
    tolerance: f64,
) -> Option<(f64, f64)> {
    if !(low < high && (high - low).is_finite()) {
        return None;
    }
    let solver = BrentOpt::new(low, high).set_tolerance(tolerance, 1e-12 * (high - low));
    let result = Executor::new(Cost(f), solver).configure(|s| s.max_iters(200)).run().ok()?;
    let state = result.state();
    Some((*state.get_best_param()?, state.get_best_cost()))
}

/// Where `f` crosses zero on `low..high`, to `tolerance` in x. `None` where its ends have the
/// same sign or `f` is not finite.
pub(crate) fn root(f: impl Fn(f64) -> f64, low: f64, high: f64, tolerance: f64) -> Option<f64> {
    let (at_low, at_high) = (f(low), f(high));
    if at_low == 0.0 {
        return Some(low);
    }
    if at_high == 0.0 {
        return Some(high);
    }
    if !(low < high && at_low * at_high < 0.0) {
        return None;
    }
    let solver = BrentRoot::new(low, high, tolerance);
    let result = Executor::new(Cost(f), solver).configure(|s| s.max_iters(200)).run().ok()?;
    result.state().get_best_param().copied().filter(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_lowest_point() {
        let (x, f) = minimum(|x| (x - 0.3).powi(2) + 1.0, -1.0, 2.0, 1e-9).unwrap_or((0.0, 0.0));
        assert!((x - 0.3).abs() < 1e-6 && (f - 1.0).abs() < 1e-12);
        // cos has its minimum at pi
        let (x, _) = minimum(f64::cos, 2.0, 4.0, 1e-9).unwrap_or((0.0, 0.0));
        assert!((x - std::f64::consts::PI).abs() < 1e-6);
        // lowest at the edge
        let (x, _) = minimum(|x| x, 1.0, 2.0, 1e-9).unwrap_or((0.0, 0.0));
        assert!((x - 1.0).abs() < 1e-6, "{x}");
        assert_eq!(minimum(f64::cos, 2.0, 2.0, 1e-9), None);
        assert_eq!(minimum(f64::cos, f64::NAN, 2.0, 1e-9), None);
    }

    #[test]
    fn finds_the_root() {
        // x = cos x has the root 0.739085133215160641655... (the Dottie number)
        let x = root(|x| x.cos() - x, 0.0, 1.0, 1e-14).unwrap_or(f64::NAN);
        assert!((x - 0.739_085_133_215_160_6).abs() < 1e-12, "{x}");
        assert_eq!(root(|x| x * x + 1.0, -1.0, 1.0, 1e-9), None);
        assert_eq!(root(|_| f64::NAN, -1.0, 1.0, 1e-9), None);
        assert_eq!(root(|x| x, 0.0, 1.0, 1e-9), Some(0.0));
    }
}
