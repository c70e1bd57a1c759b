//! White noise of a channel.

/// Standard deviation of white noise from second differences: motion leaves next to none.
pub fn white_noise(x: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = x
        .windows(3)
        .map(|w| (w[0] - 2.0 * w[1] + w[2]).abs())
        .filter(|d| d.is_finite() && *d > 0.0)
        .collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let middle = sizes.len() / 2;
    1.4826 * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1 / 6.0_f64.sqrt()
}
