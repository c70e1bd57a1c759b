//! Crown of the tyres.

use super::physics::{Multibody, Physics, Reach, Remove, Rolling};
use super::ride::scale_with;
use super::spec::{EffectSpec, Level};
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct RadiusCamber;

impl Physics for RadiusCamber {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the rolling radius falls more with camber than the tyres' width makes it",
        opposite: "the rolling radius falls less with camber than the tyres' width makes it",
        unit: "m",
        typical: 0.02,
        bounds: [-0.12, 0.12],
        source: "crowns of 50 to 95 mm, half of the width; a rear tyre of a superbike showed up to 130 mm",
        enters: "rolling radius of both wheels, of the rear one in the ratio of the widths",
        channels: &[Channel::WheelSpeedFront, Channel::VelocityX, Channel::Roll],
        kinds: &[ManoeuvreKind::Cornering],
        confounded_with: &[],
        separate_by: "corners with the front wheel rolling freely",
        level: Level::Bike,
        faint: false,
    };
    const TYRES: &[Axle] = &Axle::BOTH;
    const REACH: Reach = Reach::SLIPS;
    const MULTIBODY: Multibody = Multibody::Inherent("its tyres are toroids");
    const REMOVE: Option<Remove> = Some(|session, bike, size| {
        for (channel, wheel) in
            [(Channel::WheelSpeedFront, &bike.front), (Channel::WheelSpeedRear, &bike.rear)]
        {
            let change = size * wheel.width / bike.front.width / wheel.radius;
            scale_with(session, channel, |ride, i| 1.0 - change * (1.0 - ride.roll[i].cos()));
        }
    });

    fn rolling_radius(size: f64, radius: f64, rolling: Rolling) -> f64 {
        radius - size * rolling.crown * rolling.versine
    }
}
