//! Whether the front and the rear logger run on one clock.
//!
//! Fork, front wheel and steering head usually hang on one logger, shock, rear wheel, tail and the
//! inertial unit on another. The chassis is rigid: what the steering head feels along z follows
//! from the tail (or the inertial unit) and the pitch. The lag at which the two agree best is the
//! lag between the loggers.

use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::filter::{derivative, remove_slow};
use crate::statistics::runs::runs;

use super::kinematics::Kinematics;
use crate::motorcycle::offroad::planar::PlanarMotorcycle;

/// Largest lag that is looked for, s.
const FARTHEST: f64 = 0.25;
/// Slower motion does not determine a lag, Hz.
const SLOW: f64 = 1.0;
/// Correlation from which the two are taken for the same motion.
const ALIKE: f64 = 0.7;
/// Rate at which lags are first looked for, Hz.
const COARSE: f64 = 400.0;

/// Compares the loggers; at most one warning, when they are apart by more than `max_lag` seconds.
pub(crate) fn check(
    session: &Session,
    k: &Kinematics,
    machine: &PlanarMotorcycle,
    max_lag: f64,
) -> Option<Warning> {
    let lag = lag(session, k, machine)?;
    if lag.abs() <= max_lag {
        return None;
    }
    let which = if lag > 0.0 { "late" } else { "early" };
    Some(Warning {
        stage: "estimate",
        code: "unsynchronised",
        channel: Some(Channel::HeadAccelerationZ),
        count: 1,
        time: None,
        message: format!(
            "head_acceleration_z is {:.0} ms {which} against the pitch and the rear accelerometers: \
             front and rear logger are not synchronised; load transfer and wheel flights are smeared \
             by as much. Shift the front logger's channels by {:+.4} s and convert the log again",
            1000.0 * lag.abs(),
            -lag
        ),
    })
}

/// Lag of the steering head behind the rest, s; `None` where it is not determined.
pub(crate) fn lag(session: &Session, k: &Kinematics, machine: &PlanarMotorcycle) -> Option<f64> {
    let head = session.get(Channel::HeadAccelerationZ)?;
    let sensors = &machine.sensors;
    let (other, place) = match session.get(Channel::ChassisAccelerationZ) {
        Some(x) => (x, sensors.imu),
        None => (session.get(Channel::TailAccelerationZ)?, sensors.tail),
    };
    session.get(Channel::Pitch)?;
    let rate = k.rate;
    let turn = derivative(&k.mud, rate, 0.02); // from the pitch alone, not from the head
    let dx = sensors.head[0] - place[0];
    // measured along z up: a_head = a_other + mu'' dx
    let predicted: Vec<f64> = other.iter().zip(&turn).map(|(a, t)| a + t * dx).collect();
    let joint: Vec<f64> = predicted.iter().zip(head).map(|(a, b)| a + b).collect();
    let longest = runs(&joint).into_iter().max_by_key(std::ops::Range::len)?;
    if (longest.len() as f64) < 5.0 * rate {
        return None;
    }
    let lively = |x: &[f64]| -> Vec<f64> {
        let mut x = x[longest.clone()].to_vec();
        remove_slow(&mut x, rate, SLOW);
        x
    };
    let (a, b) = (lively(&predicted), lively(head));
    let far = (FARTHEST * rate) as isize;
    let coarse = (rate / COARSE).round().max(1.0) as usize;
    let score = |lag: isize, step: usize| -> f64 {
        let from = lag.max(0) as usize;
        let to = (b.len() as isize + lag.min(0)).max(0) as usize;
        let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
        for i in (from..to).step_by(step) {
            let (x, y) = (a[(i as isize - lag) as usize], b[i]);
            ab += x * y;
            aa += x * x;
            bb += y * y;
        }
        ab / (aa * bb).sqrt().max(f64::MIN_POSITIVE)
    };
    let best = |lags: &mut dyn Iterator<Item = isize>, step: usize| {
        lags.map(|lag| (score(lag, step), lag)).max_by(|x, y| x.0.total_cmp(&y.0))
    };
    let step = coarse as isize;
    let (_, near) = best(&mut (-far..=far).step_by(coarse), coarse)?;
    let (height, lag) = best(&mut (near - step..=near + step), 1)?;
    (height >= ALIKE).then(|| lag as f64 / rate)
}
