//! Spin that is not the wheels'.

use super::physics::{Physics, Reach};
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct Gyroscopic;

impl Physics for Gyroscopic {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "more spins than the wheels, as an engine does",
        opposite: "less spins than the bike file says of the wheels",
        unit: "1",
        typical: 0.25,
        bounds: [-1.0, 1.5],
        source: "a crankshaft adds 10 to 40 % of the wheels' gyroscopic moment",
        enters: "gyroscopic moments in roll and yaw",
        channels: &[Channel::Roll, Channel::AccelerationY, Channel::YawRate],
        kinds: &[ManoeuvreKind::Cornering],
        confounded_with: &["overturning_stiffness"],
        separate_by: "corners of the same lean at different speeds",
        level: Level::Bike,
        faint: true,
    };
    const REACH: Reach = Reach::TURNING;

    fn spin(size: f64, ratio: f64) -> f64 {
        ratio + size
    }
}
