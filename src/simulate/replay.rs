//! Braking ridden again: the measured brake pressures go in, deceleration and slip come out.

use std::ops::Range;

use super::preview::{Preview, Target};
use crate::contract::channel::Channel;
use crate::contract::session::{Meta, Session};
use crate::segment::Segment;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::simulate::multibody::run::{Fall, Run};
use crate::simulate::multibody::trim;
use crate::simulate::multibody::trim::NoTrim;
use crate::simulate::multibody::{Action, Model};
use crate::store::tables::rows::BrakingReplay;

/// Longest integration step, s.
const STEP: f64 = 1e-3;

/// One braking, measured and simulated, sample by sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Replay {
    /// Since the start of the session, s.
    pub time: Vec<f64>,
    /// Brake pressures, Pa, front and rear.
    pub pressure: [Vec<f64>; 2],
    /// Longitudinal acceleration, m/s².
    pub measured_acceleration: Vec<f64>,
    /// The same in the simulation.
    pub acceleration: Vec<f64>,
    /// Slip ratios from wheel speeds and velocity, front and rear.
    pub measured_slip: [Vec<f64>; 2],
    /// The same in the simulation.
    pub slip: [Vec<f64>; 2],
}

/// Why a braking cannot be ridden again.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The log lacks a channel.
    #[error("the log has no channel {0}")]
    Channel(&'static str),
    /// The motorcycle cannot run straight at the speed.
    #[error(transparent)]
    Trim(#[from] NoTrim),
    #[error(transparent)]
    Fall(#[from] Fall),
}

/// Peaks of one braked wheel: measured, simulated, and how much later the simulated one comes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peaks {
    /// Largest decelerations over 0.2 s, m/s², positive.
    pub deceleration: [f64; 2],
    /// Deepest slip ratios.
    pub slip: [f64; 2],
    /// How much later the simulation comes to half the deepest measured slip, s.
    pub delay: f64,
}

/// A braking of a session, ridden again.
#[derive(Debug)]
pub(crate) struct Braking {
    pub kind: ManoeuvreKind,
    /// Since the start of the session, s.
    pub start: f64,
    pub replay: Result<Replay, Error>,
}

impl Braking {
    /// The wheel whose slip counts: 0 front, 1 rear.
    pub(crate) fn wheel(&self) -> usize {
        usize::from(self.kind == ManoeuvreKind::RearBraking)
    }

    /// Its row of the table `replay`; `None` where it could not be ridden again.
    pub(crate) fn row(&self, meta: &Meta) -> Option<BrakingReplay> {
        let replay = self.replay.as_ref().ok()?;
        let peaks = replay.peaks(self.wheel());
        let [rms_acceleration, slip_ratio_rms_difference] = replay.rms(self.wheel());
        Some(BrakingReplay {
            session_id: meta.session_id.clone(),
            bike_id: meta.bike_id.clone(),
            kind: self.kind.name().to_owned(),
            start: self.start,
            measured_deceleration: peaks.deceleration[0],
            simulated_deceleration: peaks.deceleration[1],
            slip_ratio_measured: peaks.slip[0],
            slip_ratio_simulated: peaks.slip[1],
            delay: Some(peaks.delay).filter(|d| d.is_finite()),
            rms_acceleration,
            slip_ratio_rms_difference,
        })
    }
}

/// Simulates stops again, each when it is asked for, from 0.3 s before its start so that the run
/// begins steady.
pub(crate) fn brakings<'a>(
    model: &'a Model,
    steering: &'a Preview,
    session: &'a Session,
    segments: &'a [&Segment],
) -> impl Iterator<Item = Braking> + 'a {
    segments.iter().map(move |s| {
        let from = s.start.saturating_sub((0.3 * session.rate) as usize);
        let replay = braking(model, steering, session, from..s.end);
        Braking { kind: s.kind, start: session.time(s.start), replay }
    })
}

