//! Contiguous runs of samples that are there.

use std::ops::Range;

/// The first contiguous run of finite samples at or after `from`.
pub(crate) fn next_run(x: &[f64], from: usize) -> Option<Range<usize>> {
    let start = from + x.get(from..)?.iter().position(|v| v.is_finite())?;
    let len = x[start..].iter().position(|v| !v.is_finite()).unwrap_or(x.len() - start);
    Some(start..start + len)
}

/// The contiguous runs of finite samples.
pub(crate) fn runs(x: &[f64]) -> Vec<Range<usize>> {
    std::iter::successors(next_run(x, 0), |last| next_run(x, last.end)).collect()
}
