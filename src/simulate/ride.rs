//! One session on the nonlinear motorcycle.

use nalgebra::Vector3;

use super::imu::{self, Motion};
use super::odd_manoeuvre::with_odd;
use super::pilot::{Pilot, Skill};
use super::programme::{Controls, Programme};
use super::sensors;
use super::simulated::{Label, labels};
use super::tour::Tour;
use super::unsteady::Unsteady;
use super::wheel_sensors;
use crate::contract::channel::Channel;
use crate::contract::session::{Meta, Session};
use crate::simulate::multibody::run::{Fall, Run};
use crate::simulate::multibody::{Action, Wheel, joint};
use crate::statistics::random::Random;
use crate::store::tables::rows::TruthSignal;

/// Longest ride that is simulated, s.
const LONGEST: f64 = 7200.0;
/// The rider decides at least this often, Hz.
const DECISIONS: f64 = 100.0;

/// The true motion at one sample of the log.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Motion of the frame, about the centre of mass of the upright motorcycle.
    pub motion: Motion,
    /// Position of the rear contact, m.
    pub position: [f64; 2],
    pub joints: [f64; joint::COUNT],
    pub rates: [f64; joint::COUNT],
    pub wheels: [Wheel; 2],
    /// Action of the rider.
    pub action: Action,
    /// Controls seen by the loggers.
    pub controls: Controls,
}

/// One simulated session with everything known about it.
#[derive(Debug, Clone)]
pub struct MultibodyRide {
    pub session: Session,
    /// Manoeuvres: kind, start and end (s), direction.
    pub labels: Vec<Label>,
    /// The truth, sample by sample.
    pub samples: Vec<Sample>,
    /// How it ended before its time, if it did; the log ends there.
    pub fall: Option<Fall>,
    /// Integration steps taken.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub steps: usize,
}

/// Span between the rider's decisions for a log of this rate, s.
pub fn period(rate: f64) -> f64 {
    1.0 / (rate * (DECISIONS / rate).ceil().max(1.0))
}

/// Rides the `number`-th session of a tour.
pub fn ride(tour: &Tour, skill: &Skill, number: usize) -> MultibodyRide {
    let id = format!("{}_{}_s{:04}", tour.name, tour.bike.bike_id, number + 1);
    let mut random = Random::new(tour.seed, &format!("{id} plan"));
    let phases = tour.manoeuvres.iter().flat_map(|m| m.phases(&mut random)).collect();
    let phases = with_odd(phases, &tour.odd_manoeuvres);
    let decisions = (DECISIONS / tour.rate).ceil().max(1.0) as usize;
    let period = period(tour.rate);
    let substeps = (period / tour.step).ceil().max(1.0) as usize;
    let step = period / substeps as f64;

    let model = &tour.model;
    let mut run = Run::new(model, model.straight(tour.start_speed));
    let mut pilot = Pilot::new(model, Programme::new(&phases, period), skill);
    let centre = model.motorcycle.centre();
    let mut samples: Vec<Sample> = Vec::new();
    let mut kinds = Vec::new();
    let mut fall = None;
    let mut steps = 0;
    let mut action = Action { wind: tour.wind, ..Action::default() };
    let noise = Random::new(tour.seed, &format!("{id} ride"));
    let mut unsteady = Unsteady::new(
        &model.motorcycle,
        tour.disturbance,
        tour.model_error,
        tour.wind,
        noise,
        period,
    );
    run.observe(&action);
    let limit = (LONGEST * tour.rate) as usize;
    'ride: while pilot.programme.phase().is_some() && samples.len() < limit {
        for decision in 0..decisions {
            let label = pilot.programme.label(run.state.angles[1]);
            pilot.sway = unsteady.sway();
            let controls;
            let done;
            (action, controls, done) = pilot.act(&run.state, &run.scratch);
            let speed = pilot.perceive(&run.state, &run.scratch).speed;
            unsteady.act(&mut action, &controls, speed);
            if done {
                unsteady.next_phase();
            }
            run.observe(&action);
            if decision == 0 {
                samples.push(sample(&run, &action, controls, &centre));
                kinds.push(label);
            }
            for _ in 0..substeps {
                run.step(&action, step);
            }
            steps += substeps;
            if let Err(end) = run.check() {
                fall = Some(end);
                break 'ride;
            }
            run.observe(&action);
        }
    }
    let mut session = record(meta(tour, id, number, fall.is_some()), tour, &samples);
    let seen = samples.iter().map(|s| (s.wheels, s.action));
    wheel_sensors::of_multibody(&mut session, seen, &tour.sensors);
    for &channel in &tour.drop {
        session.remove(channel);
    }
    tour.model_error.measure(&mut session);
    sensors::measure(&mut session, &tour.sensors, tour.seed);
    sensors::clamp_physical(&mut session);
    let labels = labels(&kinds, tour.rate);
    MultibodyRide { session, labels, samples, fall, steps }
}

