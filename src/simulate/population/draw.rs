//! Draws that a machine is made of.

use crate::statistics::random::Random;

/// Even in the logarithm between two bounds.
pub(super) fn spread(random: &mut Random, low: f64, high: f64) -> f64 {
    random.between(low.ln(), high.ln()).exp()
}

/// Normal, within `reach` standard deviations.
pub(super) fn within(random: &mut Random, mean: f64, sd: f64, reach: f64) -> f64 {
    mean + sd * random.normal().clamp(-reach, reach)
}
