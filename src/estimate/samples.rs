//! The measured channels of the used segments, gathered at the estimation rate.

use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::{
    contract::manoeuvre::{Direction, ManoeuvreKind},
    segment::Segment,
};

use super::Config;

/// Samples of several segments, side by side; columns of equal length, NaN where there is no
/// channel. Velocities are read where their latency puts them; zeros are taken off later.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// Place of the segment in the session's list.
    pub segment: Vec<usize>,
    /// Time, s.
    pub time: Vec<f64>,
    /// Forward velocity at the stamp, m/s.
    pub velocity_x: Vec<f64>,
    /// Rate of the forward velocity channel, m/s², for the latency.
    pub velocity_x_rate: Vec<f64>,
    /// Lateral velocity, m/s.
    pub velocity_y: Vec<f64>,
    /// Its rate, m/s².
    pub velocity_y_rate: Vec<f64>,
    /// Forward acceleration, m/s².
    pub acceleration_x: Vec<f64>,
    /// Pitch, rad.
    pub pitch: Vec<f64>,
    /// Pitch rate, rad/s.
    pub pitch_rate: Vec<f64>,
    /// Roll, rad.
    pub roll: Vec<f64>,
    /// Roll rate, rad/s.
    pub roll_rate: Vec<f64>,
    /// Roll acceleration, rad/s², over 0.2 s.
    pub roll_acceleration: Vec<f64>,
    /// Largest change of roll within 0.4 s before or after, rad: how quasi-static it is.
    pub roll_change: Vec<f64>,
    /// Yaw rate, rad/s.
    pub yaw_rate: Vec<f64>,
    /// Yaw acceleration, rad/s², over 0.2 s.
    pub yaw_acceleration: Vec<f64>,
    /// Handlebar angle, rad.
    pub steer: Vec<f64>,
    /// Wheel speeds, front and rear, rad/s.
    pub omega: [Vec<f64>; 2],
    /// Their rates, rad/s².
    pub omega_rate: [Vec<f64>; 2],
    /// Direction of travel: +1, -1, or 0 where unknown.
    pub direction: Vec<f64>,
}

impl Samples {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.segment.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.segment.is_empty()
    }

    /// Some of the samples, by their places.
    pub fn select(&self, places: &[usize]) -> Samples {
        let of = |x: &Vec<f64>| places.iter().map(|&i| x[i]).collect::<Vec<f64>>();
        Samples {
            segment: places.iter().map(|&i| self.segment[i]).collect(),
            time: of(&self.time),
            velocity_x: of(&self.velocity_x),
            velocity_x_rate: of(&self.velocity_x_rate),
            velocity_y: of(&self.velocity_y),
            velocity_y_rate: of(&self.velocity_y_rate),
            acceleration_x: of(&self.acceleration_x),
            pitch: of(&self.pitch),
            pitch_rate: of(&self.pitch_rate),
            roll: of(&self.roll),
            roll_rate: of(&self.roll_rate),
            roll_acceleration: of(&self.roll_acceleration),
            roll_change: of(&self.roll_change),
            yaw_rate: of(&self.yaw_rate),
            yaw_acceleration: of(&self.yaw_acceleration),
            steer: of(&self.steer),
            omega: [of(&self.omega[0]), of(&self.omega[1])],
            omega_rate: [of(&self.omega_rate[0]), of(&self.omega_rate[1])],
            direction: of(&self.direction),
        }
    }

    /// Puts other samples behind these.
    pub fn append(&mut self, mut other: Samples) {
        self.segment.append(&mut other.segment);
        self.time.append(&mut other.time);
        self.velocity_x.append(&mut other.velocity_x);
        self.velocity_x_rate.append(&mut other.velocity_x_rate);
        self.velocity_y.append(&mut other.velocity_y);
        self.velocity_y_rate.append(&mut other.velocity_y_rate);
        self.acceleration_x.append(&mut other.acceleration_x);
        self.pitch.append(&mut other.pitch);
        self.pitch_rate.append(&mut other.pitch_rate);
        self.roll.append(&mut other.roll);
        self.roll_rate.append(&mut other.roll_rate);
        self.roll_acceleration.append(&mut other.roll_acceleration);
        self.roll_change.append(&mut other.roll_change);
        self.yaw_rate.append(&mut other.yaw_rate);
        self.yaw_acceleration.append(&mut other.yaw_acceleration);
        self.steer.append(&mut other.steer);
        for k in 0..2 {
            self.omega[k].append(&mut other.omega[k]);
            self.omega_rate[k].append(&mut other.omega_rate[k]);
        }
        self.direction.append(&mut other.direction);
    }
}

/// A value between samples by a cubic through its four neighbours; `at` in samples.
fn between(x: &[f64], at: f64) -> f64 {
    let last = x.len().saturating_sub(1) as f64;
    let at = at.clamp(0.0, last);
    let i = at.floor();
    let f = at - i;
    let pick = |k: f64| x[(i + k).clamp(0.0, last) as usize];
    if f == 0.0 {
        return pick(0.0);
    }
    let (a, b, c, d) = (pick(-1.0), pick(0.0), pick(1.0), pick(2.0));
    // Catmull-Rom
    b + 0.5 * f * (c - a + f * (2.0 * a - 5.0 * b + 4.0 * c - d + f * (3.0 * (b - c) + d - a)))
}

