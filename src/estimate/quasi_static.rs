//! Which samples of a corner count as quasi-static and free of combined slip.

use super::Config;

/// Largest longitudinal tyre force over weight of a corner sample: with more the tyre slips both ways.
const MAX_LONGITUDINAL: f64 = 0.15;

/// The limits of a quasi-static corner sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuasiStatic {
    max_roll_rate: f64,
    min_camber: f64,
}

impl From<&Config> for QuasiStatic {
    fn from(config: &Config) -> Self {
        QuasiStatic { max_roll_rate: config.max_roll_rate, min_camber: config.min_camber }
    }
}

impl QuasiStatic {
    /// Whether a sample with this roll (rad), roll rate (rad/s) and longitudinal tyre force (N) counts,
    /// of a motorcycle of this weight (N).
    pub fn holds(&self, roll: f64, roll_rate: f64, longitudinal: f64, weight: f64) -> bool {
        roll_rate.abs() < self.max_roll_rate
            && roll.abs() > self.min_camber
            && longitudinal.abs() < MAX_LONGITUDINAL * weight
    }
}
