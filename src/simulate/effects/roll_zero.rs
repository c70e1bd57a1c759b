//! Zero of the roll reading.

use super::physics::{Physics, Reach, Remove};
use super::ride::add;
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct RollZero;

impl Physics for RollZero {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the roll sensor does not read zero upright",
        opposite: "the roll sensor does not read zero upright",
        unit: "rad",
        typical: 0.006,
        bounds: [-0.06, 0.06],
        source: "mounting angles and attitude filters are off by half a degree",
        enters: "roll",
        channels: &[Channel::Roll, Channel::AccelerationY],
        kinds: &[ManoeuvreKind::Cornering],
        confounded_with: &["rider_lean"],
        separate_by: "corners to both sides",
        level: Level::Session,
        faint: false,
    };
    const REACH: Reach = Reach::ATTITUDE;
    const REMOVE: Option<Remove> = Some(|session, _, size| add(session, Channel::Roll, size));

    fn roll(size: f64, reading: f64) -> f64 {
        reading + size
    }

    fn measure(size: f64, session: &mut Session) {
        add(session, Channel::Roll, -size);
    }
}
