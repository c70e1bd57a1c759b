//! Loss on manoeuvres left out of a fit, fold by fold.

use rayon::prelude::*;

pub(crate) const FOLDS: usize = 5;

/// Sum of a loss over the folds, which are computed in parallel: the same to the last digit on any number
/// of threads.
pub(crate) fn sum_over_folds(loss: impl Fn(usize) -> f64 + Sync) -> f64 {
    let losses: Vec<f64> = (0..FOLDS).into_par_iter().map(&loss).collect();
    by_halves(&losses)
}

/// Sum of both halves' sums.
fn by_halves(terms: &[f64]) -> f64 {
    match terms {
        [] => 0.0,
        [term] => *term,
        _ => {
            let (left, right) = terms.split_at(terms.len() / 2);
            by_halves(left) + by_halves(right)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of these terms every order of summation gives another sum.
    #[test]
    fn a_sum_does_not_depend_on_the_number_of_threads() {
        let terms = [0.1, 1e16, -1e16, 0.3, 7e-17];
        let wanted = (terms[0] + terms[1]) + (terms[2] + (terms[3] + terms[4]));
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("pool");
            let sum = pool.install(|| sum_over_folds(|fold| terms[fold]));
            assert_eq!(sum.to_bits(), wanted.to_bits(), "{threads}");
        }
    }
}