/// Metadata of the session in the log; a log that ends in a fall says so.
fn meta(tour: &Tour, id: String, number: usize, fell: bool) -> Meta {
    Meta {
        session_id: id,
        bike_id: tour.bike.bike_id.clone(),
        start_time: Some(format!(
            "2026-06-{:02}T{:02}:00:00Z",
            1 + number / 8 % 28,
            8 + number % 8
        )),
        tyre_front: tour.bike.front.model.clone(),
        tyre_rear: tour.bike.rear.model.clone(),
        site: Some(if fell { "simulated, partial: fell" } else { "simulated" }.into()),
        rider_id: None,
    }
}

pub(super) fn sample(
    run: &Run<'_>,
    action: &Action,
    controls: Controls,
    centre: &Vector3<f64>,
) -> Sample {
    let frame = &run.scratch.work.links[0];
    let at = frame.position + frame.rotation * centre;
    let gravity = run.scratch.gravity;
    Sample {
        motion: Motion {
            rotation: frame.rotation,
            spin: frame.velocity.angular,
            spin_rate: run.rates.velocity.angular,
            velocity: frame.velocity_at(&at),
            acceleration: frame.acceleration_at(&at, &gravity),
            gravity: gravity - run.scratch.pull,
        },
        position: [run.state.position.x, run.state.position.y],
        joints: run.state.joints,
        rates: run.state.rates,
        wheels: run.scratch.wheels,
        action: *action,
        controls,
    }
}

/// The log before its sensors' own errors.
fn record(meta: Meta, tour: &Tour, samples: &[Sample]) -> Session {
    use Channel as C;
    let mut session = Session::new(meta, tour.rate, samples.len());
    let motions: Vec<Motion> = samples.iter().map(|s| s.motion).collect();
    let perfect = imu::Imu::default();
    let unit = tour.imu.as_ref().unwrap_or(&perfect);
    let mut random = Random::new(tour.seed, &format!("imu {}", session.meta.session_id));
    let m = imu::measure(unit, &motions, tour.rate, &mut random);
    session.set(C::VelocityX, m.velocity_x);
    session.set(C::VelocityY, m.velocity_y);
    session.set(C::AccelerationX, m.acceleration_x);
    session.set(C::AccelerationY, m.acceleration_y);
    // of the road's bank an inertial unit knows nothing
    let bank = -tour.model_error.camber(0.0);
    session.set(C::Roll, m.roll.into_iter().map(|roll| roll + bank).collect());
    session.set(C::Pitch, m.pitch);
    session.set(C::Yaw, m.yaw);
    session.set(C::RollRate, m.roll_rate);
    session.set(C::PitchRate, m.pitch_rate);
    session.set(C::YawRate, m.yaw_rate);
    let column = |f: fn(&Sample) -> f64| samples.iter().map(f).collect::<Vec<f64>>();
    session.set(C::SteerAngle, column(|s| s.joints[joint::STEER]));
    session.set(C::WheelSpeedFront, column(|s| s.rates[joint::FRONT]));
    session.set(C::WheelSpeedRear, column(|s| s.rates[joint::REAR]));
    session.set(C::BrakePressureFront, column(|s| s.controls.pressure[0]));
    session.set(C::BrakePressureRear, column(|s| s.controls.pressure[1]));
    session.set(C::Throttle, column(|s| s.controls.throttle));
    session.set(C::Gear, column(|s| s.controls.gear));
    session
}

/// The truth as rows of `truth_signals`.
pub(crate) fn truth_signals(ridden: &MultibodyRide) -> Vec<TruthSignal> {
    let meta = &ridden.session.meta;
    let row = |(i, s): (usize, &Sample)| {
        let [front, rear] = &s.wheels;
        TruthSignal {
            session_id: meta.session_id.clone(),
            bike_id: meta.bike_id.clone(),
            time: ridden.session.time(i),
            steer_torque: s.action.steer_torque,
            drive_torque: s.action.drive,
            x: s.position[0],
            y: s.position[1],
            slip_ratio_front: front.slip[0],
            slip_angle_front: front.slip[1],
            camber_front: front.camber,
            load_front: front.load,
            force_x_front: front.force[0],
            force_y_front: front.force[1],
            moment_x_front: front.moment_x,
            moment_z_front: front.moment_z,
            slip_ratio_rear: rear.slip[0],
            slip_angle_rear: rear.slip[1],
            camber_rear: rear.camber,
            load_rear: rear.load,
            force_x_rear: rear.force[0],
            force_y_rear: rear.force[1],
            moment_x_rear: rear.moment_x,
            moment_z_rear: rear.moment_z,
        }
    };
    ridden.samples.iter().enumerate().map(row).collect()
}
