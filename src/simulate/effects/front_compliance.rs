//! Give of the front frame.

use super::physics::{Physics, Reach, Remove};
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct FrontCompliance;

impl Physics for FrontCompliance {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the front frame gives way under side force",
        opposite: "the front frame steers further under side force",
        unit: "rad/N",
        typical: 5e-06,
        bounds: [-5e-06, 5e-05],
        source: "0.3 to 3 degrees per kN",
        enters: "steering angle at the road",
        channels: &[Channel::SteerAngle, Channel::AccelerationY],
        kinds: &[ManoeuvreKind::Cornering],
        confounded_with: &["cornering_stiffness_front"],
        separate_by: "corners with the brake on",
        level: Level::Bike,
        faint: false,
    };
    const REACH: Reach = Reach::ATTITUDE;
    const REMOVE: Option<Remove> = Some(|session, bike, size| {
        let share = bike.mass * bike.cg_to_rear() / bike.wheelbase;
        let across = session.get(Channel::AccelerationY).map(<[f64]>::to_vec);
        if let (Some(ay), Some(x)) = (across, session.get_mut(Channel::SteerAngle)) {
            // a degree on the road is a little more at the handlebar
            let turned = bike.caster_angle.cos();
            x.iter_mut().zip(ay).for_each(|(x, a)| *x -= size * share * a / turned);
        }
    });

    fn compliance(size: f64, compliance: f64) -> f64 {
        compliance + size
    }
}
