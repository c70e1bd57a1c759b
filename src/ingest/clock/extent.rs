//! What many numbers are between, without putting them in order.

use crate::statistics::order::upper_median_of;

/// Least, middle and largest of the numbers that are finite, and their count; `None` of none.
pub(crate) fn extent(values: &[f64]) -> Option<([f64; 3], usize)> {
    let finite = |v: &&f64| v.is_finite();
    let count = values.iter().map(|v| usize::from(v.is_finite())).sum::<usize>();
    if count < values.len() {
        let there: Vec<f64> = values.iter().filter(finite).copied().collect();
        return if there.is_empty() { None } else { extent(&there) };
    }
    const LANES: usize = 8;
    let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    let (chunks, rest) = values.as_chunks::<LANES>();
    let mut lane = |k: usize, v: f64| {
        low[k] = if v < low[k] { v } else { low[k] };
        high[k] = if v > high[k] { v } else { high[k] };
    };
    for chunk in chunks {
        chunk.iter().enumerate().for_each(|(k, v)| lane(k, *v));
    }
    rest.iter().for_each(|v| lane(0, *v));
    let low = low.into_iter().fold(f64::INFINITY, f64::min);
    let high = high.into_iter().fold(f64::NEG_INFINITY, f64::max);
    Some(([low, upper_median_of(values)?, high], count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::order::tests::hard_to_sample;

    #[test]
    fn the_middle_is_that_of_the_numbers_in_order() {
        for values in hard_to_sample() {
            let n = values.len();
            let mut ordered = values.clone();
            ordered.sort_unstable_by(f64::total_cmp);
            let wanted = [ordered[0], ordered[n / 2], ordered[n - 1]];
            let mut patchy = values.clone();
            patchy.extend([f64::NAN, f64::INFINITY]);
            assert_eq!(extent(&values), Some((wanted, n)));
            assert_eq!(extent(&patchy), Some((wanted, n)));
        }
        assert_eq!(extent(&[f64::NAN]), None);
    }
}
