//! A ride on springs, converted to the signals of the nominal model: without pitch.
//!
//! The nominal model's frame stays level. On springs it dives, squats and sits down in corners, and two of
//! its signals are no longer what the model calls them by
//!
//! ```text
//! yaw rate     the trace of the frame turns with it and with d/dt(-pitch tan(roll))
//! centre of mass  stands `(h - R) pitch` further ahead of the wheels' contacts
//! ```
//!
//! The first looks like a lateral acceleration over roll rate, the second like a velocity sensor two
//! centimetres from its place.

use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::ingest::motion::yaw::trace_angle;
use crate::statistics::order::median_or_zero;
use crate::statistics::smooth::{gradient, mean_twice, smooth};
use crate::tyre::dive::above_axles;

/// More pitch is no dive, rad.
const DEEPEST: f64 = 0.2;
/// Lean up to which a bike stands on its usual pitch, rad, and least speed, m/s.
const STRAIGHT: (f64, f64) = (0.05, 4.0);

/// Pitch of the frame beyond the usual one on straights, rad, positive nose down; zero in gaps. `None`
/// where pitch or roll is not measured.
pub(crate) fn dive(session: &Session) -> Option<Vec<f64>> {
    let pitch = smooth(session.get(Channel::Pitch)?, session.rate);
    Some(beyond(&pitch, usual_of(session, &pitch)?))
}

/// The pitch of a session, rad, that is usual on its straights; `None` where pitch or roll is not measured.
pub(super) fn usual_pitch(session: &Session) -> Option<f64> {
    usual_of(session, &smooth(session.get(Channel::Pitch)?, session.rate))
}

fn usual_of(session: &Session, pitch: &[f64]) -> Option<f64> {
    let roll = smooth(session.get(Channel::Roll)?, session.rate);
    let v = session.get(Channel::VelocityX)?;
    let straight =
        |i: &usize| roll[*i].abs() < STRAIGHT.0 && v[*i] > STRAIGHT.1 && pitch[*i].is_finite();
    let usual: Vec<f64> = (0..session.len).filter(straight).map(|i| pitch[i]).collect();
    Some(median_or_zero(&usual))
}

/// Smoothed pitch, rad, beyond `usual`; zero in gaps.
pub(super) fn beyond(pitch: &[f64], usual: f64) -> Vec<f64> {
    let beyond = |p: &f64| (p - usual).clamp(-DEEPEST, DEEPEST);
    pitch.iter().map(|p| if p.is_finite() { beyond(p) } else { 0.0 }).collect()
}

/// Window of the means that take the sensor's noise off a motion, s.
pub(crate) const NOISY: f64 = 0.3;

/// The dive that a frame did, without the noise of its sensor.
pub(crate) fn true_dive(session: &Session) -> Option<Vec<f64>> {
    Some(mean_twice(&dive(session)?, session.rate, NOISY))
}

/// How fast the rate of the dive changes, rad/s², without the noise of its sensor; zero in gaps. `None` as of
/// [`dive`].
pub(crate) fn diving(session: &Session) -> Option<Vec<f64>> {
    let rate = session.rate;
    Some(gradient(&gradient(&true_dive(session)?, rate), rate))
}

/// The session without the dive of its frame; `None` where pitch or roll is not measured.
pub(crate) fn level(session: &Session, bike: &Bike) -> Option<Session> {
    let rate = session.rate;
    let dive = dive(session)?;
    let roll = smooth(session.get(Channel::Roll)?, rate);
    let above = above_axles(bike.cg_height, [bike.front.radius, bike.rear.radius]);
    let trace: Vec<f64> = roll.iter().zip(&dive).map(|(r, p)| trace_angle(*r, *p)).collect();
    let turning = gradient(&trace, rate);
    let mut out = session.clone();
    let known = |x: f64| if x.is_finite() { x } else { 0.0 };
    let turn = out.get_mut(Channel::YawRate)?;
    turn.iter_mut().zip(&turning).for_each(|(r, t)| *r += known(*t));
    let shift: Vec<f64> = turn.iter().zip(&dive).map(|(r, dive)| known(above * dive * r)).collect();
    let shift = smooth(&shift, rate);
    let change = gradient(&shift, rate);
    for (channel, by) in [(Channel::VelocityY, &shift), (Channel::AccelerationY, &change)] {
        if let Some(x) = out.get_mut(channel) {
            x.iter_mut().zip(by).for_each(|(x, by)| *x -= known(*by));
        }
    }
    Some(out)
}
