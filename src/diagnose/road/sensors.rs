//! What the base's sensors show of a ride, and the ride behind what they showed: zeros, an attitude that is late or too
//! large, places beside the centre of mass. The residuals take the same errors off.

use super::dive::diving;
use super::parameters::{Parameters, Sensors};
use super::residuals::beside;
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::statistics::smooth::gradient;

/// The lean and its rates, of a session that has it.
struct Motion {
    sin_cos: Vec<(f64, f64)>,
    rate: Vec<f64>,
    acceleration: Vec<f64>,
    /// Of the dive, rad/s².
    diving: Vec<f64>,
}

impl Motion {
    fn of(session: &Session) -> Option<Self> {
        let roll = session.get(Channel::Roll)?;
        let rate = rate_of(roll, session.rate);
        Some(Motion {
            sin_cos: roll.iter().map(|phi| phi.sin_cos()).collect(),
            acceleration: rate_of(&rate, session.rate),
            diving: diving(session).unwrap_or_else(|| vec![0.0; session.len]),
            rate,
        })
    }

    /// True less measured lean at a sample, rad.
    fn missing(&self, p: &Sensors, i: usize) -> f64 {
        p.attitude_scale * self.sin_cos[i].0 + p.attitude_delay * self.rate[i]
    }

    /// How much slower aside the centre of mass goes than the place of the sensor, m/s.
    fn slower(&self, p: &Sensors, i: usize) -> f64 {
        -p.velocity_height * self.sin_cos[i].1 * self.rate[i]
    }
}

/// Derivative of a column; nil beside samples that are not known.
fn rate_of(x: &[f64], rate: f64) -> Vec<f64> {
    let known = |x: f64| if x.is_finite() { x } else { 0.0 };
    gradient(x, rate).into_iter().map(known).collect()
}

/// The session with the sensors' errors taken off what a replay is driven by.
pub fn as_ridden(recorded: &Session, values: &Parameters) -> Session {
    let p = &values.sensors;
    let mut session = recorded.clone();
    shift(&mut session, p, -1.0);
    if let Some(motion) = Motion::of(recorded) {
        change(&mut session, Channel::Roll, |i| motion.missing(p, i));
        change(&mut session, Channel::VelocityY, |i| -motion.slower(p, i));
    }
    session
}

/// A perfect logger's session with the sensors' errors in it.
pub fn as_recorded(mut session: Session, values: &Parameters) -> Session {
    let p = &values.sensors;
    if let Some(motion) = Motion::of(&session) {
        change(&mut session, Channel::VelocityY, |i| motion.slower(p, i));
        with_accelerometer(&mut session, p, &motion);
        change(&mut session, Channel::Roll, |i| -motion.missing(p, i));
    }
    shift(&mut session, p, 1.0);
    session
}

/// Adds the zeros, times a sign.
fn shift(session: &mut Session, p: &Sensors, sign: f64) {
    for (channel, zero) in p.zeros() {
        change(session, channel, |_| sign * zero);
    }
}

/// Adds to a channel, if it is there, what belongs to each sample.
fn change(session: &mut Session, channel: Channel, by: impl Fn(usize) -> f64) {
    if session.has(channel)
        && let Some(x) = session.get_mut(channel)
    {
        x.iter_mut().enumerate().for_each(|(i, x)| *x += by(i));
    }
}

/// Accelerations of a sensor somewhat ahead, above and turned, which takes a wrong lean for gravity.
fn with_accelerometer(session: &mut Session, p: &Sensors, motion: &Motion) {
    let columns = [Channel::AccelerationX, Channel::AccelerationY, Channel::YawRate];
    let [Some(ax), Some(ay), Some(yaw_rate)] = columns.map(|c| session.get(c)) else {
        return;
    };
    let turning = rate_of(yaw_rate, session.rate);
    let off: Vec<[f64; 2]> = (0..session.len)
        .map(|i| {
            let rolling = [motion.rate[i], motion.acceleration[i]];
            let yaw = [yaw_rate[i], turning[i]];
            let [along, aside] = beside(p.accelerometer, yaw, motion.sin_cos[i], rolling);
            let turned = p.accelerometer_yaw;
            let gravity = GRAVITY * motion.missing(p, i);
            let ahead = p.accelerometer[1] * motion.diving[i];
            [along + ahead + turned * ay[i], aside - turned * ax[i] + gravity]
        })
        .collect();
    change(session, columns[0], |i| off[i][0]);
    change(session, columns[1], |i| off[i][1]);
}
