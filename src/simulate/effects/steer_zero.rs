//! Zero of the steering sensor.

use super::physics::{Physics, Reach, Remove};
use super::ride::add;
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct SteerZero;

impl Physics for SteerZero {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the steering sensor does not read zero straight on",
        opposite: "the steering sensor does not read zero straight on",
        unit: "rad",
        typical: 0.005,
        bounds: [-0.05, 0.05],
        source: "potentiometers are set to a degree",
        enters: "handlebar angle",
        channels: &[Channel::SteerAngle, Channel::VelocityY, Channel::YawRate],
        kinds: &[ManoeuvreKind::Cornering, ManoeuvreKind::Coasting],
        confounded_with: &[],
        separate_by: "straight running",
        level: Level::Session,
        faint: false,
    };
    const REACH: Reach = Reach::ATTITUDE;
    const REMOVE: Option<Remove> = Some(|session, _, size| add(session, Channel::SteerAngle, size));

    fn steer(size: f64, reading: f64) -> f64 {
        reading + size
    }

    fn measure(size: f64, session: &mut Session) {
        add(session, Channel::SteerAngle, -size);
    }
}
