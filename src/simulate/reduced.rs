//! One session on the reduced-order motorcycle.

use super::motorcycle::{Action, Plant, Response, State};
use super::odd_manoeuvre::with_odd;
use super::plan::{self, Phase};
use super::programme::Controls;
use super::rider::{Disturbance, Rider};
use super::scenario::{Machine, Scenario};
use super::sensors;
use super::simulated::{Simulated, labels};
use super::wheel_sensors;
use crate::contract::channel::Channel;
use crate::contract::session::{Meta, Session};
use crate::segment::manoeuvre::{Direction, ManoeuvreKind};
use crate::statistics::random::Random;

/// Longest ride that is simulated, s: a plan that does not end is a defect.
const LONGEST: f64 = 7200.0;

/// The `number`-th session of the fleet (bike by bike).
pub fn session(scenario: &Scenario, machine: &Machine, number: usize) -> Simulated {
    session_with(scenario, machine, number, |_| Vec::new())
}

/// The same with more after it: `more` makes it of the heading (rad) that the plan ends with.
pub fn session_with(
    scenario: &Scenario,
    machine: &Machine,
    number: usize,
    more: impl FnOnce(f64) -> Vec<Phase>,
) -> Simulated {
    let id = format!("{}_s{:04}", scenario.name, number + 1);
    let purpose = |what: &str| Random::new(scenario.seed, &format!("{id} {what}"));
    let plan = &scenario.plans[number % scenario.plans.len()];
    let mut phases = plan.phases(&mut purpose("plan"));
    phases.extend(more(plan::heading(&phases)));
    let phases = with_odd(phases, &scenario.odd_manoeuvres);
    let day = number / 2 % 28 + 1;
    let meta = Meta {
        session_id: id.clone(),
        bike_id: machine.bike.bike_id.clone(),
        start_time: Some(format!(
            "2026-{:02}-{day:02}T{:02}:00:00Z",
            5 + number / 56 % 6,
            9 + 4 * (number % 2)
        )),
        tyre_front: machine.bike.front.model.clone(),
        tyre_rear: machine.bike.rear.model.clone(),
        site: Some("simulated".into()),
        rider_id: Some(format!("rider_{}", number % 3 + 1)),
    };
    let (plant, rate) = (&machine.plant, scenario.rate);
    let mut simulated =
        simulate_phases(plant, &phases, scenario.disturbance, purpose("ride"), rate, LONGEST, meta);
    let session = &mut simulated.session;
    // a logger with an altitude rides over hills that it sees
    if scenario.sensors.contains_key(Channel::Altitude.name()) {
        session.set(Channel::Altitude, simulated.road.iter().map(|[_, height]| *height).collect());
        session
            .set(Channel::Pitch, simulated.road.iter().map(|[grade, _]| -grade.atan()).collect());
    }
    wheel_sensors::of_reduced(&mut simulated, plant, &scenario.sensors);
    let session = &mut simulated.session;
    for &channel in &scenario.drop {
        session.remove(channel);
    }
    plant.model_error.measure(session);
    sensors::measure(session, &scenario.sensors, scenario.seed);
    sensors::clamp_physical(session);
    simulated
}

/// Phases on a motorcycle at a logger's `rate` (Hz), `longest` s at most: the true signals.
pub fn simulate_phases(
    plant: &Plant,
    phases: &[Phase],
    disturbance: Disturbance,
    random: Random,
    rate: f64,
    longest: f64,
    meta: Meta,
) -> Simulated {
    let dt = 1.0 / rate;
    // the rider decides at 100 Hz at least
    let decisions = (100.0 / rate).ceil().max(1.0) as usize;
    let step = dt / decisions as f64;
    let mut rider = Rider::new(plant, phases, disturbance, random, step);

    let mut state = State::default();
    let mut action = Action::default();
    let mut record = Record::default();
    let mut before: Option<Controls> = None;
    let limit = (longest * rate) as usize;
    // a motorcycle that nobody can ride ends the ride
    while rider.phase().is_some() && record.states.len() < limit && state.roll.is_finite() {
        for decision in 0..decisions {
            let response = plant.response(&state, &action);
            let label = rider.label(state.roll);
            let (next, controls) = rider.act(&state, &response);
            action = next;
            if decision == 0 {
                let response = plant.response(&state, &action);
                // torques are held from decision to decision: about a sample the mean of both acts
                let last = before.unwrap_or(controls).pressure;
                let pressure = [0, 1].map(|k| 0.5 * (last[k] + controls.pressure[k]));
                record.push(&state, &response, Controls { pressure, ..controls }, label);
                record.road.push(rider.road());
            }
            before = Some(controls);
            plant.advance(&mut state, &action, step);
        }
    }
    let session = record.session(meta, rate);
    let labels = labels(&record.kinds, rate);
    let Record { states, responses, road, .. } = record;
    Simulated { session, labels, trace: responses, states, road }
}

/// Record of a ride, sample by sample.
#[derive(Default)]
struct Record {
    states: Vec<State>,
    responses: Vec<Response>,
    controls: Vec<Controls>,
    kinds: Vec<(ManoeuvreKind, Option<Direction>)>,
    /// Grade of the road and what was climbed since the start, m.
    road: Vec<[f64; 2]>,
}

impl Record {
    fn push(
        &mut self,
        state: &State,
        response: &Response,
        controls: Controls,
        kind: (ManoeuvreKind, Option<Direction>),
    ) {
        self.states.push(*state);
        self.responses.push(*response);
        self.controls.push(controls);
        self.kinds.push(kind);
    }

    fn session(&self, meta: Meta, rate: f64) -> Session {
        let mut session = Session::new(meta, rate, self.states.len());
        let states = |f: fn(&State) -> f64| self.states.iter().map(f).collect::<Vec<_>>();
        let responses = |f: fn(&Response) -> f64| self.responses.iter().map(f).collect::<Vec<_>>();
        let controls = |f: fn(&Controls) -> f64| self.controls.iter().map(f).collect::<Vec<_>>();
        use Channel as C;
        session.set(C::VelocityX, states(|s| s.vx));
        session.set(C::VelocityY, states(|s| s.vy));
        session.set(C::AccelerationX, responses(|r| r.acceleration[0]));
        session.set(C::AccelerationY, responses(|r| r.acceleration[1]));
        session.set(C::Roll, states(|s| s.roll));
        session.set(C::Yaw, states(|s| s.yaw));
        session.set(C::RollRate, states(|s| s.roll_rate));
        session.set(C::YawRate, states(|s| s.yaw_rate));
        session.set(C::SteerAngle, states(|s| s.steer));
        session.set(C::WheelSpeedFront, states(|s| s.omega[0]));
        session.set(C::WheelSpeedRear, states(|s| s.omega[1]));
        session.set(C::BrakePressureFront, controls(|c| c.pressure[0]));
        session.set(C::BrakePressureRear, controls(|c| c.pressure[1]));
        session.set(C::Throttle, controls(|c| c.throttle));
        session.set(C::Gear, controls(|c| c.gear));
        // no suspension: the frame stays level
        session.set(C::Pitch, vec![0.0; self.states.len()]);
        session
    }
}
