//! Sessions of a rider on a closed track, on the multibody motorcycle: several laps, always in gear.
//!
//! ```text
//! scenario -> machine, circuit, pace -> rider (lean by preview, throttle, gears, brakes) + motorcycle
//!          -> samples -> session in the contract's form, and what foreign loggers write of it
//! ```
//!
//! Nothing of it is made for an estimate: no coasting in neutral, no single brake, no steady turn. The slope acts
//! as a force along the heading at the aerodynamic centre, which is about the height of the centre of mass; banked
//! corners, kerbs and the tyres' warming are left out. Tyres that fade lose a share of their forces (`fade`) evenly
//! over the distance of the session.

pub(crate) mod circuit;
pub(crate) mod drivetrain;
mod fade;
pub(crate) mod ridden;
pub(crate) mod rider;
pub(crate) mod scenario;
pub(crate) mod truth;

use nalgebra::Vector3;

use self::ridden::CORNER;
pub(crate) use self::ridden::{TrackRide, position};
use self::rider::{Hands, Rider};
pub(crate) use self::scenario::{Entry, Track};
pub(crate) use self::truth::notes;
use super::imu;
use super::preview::{Preview, Target};
use super::programme::Controls;
use super::ride::{MultibodyRide, sample};
use super::sensors;
use super::simulated::labels;
use super::unsteady::Unsteady;
use super::wheel_sensors;
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::session::{Meta, Session};
use crate::segment::manoeuvre::{Direction, ManoeuvreKind};
use crate::simulate::effects::ModelError;
use crate::simulate::error::Error;
use crate::simulate::multibody::joint;
use crate::simulate::multibody::run::{Fall, Run};
use crate::statistics::random::Random;
use crate::tyre::tyre_model::TyreModel;

/// Longest integration step, s.
const STEP: f64 = 0.002;
/// Speed on the start line, m/s.
const START: f64 = 30.0;
/// Attempts at a session that comes to its end.
pub(crate) const ATTEMPTS: usize = 8;
/// Rides the session of a number: the first attempt that does not fall.
///
/// # Errors
/// None of [`ATTEMPTS`] comes to its end; a sentence that says how they fell.
pub fn ride(track: &Track, number: usize) -> Result<TrackRide, Error> {
    let mut failed = Vec::new();
    for attempt in 0..ATTEMPTS {
        let tried = track.entry(number, attempt).and_then(|entry| attempted(track, entry, number));
        match tried {
            Ok(ridden) => match ridden.ride.fall {
                Some(fall) => failed.push(fall.to_string()),
                None => return Ok(TrackRide { failed, ..ridden }),
            },
            Err(why) => failed.push(why.to_string()),
        }
    }
    Err(Error::Ride(format!("{} session {}: {}", track.name, number + 1, failed.join("; "))))
}

/// One attempt; it may end in a fall.
fn attempted(track: &Track, mut entry: Entry, number: usize) -> Result<TrackRide, Error> {
    let decisions = (100.0 / track.rate).ceil().max(1.0) as usize;
    let period = 1.0 / (track.rate * decisions as f64);
    let substeps = (period / STEP).ceil().max(1.0) as usize;
    let left = fade::RemainingGrip::all();
    if track.fade != 0.0 {
        let fading =
            |base| Box::new(fade::Fading { base, left: left.clone() }) as Box<dyn TyreModel>;
        entry.model.motorcycle.tyres = entry.model.motorcycle.tyres.map(|tyres| tyres.map(fading));
    }
    let entry = entry;
    let model = &entry.model;
    let steering =
        Preview::new(model, Target::Roll, period).map_err(|e| Error::Ride(e.to_string()))?;
    let id = format!("{}_{}_s{:04}", track.name, entry.bike.bike_id, number + 1);
    let mut random = Random::new(track.seed, &format!("{id} rider"));
    let riding = (entry.pace, track.laps, START);
    let mut rider =
        Rider::new(model, &entry.circuit, entry.drivetrain, steering, riding, &mut random);
    let mut state = model.straight(START);
    state.position.x = entry.circuit.points[0][0];
    let mut run = Run::new(model, state);
    let noise = Random::new(track.seed, &format!("{id} ride"));
    let m = &model.motorcycle;
    let error = ModelError::default();
    let mut unsteady = Unsteady::new(m, entry.disturbance, error, entry.wind, noise, period);
    let centre = m.centre();
    let (mut samples, mut hands, mut kinds) = (Vec::new(), Vec::new(), Vec::new());
    let (mut crossings, mut lap, mut corner) = (vec![0.0], 0, usize::MAX);
    let mut fall = None;
    let mut steps = 0;
    // nobody takes a minute for a kilometre
    let limit = (track.laps as f64 * entry.circuit.length * 0.06 * track.rate) as usize;
    run.observe(&crate::simulate::multibody::Action { wind: entry.wind, ..Default::default() });
    'ride: while rider.lap() < track.laps && samples.len() < limit {
        for decision in 0..decisions {
            rider.sway = unsteady.sway();
            let mut action = rider.act(&run.state, &run.scratch);
            let controls = Controls {
                pressure: rider.hands.pressure,
                throttle: rider.hands.throttle,
                gear: rider.hands.gear as f64,
            };
            let speed = run.state.velocity.linear.x;
            unsteady.act(&mut action, &controls, speed);
            let along = rider.hands.along;
            let progress = along / (track.laps as f64 * entry.circuit.length);
            left.set(1.0 - track.fade * progress.clamp(0.0, 1.0));
            let here = entry.circuit.next_corner[entry.circuit.index(along)];
            if here != corner {
                // pads bite anew in every corner; the slope is the track's, not drawn
                corner = here;
                unsteady.next_phase();
            }
            let grade = entry.circuit.value(&entry.circuit.grade, along);
            action.gust[0] -= m.mass() * GRAVITY * grade;
            run.observe(&action);
            if decision == 0 {
                let mut now = sample(&run, &action, controls, &centre);
                // the road's plane is tilted: what an accelerometer feels of it
                let (sin, cos) = run.state.angles[0].sin_cos();
                now.motion.gravity += Vector3::new(cos, sin, 0.0) * (-GRAVITY * grade);
                samples.push(now);
                kinds.push(kind(&rider.hands, run.state.angles[1]));
                hands.push(rider.hands);
            }
            if rider.lap() > lap {
                lap = rider.lap();
                crossings.push(run.time);
            }
            for _ in 0..substeps {
                run.step(&action, period / substeps as f64);
            }
            steps += substeps;
            if let Err(end) = run.check() {
                fall = Some(end);
                break 'ride;
            }
            run.observe(&action);
        }
        if rider.hands.left.abs() > 25.0 {
            fall = Some(Fall::Over {
                time: run.time,
                roll: run.state.angles[1],
                speed: run.state.velocity.linear.x,
            });
            break;
        }
    }
    // truths of the session are those of its middle
    left.set(1.0 - 0.5 * track.fade);
    let meta = Meta {
        session_id: id.clone(),
        bike_id: entry.bike.bike_id.clone(),
        start_time: Some(format!(
            "2026-07-{:02}T{:02}:00:00Z",
            1 + number / 8 % 28,
            9 + number % 8
        )),
        tyre_front: entry.bike.front.model.clone(),
        tyre_rear: entry.bike.rear.model.clone(),
        site: Some("simulated track".into()),
        rider_id: None,
    };
    let mut session = record(track, meta, &entry, &samples, &hands);
    let seen = samples.iter().map(|s| (s.wheels, s.action));
    wheel_sensors::of_multibody(&mut session, seen, &track.sensors);
    for &channel in &track.drop {
        session.remove(channel);
    }
    sensors::measure(&mut session, &track.sensors, track.seed);
    sensors::clamp_physical(&mut session);
    let labels = labels(&kinds, track.rate);
    let ride = MultibodyRide { session, labels, samples, fall, steps };
    Ok(TrackRide { entry, ride, hands, crossings, failed: Vec::new() })
}

