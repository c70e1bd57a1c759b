//! How many of several discoveries are false.

/// Of tests with these chances, done among `tests` in all, the share of false ones among those that are at least as sure:
/// Benjamini and Hochberg's (1995) rule, as a number for each.
pub(crate) fn discovery_rates(chances: &[f64], tests: usize) -> Vec<f64> {
    let mut order: Vec<usize> = (0..chances.len()).collect();
    order.sort_by(|a, b| chances[*b].total_cmp(&chances[*a]));
    let mut rates = vec![1.0; chances.len()];
    let mut least: f64 = 1.0;
    for (k, i) in order.into_iter().enumerate() {
        let rank = chances.len() - k;
        least = least.min(chances[i] * tests as f64 / rank as f64);
        rates[i] = least;
    }
    rates
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discovery_rates_are_those_of_the_rule() {
        let rates = discovery_rates(&[0.01, 0.001, 0.04, 0.03], 5);
        let expected = [0.025, 0.005, 0.05, 0.05];
        assert!(rates.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{rates:?}");
        // of a thousand bikes to which nothing happened ten have an event by chance: none is to be believed
        let rates = discovery_rates(
            &[0.001, 0.002, 0.003, 0.004, 0.005, 0.006, 0.007, 0.008, 0.009, 0.01],
            1010,
        );
        assert!(rates.iter().all(|q| *q > 0.9), "{rates:?}");
    }
}
