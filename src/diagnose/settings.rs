//! How a diagnosis is done.

use crate::simulate::effects;
use crate::simulate::effects::Effect;

/// How a diagnosis is done.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Number of fault-free simulations, from which the thresholds come. 0: a ride on the road is only compared with the
    /// motorcycle's other rides; off the road, where there is no such comparison, the default counts.
    pub nulls: usize,
    /// Candidate causes on the road; off-road has its own.
    pub effects: Vec<Effect>,
    /// Whether more riding is also simulated for effects that the ride cannot identify, not only for those
    /// that it cannot tell apart.
    pub advise: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { nulls: 24, effects: effects::ALL.to_vec(), advise: false }
    }
}