/// Current manoeuvre: a corner by its lean, else what the brakes say. Engine braking is driving.
fn kind(hands: &Hands, roll: f64) -> (ManoeuvreKind, Option<Direction>) {
    let pressed = hands.pressure.map(|p| p > 5e4);
    if roll.abs() > CORNER {
        let side = if roll < 0.0 { Direction::Left } else { Direction::Right };
        return (ManoeuvreKind::Cornering, Some(side));
    }
    let kind = match pressed {
        [true, false] => ManoeuvreKind::FrontBraking,
        [false, true] => ManoeuvreKind::RearBraking,
        [true, true] => ManoeuvreKind::CombinedBraking,
        [false, false] => ManoeuvreKind::Driving,
    };
    (kind, None)
}

/// The contract's log before its sensors' own errors.
fn record(
    track: &Track,
    meta: Meta,
    entry: &Entry,
    samples: &[super::ride::Sample],
    hands: &[Hands],
) -> Session {
    use Channel as C;
    let mut session = Session::new(meta, track.rate, samples.len());
    let motions: Vec<imu::Motion> = samples.iter().map(|s| s.motion).collect();
    let perfect = imu::Imu::default();
    let unit = track.imu.as_ref().unwrap_or(&perfect);
    let mut random = Random::new(track.seed, &format!("imu {}", session.meta.session_id));
    let m = imu::measure(unit, &motions, track.rate, &mut random);
    session.set(C::VelocityX, m.velocity_x);
    session.set(C::VelocityY, m.velocity_y);
    session.set(C::AccelerationX, m.acceleration_x);
    session.set(C::AccelerationY, m.acceleration_y);
    session.set(C::Roll, m.roll);
    // uphill the nose is up, which is negative
    let circuit = &entry.circuit;
    let grade = |h: &Hands| circuit.value(&circuit.grade, h.along);
    session.set(C::Pitch, m.pitch.iter().zip(hands).map(|(p, h)| p - grade(h)).collect());
    session.set(C::Yaw, m.yaw);
    session.set(C::RollRate, m.roll_rate);
    session.set(C::PitchRate, m.pitch_rate);
    session.set(C::YawRate, m.yaw_rate);
    let column = |f: fn(&super::ride::Sample) -> f64| samples.iter().map(f).collect::<Vec<f64>>();
    session.set(C::SteerAngle, column(|s| s.joints[joint::STEER]));
    session.set(C::WheelSpeedFront, column(|s| s.rates[joint::FRONT]));
    session.set(C::WheelSpeedRear, column(|s| s.rates[joint::REAR]));
    session.set(C::BrakePressureFront, column(|s| s.controls.pressure[0]));
    session.set(C::BrakePressureRear, column(|s| s.controls.pressure[1]));
    session.set(C::Throttle, column(|s| s.controls.throttle));
    session.set(C::Gear, column(|s| s.controls.gear));
    session.set(C::Latitude, column(|s| position(s.position)[0]));
    session.set(C::Longitude, column(|s| position(s.position)[1]));
    let height = |h: &Hands| circuit.value(&circuit.altitude, h.along);
    session.set(C::Altitude, hands.iter().map(height).collect());
    session
}
