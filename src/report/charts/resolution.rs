//! How many decimals a chart's numbers have.

/// Parts of its range that a number on a chart resolves: finer than any screen.
pub(super) const PARTS: f64 = 20_000.0;

/// Decimals that resolve [`PARTS`] of the range.
pub(crate) fn digits(values: impl Iterator<Item = f64>) -> usize {
    digits_of(PARTS, values)
}

/// Decimals that resolve so many `parts` of the range of some values; 6 where they have none.
pub(super) fn digits_of(parts: f64, values: impl Iterator<Item = f64>) -> usize {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let range = high - low;
    if !(range > 0.0 && range.is_finite()) {
        return 6;
    }
    (parts / range).log10().ceil().clamp(0.0, 12.0) as usize
}
