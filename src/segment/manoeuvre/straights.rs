//! Braking and driving, by acceleration; which brake, by the braking forces of the estimate.

use super::braking::{COMBINED_BRAKING, FRONT_BRAKING, REAR_BRAKING};
use super::detector::Claim;
use super::driving::DRIVING;
use super::mask::{close_holes, drop_short, hysteresis, runs};
use super::means::Means;
use super::offroad::Config;

/// Front share of the braking force above which the front brake is the only one.
const FRONT_ONLY: f64 = 0.85;
/// Front share below which the rear brake is the only one.
const REAR_ONLY: f64 = 0.15;

/// Runs of at least `least`, left below half of it, m/s².
fn strong(
    x: impl ExactSizeIterator<Item = f64> + Clone,
    least: f64,
    m: &Means,
    c: &Config,
) -> Vec<bool> {
    let mut mask = hysteresis(x, least, 0.5 * least);
    close_holes(&mut mask, m.count(0.1));
    drop_short(&mut mask, m.count(c.shortest));
    mask
}

/// Drives.
pub(super) fn driving(m: &Means, config: &Config) -> Vec<Claim> {
    let mask = strong(m.acceleration.iter().copied(), config.driving, m, config);
    runs(&mask).into_iter().map(|at| Claim::new(at, &DRIVING)).collect()
}

pub(super) fn braking(m: &Means, config: &Config) -> Vec<Claim> {
    let mask = strong(m.acceleration.iter().map(|a| -a), config.braking, m, config);
    let claim = |at| {
        let [front, rear] = m.braking.each_ref().map(|x| Means::sum(x, &at));
        let kind = match front / (front + rear) {
            share if share > FRONT_ONLY => &FRONT_BRAKING,
            share if share < REAR_ONLY => &REAR_BRAKING,
            _ => &COMBINED_BRAKING,
        };
        Claim::new(at, kind)
    };
    runs(&mask).into_iter().map(claim).collect()
}
