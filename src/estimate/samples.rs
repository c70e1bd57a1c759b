//! The measured channels of the used segments, gathered at the estimation rate.

use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::segment::Segment;
use crate::segment::manoeuvre::{Course, Direction, ManoeuvreKind};

use super::Config;

/// Slip angles, front and rear.
pub(crate) const SLIP_ANGLE: [Channel; 2] = [Channel::SlipAngleFront, Channel::SlipAngleRear];
/// Longitudinal forces.
pub(crate) const FORCE_X: [Channel; 2] = [Channel::WheelForceXFront, Channel::WheelForceXRear];
/// Side forces.
pub(crate) const FORCE_Y: [Channel; 2] = [Channel::WheelForceYFront, Channel::WheelForceYRear];
pub(crate) const LOAD: [Channel; 2] = [Channel::WheelForceZFront, Channel::WheelForceZRear];
/// Overturning moments.
pub(crate) const MOMENT_X: [Channel; 2] = [Channel::WheelMomentXFront, Channel::WheelMomentXRear];
pub(crate) const BRAKE_TORQUE: [Channel; 2] = [Channel::BrakeTorqueFront, Channel::BrakeTorqueRear];

macro_rules! samples {
    (one: { $($(#[$doc:meta])* $column:ident,)* } two: { $($(#[$of:meta])* $pair:ident,)* }) => {
        /// Samples of several segments, side by side; columns of equal length, NaN where there is no
        /// channel. Velocities are read where their latency puts them; zeros are taken off later.
        #[derive(Debug, Clone, Default)]
        pub struct Samples {
            /// Index of the segment in the session's list.
            pub segment: Vec<usize>,
            $($(#[$doc])* pub $column: Vec<f64>,)*
            $($(#[$of])* pub $pair: [Vec<f64>; 2],)*
        }

        struct Sample {
            segment: usize,
            $($column: f64,)*
            $($pair: [f64; 2],)*
        }

        impl Samples {
            /// Some of the samples, by their indices.
            pub fn select(&self, indices: &[usize]) -> Samples {
                let of = |x: &Vec<f64>| indices.iter().map(|&i| x[i]).collect::<Vec<f64>>();
                Samples {
                    segment: indices.iter().map(|&i| self.segment[i]).collect(),
                    $($column: of(&self.$column),)*
                    $($pair: self.$pair.each_ref().map(of),)*
                }
            }

            /// Appends other samples.
            pub fn append(&mut self, mut other: Samples) {
                self.segment.append(&mut other.segment);
                $(self.$column.append(&mut other.$column);)*
                for k in 0..2 {
                    $(self.$pair[k].append(&mut other.$pair[k]);)*
                }
            }

            fn push(&mut self, sample: Sample) {
                self.segment.push(sample.segment);
                $(self.$column.push(sample.$column);)*
                for k in 0..2 {
                    $(self.$pair[k].push(sample.$pair[k]);)*
                }
            }
        }
    };
}

samples! {
    one: {
        /// Time, s.
        time,
        /// Forward velocity at the stamp, m/s.
        velocity_x,
        /// Rate of the forward velocity channel, m/s², for the latency.
        velocity_x_rate,
        /// Lateral velocity, m/s.
        velocity_y,
        /// Its rate, m/s².
        velocity_y_rate,
        /// Standard deviation of the lateral velocity, m/s.
        velocity_y_sd,
        /// Forward acceleration, m/s².
        acceleration_x,
        /// Pitch, rad.
        pitch,
        /// Pitch rate, rad/s.
        pitch_rate,
        /// Pitch acceleration, rad/s², over 0.1 s.
        pitch_acceleration,
        /// Roll, rad.
        roll,
        /// Roll rate, rad/s.
        roll_rate,
        /// Roll acceleration, rad/s², over 0.2 s.
        roll_acceleration,
        /// Largest change of roll within 0.4 s before or after, rad: how quasi-static it is.
        roll_change,
        /// Yaw rate, rad/s.
        yaw_rate,
        /// Yaw acceleration, rad/s², over 0.2 s.
        yaw_acceleration,
        /// Handlebar angle, rad.
        steer,
        /// Direction of travel: +1, -1, or 0 where unknown.
        direction,
        /// Grade of the road, uphill positive; 0 where nothing shows it.
        grade,
    }
    two: {
        /// Wheel speeds, front and rear, rad/s.
        omega,
        /// Their rates, rad/s².
        omega_rate,
        /// Measured slip angles, front and rear, rad.
        measured_slip_angle,
        /// Measured longitudinal forces of the road on the tyres, N.
        measured_force_x,
        /// Measured side forces, N.
        measured_force_y,
        /// Measured loads, N.
        measured_load,
        /// Measured overturning moments, N m.
        measured_moment_x,
        /// Measured brake torques, N m.
        brake_torque,
    }
}

impl Samples {
    pub fn len(&self) -> usize {
        self.segment.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.segment.is_empty()
    }
}

/// A value between samples by a cubic through its four neighbours; `at` in samples.
pub(crate) fn between(x: &[f64], at: f64) -> f64 {
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
pub(crate) fn gather(
    session: &Session,
    segments: &[Segment],
    kinds: &[ManoeuvreKind],
    rate: f64,
    latency: f64,
    config: &Config,
) -> Samples {
    let step = (session.rate / rate).round().max(1.0) as usize;
    let mut out = Samples::default();
    let Some(reader) = Reader::new(session, latency) else { return out };
    let differentiated = differentiated_ends(session);
    let is_sparse = differentiated > 0 && session.velocity_spacing > SPARSE;
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
        let declaration = segment.kind.declaration();
        let ends = if declaration.course == Course::Straight { differentiated } else { 0 };
        if is_sparse && ends > 0 && segment.kind != ManoeuvreKind::Coasting {
            continue;
        }
        let (start, end) = (segment.start + trim.max(ends), segment.end.min(session.len));
        let end = end.saturating_sub((trim / 4).max(ends));
        for i in (start..end).step_by(step) {
            let speed = reader.velocity_x[i];
            if speed.is_nan() || speed < config.min_speed {
                continue;
            }
            out.push(reader.sample(i, number, direction));
        }
    }
    out
}

/// Without an accelerometer, a velocity that comes less often does not show what brakes and engine do, s.
const SPARSE: f64 = 0.5;

/// Samples at each end of a manoeuvre whose acceleration is partly of its neighbour: without an accelerometer the
/// velocity is differentiated, between samples that its source measured.
fn differentiated_ends(session: &Session) -> usize {
    if session.has(Channel::AccelerationX) {
        return 0;
    }
    // a cubic between samples carries a change of slope over two of them
    (1.5 * session.velocity_spacing * session.rate).ceil().max(2.0) as usize
}

/// Half the span of a rate, s.
const SHORT: f64 = 0.02;
/// Half the span of the pitch acceleration, s: a wheel locks within little more.
const MIDDLE: f64 = 0.05;
/// Half the span of the rate of a noisy channel, s: a satellite's lateral velocity is one.
const WIDE: f64 = 0.1;
/// Time before and after a sample in which a change counts, s.
const CHANGE_WINDOW_S: f64 = 0.4;

type Values<'a> = Option<&'a [f64]>;

/// Reads samples of a session's channels, and their rates.
struct Reader<'a> {
    session: &'a Session,
    velocity_x: &'a [f64],
    /// Of the velocity channels, in samples.
    latency: f64,
    last: usize,
}

impl<'a> Reader<'a> {
    /// `None` of a session without forward velocity; `latency` in s.
    fn new(session: &'a Session, latency: f64) -> Option<Self> {
        Some(Reader {
            session,
            velocity_x: session.get(Channel::VelocityX)?,
            latency: latency * session.rate,
            last: session.len.saturating_sub(1),
        })
    }

    fn sample(&self, i: usize, segment: usize, direction: f64) -> Sample {
        let get = |c: Channel| self.session.get(c);
        let read = |x: Values<'_>| x.map_or(f64::NAN, |x| x[i]);
        let (velocity_x, velocity_y) = (Some(self.velocity_x), get(Channel::VelocityY));
        let (roll, roll_rate) = (get(Channel::Roll), get(Channel::RollRate));
        let (pitch, yaw_rate) = (get(Channel::Pitch), get(Channel::YawRate));
        let pitch_rate = get(Channel::PitchRate);
        let omega = [get(Channel::WheelSpeedFront), get(Channel::WheelSpeedRear)];
        let grade = get(Channel::Grade).map_or(0.0, |x| x[i]);
        let grade = if grade.is_finite() { grade } else { 0.0 };
        let moved = ((i as f64 + self.latency).round().max(0.0) as usize).min(self.last);
        let velocity_x_rate = self.rate(velocity_x, moved, SHORT);
        Sample {
            segment,
            time: self.session.time(i),
            velocity_x: self.late(velocity_x, i),
            velocity_x_rate,
            velocity_y: self.late(velocity_y, i),
            velocity_y_rate: self.rate(velocity_y, moved, WIDE),
            velocity_y_sd: self.late(get(Channel::VelocityYSd), i),
            // without an accelerometer the velocity is differentiated
            acceleration_x: get(Channel::AccelerationX).map_or(velocity_x_rate, |x| x[i]),
            // of the frame against the road: an uphill road lifts the nose
            pitch: read(pitch) + grade.atan(),
            pitch_rate: pitch_rate.map_or_else(|| self.rate(pitch, i, WIDE), |x| x[i]),
            pitch_acceleration: pitch_rate.map_or_else(
                || self.curvature(pitch, i, WIDE),
                |_| self.rate(pitch_rate, i, MIDDLE),
            ),
            roll: read(roll),
            roll_rate: roll_rate.map_or_else(|| self.rate(roll, i, SHORT), |x| x[i]),
            roll_acceleration: self.rate(roll_rate, i, WIDE),
            roll_change: self.change(roll, i),
            yaw_rate: read(yaw_rate),
            yaw_acceleration: self.rate(yaw_rate, i, WIDE),
            steer: read(get(Channel::SteerAngle)),
            direction,
            grade,
            omega: omega.map(read),
            omega_rate: omega.map(|x| self.rate(x, i, SHORT)),
            measured_slip_angle: SLIP_ANGLE.map(|c| read(get(c))),
            measured_force_x: FORCE_X.map(|c| read(get(c))),
            measured_force_y: FORCE_Y.map(|c| read(get(c))),
            measured_load: LOAD.map(|c| read(get(c))),
            measured_moment_x: MOMENT_X.map(|c| read(get(c))),
            brake_torque: BRAKE_TORQUE.map(|c| read(get(c))),
        }
    }

    /// A velocity where its latency puts it.
    fn late(&self, x: Values<'_>, i: usize) -> f64 {
        match x {
            Some(x) if self.latency == 0.0 => x[i],
            Some(x) => between(x, i as f64 + self.latency),
            None => f64::NAN,
        }
    }

    /// Central difference over `half` s on each side, per s.
    fn rate(&self, x: Values<'_>, i: usize, half: f64) -> f64 {
        let reach = (half * self.session.rate).round().max(1.0) as usize;
        let (a, b) = (i.saturating_sub(reach), (i + reach).min(self.last));
        x.map_or(f64::NAN, |x| (x[b] - x[a]) * self.session.rate / (b - a).max(1) as f64)
    }

    /// Second difference over `half` s on each side, per s².
    fn curvature(&self, x: Values<'_>, i: usize, half: f64) -> f64 {
        let reach = (half * self.session.rate).round().max(1.0) as usize;
        let (a, b) = (i.saturating_sub(reach), (i + reach).min(self.last));
        if i - a != b - i {
            return f64::NAN;
        }
        let span = reach as f64 / self.session.rate;
        x.map_or(f64::NAN, |x| (x[b] - 2.0 * x[i] + x[a]) / (span * span))
    }

    /// Largest change within [`CHANGE_WINDOW_S`] before and after.
    fn change(&self, x: Values<'_>, i: usize) -> f64 {
        let near = (CHANGE_WINDOW_S * self.session.rate).round() as usize;
        x.map_or(f64::NAN, |x| {
            let (before, after) = (x[i.saturating_sub(near)], x[(i + near).min(self.last)]);
            (after - x[i]).abs().max((x[i] - before).abs())
        })
    }
}
