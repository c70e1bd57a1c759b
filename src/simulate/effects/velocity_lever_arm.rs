//! Place of the velocity sensor.

use super::physics::{Physics, Reach, Remove};
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct VelocityLeverArm;

impl Physics for VelocityLeverArm {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the speed sensor is not mounted where the bike file says",
        opposite: "the speed sensor is not mounted where the bike file says",
        unit: "m",
        typical: 0.15,
        bounds: [-1.2, 1.2],
        source: "an antenna on the tail is half a metre off",
        enters: "lateral velocity over yaw rate",
        channels: &[Channel::VelocityY, Channel::YawRate],
        kinds: &[ManoeuvreKind::Cornering],
        confounded_with: &[],
        separate_by: "tight corners",
        level: Level::Bike,
        faint: false,
    };
    const REACH: Reach = Reach::ATTITUDE;
    const REMOVE: Option<Remove> = Some(|session, _, size| move_sensor(session, -size));

    fn velocity_y(size: f64, reading: f64, yaw_rate: f64) -> f64 {
        reading - size * yaw_rate
    }

    fn measure(size: f64, session: &mut Session) {
        move_sensor(session, size);
    }
}

/// Takes the velocity sensor `ahead` m forward.
fn move_sensor(session: &mut Session, ahead: f64) {
    let rate = session.get(Channel::YawRate).map(<[f64]>::to_vec);
    if let (Some(rate), Some(x)) = (rate, session.get_mut(Channel::VelocityY)) {
        x.iter_mut().zip(rate).for_each(|(x, r)| *x += ahead * r);
    }
}