/// Gathers what the used segments of some kinds have; `rate` in Hz, `latency` of the velocity
/// channels in s.
pub fn gather(
    session: &Session,
    segments: &[Segment],
    kinds: &[ManoeuvreKind],
    rate: f64,
    latency: f64,
    config: &Config,
) -> Samples {
    let step = (session.rate / rate).round().max(1.0) as usize;
    let mut out = Samples::default();
    let Some(speed) = session.get(Channel::VelocityX) else { return out };
    let column = |channel| session.get(channel);
    let last = session.len.saturating_sub(1);
    let late = latency * session.rate;
    let read = |x: Option<&[f64]>, i: usize| x.map_or(f64::NAN, |x| x[i]);
    let read_late = |x: Option<&[f64]>, i: usize| match x {
        Some(x) if late == 0.0 => x[i],
        Some(x) => between(x, i as f64 + late),
        None => f64::NAN,
    };
    let reach = (0.02 * session.rate).round().max(1.0) as usize;
    let rate_of = |x: Option<&[f64]>, i: usize| {
        let (a, b) = (i.saturating_sub(reach), (i + reach).min(last));
        x.map_or(f64::NAN, |x| (x[b] - x[a]) * session.rate / (b - a).max(1) as f64)
    };
    // a satellite's lateral velocity is noisy: its rate is taken over 0.2 s
    let wide = (0.1 * session.rate).round().max(1.0) as usize;
    let slow_rate_of = |x: Option<&[f64]>, i: usize| {
        let (a, b) = (i.saturating_sub(wide), (i + wide).min(last));
        x.map_or(f64::NAN, |x| (x[b] - x[a]) * session.rate / (b - a).max(1) as f64)
    };
    let near = (0.4 * session.rate).round() as usize;
    let change = |x: Option<&[f64]>, i: usize| {
        x.map_or(f64::NAN, |x| {
            let (before, after) = (x[i.saturating_sub(near)], x[(i + near).min(last)]);
            (after - x[i]).abs().max((x[i] - before).abs())
        })
    };
    let velocity_y = column(Channel::VelocityY);
    let acceleration_x = column(Channel::AccelerationX);
    let pitch = column(Channel::Pitch);
    let pitch_rate = column(Channel::PitchRate);
    let roll = column(Channel::Roll);
    let roll_rate = column(Channel::RollRate);
    let yaw_rate = column(Channel::YawRate);
    let steer = column(Channel::SteerAngle);
    let omega = [column(Channel::WheelSpeedFront), column(Channel::WheelSpeedRear)];
    for (number, segment) in segments.iter().enumerate() {
        if !segment.used || !kinds.contains(&segment.kind) {
            continue;
        }
        let direction = match segment.direction {
            Some(Direction::Outbound) => 1.0,
            Some(Direction::Inbound) => -1.0,
            _ => 0.0,
        };
        // the filter carries the neighbouring manoeuvre a little way in
        let trim = (config.trim * session.rate).round() as usize;
        let (start, end) = (segment.start + trim, segment.end.min(session.len));
        let end = end.saturating_sub(trim / 4);
        for i in (start..end).step_by(step) {
            if speed[i].is_nan() || speed[i] < config.min_speed {
                continue;
            }
            let moved = ((i as f64 + late).round().max(0.0) as usize).min(last);
            let from_velocity = rate_of(Some(speed), moved);
            out.segment.push(number);
            out.time.push(session.time(i));
            out.velocity_x.push(read_late(Some(speed), i));
            out.velocity_x_rate.push(from_velocity);
            out.velocity_y.push(read_late(velocity_y, i));
            out.velocity_y_rate.push(slow_rate_of(velocity_y, moved));
            // without an accelerometer the velocity is differentiated
            out.acceleration_x.push(acceleration_x.map_or(from_velocity, |x| x[i]));
            out.pitch.push(read(pitch, i));
            out.pitch_rate.push(pitch_rate.map_or_else(|| slow_rate_of(pitch, i), |x| x[i]));
            out.roll.push(read(roll, i));
            let rate = roll_rate.map_or_else(|| rate_of(roll, i), |x| x[i]);
            out.roll_rate.push(rate);
            out.roll_acceleration.push(slow_rate_of(roll_rate, i));
            out.roll_change.push(change(roll, i));
            out.yaw_rate.push(read(yaw_rate, i));
            out.yaw_acceleration.push(slow_rate_of(yaw_rate, i));
            out.steer.push(read(steer, i));
            for k in 0..2 {
                out.omega[k].push(read(omega[k], i));
                out.omega_rate[k].push(rate_of(omega[k], i));
            }
            out.direction.push(direction);
        }
    }
    out
}
