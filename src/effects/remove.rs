//! Taking what was found out of a session, so that the base model holds for it: how the extended
//! model is used by `run` (`--model`).

use super::ALL;
use super::model_error::{BrakeHistory, ModelError};
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::diagnose::samples::{along_strip, brake_history};

/// What corrections hang on, sample by sample; 0 where it is missing.
#[derive(Debug)]
pub struct Ride {
    /// Speed, m/s.
    pub v: Vec<f64>,
    /// Roll, rad.
    pub roll: Vec<f64>,
    /// Cosine of the heading against the strip.
    pub along: Vec<f64>,
    /// What the brakes have been through.
    pub brakes: Vec<BrakeHistory>,
}

impl Ride {
    fn of(session: &Session) -> Self {
        let known = |c: Channel| -> Vec<f64> {
            let missing = || vec![0.0; session.len];
            session.get(c).map_or_else(missing, |x| {
                x.iter().map(|v| if v.is_finite() { *v } else { 0.0 }).collect()
            })
        };
        let along = along_strip(session);
        Ride {
            v: known(Channel::VelocityX),
            roll: known(Channel::Roll),
            along: along.into_iter().map(|a| if a.is_finite() { a } else { 0.0 }).collect(),
            brakes: brake_history(session),
        }
    }
}

/// Adds to a channel, if it is there.
pub fn add(session: &mut Session, channel: Channel, by: impl Fn(&Ride, usize) -> f64) {
    let ride = Ride::of(session);
    if let Some(x) = session.get_mut(channel) {
        x.iter_mut().enumerate().for_each(|(i, x)| *x += by(&ride, i));
    }
}

/// Multiplies a channel, if it is there.
pub fn scale(session: &mut Session, channel: Channel, by: impl Fn(&Ride, usize) -> f64) {
    let ride = Ride::of(session);
    if let Some(x) = session.get_mut(channel) {
        x.iter_mut().enumerate().for_each(|(i, x)| *x *= by(&ride, i));
    }
}

/// Takes a departure out of a session and a bike. What cannot be taken out is returned by name: it
/// stays in the tyres' coefficients.
pub fn undo(departure: &ModelError, session: &mut Session, bike: &mut Bike) -> Vec<&'static str> {
    let mut left = Vec::new();
    for effect in ALL {
        let value = (effect.get)(departure);
        if value == 0.0 {
            continue;
        }
        match effect.undo {
            Some(undo) => undo(session, bike, value),
            None => left.push(effect.name),
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Effect;
    use crate::simulate::scenario::Scenario;

    /// What the sensors of a departure do to a ride is undone to the last digit where it is a shift,
    /// and to a thousandth of the signal where it is interpolated.
    #[test]
    fn sensor_effects_are_taken_out_again() {
        let scenario = Scenario::builtin("perfect").expect("scenario");
        let machine = scenario.machine(0);
        let clean = crate::simulate::session(&scenario, &machine, 0).session;
        for (name, value, channel, most) in [
            ("steer_zero", 0.01, Channel::SteerAngle, 1e-12),
            ("roll_zero", -0.01, Channel::Roll, 1e-12),
            ("velocity_lever_arm", 0.4, Channel::VelocityY, 1e-12),
            ("latency", 0.03, Channel::VelocityX, 0.02),
        ] {
            let mut departure = ModelError::default();
            (Effect::named(name).expect("known").set)(&mut departure, value);
            let mut session = clean.clone();
            departure.measure(&mut session);
            let mut bike = machine.bike.clone();
            assert!(undo(&departure, &mut session, &mut bike).is_empty());
            let (a, b) = (clean.get(channel).expect("there"), session.get(channel).expect("there"));
            let n = a.len() - 10;
            let off = (10..n).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max);
            assert!(off < most, "{name}: {off}");
        }
    }
}
