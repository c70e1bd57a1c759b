//! The middle of many numbers, without putting them in order.

/// Numbers that are looked at first.
const SAMPLE: usize = 2048;

/// Which of these numbers the middle is between, almost always: 54 % of them are less than one
/// and 54 % more than the other, and a sample errs by 1 %.
const SHARE: f64 = 0.04;

/// The middle one of numbers in order (of an even count the later of two), `None` of none.
/// None may be NaN.
pub fn middle(values: &[f64]) -> Option<f64> {
    let rank = values.len() / 2;
    let by_sample = || {
        if values.len() < 8 * SAMPLE {
            return None;
        }
        let mut sample: Vec<f64> = values.iter().step_by(values.len() / SAMPLE).copied().collect();
        sample.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| sample[(share * sample.len() as f64) as usize];
        let (low, high) = (at(0.5 - SHARE), at(0.5 + SHARE));
        let below = values.iter().map(|v| usize::from(*v < low)).sum::<usize>();
        let between = values.iter().copied().filter(|v| (low..=high).contains(v)).collect();
        select(between, rank.checked_sub(below)?)
    };
    by_sample().or_else(|| select(values.to_vec(), rank))
}

/// The number of a rank, if there are so many.
fn select(mut values: Vec<f64>, rank: usize) -> Option<f64> {
    let there = rank < values.len();
    there.then(|| *values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// Least, middle and largest of the numbers that are finite, and their count; `None` of none.
pub fn extent(values: &[f64]) -> Option<([f64; 3], usize)> {
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
    Some(([low, middle(values)?, high], count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_that_of_the_numbers_in_order() {
        let mut state = 3_u32;
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        for n in [1, 2, 3, 1000, 16_383, 16_384, 50_001] {
            let noise: Vec<f64> = (0..n).map(|_| random()).collect();
            let wave: Vec<f64> = (0..n).map(|i| (f64::from(i) / 700.0).sin()).collect();
            let steps: Vec<f64> = noise.iter().map(|v| (4.0 * v).round() - 2.0).collect();
            // the sample sees only the ones
            let stride = (n as usize / SAMPLE).max(1);
            let hidden: Vec<f64> = (0..n as usize).map(|i| f64::from(i % stride == 0)).collect();
            for values in [noise, wave, steps, hidden, vec![7.0; n as usize]] {
                let mut ordered = values.clone();
                ordered.sort_unstable_by(f64::total_cmp);
                let wanted = [ordered[0], ordered[n as usize / 2], ordered[n as usize - 1]];
                let mut patchy = values.clone();
                patchy.extend([f64::NAN, f64::INFINITY]);
                assert_eq!(extent(&values), Some((wanted, n as usize)));
                assert_eq!(extent(&patchy), Some((wanted, n as usize)));
            }
        }
        assert_eq!(middle(&[]), None);
        assert_eq!(extent(&[f64::NAN]), None);
    }
}
