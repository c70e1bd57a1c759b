//! A channel that is a speed.

use super::log::Log;
use crate::contract::channel::Channel;

/// Half of the time over which positions give a speed, points: 0.5 s.
pub(super) const SPAN: usize = 10;
/// Units of speeds that loggers write.
pub(super) const SPEEDS: [&str; 4] = ["m/s", "km/h", "mph", "kn"];
/// Those of whole numbers.
pub(super) const SCALED: [&str; 7] =
    ["0.1 km/h", "0.01 km/h", "0.1 m/s", "0.01 m/s", "mm/s", "0.1 mph", "0.1 kn"];

/// A channel that is a speed.
#[derive(Debug, Clone)]
pub(super) struct Speed {
    pub place: usize,
    /// The log's numbers per m/s.
    pub slope: f64,
    pub r: f64,
}

/// Whether a channel has the name of a wheel's speed.
pub(super) fn is_wheel(log: &Log<'_>, place: usize) -> bool {
    let columns = [Channel::WheelSpeedFront, Channel::WheelSpeedRear];
    columns.iter().any(|c| log.score(place, *c).is_some())
}

/// Its samples in m/s.
pub(super) fn in_si(log: &Log<'_>, speed: &Speed) -> Vec<f64> {
    log.x(speed.place).iter().map(|x| x / speed.slope).collect()
}

/// Name in a draft of the reference speed.
pub(super) fn called(log: &Log<'_>, place: usize) -> String {
    format!("speed `{}`", log.name(place))
}
