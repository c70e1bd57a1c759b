//! White noise of a channel.

/// Share of the second differences that are noise: of the rest some are motion.
const NOISE: f64 = 0.9;
/// Variance of a normal variable's smallest 90 %, by size, over its own.
const OF_SMALLEST: f64 = 0.623;

/// Standard deviation of white noise from second differences: motion leaves next to none. Squares rather than
/// a median: the differences of a coarsely rounded channel take few values.
pub(crate) fn white_noise(x: &[f64]) -> f64 {
    let difference = |w: &[f64]| (w[0] - 2.0 * w[1] + w[2]).powi(2);
    let mut squares: Vec<f64> = x.windows(3).map(difference).filter(|d| d.is_finite()).collect();
    let moving = squares.iter().filter(|d| **d > 0.0).count();
    // a channel that is held between slower readings says nothing there
    if 2 * moving < squares.len() {
        squares.retain(|d| *d > 0.0);
    }
    let count = (NOISE * squares.len() as f64) as usize;
    if count == 0 {
        return 0.0;
    }
    let (smallest, _, _) = squares.select_nth_unstable_by(count, f64::total_cmp);
    (smallest.iter().sum::<f64>() / count as f64 / OF_SMALLEST / 6.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    /// Noise and its rounding: `sigma² + quantum²/12`.
    #[test]
    fn coarse_rounding_is_noise_and_no_more() {
        let mut random = Random::new(1, "white noise");
        let noise: Vec<f64> = (0..20_000).map(|_| random.normal()).collect();
        for (sigma, quantum) in [(0.036, 0.04), (0.05, 0.04), (0.1, 0.04), (0.05, 1e-9)] {
            let slow = |i: usize| 30.0 + 5.0 * (i as f64 * 1e-3).sin();
            let round = |x: f64| (x / quantum).round() * quantum;
            let x: Vec<f64> =
                noise.iter().enumerate().map(|(i, n)| round(slow(i) + sigma * n)).collect();
            let truth = (sigma * sigma + quantum * quantum / 12.0_f64).sqrt();
            let found = white_noise(&x);
            assert!((found / truth - 1.0).abs() < 0.05, "{sigma} {quantum}: {found} for {truth}");
        }
    }

    #[test]
    fn a_held_channel_has_the_noise_of_its_readings() {
        let mut random = Random::new(2, "white noise");
        let x: Vec<f64> = (0..4000).flat_map(|_| [random.normal(); 10]).collect();
        let found = white_noise(&x);
        assert!((0.3..1.5).contains(&found), "{found}");
        assert_eq!(white_noise(&[1.0; 50]), 0.0);
        assert_eq!(white_noise(&[]), 0.0);
    }
}
