//! Motorcycles whose tyres are known: they make the archives that the estimates are tested on.
//!
//! ```text
//! scenario -> machine (bike file + truth) -> plan -> rider + motorcycle -> sensors -> session
//! tour -> nonlinear motorcycle -> manoeuvres -> pilot + model -> imu, sensors -> session
//! ```
//!
//! The first is the reduced-order motorcycle on the paper's tyre ([`motorcycle`]), for archives
//! of thousands of sessions; the second is the multibody one ([`crate::motorcycle`]) on any tyre.
//!
//! Seeded and deterministic: a session depends on the scenario and its own number only.

pub mod compare;
pub mod hidden;
pub mod hidden_offroad;
pub mod imu;
pub mod lateral_bench;
pub mod manoeuvre;
pub mod motocross;
pub mod motorcycle;
pub mod multibody;
pub mod path;
pub mod pilot;
pub mod plan;
pub mod preview;
pub mod programme;
pub mod replay;
pub mod ride;
pub mod rider;
pub mod scenario;
pub mod sensors;
pub mod simulated;
pub mod tables;
pub mod tour;
pub mod truth;
pub mod tyre_truth;
pub mod unsteady;

use std::path::PathBuf;

use crate::contract::channel::Channel;
use crate::contract::coefficient::Id;
use crate::contract::manoeuvre::{Direction, ManoeuvreKind};
use crate::contract::session::{Meta, Session};
use crate::statistics::random::Random;
use crate::tables::rows;
use motorcycle::{Action, Plant, Response, State};
use plan::Phase;
use programme::Controls;
use rider::{Disturbance, Rider};
use scenario::{Machine, Scenario};
pub use simulated::{Label, Simulated};

/// The text of a built-in scenario, or of a scenario file that has a key by which its kind is known.
fn text_with_key(
    builtin: &[(&str, &str)],
    name_or_path: &str,
    key: &str,
) -> Option<(String, PathBuf)> {
    let path = PathBuf::from(name_or_path);
    if let Some((_, text)) = builtin.iter().find(|(name, _)| *name == name_or_path) {
        return Some(((*text).to_owned(), path));
    }
    let text = std::fs::read_to_string(&path).ok()?;
    let table: toml::Table = text.parse().ok()?;
    table.contains_key(key).then_some((text, path))
}

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
        ridden(plant, &phases, scenario.disturbance, purpose("ride"), rate, LONGEST, meta);
    let session = &mut simulated.session;
    for &channel in &scenario.drop {
        session.remove(channel);
    }
    plant.model_error.measure(session);
    sensors::measure(session, &scenario.sensors, scenario.seed);
    clamp_physical(session);
    simulated
}

/// Phases on a motorcycle at a logger's `rate` (Hz), `longest` s at most: the true signals.
pub fn ridden(
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
                record.push(&state, &response, controls, label);
            }
            plant.advance(&mut state, &action, step);
        }
    }
    let session = record.session(meta, rate);
    let labels = runs_of(&record.kinds, rate);
    Simulated { session, labels, trace: record.responses, states: record.states }
}

/// Pedals and levers do not read below nothing, gears are whole.
fn clamp_physical(session: &mut Session) {
    for channel in [Channel::Throttle, Channel::BrakePressureFront, Channel::BrakePressureRear] {
        if let Some(x) = session.get_mut(channel) {
            x.iter_mut().for_each(|x| *x = x.max(0.0));
        }
    }
}

/// Every coefficient of a machine as rows of the `truth` table.
pub fn truth_rows(session: &Meta, coefficients: &[(Id, f64)]) -> Vec<rows::Truth> {
    coefficients
        .iter()
        .map(|&(id, value)| rows::Truth {
            session_id: session.session_id.clone(),
            bike_id: session.bike_id.clone(),
            tyre: id.part.name().to_owned(),
            coefficient: id.coefficient.name().to_owned(),
            value,
            unit: id.coefficient.spec().unit.to_owned(),
        })
        .collect()
}

#[derive(Default)]
struct Record {
    states: Vec<State>,
    responses: Vec<Response>,
    controls: Vec<Controls>,
    kinds: Vec<(ManoeuvreKind, Option<Direction>)>,
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

/// What went on, and from when to when (s).
fn runs_of(kinds: &[(ManoeuvreKind, Option<Direction>)], rate: f64) -> Vec<Label> {
    let mut labels = Vec::new();
    let mut start = 0;
    for i in 1..=kinds.len() {
        if i == kinds.len() || kinds[i] != kinds[start] {
            let (kind, direction) = kinds[start];
            labels.push((kind, start as f64 / rate, i as f64 / rate, direction));
            start = i;
        }
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ride_ends_stays_upright_and_is_reproducible() {
        let scenario = Scenario::builtin("paper").expect("scenario");
        let machine = scenario.machine(0);
        let a = session(&scenario, &machine, 0);
        assert!(a.session.duration() > 300.0 && a.session.duration() < 2000.0);
        let roll = a.states.iter().map(|s| s.roll.abs()).fold(0.0, f64::max);
        assert!((0.5..0.85).contains(&roll), "largest lean {roll} rad");
        let b = session(&scenario, &machine, 0);
        for channel in a.session.channels() {
            let (x, y) = (a.session.get(channel), b.session.get(channel));
            assert_eq!(x, y, "{channel}");
        }
    }

    #[test]
    fn measured_kinematics_are_consistent() {
        // v' = ax + r vy along the whole ride, for an undisturbed logger
        let scenario = Scenario::builtin("perfect").expect("scenario");
        let machine = scenario.machine(0);
        let s = session(&scenario, &machine, 0);
        let rate = scenario.rate;
        let along = |i: usize| s.trace[i].acceleration[0] + s.states[i].yaw_rate * s.states[i].vy;
        let mut errors = Vec::new();
        let mut integral = 0.0;
        for i in 1..s.states.len() - 1 {
            let derivative = (s.states[i + 1].vx - s.states[i - 1].vx) * rate / 2.0;
            errors.push((derivative - along(i)).abs());
            integral += along(i) / rate;
        }
        // brakes and throttle step between samples, so a few samples differ; nothing adds up
        errors.sort_by(f64::total_cmp);
        let most = errors[errors.len() * 99 / 100];
        assert!(most < 0.05, "{most}");
        assert!(integral.abs() < 0.5, "standstill to standstill: {integral}");
    }
}
