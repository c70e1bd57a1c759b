//! From the Euler yaw to the trace of the main frame on the road.
//!
//! With yaw, pitch, roll (z, y', x'' Euler angles) the main frame's lateral axis seen in the
//! frame turned by yaw alone is `(sin p sin r, cos r, cos p sin r)`; its plane cuts the road
//! along `y x z = (cos r, -sin p sin r)`. The trace therefore stands at
//! `delta = atan2(-sin p sin r, cos r) = -atan(sin p tan r)` to the Euler heading, about
//! `-pitch tan(roll)`.

use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::ingest::warning::warning;

/// Angle from the Euler heading to the trace, rad, positive to the left.
pub fn trace_angle(roll: f64, pitch: f64) -> f64 {
    (-pitch.sin() * roll.sin()).atan2(roll.cos())
}

/// Turns velocity, acceleration and yaw, given along the Euler yaw, into the trace's frame.
/// The yaw rate is left: it is the Euler rate in both conventions.
pub(crate) fn to_trace(session: &mut Session, warnings: &mut Vec<Warning>) {
    let (Some(roll), Some(pitch)) = (session.get(Channel::Roll), session.get(Channel::Pitch))
    else {
        warnings.push(warning(
            "yaw_convention",
            Some(Channel::VelocityY),
            session.len,
            None,
            "velocity is along the Euler yaw and cannot be turned to the trace of the frame on \
             the road: roll or pitch is missing"
                .into(),
        ));
        return;
    };
    let delta: Vec<f64> = roll.iter().zip(pitch).map(|(&r, &p)| trace_angle(r, p)).collect();
    rotate(session, Channel::VelocityX, Channel::VelocityY, &delta);
    rotate(session, Channel::AccelerationX, Channel::AccelerationY, &delta);
    if let Some(yaw) = session.get_mut(Channel::Yaw) {
        yaw.iter_mut().zip(&delta).for_each(|(y, d)| *y += d);
    }
}

/// Components of one vector in a frame turned by `delta` to the left.
fn rotate(session: &mut Session, x: Channel, y: Channel, delta: &[f64]) {
    if !(session.has(x) && session.has(y)) {
        return;
    }
    let (Some(mut xs), Some(mut ys)) = (session.remove(x), session.remove(y)) else { return };
    for ((x, y), d) in xs.iter_mut().zip(&mut ys).zip(delta) {
        let (sin, cos) = d.sin_cos();
        (*x, *y) = (*x * cos + *y * sin, *y * cos - *x * sin);
    }
    session.set(x, xs);
    session.set(y, ys);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;
    use nalgebra::{Rotation3, Vector3};

    /// The frame itself, not the formula: rotate a body, cut its plane with the road.
    #[test]
    fn the_trace_is_where_the_frame_plane_cuts_the_road() {
        for (roll, pitch, yaw) in [(-0.7_f64, 0.1, 0.3), (0.8, -0.05, 2.0), (0.5, 0.2, -1.0)] {
            let body = Rotation3::<f64>::from_euler_angles(roll, pitch, yaw);
            let trace = (body * Vector3::y()).cross(&Vector3::z());
            let heading = f64::atan2(trace.y, trace.x);
            assert!((heading - yaw - trace_angle(roll, pitch)).abs() < 1e-12);
            assert!((trace_angle(roll, pitch) + pitch * roll.tan()).abs() < 0.01);
        }
    }

    #[test]
    fn a_motorcycle_without_side_slip_has_none_afterwards() {
        let (roll, pitch, yaw, speed) = (-0.6, 0.08, 0.9, 20.0);
        let body = Rotation3::<f64>::from_euler_angles(roll, pitch, yaw);
        let along_trace = (body * Vector3::y()).cross(&Vector3::z()).normalize() * speed;
        let seen = Rotation3::from_euler_angles(0.0, 0.0, -yaw) * along_trace;
        assert!(f64::abs(seen.y) > 0.5, "the Euler frame sees side slip: {}", seen.y);
        let mut session = Session::new(Meta::default(), 10.0, 1);
        session.set(Channel::Roll, vec![roll]);
        session.set(Channel::Pitch, vec![pitch]);
        session.set(Channel::VelocityX, vec![seen.x]);
        session.set(Channel::VelocityY, vec![seen.y]);
        to_trace(&mut session, &mut Vec::new());
        let at = |c| session.get(c).map_or(f64::NAN, |v: &[f64]| v[0]);
        assert!((at(Channel::VelocityX) - speed).abs() < 1e-12);
        assert!(at(Channel::VelocityY).abs() < 1e-12);
    }
}
