//! A front disc that rubs all the time.

use super::physics::{Physics, Remove};
use super::ride::{BrakeHistory, add_with};
use super::spec::{EffectSpec, Level};
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct FrontBrakeDrag;

impl Physics for FrontBrakeDrag {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the front brake drags all the time",
        opposite: "the front wheel turns more easily than assumed",
        unit: "N m",
        typical: 2.0,
        // it cannot push
        bounds: [0.0, 20.0],
        source: "assumed: a disc that rubs and is still turned by hand; not measured",
        enters: "constant torque on the front wheel",
        channels: &[
            Channel::WheelSpeedFront,
            Channel::BrakePressureFront,
            Channel::VelocityX,
            Channel::AccelerationX,
        ],
        kinds: &[ManoeuvreKind::Coasting],
        confounded_with: &["rolling_resistance"],
        separate_by: "the lifted front wheel, turned by hand",
        level: Level::Bike,
        faint: true,
    };
    const REMOVE: Option<Remove> = Some(|session, bike, size| {
        let pull = size / (bike.front.radius * bike.mass);
        add_with(
            session,
            Channel::AccelerationX,
            |ride, i| if ride.v[i] > 0.0 { pull } else { 0.0 },
        );
    });

    fn brake_drag(size: f64, torque: f64, _mass: f64, _brakes: BrakeHistory, axle: Axle) -> f64 {
        if axle == Axle::Front { torque + size } else { torque }
    }
}
