//! How many sessions more would show a difference.
//!
//! ```text
//! t sqrt(shared + own_A n_A / (n_A + m) + own_B n_B / (n_B + m)) <= size
//! ```

use super::contrast::Variance;
use crate::statistics::interval::t95;

/// More than so many nobody rides.
const MAX_MORE_RIDES: usize = 1000;

/// Sessions such as these on each side, beyond those that there are; 0 where these do, `None` where no number does.
pub(super) fn sessions(variance: &Variance, there: [usize; 2], size: f64) -> Option<usize> {
    let left: f64 = (variance.total - variance.own.iter().sum::<f64>()).max(0.0);
    let half = |m: usize| {
        let own = variance.own.iter().zip(there).map(|(own, n)| own * n as f64 / (n + m) as f64);
        // each one more tells of the spread between sessions, too
        t95(variance.dof + 2.0 * m as f64) * (left + own.sum::<f64>()).sqrt()
    };
    if half(0) <= size {
        return Some(0);
    }
    if half(MAX_MORE_RIDES) > size {
        return None;
    }
    let (mut low, mut high) = (0, MAX_MORE_RIDES);
    while high - low > 1 {
        let middle = usize::midpoint(low, high);
        if half(middle) <= size { high = middle } else { low = middle }
    }
    Some(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variance(shared: f64, own: [f64; 2]) -> Variance {
        let total = shared + own[0] + own[1];
        Variance { total, own, dof: 1e9, shared: std::collections::BTreeMap::new() }
    }

    #[test]
    fn four_times_the_sessions_halve_the_interval_down_to_what_is_shared() {
        let found = |shared, size| sessions(&variance(shared, [0.5e-4; 2]), [2, 2], size);
        let half = 1.959_964 * 0.01;
        assert_eq!(found(0.0, 1.001 * half), Some(0));
        assert_eq!(found(0.0, 0.501 * half), Some(6), "eight in place of two");
        assert_eq!(found(1e-4, 0.9 * half), None, "what is shared is as much alone");
        assert!(found(1e-4, 1.2 * half).is_some_and(|m| m > 0));
    }
}