/// Rides the samples of `range` again.
///
/// # Errors
/// See [`Error`].
pub fn braking(
    model: &Model,
    steering: &Preview,
    session: &Session,
    range: Range<usize>,
) -> Result<Replay, Error> {
    let need = |c: Channel| session.get(c).ok_or(Error::Channel(c.name()));
    let velocity = need(Channel::VelocityX)?;
    let acceleration = need(Channel::AccelerationX)?;
    let omega = [need(Channel::WheelSpeedFront)?, need(Channel::WheelSpeedRear)?];
    let pressure =
        [Channel::BrakePressureFront, Channel::BrakePressureRear].map(|c| session.get(c));
    let m = &model.motorcycle;
    let loads = m.static_loads();
    let radius: [f64; 2] = std::array::from_fn(|i| {
        m.tyres.as_ref().map_or(m.centres[i].z, |t| t[i].carcass().rolling_radius(loads[i], 0.0))
    });
    let start = velocity[range.start];
    let trim = trim::steady(model, start, 0.0, None)?;
    let mut run = Run::new(model, trim.state);
    let dt = 1.0 / session.rate;
    let substeps = (dt / STEP).ceil().max(1.0) as usize;
    let mut out = Replay::default();
    for i in range {
        let on = |k: usize| {
            let p = pressure[k].map_or(0.0, |p| p[i]);
            if p.is_finite() { p.max(0.0) } else { 0.0 }
        };
        let speed = run.state.velocity.linear.x;
        let action = Action {
            brake: [m.brake_gain[0] * on(0), m.brake_gain[1] * on(1)],
            steer_torque: steering.torque(&run.state, speed.max(3.5), |_| 0.0),
            ..Action::default()
        };
        run.observe(&action);
        let at =
            run.scratch.work.links[0].position + run.scratch.work.links[0].rotation * m.centre();
        let felt = run.scratch.work.links[0].acceleration_at(&at, &run.scratch.gravity);
        let (sin, cos) = run.state.angles[0].sin_cos();
        out.time.push(session.time(i));
        out.measured_acceleration.push(acceleration[i]);
        out.acceleration.push(felt.x * cos + felt.y * sin);
        for k in 0..2 {
            out.pressure[k].push(on(k));
            out.measured_slip[k].push(radius[k] * omega[k][i] / velocity[i] - 1.0);
            out.slip[k].push(run.scratch.wheels[k].kinematic[0]);
        }
        for _ in 0..substeps {
            run.step(&action, dt / substeps as f64);
        }
        run.check()?;
        if run.state.velocity.linear.x < 2.0 {
            break; // slips mean nothing any more
        }
    }
    Ok(out)
}

impl Replay {
    /// Peaks of wheel `k` (0 front).
    pub fn peaks(&self, k: usize) -> Peaks {
        let lowest = |x: &[f64]| x.iter().copied().filter(|x| x.is_finite()).fold(0.0, f64::min);
        let deepest = lowest(&self.measured_slip[k]);
        let reached = |x: &[f64]| {
            let first = x.iter().position(|&s| s <= 0.5 * deepest);
            first.map_or(f64::NAN, |i| self.time[i])
        };
        // an accelerometer above the centre of mass feels the frame's pitching: a fifth of a second
        // on average counts
        let rate = match self.time.len() {
            0 | 1 => 1.0,
            n => (n - 1) as f64 / (self.time[n - 1] - self.time[0]),
        };
        let width = ((0.2 * rate).round() as usize).max(1);
        let hardest = |x: &[f64]| {
            let means = x.windows(width).map(|w| w.iter().sum::<f64>() / width as f64);
            -means.filter(|x| x.is_finite()).fold(0.0, f64::min)
        };
        Peaks {
            deceleration: [hardest(&self.measured_acceleration), hardest(&self.acceleration)],
            slip: [deepest, lowest(&self.slip[k])],
            delay: reached(&self.slip[k]) - reached(&self.measured_slip[k]),
        }
    }

    /// Root mean squared differences of acceleration (m/s²) and of wheel `k`'s slip.
    pub fn rms(&self, k: usize) -> [f64; 2] {
        let rms = |a: &[f64], b: &[f64]| {
            let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
            (sum / a.len().max(1) as f64).sqrt()
        };
        [
            rms(&self.measured_acceleration, &self.acceleration),
            rms(&self.measured_slip[k], &self.slip[k]),
        ]
    }
}

/// Steering that keeps a motorcycle upright during a replay.
///
/// # Errors
/// It cannot run straight.
pub fn steering(model: &Model, rate: f64) -> Result<Preview, NoTrim> {
    Preview::new(model, Target::Roll, 1.0 / rate)
}
