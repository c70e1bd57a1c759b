//! Give of the front frame.

use super::Effect;
use super::Level;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;

/// See the sentence.
pub const EFFECT: Effect = Effect {
    name: "front_compliance",
    sentence: "the front frame gives way under side force",
    unit: "rad/N",
    typical: 5e-06,
    bounds: [-5e-06, 5e-05],
    source: "0.3 to 3 degrees per kN",
    enters: "steering angle at the road",
    channels: &[Channel::SteerAngle, Channel::AccelerationY],
    kinds: &[ManoeuvreKind::Cornering],
    alike: &["cornering_stiffness_front", "side_force_ratio_front", "twisting_stiffness"],
    separate_by: "bends with the brake on",
    level: Level::Bike,
    get: |d| d.compliance,
    set: |d, value| d.compliance = value,
    undo: Some(|session, bike, value| {
        let share = bike.mass * bike.cg_to_rear() / bike.wheelbase;
        let across = session.get(Channel::AccelerationY).map(<[f64]>::to_vec);
        if let (Some(ay), Some(x)) = (across, session.get_mut(Channel::SteerAngle)) {
            // a degree on the road is a little more at the handlebar
            let turned = bike.caster_angle.cos();
            x.iter_mut().zip(ay).for_each(|(x, a)| *x -= value * share * a / turned);
        }
    }),
};
