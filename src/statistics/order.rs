//! Medians and quantiles of values that need not be in order.
//!
//! Contract: values are ordered by [`f64::total_cmp`], so that NaN (of positive sign) counts as
//! larger than everything and takes its rank; take [`finite`] of the values first to ignore it. No
//! values have no median: `None`, never a number.

/// Standard deviation of a normal distribution over its median absolute deviation.
pub(crate) const SD_PER_MAD: f64 = 1.4826;

/// The finite ones of the values.
pub(crate) fn finite(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    values.into_iter().filter(|v| v.is_finite()).collect()
}

/// The value in the middle; of an even number of values the mean of the two in the middle.
/// Reorders the values.
pub fn median(values: &mut [f64]) -> Option<f64> {
    let n = values.len();
    if n == 0 {
        return None;
    }
    let (low, &mut high, _) = values.select_nth_unstable_by(n / 2, f64::total_cmp);
    if n % 2 == 1 {
        return Some(high);
    }
    let below = low.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some(0.5 * (below + high))
}

/// [`median`] of values that stay as they are; 0 where there are none, for sizes and offsets of
/// which no evidence means none.
pub(crate) fn median_or_zero(values: &[f64]) -> f64 {
    median(&mut values.to_vec()).unwrap_or(0.0)
}

/// As [`median`], but of an even number of values the upper one of the two in the middle: always one
/// of the values. Reorders the values.
pub(crate) fn upper_median(values: &mut [f64]) -> Option<f64> {
    let rank = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// [`median`] of the finite ones among values that stay as they are.
pub fn median_of_finite(values: &[f64]) -> Option<f64> {
    median(&mut finite(values.iter().copied()))
}

/// Values that are looked at first.
const SAMPLE: usize = 2048;
/// Between these quantiles of a sample the median is, almost always: 54 % of the values are above
/// the one and 54 % below the other, and a sample errs by 1 %.
const MARGIN: f64 = 0.04;

/// [`upper_median`] of values that stay as they are and of which none is NaN: of many values only
/// those that a sample places near the middle are put in order.
pub fn upper_median_of(values: &[f64]) -> Option<f64> {
    let rank = values.len() / 2;
    let by_sample = || {
        if values.len() < 8 * SAMPLE {
            return None;
        }
        let mut sample: Vec<f64> = values.iter().step_by(values.len() / SAMPLE).copied().collect();
        sample.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| sample[(share * sample.len() as f64) as usize];
        let (low, high) = (at(0.5 - MARGIN), at(0.5 + MARGIN));
        let below = values.iter().map(|v| usize::from(*v < low)).sum::<usize>();
        let between = values.iter().copied().filter(|v| (low..=high).contains(v)).collect();
        select(between, rank.checked_sub(below)?)
    };
    by_sample().or_else(|| select(values.to_vec(), rank))
}

/// The value of a rank, if there are so many.
fn select(mut values: Vec<f64>, rank: usize) -> Option<f64> {
    (rank < values.len()).then(|| *values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// The value whose rank is nearest to a share (0 to 1) of the largest rank: always one of the
/// values. Reorders the values.
pub(crate) fn quantile(values: &mut [f64], share: f64) -> Option<f64> {
    let rank = (values.len().saturating_sub(1) as f64 * share).round() as usize;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// [`median`] and a robust standard deviation about it: the median absolute deviation times
/// [`SD_PER_MAD`], 0 of a single value. Reorders the values.
pub(crate) fn median_and_spread(values: &mut [f64]) -> Option<(f64, f64)> {
    let centre = median(values)?;
    Some((centre, spread_about(values, centre)))
}

/// Robust standard deviation about a centre: the median absolute deviation from it times
/// [`SD_PER_MAD`]; 0 where there are no values.
pub(crate) fn spread_about(values: &[f64], centre: f64) -> f64 {
    let mut deviations: Vec<f64> = values.iter().map(|v| (v - centre).abs()).collect();
    median(&mut deviations).map_or(0.0, |mad| SD_PER_MAD * mad)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Few and many values: noise, a wave, steps, values of which the sample sees only the ones, and equal
    /// ones.
    pub(crate) fn hard_to_sample() -> Vec<Vec<f64>> {
        let mut state = 3_u32;
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        let of = |n: i32| {
            let noise: Vec<f64> = (0..n).map(|_| random()).collect();
            let wave = (0..n).map(|i| (f64::from(i) / 700.0).sin()).collect();
            let steps = noise.iter().map(|v| (4.0 * v).round() - 2.0).collect();
            let stride = (n as usize / SAMPLE).max(1);
            let hidden = (0..n as usize).map(|i| f64::from(i % stride == 0)).collect();
            [noise, wave, steps, hidden, vec![7.0; n as usize]]
        };
        [1, 2, 3, 1000, 16_383, 16_384, 50_001].into_iter().flat_map(of).collect()
    }

    #[test]
    fn medians() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [4.0, 1.0, 3.0, 2.0]), Some(2.5));
        assert_eq!(median(&mut [7.0]), Some(7.0));
        assert_eq!(median(&mut []), None);
        assert_eq!(upper_median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(upper_median(&mut [4.0, 1.0, 3.0, 2.0]), Some(3.0));
        assert_eq!(upper_median(&mut []), None);
    }

    #[test]
    fn the_median_of_many_values_is_that_of_the_values_in_order() {
        for values in hard_to_sample() {
            assert_eq!(upper_median_of(&values), upper_median(&mut values.clone()));
        }
        assert_eq!(upper_median_of(&[]), None);
    }

    #[test]
    fn a_nan_takes_the_largest_rank() {
        assert_eq!(median(&mut [f64::NAN, 1.0, 2.0]), Some(2.0));
        assert_eq!(quantile(&mut [f64::NAN, 1.0, 2.0], 0.0), Some(1.0));
        assert!(quantile(&mut [f64::NAN, 1.0, 2.0], 1.0).is_some_and(f64::is_nan));
        assert_eq!(finite([f64::NAN, 1.0, f64::INFINITY]), [1.0]);
    }

    #[test]
    fn quantiles() {
        let mut x = [5.0, 1.0, 4.0, 2.0, 3.0];
        assert_eq!(quantile(&mut x, 0.0), Some(1.0));
        assert_eq!(quantile(&mut x, 0.7), Some(4.0)); // rank 2.8
        assert_eq!(quantile(&mut x, 1.0), Some(5.0));
        assert_eq!(quantile(&mut [], 0.5), None);
    }

    #[test]
    fn spread() {
        // R: mad(c(1, 2, 4, 8)) = 2.2239
        let (centre, spread) = median_and_spread(&mut [8.0, 1.0, 4.0, 2.0]).expect("four values");
        assert_eq!(centre, 3.0);
        assert!((spread - 2.2239).abs() < 1e-12);
        assert_eq!(median_and_spread(&mut [3.0]), Some((3.0, 0.0)));
        assert_eq!(median_and_spread(&mut []), None);
    }
}
