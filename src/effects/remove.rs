//! Taking what was found out of a session, so that the base model holds for it: how the extended
//! model is used by `run` (`--model`).

use super::{ALL, ModelError};
use crate::contract::bike::Bike;
use crate::contract::session::Session;

/// Takes a model error out of a session and a bike. What cannot be taken out is returned by name: it
/// stays in the tyres' coefficients.
pub fn remove(error: &ModelError, session: &mut Session, bike: &mut Bike) -> Vec<&'static str> {
    let mut left = Vec::new();
    for effect in ALL {
        let size = (effect.get)(error);
        if size == 0.0 {
            continue;
        }
        match effect.remove {
            Some(remove) => remove(session, bike, size),
            None => left.push(effect.name),
        }
    }
    bike.settle();
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::channel::Channel;
    use crate::effects::Effect;
    use crate::simulate::scenario::Scenario;

    /// What the sensors of a model error do to a ride is removed to the last digit where it is a shift,
    /// and to a thousandth of the signal where it is interpolated.
    #[test]
    fn sensor_effects_are_taken_out_again() {
        let scenario = Scenario::builtin("perfect").expect("scenario");
        let machine = scenario.machine(0);
        let clean = crate::simulate::session(&scenario, &machine, 0).session;
        for (name, size, channel, most) in [
            ("steer_zero", 0.01, Channel::SteerAngle, 1e-12),
            ("roll_zero", -0.01, Channel::Roll, 1e-12),
            ("velocity_lever_arm", 0.4, Channel::VelocityY, 1e-12),
            ("latency", 0.03, Channel::VelocityX, 0.02),
        ] {
            let mut error = ModelError::default();
            (Effect::named(name).expect("known").set)(&mut error, size);
            let mut session = clean.clone();
            error.measure(&mut session);
            let mut bike = machine.bike.clone();
            assert!(remove(&error, &mut session, &mut bike).is_empty());
            let (a, b) = (clean.get(channel).expect("there"), session.get(channel).expect("there"));
            let n = a.len() - 10;
            let off = (10..n).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max);
            assert!(off < most, "{name}: {off}");
        }
    }
}
