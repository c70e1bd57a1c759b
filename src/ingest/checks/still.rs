//! Channels that stay while the others move: a sensor that is not connected, or stopped.
//!
//! One number all along is no measurement where the others tell that it had to change. Brakes and throttle may rest
//! for a ride, but not at a pressure, and not while it brakes hard.

use super::finding::{Finding, Findings};
use super::view::View;
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;

/// A range of speeds in which everything has to move, m/s.
const VARIED: f64 = 3.0;
/// Lateral acceleration of a corner, m/s².
const BEND: f64 = 1.0;
/// A deceleration that no engine gives, m/s², and how many means it must last for: 2 s.
const HARD: (f64, usize) = (4.0, 10);
/// A pressure that is none, Pa.
const REST: f64 = 5e4;

pub(crate) fn check(view: &View, out: &mut Findings<'_>) -> Result<(), Error> {
    use Channel::*;
    let v = view.get(VelocityX).unwrap_or_default();
    let speed = view.extent(v).unwrap_or_default();
    let other_speed = [WheelSpeedFront, WheelSpeedRear].into_iter().any(|c| {
        let range = view.get(c).and_then(|x| view.extent(x));
        range.is_some_and(|[low, high]| high - low > 0.2 * high.abs() && high > 0.0)
    }) || view.track().is_some_and(|(ground, _)| {
        let Some(m) = view.median(|i| ground[i]) else { return false };
        view.median(|i| (ground[i] - m.value).abs()).is_some_and(|m| m.value > VARIED)
    });
    let varied = speed[1] - speed[0] > VARIED;
    let turns = bends(view);
    let slows = view.rate_of(v);
    let hard = view.moving(|i| slows[i]).iter().filter(|a| **a < -HARD.0).count() >= HARD.1;
    for channel in [
        VelocityX,
        VelocityY,
        AccelerationX,
        AccelerationY,
        Roll,
        YawRate,
        RollRate,
        PitchRate,
        Pitch,
        SteerAngle,
        Latitude,
        Longitude,
        BrakePressureFront,
        BrakePressureRear,
        Throttle,
    ] {
        let Some([low, high]) = view.get(channel).and_then(|x| view.extent(x)) else { continue };
        if high - low > 1e-9 * high.abs().max(low.abs()) {
            continue;
        }
        let pressed =
            |c| view.get(c).and_then(|x| view.extent(x)).is_some_and(|e| e[1] - e[0] > REST);
        let against = match channel {
            VelocityX => other_speed.then_some("wheels or track show that the speed changes"),
            VelocityY | AccelerationY | Roll | YawRate | RollRate | SteerAngle => {
                turns.filter(|of| *of != channel).map(|_| "the other channels show corners")
            }
            // a road may lead straight along a parallel
            Latitude | Longitude => (low == 0.0 && varied).then_some("the bike moves"),
            BrakePressureFront | BrakePressureRear if low.abs() > REST => {
                varied.then_some("the bike moves and no brake is pressed throughout")
            }
            BrakePressureFront | BrakePressureRear => {
                let any = pressed(BrakePressureFront) || pressed(BrakePressureRear);
                (hard && !any).then_some("it brakes hard without any pressure")
            }
            Throttle => (hard && low > 0.03).then_some("it brakes hard"),
            _ => varied.then_some("the speed changes"),
        };
        let Some(against) = against else { continue };
        out.push(Finding {
            code: RejectionCode::Stuck,
            channel,
            count: view.count_moving(),
            message: format!(
                "{channel} stays at {low:.4} while {against}: taken as stuck; check the sensor, or \
                 remove it from the channel map"
            ),
        })?;
    }
    Ok(())
}

/// The first channel that tells of corners, if one does.
fn bends(view: &View) -> Option<Channel> {
    use Channel::*;
    let v = view.get(VelocityX)?;
    let bent = |x: &dyn Fn(usize) -> f64| view.p99(x).is_some_and(|p| p > BEND);
    if view.get(Roll).is_some_and(|x| bent(&|i| GRAVITY * x[i].tan())) {
        return Some(Roll);
    }
    if view.get(YawRate).is_some_and(|x| bent(&|i| v[i] * x[i])) {
        return Some(YawRate);
    }
    if view.get(AccelerationY).is_some_and(|x| bent(&|i| x[i])) {
        return Some(AccelerationY);
    }
    let turn = view.get(Yaw).map(|x| view.rate_of(x));
    if turn.is_some_and(|x| bent(&|i| v[i] * x[i])) {
        return Some(Yaw);
    }
    let (_, turn) = view.track()?;
    // a median tells more than single jumps of a receiver
    let of = view.median(|i| if (v[i] * turn[i]).abs() > BEND { 1.0 } else { f64::NAN });
    of.map(|_| Latitude)
}
