//! Relaxation length of the tyres.

use super::physics::{Physics, Reach, Remove};
use super::spec::{EffectSpec, Level};
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

/// No relaxation length is shorter, m.
const SHORTEST: f64 = 0.02;

pub(super) struct RelaxationLength;

impl Physics for RelaxationLength {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the tyres answer later than assumed",
        opposite: "the tyres answer sooner than assumed",
        unit: "m",
        typical: 0.15,
        bounds: [-0.3, 0.8],
        source: "0.1 to 0.4 m, growing with speed, de Vries and Pacejka 1998",
        enters: "lag of the slip angles",
        channels: &[Channel::SteerAngle, Channel::VelocityY, Channel::YawRate],
        kinds: &[ManoeuvreKind::Cornering],
        confounded_with: &[],
        separate_by: "quick changes of lean",
        level: Level::Bike,
        faint: true,
    };
    const TYRES: &[Axle] = &Axle::BOTH;
    const REACH: Reach = Reach { within_blocks: true, ..Reach::ATTITUDE };
    const REMOVE: Option<Remove> = Some(|_, bike, size| {
        for wheel in [&mut bike.front, &mut bike.rear] {
            let usual = wheel.relaxation_length.unwrap_or(wheel.radius);
            wheel.relaxation_length = Some(Self::relaxation_length(size, usual));
        }
    });

    fn relaxation_length(size: f64, length: f64) -> f64 {
        (length + size).max(SHORTEST)
    }
}
