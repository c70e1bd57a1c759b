//! Sensors that few motorcycles have: measuring wheels, optical slip angles, brake torques, steering torque. A log has those
//! that `[sensors]` of the scenario gives errors of.

use super::motorcycle::Plant;
use super::multibody::{Action, Wheel};
use super::sensors::Sensors;
use super::simulated::Simulated;
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::estimate::measured::Quantity;

/// Error-free signals of the sensors of both wheels, sample by sample.
#[derive(Default)]
struct Seen {
    /// In the order of [`Quantity::ALL`], front and rear.
    columns: [[Vec<f64>; 2]; Quantity::ALL.len()],
    /// N m; empty where no rider has it.
    steer_torque: Vec<f64>,
}

impl Seen {
    fn put(&mut self, quantity: Quantity, values: [f64; 2]) {
        for (column, value) in self.columns[quantity as usize].iter_mut().zip(values) {
            column.push(value);
        }
    }

    /// Into a log, as far as there are such sensors.
    fn record(mut self, session: &mut Session, sensors: &Sensors) {
        let has = |c: Channel| sensors.contains_key(c.name());
        for quantity in Quantity::ALL {
            for (k, channel) in quantity.channels().into_iter().enumerate().filter(|(_, c)| has(*c))
            {
                session.set(channel, std::mem::take(&mut self.columns[quantity as usize][k]));
            }
        }
        if has(Channel::SteerTorque) && !self.steer_torque.is_empty() {
            session.set(Channel::SteerTorque, self.steer_torque);
        }
    }
}

/// Whether a scenario has any of these sensors.
fn any(sensors: &Sensors) -> bool {
    let mut all = Quantity::ALL.into_iter().flat_map(Quantity::channels);
    all.any(|c| sensors.contains_key(c.name())) || sensors.contains_key(Channel::SteerTorque.name())
}

/// Puts what the sensors see of a ride of the nonlinear motorcycle, both wheels and what the rider does at every sample, into
/// its log, without their errors.
pub fn of_multibody(
    session: &mut Session,
    samples: impl Iterator<Item = ([Wheel; 2], Action)>,
    sensors: &Sensors,
) {
    if !any(sensors) {
        return;
    }
    let mut seen = Seen::default();
    for (wheels, action) in samples {
        let of = |f: fn(&Wheel) -> f64| wheels.each_ref().map(f);
        seen.put(Quantity::SlipAngle, of(|w| w.kinematic[1]));
        seen.put(Quantity::ForceX, of(|w| w.force[0]));
        seen.put(Quantity::ForceY, of(|w| w.force[1]));
        seen.put(Quantity::Load, of(|w| w.load));
        seen.put(Quantity::MomentX, of(|w| w.moment_x));
        seen.put(Quantity::BrakeTorque, action.brake);
        seen.steer_torque.push(action.steer_torque);
    }
    seen.record(session, sensors);
}

/// The same of a ride of the reduced-order motorcycle, whose log has the pressures without errors. It has no steering torque.
pub(super) fn of_reduced(ride: &mut Simulated, plant: &Plant, sensors: &Sensors) {
    if !any(sensors) {
        return;
    }
    let mut seen = Seen::default();
    let rate = ride.session.rate;
    let last = ride.states.len().saturating_sub(1);
    let pressure = [Channel::BrakePressureFront, Channel::BrakePressureRear]
        .map(|c| ride.session.get(c).unwrap_or_default().to_vec());
    for (i, (state, response)) in ride.states.iter().zip(&ride.trace).enumerate() {
        // the wheel's own angle is ahead of the carcass's
        let (before, after) = (&ride.states[i.saturating_sub(1)], &ride.states[(i + 1).min(last)]);
        let span = ((i + 1).min(last) - i.saturating_sub(1)).max(1) as f64 / rate;
        let angle = Axle::BOTH.map(|axle| {
            let k = axle as usize;
            let rate = (after.alpha[k] - before.alpha[k]) / span;
            let tyre = &plant.tyres[k];
            state.alpha[k]
                + tyre.relaxation_length / (state.omega[k] * tyre.rolling_radius).max(1.0) * rate
        });
        seen.put(Quantity::SlipAngle, angle);
        let rolls = |k: usize| plant.tyres[k].rolling_force(response.load[k]);
        seen.put(Quantity::ForceX, [0, 1].map(|k| response.tyre[k].force_x + rolls(k)));
        seen.put(Quantity::ForceY, response.tyre.map(|t| t.force_y));
        seen.put(Quantity::Load, response.load);
        seen.put(Quantity::MomentX, response.tyre.map(|t| t.moment_x));
        let torque = |k: usize| pressure[k].get(i).map_or(0.0, |p| p * plant.vehicle.brake_gain[k]);
        seen.put(Quantity::BrakeTorque, [torque(0), torque(1)]);
    }
    seen.record(&mut ride.session, sensors);
}
