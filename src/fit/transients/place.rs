//! Velocities where the accelerometer is.
//!
//! An attitude's drift is what accelerations have and the changes of velocity lack ([`super::attitude`]). The two must be of
//! one point. A velocity `x` ahead of the accelerometer changes by `x psi''` besides, which comes and goes with
//! every corner like a drift: 0.25 m moved cornering stiffnesses by 20 %.

use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::estimate::samples::between;

/// Distances that change nothing, m.
const TOGETHER: f64 = 1e-3;

/// The session with its velocities carried `ahead` and `above`, m along the motorcycle, to the accelerometer. They stay as
/// late as they are, by `latency`, s. `None` where the places are one, or the turning is not known.
pub(crate) fn at_accelerometer(
    session: &Session,
    [ahead, above]: [f64; 2],
    latency: f64,
) -> Option<Session> {
    if ahead.abs().max(above.abs()) < TOGETHER {
        return None;
    }
    let late = latency * session.rate;
    let get = |channel| session.get(channel);
    let (turn, roll) = (get(Channel::YawRate)?, get(Channel::Roll)?);
    let (rolling, pitching) = (get(Channel::RollRate)?, get(Channel::PitchRate));
    let mut out = session.clone();
    let moved = |channel: Channel, by: &dyn Fn(f64) -> f64| {
        let old = session.get(channel)?;
        Some(old.iter().enumerate().map(|(i, v)| v + by(i as f64 - late)).collect::<Vec<f64>>())
    };
    // a point above a leaned motorcycle runs inside of it, and goes to the right as the lean grows
    let forward = |at: f64| {
        let pitching = pitching.map_or(0.0, |x| between(x, at));
        above * (between(turn, at) * between(roll, at).sin() + pitching)
    };
    let aside = |at: f64| {
        ahead * between(turn, at) - above * between(roll, at).cos() * between(rolling, at)
    };
    if let Some(v) = moved(Channel::VelocityX, &forward) {
        out.set(Channel::VelocityX, v);
    }
    if let Some(v) = moved(Channel::VelocityY, &aside) {
        out.set(Channel::VelocityY, v);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::super::attitude;
    use super::*;
    use crate::contract::session::Meta;
    use crate::estimate::zeros::Zeros;

    const RATE: f64 = 100.0;
    const LATENCY: f64 = 0.05;

    /// A ride in corners that come and go within 6 s, its velocities late and of a point `ahead` and `above`, m, of the
    /// accelerometer, which has no error.
    fn ride(ahead: f64, above: f64) -> Session {
        let n = 12_000;
        let turn = |t: f64| 0.4 * (1.05 * t).sin() + 0.3 * (0.4 * t).cos();
        let turning = |t: f64| 0.42 * (1.05 * t).cos() - 0.12 * (0.4 * t).sin();
        let roll = |t: f64| -1.2 * turn(t);
        let column = |f: &dyn Fn(f64) -> f64| (0..n).map(|i| f(i as f64 / RATE)).collect();
        let mut session = Session::new(Meta::default(), RATE, n);
        let late = |t: f64| t - LATENCY;
        let x = |t: f64| 15.0 + above * turn(late(t)) * roll(late(t)).sin();
        let y =
            |t: f64| ahead * turn(late(t)) + above * roll(late(t)).cos() * 1.2 * turning(late(t));
        session.set(Channel::VelocityX, column(&x));
        session.set(Channel::VelocityY, column(&y));
        session.set(Channel::AccelerationX, column(&|_| 0.0));
        session.set(Channel::AccelerationY, column(&|t| 15.0 * turn(t)));
        session.set(Channel::YawRate, column(&turn));
        session.set(Channel::Roll, column(&roll));
        session.set(Channel::RollRate, column(&|t| -1.2 * turning(t)));
        session.set(Channel::Pitch, column(&|_| 0.0));
        session
    }

    /// Largest change of the roll within the ride's middle, rad.
    fn change(before: &Session, after: &Session) -> f64 {
        let of = |s: &Session| s.get(Channel::Roll).map(<[f64]>::to_vec).unwrap_or_default();
        let pairs = of(before).into_iter().zip(of(after));
        pairs.skip(1000).take(10_000).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn velocities_ahead_of_the_accelerometer_are_no_drift() {
        let session = ride(0.25, 0.1);
        let zeros = Zeros { acceleration_known: true, latency: LATENCY, ..Zeros::default() };
        let as_they_are = attitude::corrected(&session, &zeros).expect("all channels");
        let moved = at_accelerometer(&session, [-0.25, -0.1], LATENCY).expect("apart");
        let carried = attitude::corrected(&moved, &zeros).expect("all channels");
        let [before, after] = [&as_they_are, &carried].map(|s| change(&session, s));
        assert!(before > 1e-3 && after < 0.1 * before, "{before} {after}");
    }

    #[test]
    fn velocities_of_the_accelerometer_stay() {
        assert!(at_accelerometer(&ride(0.0, 0.0), [0.0, 0.0], LATENCY).is_none());
    }
}
